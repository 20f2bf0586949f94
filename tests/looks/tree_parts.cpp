#include "tree_parts.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "test_foliage.h"

namespace coppice::test {
namespace {

std::uint8_t byte_of(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 255.0f)));
}

/// stalk: the middle of the card's lower edge. right, up: unit
void add_leaf(Shape& leaves, const glm::vec3& stalk, const glm::vec3& right, const glm::vec3& up) {
  add_card(leaves, stalk - 0.13f * right, 0.26f * right, 0.39f * up);
}

}  // namespace

Shape bare_tree() {
  Shape wood;
  add_tube(wood, {.from = {0, 0, 0}, .to = {0, 3, 0}, .from_radius_m = 0.16f, .to_radius_m = 0.06f, .uvs = {{0, 0}, {2, 6}}});
  for (int i = 0; i < 6; ++i) {
    const float angle = 1.9f * static_cast<float>(i), height_m = 1.5f + 0.22f * static_cast<float>(i);
    const glm::vec3 from(0, height_m, 0), out(std::cos(angle), 0.8f, std::sin(angle));
    add_tube(wood,
             {.from = from, .to = from + 0.9f * out, .from_radius_m = 0.1f, .to_radius_m = 0.05f, .sides = 7, .uvs = {{0, 0}, {1, 3}}});
  }
  return wood;
}

Shape forked_tree(float foot_radius_m) {
  constexpr std::uint32_t kSides = 6, kSections = 4;
  constexpr float kForkRadius_m = 0.16f;
  const glm::vec3 fork(0, 2.6f, 0);
  Shape wood;
  const auto add_stem = [&](const glm::vec3& from, const glm::vec3& to, float from_radius_m, float to_radius_m) {
    for (std::uint32_t ring = 0; ring <= kSections; ++ring)
      for (std::uint32_t side = 0; side <= kSides; ++side) {
        const float along = static_cast<float>(ring) / kSections, share = static_cast<float>(side % kSides) / kSides;
        const glm::vec3 out(std::cos(6.2831853f * share), 0, std::sin(6.2831853f * share));
        if (ring > 0 && side > 0) {
          const auto next = static_cast<std::uint32_t>(wood.positions.size()), below = next - kSides - 1;
          wood.indices.insert(wood.indices.end(), {below - 1, below, next - 1, next - 1, below, next});
        }
        wood.positions.push_back(glm::mix(from, to, along) + glm::mix(from_radius_m, to_radius_m, along) * out);
        wood.normals.push_back(out);
        wood.uvs.emplace_back(static_cast<float>(side) / kSides, along);
      }
  };
  add_stem({0, 0, 0}, fork, foot_radius_m, kForkRadius_m);
  // The boughs begin with the trunk's last ring.
  for (const float side : {1.0f, -1.0f}) add_stem(fork, fork + glm::vec3(0.9f * side, 1.5f, 0.3f * side), kForkRadius_m, 0.03f);
  return wood;
}

Shape crown_of_cards(std::uint32_t count) {
  std::mt19937 random(2);
  Shape leaves;
  for (std::uint32_t i = 0; i < count; ++i) {
    const glm::vec3 middle = glm::vec3(0, 2.6f, 0) + 1.2f * in_ball(random);
    const glm::vec3 up = glm::normalize(in_ball(random));
    const glm::vec3 right = glm::normalize(glm::cross(up, glm::vec3(up.y, up.z + 0.1f, -up.x)));
    add_leaf(leaves, middle, right, up);
  }
  return leaves;
}

Shape leaves_up_a_stem(std::uint32_t count, float low_m, float high_m) {
  Shape leaves;
  for (std::uint32_t i = 0; i < count; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(count), angle = 2.4f * static_cast<float>(i);
    const glm::vec3 up = glm::normalize(glm::vec3(std::cos(angle), 0.5f, std::sin(angle)));
    add_leaf(leaves, {0, low_m + share * (high_m - low_m), 0}, {-std::sin(angle), 0, std::cos(angle)}, up);
  }
  return leaves;
}

Rgba oval_leaf(float u, float v) {
  const float x = 2.0f * u - 1.0f, y = 2.0f * v - 1.0f;
  const float lightness = std::abs(x) < 0.08f ? 1.25f : 1.0f - 0.15f * std::abs(x);
  const bool is_leaf = x * x / 0.64f + y * y / 0.95f < 1.0f;
  return {byte_of(86 * lightness), byte_of(128 * lightness), byte_of(48 * lightness), static_cast<std::uint8_t>(is_leaf ? 255 : 0)};
}

Rgba furrowed_bark(float u, float v) {
  const float lightness = 1.0f + 0.3f * std::sin(25.0f * u + 3.0f * std::sin(6.2831853f * v));
  return {byte_of(112 * lightness), byte_of(86 * lightness), byte_of(62 * lightness), 255};
}

}  // namespace coppice::test
