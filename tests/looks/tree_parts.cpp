#include "tree_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

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
  constexpr std::uint32_t kSides = 8, kTrunkRings = 5, kBoughRings = 4;
  constexpr float kRadius_m = 0.14f, kFork_m = 2.0f, kLean = 0.6f;
  Shape wood;
  const auto add_vertex = [&](const glm::vec3& at, const glm::vec3& out) {
    wood.positions.push_back(at), wood.normals.push_back(glm::normalize(out)), wood.uvs.emplace_back(0.0f);
    return static_cast<std::uint32_t>(wood.positions.size() - 1);
  };
  const auto out_at = [](std::uint32_t side) {
    const float angle = 6.2831853f * static_cast<float>(side) / kSides;
    return glm::vec3(std::cos(angle), 0, std::sin(angle));
  };
  using Ring = std::array<std::uint32_t, kSides>;
  const auto join = [&](const Ring& low, const Ring& high) {
    for (std::size_t i = 0; i < kSides; ++i) {
      const std::size_t next = (i + 1) % kSides;
      wood.indices.insert(wood.indices.end(), {low[i], low[next], high[i], high[i], low[next], high[next]});
    }
  };
  Ring ring{};
  for (std::uint32_t height = 0; height < kTrunkRings; ++height) {
    const float share = static_cast<float>(height) / (kTrunkRings - 1);
    Ring next{};
    for (std::uint32_t i = 0; i < kSides; ++i)
      next[i] = add_vertex(glm::mix(foot_radius_m, kRadius_m, share) * out_at(i) + glm::vec3(0, share * kFork_m, 0), out_at(i));
    if (height > 0) join(ring, next);
    ring = next;
  }
  // A seam across the last ring, from its first corner to its fifth, parts it into the first rings of the boughs.
  std::array<std::uint32_t, 3> seam{};
  for (std::uint32_t i = 0; i < 3; ++i)
    seam[i] = add_vertex({kRadius_m * (0.5f - 0.5f * static_cast<float>(i)), kFork_m + 0.05f, 0}, {0, 1, 0});
  for (const float side : {1.0f, -1.0f}) {
    Ring low = side > 0 ? Ring{ring[0], ring[1], ring[2], ring[3], ring[4], seam[2], seam[1], seam[0]}
                        : Ring{ring[4], ring[5], ring[6], ring[7], ring[0], seam[0], seam[1], seam[2]};
    for (std::uint32_t step = 1; step <= kBoughRings; ++step) {
      const float share = static_cast<float>(step) / kBoughRings;
      const glm::vec3 middle(0, kFork_m + 1.5f * share, side * (0.05f + kLean * 1.5f * share));
      Ring next{};
      for (std::uint32_t i = 0; i < kSides; ++i) {
        const glm::vec3 out = out_at(side > 0 ? i : i + 4);
        next[i] = add_vertex(middle + glm::mix(0.7f * kRadius_m, 0.03f, share) * out, out);
      }
      join(low, next);
      low = next;
    }
  }
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
