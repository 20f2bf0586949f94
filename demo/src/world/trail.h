#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace forest {

/// A closed footpath through the planted square, in plan (x, z), metres. Nothing grows on it; the walking camera follows it.
struct Trail {
  std::vector<glm::vec2> points;     ///< closed: the last joins the first
  std::vector<float> distance_to_m;  ///< [points.size() + 1]: length of the trail before each point, and its whole length
};

Trail make_trail(float half_extent_m, std::uint32_t seed);
float length_m(const Trail& trail);
/// The point `distance_m` along the trail; wraps round.
glm::vec2 point_on(const Trail& trail, float distance_m);
float distance_from(const Trail& trail, glm::vec2 point);

}  // namespace forest
