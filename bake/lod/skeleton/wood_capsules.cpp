#include "wood_capsules.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include <glm/geometric.hpp>

#include "bounds.h"
#include "wood_skeleton.h"

namespace coppice::bake {
namespace {

/// Rings of the skeleton along a plant as high as it is wide.
constexpr double kRings = 40.0;
/// Limbs below this share of the thickest radius have no capsule.
constexpr double kThinShare = 0.1;
/// A capsule whose surface is this share of its radius off is good enough.
constexpr double kGoodShare = 0.25;

/// A part of a limb.
struct Part {
  std::vector<Ring> rings;  ///< from the one that bears it on; at least one
  Capsule capsule;
  std::size_t worst = 0;  ///< the ring that fits the capsule least; it parts the two halves, so it is not at an end
  double gain_m3 = 0.0;   ///< wood that the next step would add or correct
  bool is_shown = false;
  std::size_t name = 0;  ///< of two parts with the same gain, the lower name is first

  bool operator<(const Part& other) const { return gain_m3 != other.gain_m3 ? gain_m3 < other.gain_m3 : name > other.name; }
};

double distance_to_line(const glm::dvec3& point, const Capsule& capsule) {
  const glm::dvec3 along = capsule.to - capsule.from;
  const double length_2 = glm::dot(along, along);
  const double at = length_2 > 0.0 ? std::clamp(glm::dot(point - capsule.from, along) / length_2, 0.0, 1.0) : 0.0;
  return glm::distance(point, capsule.from + at * along);
}

Part part_of(std::vector<Ring> rings, std::size_t name, bool is_shown) {
  Part part{std::move(rings), {}, 0, 0.0, is_shown, name};
  Capsule& capsule = part.capsule;
  capsule.from = part.rings.front().center;
  capsule.to = part.rings.back().center;
  // The first ring of a limb is that of what bears it.
  const std::size_t first = part.rings.size() > 1 ? 1 : 0;
  for (std::size_t i = first; i < part.rings.size(); ++i) capsule.radius_m += part.rings[i].radius_m;
  capsule.radius_m /= static_cast<double>(part.rings.size() - first);
  double length_m = 0.0, worst_m = 0.0;
  for (std::size_t i = 1; i < part.rings.size(); ++i) length_m += glm::distance(part.rings[i - 1].center, part.rings[i].center);
  for (std::size_t i = 1; i + 1 < part.rings.size(); ++i) {
    const double off_m = distance_to_line(part.rings[i].center, capsule) + std::abs(part.rings[i].radius_m - capsule.radius_m);
    if (off_m > worst_m) {
      worst_m = off_m;
      part.worst = i;
    }
  }
  if (!is_shown)
    part.gain_m3 = (length_m + capsule.radius_m) * capsule.radius_m * capsule.radius_m;
  else if (worst_m > kGoodShare * capsule.radius_m)
    part.gain_m3 = length_m * capsule.radius_m * std::min(worst_m, capsule.radius_m);
  return part;
}

/// The rings of each limb, after the one that bears it.
std::vector<std::vector<Ring>> limbs_of(const std::vector<Ring>& rings) {
  std::vector<std::uint32_t> parents;
  for (const Ring& ring : rings) parents.push_back(ring.parent);
  const std::vector<std::uint32_t> limb_of = limbs_of_rings(parents);
  std::vector<std::vector<Ring>> limbs;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (limb_of[i] == limbs.size()) {
      limbs.emplace_back();
      if (rings[i].parent != kNone) limbs.back().push_back(rings[rings[i].parent]);
    }
    limbs[limb_of[i]].push_back(rings[i]);
  }
  return limbs;
}

}  // namespace

std::vector<Capsule> wood_capsules(const Mesh& wood, std::uint32_t max_count) {
  PointBox<glm::dvec3> box;
  for (const glm::vec3& position : wood.positions) box.add(position);
  if (wood.indices.empty()) return {};
  const double size_m = glm::distance(box.low, box.high);
  const std::vector<Ring> rings = wood_skeleton(wood, stand_of(box.low.y, box.high.y), size_m / kRings);
  double thickest_m = 0.0;
  for (const Ring& ring : rings) thickest_m = std::max(thickest_m, ring.radius_m);

  std::priority_queue<Part> parts;
  std::vector<Part> shown;
  std::size_t name = 0;
  for (std::vector<Ring>& limb : limbs_of(rings))
    if (Part part = part_of(std::move(limb), name++, false); part.capsule.radius_m >= kThinShare * thickest_m) parts.push(std::move(part));
  std::uint32_t count = 0;
  while (!parts.empty()) {
    Part part = parts.top();
    parts.pop();
    if (!part.is_shown) {
      if (count++ == max_count) break;
      parts.push(part_of(std::move(part.rings), part.name, true));
    } else if (part.gain_m3 == 0.0 || part.worst == 0 || count == max_count) {
      shown.push_back(std::move(part));
    } else {
      const auto middle = part.rings.begin() + static_cast<std::ptrdiff_t>(part.worst);
      parts.push(part_of({part.rings.begin(), middle + 1}, part.name, true));
      parts.push(part_of({middle, part.rings.end()}, name++, true));
      ++count;
    }
  }
  std::vector<Capsule> capsules;
  for (; !parts.empty(); parts.pop())
    if (parts.top().is_shown) shown.push_back(parts.top());
  std::ranges::sort(shown, {}, &Part::name);
  for (const Part& part : shown) capsules.push_back(part.capsule);
  return capsules;
}

}  // namespace coppice::bake
