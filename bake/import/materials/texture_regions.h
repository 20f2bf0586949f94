#pragma once

#include <cstdint>
#include <limits>

#include <glm/common.hpp>
#include <glm/vec2.hpp>

#include "plant.h"

namespace coppice::bake {

/// Bounds of some texture coordinates; none before the first is added.
struct UvBounds {
  glm::dvec2 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};

  void add(const glm::vec2& uv) { add(UvBounds{glm::dvec2(uv), glm::dvec2(uv)}); }
  void add(const UvBounds& other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
  [[nodiscard]] bool none() const { return !(low.x <= high.x); }
};

/// Texels [first, last) of an image.
struct TextureRegion {
  glm::uvec2 first{0}, last{0};
  [[nodiscard]] glm::uvec2 size() const { return last - first; }
  [[nodiscard]] std::uint64_t texels() const { return std::uint64_t{size().x} * size().y; }
};

/// The texels of an image that such coordinates show, with a margin of one texel. Along an axis on which they span several periods it is
/// all texels.
TextureRegion texture_region(const UvBounds& bounds, const Image& image);

/// Gives each material the part of its image that its triangles show, as an image of its own, and measures what they show of it
/// (Image::shown). Artists put bark, leaves and the white paper between them into one image. From afar, where a pixel is many texels, a
/// leaf must not take on bark and paper, nor a trunk the mean of everything.
///
/// A material gets an image of its own if that drops a quarter of the image or more, or if another material shows other colours of it;
/// normal maps are cut alike. Same plant, same result.
/// plant  foliage, wood, materials and images change; images that no material names any more are dropped
void cut_texture_regions(Plant& plant);

/// Drops materials that no card, leaf mesh or wood uses, and images that no material uses, and renumbers the rest.
void drop_unused_materials(BakedPlant& plant);

}  // namespace coppice::bake
