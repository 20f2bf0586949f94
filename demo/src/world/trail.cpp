#include "trail.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "noise.h"

namespace forest {

Trail make_trail(float half_extent_m, std::uint32_t seed) {
  constexpr int kPoints = 160;
  constexpr float kTurn = 2 * std::numbers::pi_v<float>;
  Trail trail;
  for (int i = 0; i < kPoints; ++i) {
    const float angle = kTurn * static_cast<float>(i) / kPoints;
    const glm::vec2 direction(std::cos(angle), std::sin(angle));
    // Noise on a circle closes by itself; two octaves give bends of tens of metres.
    const float bends = fractal_noise(1.6f * direction.x + 7, 1.6f * direction.y + 7, 2, seed + 101);
    trail.points.push_back(half_extent_m * (0.5f + 0.3f * bends) * direction);
  }
  trail.distance_to_m.push_back(0);
  for (int i = 0; i < kPoints; ++i) {
    const auto from = static_cast<std::size_t>(i);
    const auto to = static_cast<std::size_t>((i + 1) % kPoints);
    trail.distance_to_m.push_back(trail.distance_to_m.back() + glm::distance(trail.points[from], trail.points[to]));
  }
  return trail;
}

float length_m(const Trail& trail) {
  return trail.distance_to_m.back();
}

glm::vec2 point_on(const Trail& trail, float distance_m) {
  const float total = length_m(trail);
  const float wrapped = distance_m - total * std::floor(distance_m / total);
  const auto above = std::upper_bound(trail.distance_to_m.begin() + 1, trail.distance_to_m.end() - 1, wrapped);
  const auto i = static_cast<std::size_t>(above - trail.distance_to_m.begin()) - 1;
  const float along = (wrapped - trail.distance_to_m[i]) / (trail.distance_to_m[i + 1] - trail.distance_to_m[i]);
  return glm::mix(trail.points[i], trail.points[(i + 1) % trail.points.size()], along);
}

float distance_from(const Trail& trail, glm::vec2 point) {
  float nearest = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < trail.points.size(); ++i) {
    const glm::vec2 from = trail.points[i];
    const glm::vec2 segment = trail.points[(i + 1) % trail.points.size()] - from;
    const float along = std::clamp(glm::dot(point - from, segment) / glm::dot(segment, segment), 0.0f, 1.0f);
    const glm::vec2 offset = from + along * segment - point;
    nearest = std::min(nearest, glm::dot(offset, offset));
  }
  return std::sqrt(nearest);
}

}  // namespace forest
