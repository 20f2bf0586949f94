#include "skeleton.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

// Branching after Weber and Penn, "Creation and Rendering of Realistic Trees", SIGGRAPH 1995: each level of stems has a table of length,
// angle from its parent, curvature and taper; children sit along the parent, each turned by the golden angle from the one before; the
// length along the parent follows a profile that makes the crown's outline. Theirs turns stems by fixed angles; ours also pull up to the
// light and down by weight at every segment, which gives arching shrubs and weeping twigs with two numbers.

namespace coppice::bake {
namespace {

/// What grow_stem needs to know about one stem.
struct StemStart {
  std::uint32_t level = 0;
  glm::vec3 root{0.0f};       ///< inside the parent or below the ground
  glm::vec3 start{0.0f};      ///< where it comes out
  glm::vec3 direction{0.0f};  ///< unit, at `start`
  float length_m = 0.0f;
  float radius_m = 0.0f;
  float collar = 0.0f;  ///< radius gained at `root`, as a fraction: smooths the joint
};

glm::vec3 turned(const glm::vec3& direction, float degrees, float around_deg) {
  const CrossAxes axes = cross_axes(direction);
  const float angle = glm::radians(degrees), around = glm::radians(around_deg);
  return std::cos(angle) * direction + std::sin(angle) * (std::cos(around) * axes.first + std::sin(around) * axes.second);
}

float profile_at(const std::array<float, 4>& profile, float fraction) {
  const float at = std::clamp(fraction, 0.0f, 1.0f) * 3.0f;
  const std::size_t first = std::min<std::size_t>(static_cast<std::size_t>(at), 2);
  return glm::mix(profile[first], profile[first + 1], at - static_cast<float>(first));
}

/// Radii from collar to pointed end.
void taper(Stem& stem, const StemLevel& level, const StemStart& start) {
  const float flare_m = 2.5f * start.radius_m + glm::distance(start.root, start.start);
  stem.distances.assign(1, 0.0f);
  for (std::size_t i = 1; i < stem.points.size(); ++i)
    stem.distances.push_back(stem.distances.back() + glm::distance(stem.points[i - 1], stem.points[i]));
  for (const float distance : stem.distances) {
    const float body = glm::mix(1.0f, level.tip_radius_fraction, distance / stem.length());
    const float joint = std::max(0.0f, 1.0f - distance / flare_m);
    stem.radii.push_back(start.radius_m * body * (1.0f + start.collar * joint * joint));
  }
  stem.radii.back() = 0.0f;
}

Stem grow_stem(const Species& species, const StemStart& start, SeededRandom& random) {
  const StemLevel& level = species.levels[start.level];
  Stem stem;
  stem.level = start.level;
  stem.points = {start.root, start.start};
  const float step_m = start.length_m / static_cast<float>(level.segment_count);
  glm::vec3 direction = start.direction;
  for (std::uint32_t segment = 0; segment < level.segment_count; ++segment) {
    const float fraction = static_cast<float>(segment) / static_cast<float>(level.segment_count);
    const float lift = glm::mix(level.lift_first_per_m, level.lift_last_per_m, fraction) * step_m;
    // These are no arguments of the call below: compilers evaluate arguments in different orders.
    const float about_deg = 360.0f * random.unit();
    const float wander_deg = random.around(level.wander_deg);
    direction = turned(glm::normalize(direction + lift * kUp), wander_deg, about_deg);
    const glm::vec3 next = stem.points.back() + step_m * direction;
    if (next.y < species.min_height_m && direction.y < 0.0f) break;
    stem.points.push_back(next);
  }
  if (stem.points.size() < 3) stem.points.push_back(stem.points.back() + 0.5f * step_m * glm::normalize(start.direction + kUp));
  taper(stem, level, start);
  return stem;
}

StemStart ground_start(const Species& species, std::uint32_t index, std::uint32_t count, float turn_deg, SeededRandom& random) {
  const StemLevel& level = species.levels.front();
  // Stems fan out from the middle of the stool: the inner ones upright, the outer ones leaning.
  const float rank = (static_cast<float>(index) + 0.5f) / static_cast<float>(count);
  const float around_deg = turn_deg + kGoldenAngleDeg * static_cast<float>(index);
  const glm::vec3 outwards{std::cos(glm::radians(around_deg)), 0.0f, std::sin(glm::radians(around_deg))};
  const float lean_deg = glm::mix(level.angle_first_deg, level.angle_last_deg, rank) + random.around(level.angle_spread_deg);
  StemStart start;
  start.level = 0;
  start.start = level.spacing_m * std::sqrt(rank) * outwards;
  start.direction = glm::normalize(std::cos(glm::radians(lean_deg)) * kUp + std::sin(glm::radians(lean_deg)) * outwards);
  start.root = start.start - species.root_depth_m * kUp;
  start.length_m = level.length_m * profile_at(level.length_profile, rank) * (1.0f + random.around(level.length_spread));
  start.radius_m = level.radius_ratio * (1.0f + random.around(0.5f * level.length_spread));
  start.collar = species.root_flare;
  return start;
}

StemStart child_start(const Species& species, const Stem& parent, float rank, float around_deg, SeededRandom& random) {
  const StemLevel& level = species.levels[parent.level + 1];
  const StemPoint at = point_on(parent, glm::mix(level.first_fraction, level.last_fraction, rank));
  const float angle_deg = glm::mix(level.angle_first_deg, level.angle_last_deg, rank) + random.around(level.angle_spread_deg);
  const glm::vec3 light = level.light * glm::normalize(out_of_crown(species, at.position) + kUp);
  // Children of a stunted parent are stunted too.
  const float vigour = std::sqrt(std::min(1.0f, parent.length() / species.levels[parent.level].length_m));
  StemStart start;
  start.level = parent.level + 1;
  start.direction = glm::normalize(turned(at.tangent, angle_deg, around_deg) + light);
  start.length_m = level.length_m * profile_at(level.length_profile, rank) * vigour * (1.0f + random.around(level.length_spread));
  start.radius_m = std::min(std::max(level.radius_ratio * at.radius, level.min_radius_m), 0.85f * std::max(at.radius, 0.001f));
  // The branch leaves the parent's axis a little below the fork, so that the two barks meet at a shallow angle.
  start.root = at.position - 0.8f * at.radius * at.tangent;
  start.start = at.position + 1.1f * at.radius * start.direction;
  start.collar = 0.35f;
  return start;
}

void grow_children(const Species& species, const Stem& parent, std::vector<Stem>& stems, SeededRandom& random) {
  const StemLevel& level = species.levels[parent.level + 1];
  const float bearing_m = parent.length() * (level.last_fraction - level.first_fraction);
  const auto wanted = static_cast<std::uint32_t>(std::lround(bearing_m / level.spacing_m));
  const std::uint32_t count = std::clamp(wanted, level.min_count, level.max_count);
  const float turn_deg = 360.0f * random.unit();
  for (std::uint32_t child = 0; child < count; ++child) {
    const float rank = (static_cast<float>(child) + 0.5f + random.around(0.3f)) / static_cast<float>(count);
    const float around_deg = turn_deg + kGoldenAngleDeg * static_cast<float>(child) + random.around(12.0f);
    stems.push_back(grow_stem(species, child_start(species, parent, rank, around_deg, random), random));
  }
}

}  // namespace

StemPoint point_on(const Stem& stem, float fraction) {
  const float distance = std::clamp(fraction, 0.0f, 1.0f) * stem.length();
  const auto above = std::ranges::upper_bound(stem.distances, distance);
  const auto last = std::clamp<std::size_t>(static_cast<std::size_t>(above - stem.distances.begin()), 1, stem.points.size() - 1);
  const glm::vec3 along = stem.points[last] - stem.points[last - 1];
  const float share = (distance - stem.distances[last - 1]) / (stem.distances[last] - stem.distances[last - 1]);
  return {stem.points[last - 1] + share * along, glm::normalize(along), glm::mix(stem.radii[last - 1], stem.radii[last], share)};
}

CrossAxes cross_axes(const glm::vec3& axis) {
  const glm::vec3 other = std::abs(axis.y) < 0.9f ? kUp : glm::vec3(1.0f, 0.0f, 0.0f);
  const glm::vec3 first = glm::normalize(glm::cross(other, axis));
  return {first, glm::cross(axis, first)};
}

glm::vec3 out_of_crown(const Species& species, const glm::vec3& position) {
  const glm::vec3 out = position - glm::vec3(0.0f, species.crown_centre_fraction * species.height_m, 0.0f);
  const float length = glm::length(out);
  return length > 1e-4f ? out / length : kUp;
}

std::vector<Stem> grow_skeleton(const Species& species, SeededRandom& random) {
  const StemLevel& ground = species.levels.front();
  const std::uint32_t choices = ground.max_count - ground.min_count + 1;
  const std::uint32_t count = ground.min_count + static_cast<std::uint32_t>(random.next() % choices);
  const float turn_deg = 360.0f * random.unit();
  std::vector<Stem> stems;
  for (std::uint32_t index = 0; index < count; ++index)
    stems.push_back(grow_stem(species, ground_start(species, index, count, turn_deg, random), random));
  for (std::size_t parent = 0; parent < stems.size(); ++parent) {
    if (stems[parent].level + 1 >= species.levels.size()) continue;
    SeededRandom own = random.fork();
    grow_children(species, Stem(stems[parent]), stems, own);  // a copy: the vector grows
  }
  return stems;
}

}  // namespace coppice::bake
