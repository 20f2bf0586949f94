#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "seeded_random.h"
#include "species.h"

namespace coppice::bake {

inline constexpr glm::vec3 kUp{0.0f, 1.0f, 0.0f};

/// A trunk, branch or twig: a polyline with a radius at each point. Metres.
struct Stem {
  std::vector<glm::vec3> points;  ///< at least three; the first lies inside the parent, or below the ground
  std::vector<float> radii;       ///< one per point; 0 at the last
  std::vector<float> distances;   ///< from the first point along the polyline, one per point
  std::uint32_t level = 0;
  [[nodiscard]] float length() const { return distances.back(); }
};

struct StemPoint {
  glm::vec3 position{0.0f};
  glm::vec3 tangent{0.0f};  ///< unit
  float radius = 0.0f;
};

/// The point at `fraction` (0: base, 1: tip) of the stem's length.
StemPoint point_on(const Stem& stem, float fraction);

/// Two unit vectors that form a right-handed frame with the unit `axis`.
struct CrossAxes {
  glm::vec3 first, second;
};
CrossAxes cross_axes(const glm::vec3& axis);

/// Unit vector from the crown's centre line to a point: the way to the light.
glm::vec3 out_of_crown(const Species& species, const glm::vec3& position);

/// Degrees between successive leaves or branches on a spiral: the golden angle.
inline constexpr float kGoldenAngleDeg = 137.50776f;

/// Grows all stems, parents before children. A pure function of the species and the state of `random`.
std::vector<Stem> grow_skeleton(const Species& species, SeededRandom& random);

}  // namespace coppice::bake
