#include "leaf_area.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "leaf_canvas.h"

namespace coppice::bake {
namespace {

constexpr std::uint32_t kSamplesPerSide = 32;
constexpr int kDirections = 16;
/// Maximum error of a flat leaf's ratio: samples miss parts of its edge.
constexpr double kNoise = 0.03;
/// The ratio of a ball: a disc shows half of its area on average, a ball all of it.
constexpr double kMaxFull = 2.0;

/// A rectangle across `direction`, as large as the leaf's box. Its area is 0 if the leaf is a line from there.
struct Outlook {
  CardFrame frame;
  double area_m2 = 0.0;
};

Outlook outlook(const Mesh& mesh, const LeafRange& leaf, const glm::dvec3& direction, const glm::dvec3& side) {
  const glm::dvec3 x = glm::normalize(side - glm::dot(side, direction) * direction), y = glm::cross(direction, x);
  glm::dvec2 low(std::numeric_limits<double>::max()), high(std::numeric_limits<double>::lowest());
  for (std::size_t i = 0; i < 3 * std::size_t{leaf.triangle_count}; ++i) {
    const glm::dvec3 point(mesh.positions[mesh.indices[3 * std::size_t{leaf.first_triangle} + i]]);
    const glm::dvec2 at(glm::dot(point, x), glm::dot(point, y));
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  const glm::dvec2 size = high - low;
  if (!(size.x > 0.0 && size.y > 0.0)) return {};
  return {{low.x * x + low.y * y, x / size.x, y / size.y, direction}, size.x * size.y};
}

double outline_m2(const Plant& plant, const LeafRange& leaf, const Outlook& outlook) {
  if (outlook.area_m2 == 0.0) return 0.0;
  LeafCanvas canvas(plant, outlook.frame, kSamplesPerSide);
  canvas.draw(leaf);
  std::uint32_t count = 0;
  for (std::uint32_t y = 0; y < kSamplesPerSide; ++y)
    for (std::uint32_t x = 0; x < kSamplesPerSide; ++x) count += canvas.texel(x, y).a > 0.0f ? 1u : 0u;
  return outlook.area_m2 * count / (kSamplesPerSide * kSamplesPerSide);
}

}  // namespace

double fullness(const Plant& plant, const LeafRange& leaf, const Quad& quad) {
  const glm::dvec3 x = glm::normalize(glm::dvec3(quad[2]) - glm::dvec3(quad[3])),
                   normal = glm::normalize(glm::cross(x, glm::dvec3(quad[0]) - glm::dvec3(quad[3]))), y = glm::cross(normal, x);
  const double flat_m2 = outline_m2(plant, leaf, outlook(plant.foliage, leaf, normal, x));
  double shown_m2 = 0.0, flat_shown_m2 = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    // Spreads directions evenly over the half sphere: equal steps of height, turned by the golden angle.
    const double height = (i + 0.5) / kDirections, turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double radius = std::sqrt(1.0 - height * height);
    const glm::dvec3 direction = radius * std::cos(turn) * x + radius * std::sin(turn) * y + height * normal;
    shown_m2 += outline_m2(plant, leaf, outlook(plant.foliage, leaf, direction, x));
    flat_shown_m2 += flat_m2 * height;
  }
  if (!(flat_shown_m2 > 0.0)) return 1.0;
  const double ratio = shown_m2 / flat_shown_m2;
  return ratio < 1.0 + kNoise ? 1.0 : std::min(ratio, kMaxFull);
}

}  // namespace coppice::bake
