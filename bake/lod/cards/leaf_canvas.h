#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "plant.h"

namespace coppice::bake {

/// Maps plant space to a card's image: column and row in samples, and height above its plane.
struct CardFrame {
  glm::dvec3 origin{0.0}, column_per_m{0.0}, row_per_m{0.0}, normal{0.0};
  [[nodiscard]] glm::dvec3 at(const glm::dvec3& point, double size) const {
    const glm::dvec3 arm = point - origin;
    return {glm::dot(arm, column_per_m) * size, glm::dot(arm, row_per_m) * size, glm::dot(arm, normal)};
  }
};

/// The frame of a quad's image: its left edge is the stalk's (corners 3, 0), its rows run from corner 3 to 2.
CardFrame card_frame(const Quad& quad);

/// The topmost texel at each sample of a card's image; alpha is 0 where there is none.
class LeafCanvas {
 public:
  /// size  samples on each side
  LeafCanvas(const Plant& plant, const CardFrame& frame, std::uint32_t size)
      : plant_(plant),
        frame_(frame),
        size_(size),
        heights_(std::size_t{size} * size, -std::numeric_limits<double>::infinity()),
        texels_(heights_.size(), glm::vec4(0.0f)) {}

  void draw(const LeafRange& leaf) {
    for (std::size_t t = 0; t < leaf.triangle_count; ++t) draw(leaf.first_triangle + t);
  }
  [[nodiscard]] const glm::vec4& texel(std::uint32_t x, std::uint32_t y) const { return texels_[std::size_t{y} * size_ + x]; }

 private:
  void draw(std::size_t triangle);

  const Plant& plant_;
  CardFrame frame_;
  std::uint32_t size_;
  std::vector<double> heights_;
  std::vector<glm::vec4> texels_;
};

}  // namespace coppice::bake
