// Plants of few leaves that are bent or folded, near and far: a leaf's quad is flat, and far off nothing else covers what it gets wrong.

#include <cmath>
#include <random>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "looks_case.h"
#include "test_foliage.h"
#include "tree_parts.h"

namespace coppice::test::bent_leaves {

struct Blade {
  glm::vec3 foot{0.0f}, out{1, 0, 0};  ///< out: level, unit
  float length_m = 1, width_m = 0.3f;
  float from_slope = 0, to_slope = 0;  ///< radians above the level
  float fold = 0;                      ///< radians by which both halves rise beside the rib
};

void add_blade(Shape& leaves, const Blade& blade) {
  constexpr std::uint32_t kSegments = 8;
  const glm::vec3 side(-blade.out.z, 0, blade.out.x);
  const auto first = static_cast<std::uint32_t>(leaves.positions.size());
  glm::vec3 rib = blade.foot;
  for (std::uint32_t i = 0; i <= kSegments; ++i) {
    const float t = static_cast<float>(i) / kSegments, slope = glm::mix(blade.from_slope, blade.to_slope, t);
    const glm::vec3 along = std::cos(slope) * blade.out + glm::vec3(0, std::sin(slope), 0), normal = glm::cross(side, along);
    const float half_width_m = 0.5f * blade.width_m * (0.1f + 0.9f * std::sin(3.14159f * std::sqrt(t)));
    for (const float across : {-1.0f, 0.0f, 1.0f}) {
      const glm::vec3 rise = std::abs(across) * std::sin(blade.fold) * normal;
      leaves.positions.push_back(rib + half_width_m * (across * std::cos(blade.fold) * side + rise));
      leaves.normals.push_back(glm::normalize(std::cos(blade.fold) * normal - across * std::sin(blade.fold) * side));
      leaves.uvs.emplace_back(0.5f + 0.5f * across, 1.0f - t);
    }
    rib += blade.length_m / kSegments * along;
    if (i == 0) continue;
    const std::uint32_t low = first + 3 * (i - 1);
    for (const std::uint32_t corner : {0u, 1u, 3u, 3u, 1u, 4u, 1u, 2u, 4u, 4u, 2u, 5u}) leaves.indices.push_back(low + corner);
  }
}

glm::vec3 around(std::uint32_t i, std::uint32_t count) {
  const float angle = 6.2831853f * static_cast<float>(i) / static_cast<float>(count) + 0.3f;
  return {std::cos(angle), 0, std::sin(angle)};
}

GltfBuilder drooping_fronds(std::uint32_t count) {
  GltfBuilder builder;
  const int stem = add_surface(builder, {.name = "stem", .base_color = {0.2f, 0.13f, 0.07f, 1}});
  const int green = add_surface(builder, {.name = "leaf", .base_color = {0.1f, 0.25f, 0.04f, 1}});
  Shape wood, fronds;
  add_tube(wood, {.from = {0, 0, 0}, .to = {0, 1.2f, 0}, .from_radius_m = 0.08f, .to_radius_m = 0.06f});
  for (std::uint32_t i = 0; i < count; ++i)
    add_blade(fronds, {.foot = {0, 1.2f, 0},
                       .out = around(i, count),
                       .length_m = 1.4f,
                       .width_m = 0.4f,
                       .from_slope = 1.2f,
                       .to_slope = i % 2 == 0 ? -1.2f : -0.4f});
  add_shape(builder, wood, stem, "trunk");
  add_shape(builder, fronds, green, "fronds");
  return builder;
}

GltfBuilder sunflower(std::uint32_t leaf_count) {
  GltfBuilder builder;
  const int stem = add_surface(builder, {.name = "stem", .base_color = {0.12f, 0.2f, 0.06f, 1}});
  const int green = add_surface(builder, {.name = "leaf", .base_color = {0.1f, 0.25f, 0.04f, 1}});
  const int yellow = add_surface(builder, {.name = "petal", .base_color = {0.8f, 0.5f, 0.03f, 1}});
  Shape wood, leaves, petals;
  add_tube(wood, {.from = {0, 0, 0}, .to = {0, 1.7f, 0}, .from_radius_m = 0.02f, .to_radius_m = 0.015f});
  add_tube(wood, {.from = {0, 1.68f, 0}, .to = {0, 1.72f, 0}, .from_radius_m = 0.03f, .to_radius_m = 0.1f});
  for (std::uint32_t i = 0; i < leaf_count; ++i)
    add_blade(leaves, {.foot = {0, 0.3f + 1.2f * static_cast<float>(i) / static_cast<float>(leaf_count), 0},
                       .out = around(3 * i, 8),
                       .length_m = 0.4f,
                       .width_m = 0.28f,
                       .from_slope = 0.5f,
                       .to_slope = -1.0f,
                       .fold = 0.3f});
  for (std::uint32_t i = 0; i < 24; ++i)
    add_blade(petals, {.foot = glm::vec3(0, 1.72f, 0) + 0.1f * around(i, 24),
                       .out = around(i, 24),
                       .length_m = 0.14f,
                       .width_m = 0.05f,
                       .from_slope = 0.6f,
                       .to_slope = 0.1f});
  add_shape(builder, wood, stem, "trunk");
  add_shape(builder, leaves, green, "leaves");
  add_shape(builder, petals, yellow, "petals");
  return builder;
}

GltfBuilder mat_of_folded_leaves(std::uint32_t leaf_count) {
  GltfBuilder builder;
  const int green = add_surface(builder, {.name = "leaf", .base_color = {0.1f, 0.25f, 0.04f, 1}});
  std::mt19937 random(4);
  Shape leaves;
  for (std::uint32_t i = 0; i < leaf_count; ++i) {
    const float radius_m = std::sqrt(uniform(random, 0, 1)), turn = uniform(random, 0, 1), slope = uniform(random, -0.1f, 0.4f);
    const glm::vec3 foot = radius_m * around(i, 137);
    add_blade(leaves, {.foot = foot,
                       .out = around(static_cast<std::uint32_t>(1000.0f * turn), 1000),
                       .length_m = 0.22f,
                       .width_m = 0.12f,
                       .from_slope = slope + 0.4f,
                       .to_slope = slope - 0.4f,
                       .fold = 0.7f});
  }
  add_shape(builder, leaves, green, "mat");
  return builder;
}

const std::vector<float> kSizes{240, 72, 24};

INSTANTIATE_TEST_SUITE_P(BentLeaves, LooksTest,
                         testing::Values(LooksCase{.name = "drooping_fronds",
                                                   .plant = [] { return drooping_fronds(9); },
                                                   .defect = [] { return drooping_fronds(6); },
                                                   .sizes_px = kSizes,
                                                   .defect_size_px = 72},
                                         LooksCase{.name = "sunflower",
                                                   .plant = [] { return sunflower(10); },
                                                   .defect = [] { return sunflower(6); },
                                                   .sizes_px = kSizes,
                                                   .defect_size_px = 72},
                                         LooksCase{.name = "mat_of_folded_leaves",
                                                   .plant = [] { return mat_of_folded_leaves(300); },
                                                   .defect = [] { return mat_of_folded_leaves(150); },
                                                   .sizes_px = kSizes,
                                                   .defect_size_px = 72}),
                         looks_name);

}  // namespace coppice::test::bent_leaves
