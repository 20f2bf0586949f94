#pragma once

// Small foliages for tests: everything opaque, one card, one material.

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "plant.h"

namespace coppice::test {

/// std::uniform_real_distribution is not the same everywhere; this is.
inline float uniform(std::mt19937& random, float low, float high) {
  return low + (high - low) * static_cast<float>(static_cast<double>(random()) / 4294967296.0);
}

inline bake::Foliage plain_foliage(std::vector<bake::Quad> quads) {
  bake::Foliage foliage;
  foliage.cards.assign(quads.size(), 0);
  foliage.quads = std::move(quads);
  foliage.card_table = {bake::Card{0, {glm::vec2(0, 0), glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0)}}};
  return foliage;
}

inline std::vector<bake::Material> plain_materials() {
  return std::vector<bake::Material>(1);
}

/// A rectangle spanned by two vectors from a corner.
inline bake::Quad rectangle(const glm::vec3& corner, const glm::vec3& along, const glm::vec3& across) {
  return {corner, corner + along, corner + along + across, corner + across};
}

/// Four random points each: folded, overlapping, intersecting.
inline bake::Foliage random_quads(std::uint32_t leaf_count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<bake::Quad> quads(leaf_count);
  for (bake::Quad& quad : quads) {
    const glm::vec3 center(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    for (glm::vec3& corner : quad)
      corner = center + glm::vec3(uniform(random, -0.4f, 0.4f), uniform(random, -0.4f, 0.4f), uniform(random, -0.4f, 0.4f));
  }
  return plain_foliage(quads);
}

/// Flat leaves on a ball, facing outwards more or less: a crown, with an inside that few viewpoints see.
inline bake::Foliage ball_crown(std::uint32_t leaf_count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<bake::Quad> quads;
  for (std::uint32_t i = 0; i < leaf_count; ++i) {
    const float height = uniform(random, -1, 1), angle = uniform(random, 0, 6.2831853f), radius = std::sqrt(uniform(random, 0.2f, 1));
    const float ring = std::sqrt(1 - height * height);
    const glm::vec3 normal(ring * std::cos(angle), height, ring * std::sin(angle));
    const glm::vec3 tilt(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    const glm::vec3 along = glm::normalize(glm::cross(normal + 0.5f * tilt, glm::vec3(0.3f, 1, 0.2f)));
    const glm::vec3 across = glm::normalize(glm::cross(along, normal + 0.3f * tilt));
    quads.push_back(rectangle(normal * (2 * radius) - along * 0.25f - across * 0.15f, along * 0.5f, across * 0.3f));
  }
  return plain_foliage(quads);
}

/// Evenly distributed in the ball of radius 1, and not near its middle: there is a direction.
inline glm::vec3 in_ball(std::mt19937& random) {
  for (;;) {
    const float x = uniform(random, -1, 1), y = uniform(random, -1, 1), z = uniform(random, -1, 1);
    const glm::vec3 point(x, y, z);
    if (glm::dot(point, point) <= 1.0f && glm::dot(point, point) > 0.01f) return point;
  }
}

/// The same crown whatever the number of its leaves: an ellipsoid of 4 x 6 x 4 m, evenly filled, whose leaves, 2 : 1, have 60 m^2 in all.
inline bake::Foliage filled_crown(std::uint32_t leaf_count, std::uint32_t seed) {
  constexpr float kLeafArea_m2 = 60.0f;
  std::mt19937 random(seed);
  const float width_m = std::sqrt(kLeafArea_m2 / static_cast<float>(leaf_count) / 2);
  std::vector<bake::Quad> quads;
  for (std::uint32_t i = 0; i < leaf_count; ++i) {
    const glm::vec3 center = in_ball(random) * glm::vec3(2, 3, 2), along = glm::normalize(in_ball(random));
    const glm::vec3 sideways = glm::cross(along, glm::vec3(0.48f, 0.6f, 0.64f)) + 0.01f * glm::vec3(along.y, -along.x, 0.5f);
    const glm::vec3 across = glm::normalize(glm::cross(along, sideways));
    quads.push_back(rectangle(center - width_m * (along + 0.5f * across), 2 * width_m * along, width_m * across));
  }
  return plain_foliage(quads);
}

/// Leaves that come in threes at exactly the same place: every choice has ties.
inline bake::Foliage duplicated_leaves(std::uint32_t leaf_count, std::uint32_t seed) {
  bake::Foliage foliage = random_quads(leaf_count, seed);
  for (std::uint32_t i = 0; i < leaf_count; ++i) foliage.quads[i] = foliage.quads[i - i % 3];
  return foliage;
}

}  // namespace coppice::test
