// A clump of grass: blades in one mesh without a picture, each a strip that narrows and bends over.

#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "looks_case.h"
#include "test_foliage.h"

namespace coppice::test::grass {

/// out: level, unit, where it bends to
void add_blade(Shape& grass, const glm::vec3& foot, const glm::vec3& out, float height_m) {
  constexpr std::uint32_t kSegments = 4;
  constexpr float kWidth_m = 0.012f;
  const glm::vec3 side(-out.z, 0, out.x);
  const auto first = static_cast<std::uint32_t>(grass.positions.size());
  for (std::uint32_t i = 0; i <= kSegments; ++i) {
    const float t = static_cast<float>(i) / kSegments;
    const glm::vec3 middle = foot + height_m * (glm::vec3(0, t - 0.25f * t * t, 0) + 0.6f * t * t * out);
    const glm::vec3 along = glm::vec3(0, 1.0f - 0.5f * t, 0) + 1.2f * t * out;
    const glm::vec3 half_width = 0.5f * kWidth_m * (1.0f - 0.9f * t) * side;
    for (const float across : {-1.0f, 1.0f}) {
      grass.positions.push_back(middle + across * half_width);
      grass.normals.push_back(glm::normalize(glm::cross(side, along)));
      grass.uvs.emplace_back(0.5f + 0.5f * across, 1.0f - t);
    }
    if (i == 0) continue;
    const std::uint32_t low = first + 2 * (i - 1);
    for (const std::uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u}) grass.indices.push_back(low + corner);
  }
}

GltfBuilder clump(std::uint32_t blade_count) {
  GltfBuilder builder;
  const int green = add_surface(builder, {.name = "grass", .base_color = {0.1f, 0.25f, 0.04f, 1}});
  std::mt19937 random(4);
  Shape grass;
  for (std::uint32_t i = 0; i < blade_count; ++i) {
    const float angle = 2.4f * static_cast<float>(i), radius_m = 0.08f * std::sqrt(uniform(random, 0, 1));
    const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
    add_blade(grass, radius_m * out, out, uniform(random, 0.25f, 0.5f));
  }
  add_shape(builder, grass, green, "clump");
  return builder;
}

INSTANTIATE_TEST_SUITE_P(Grass, LooksTest,
                         testing::Values(LooksCase{
                             .name = "clump_of_grass", .plant = [] { return clump(160); }, .defect = [] { return clump(80); }}),
                         looks_name);

}  // namespace coppice::test::grass
