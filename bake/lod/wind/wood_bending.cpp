#include "wood_bending.h"

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

namespace coppice::bake {
namespace {

/// The stem continues in the child that bears most, as long as that bears at least this share of what all children bear ...
constexpr double kMainShare = 0.55;
/// ... and is not thinner than this share of the stem's lowest third: otherwise it is a twig like others.
constexpr double kThinShare = 0.3;
/// Maximum slope: what bends farther lies down, and catches less.
constexpr double kMaxSlope = 1.0;

/// Adds the wood's own load, and to each ring the load of what it bears.
void sum_loads(std::span<const Ring> rings, std::vector<RingLoad>& loads) {
  for (std::size_t i = rings.size(); i-- > 0;) {
    const double wood_m2 = 2.0 * rings[i].radius_m * rings[i].length_m;
    loads[i].area_m2 += wood_m2;
    loads[i].moment += wood_m2 * rings[i].center;
    if (rings[i].parent == kNone) continue;
    loads[rings[i].parent].area_m2 += loads[i].area_m2;
    loads[rings[i].parent].moment += loads[i].moment;
  }
}

/// What all children of a ring bear, and the first of those that bear most.
struct Children {
  double load_m2 = 0.0;
  std::uint32_t main = kNone;
};

std::vector<Children> children_of(std::span<const Ring> rings, std::span<const RingLoad> loads) {
  std::vector<Children> children(rings.size());
  for (std::uint32_t i = 0; i < rings.size(); ++i) {
    if (rings[i].parent == kNone) continue;
    Children& siblings = children[rings[i].parent];
    siblings.load_m2 += loads[i].area_m2;
    if (siblings.main == kNone || loads[i].area_m2 > loads[siblings.main].area_m2) siblings.main = i;
  }
  return children;
}

/// Rings of a stem, upwards, and the radius of its lowest third.
struct Stem {
  std::vector<std::uint32_t> rings;
  double radius_m = 0.0;
};

Stem stem_from(std::uint32_t root, std::span<const Ring> rings, std::span<const RingLoad> loads, std::span<const Children> children) {
  std::vector<std::uint32_t> stem{root};
  for (Children next = children[root]; next.main != kNone && loads[next.main].area_m2 >= kMainShare * next.load_m2;
       next = children[next.main])
    stem.push_back(next.main);
  const std::size_t third = (stem.size() + 2) / 3;
  std::vector<double> radii_m;
  for (const std::uint32_t ring : std::span(stem).first(third)) radii_m.push_back(rings[ring].radius_m);
  const double radius_m = quantile(std::move(radii_m), 5);
  std::size_t thick = third;
  while (thick < stem.size() && rings[stem[thick]].radius_m >= kThinShare * radius_m) ++thick;
  stem.resize(thick);
  return {std::move(stem), radius_m};
}

/// Bends a ring as the next piece of a cantilever whose end is `from`.
void bend_on(const Ring& ring, const RingLoad& load, double force_pa, const RingBend& from, RingBend& bend) {
  const double inertia_m4 = 0.25 * std::numbers::pi * ring.radius_m * ring.radius_m * ring.radius_m * ring.radius_m;
  const double arm_m = load.area_m2 > 0.0 ? glm::distance(load.moment / load.area_m2, ring.center) : 0.0;
  const double curvature_per_m = force_pa * load.area_m2 * arm_m / (kWoodModulus_pa * inertia_m4);
  bend.slope = std::min(from.slope + curvature_per_m * ring.length_m, kMaxSlope);
  bend.offset_m = from.offset_m + 0.5 * (from.slope + bend.slope) * ring.length_m;
}

struct BeamSum {
  double weight = 0.0, length = 0.0, diameter = 0.0;
  void add(double load_m2, double length_m, double diameter_m) {
    weight += load_m2;
    length += load_m2 * length_m;
    diameter += load_m2 * diameter_m;
  }
  [[nodiscard]] Beam mean() const { return weight > 0.0 ? Beam{length / weight, diameter / weight} : Beam{}; }
};

/// Mean length and diameter of branches. A branch is as long as the way to its farthest ring.
Beam mean_branch(std::span<const Ring> rings, std::span<const RingLoad> loads, std::span<const RingBend> bends) {
  std::vector<double> reached_m(rings.size(), 0.0), longest_m(rings.size(), 0.0);
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (bends[i].is_stem || bends[i].branch_ring == kNone) continue;
    reached_m[i] = (rings[i].parent == kNone ? 0.0 : reached_m[rings[i].parent]) + rings[i].length_m;
    longest_m[bends[i].branch_ring] = std::max(longest_m[bends[i].branch_ring], reached_m[i]);
  }
  BeamSum sum;
  for (std::size_t i = 0; i < rings.size(); ++i)
    if (bends[i].branch_ring == i) sum.add(loads[i].area_m2, longest_m[i], 2.0 * rings[i].radius_m);
  return sum.mean();
}

}  // namespace

WoodBend bend_wood(std::span<const Ring> rings, std::vector<RingLoad> loads, const Stand& stand, double max_area_m2) {
  WoodBend bend;
  bend.rings.resize(rings.size());
  sum_loads(rings, loads);
  const std::vector<Children> children = children_of(rings, loads);
  double all_m2 = 0.0;
  for (std::size_t i = 0; i < rings.size(); ++i)
    if (rings[i].parent == kNone) all_m2 += loads[i].area_m2;
  const double softness = 1.0 / std::clamp(stand.height_m() / kWoodHeight_m, 0.1, 1.0);
  const double force_pa = softness * kGalePressure_pa * kCrownDrag * (all_m2 > max_area_m2 ? max_area_m2 / all_m2 : 1.0);

  std::vector<Stem> stems;
  for (std::uint32_t i = 0; i < rings.size(); ++i)
    if (rings[i].parent == kNone) stems.push_back(stem_from(i, rings, loads, children));
  for (const Stem& stem : stems)
    for (const std::uint32_t ring : stem.rings) bend.rings[ring].is_stem = true;
  for (std::uint32_t i = 0; i < rings.size(); ++i) {
    if (rings[i].parent == kNone) continue;
    const RingBend& parent = bend.rings[rings[i].parent];
    RingBend& own = bend.rings[i];
    const bool leaves_stem = parent.is_stem && !own.is_stem;
    if (!own.is_stem) own.branch_ring = leaves_stem ? i : parent.branch_ring;
    bend_on(rings[i], loads[i], force_pa, leaves_stem ? RingBend{} : parent, own);
  }

  BeamSum beams;
  double top = 0.0;
  for (const Stem& stem : stems) {
    const std::uint32_t root = stem.rings.front(), end = stem.rings.back();
    const double rest_m = std::max(stand.top_y_m - rings[end].center.y, 0.0);
    top += loads[root].area_m2 * (bend.rings[end].offset_m + bend.rings[end].slope * rest_m);
    beams.add(loads[root].area_m2, stand.height_m(), 2.0 * stem.radius_m);
  }
  bend.top_m = beams.weight > 0.0 ? top / beams.weight : 0.0;
  bend.stem = beams.mean();
  bend.branches = mean_branch(rings, loads, bend.rings);
  return bend;
}

}  // namespace coppice::bake
