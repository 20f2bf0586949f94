#include "wind.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "nearest_point.h"
#include "parallel_for.h"
#include "wind_field.h"
#include "wind_grid.h"
#include "wood_bending.h"
#include "wood_skeleton.h"

namespace coppice::bake {
namespace {

/// Distance between rings, relative to the sphere's radius.
constexpr double kRingShare = 1.0 / 40.0;
/// A leaf shows half of its area, averaged over all directions; a full crown covers this share of its box.
constexpr double kShownShare = 0.5, kFullShare = 0.7;
/// Lean of a leaf for each metre away from the wood that bears it, and of the top of a plant without wood for each metre of height.
constexpr double kLeafSlope = 0.1, kBladeSlope = 0.5;
/// Minimum lean of the leaves that lean most, relative to the radius: leaves stir on any plant.
constexpr double kMinLean = 0.04;
/// Usual bend of a model in a gale, as computed, relative to the height.
constexpr double kUsualBend = 0.014;
/// Limits of the bend: of herbs and of trees by height, of all relative to the radius.
constexpr double kHerb_m = 2.5, kHerbBend = 0.32, kTree_m = 6.0, kTreeBend = 0.06, kRadiusBend = 0.6;
/// Share of the leaning and swaying that is shown, and the limit for both together, relative to the radius.
constexpr double kShownLean = 0.4, kMaxLean = 0.06;
/// How many leaves of its size a ring counts for in the motion of its place. A stem's ring counts more: inside a crown it must not follow
/// the leaves.
constexpr double kBranchWeight = 8.0, kStemWeight = 20.0;
constexpr double kMinPeriod_s = 0.25, kMaxPeriod_s = 10.0;

using Box = PointBox<glm::dvec3>;

/// The plant's leaves: a plant that is all wood has a quad that is no leaf.
std::span<const Quad> leaf_quads(const WindSource& source) {
  return source.quads.first(std::min(source.quads.size(), source.leaves.size()));
}

Box leaf_box(const WindSource& source) {
  Box box;
  for (const Quad& quad : leaf_quads(source))
    for (const glm::vec3& corner : quad) box.add(corner);
  for (const glm::vec3& position : source.foliage.positions) box.add(position);
  return box;
}

glm::dvec3 stalk_of(const Quad& quad) {
  return 0.5 * (glm::dvec3(quad[0]) + glm::dvec3(quad[3]));
}

double area_m2(const Quad& quad) {
  return 0.5 * glm::length(glm::cross(glm::dvec3(quad[2]) - glm::dvec3(quad[0]), glm::dvec3(quad[3]) - glm::dvec3(quad[1])));
}

/// [leaf] The ring that bears it.
std::vector<std::uint32_t> bearers_of(std::span<const Quad> quads, std::span<const Ring> rings) {
  std::vector<glm::dvec3> centers;
  for (const Ring& ring : rings) centers.push_back(ring.center);
  const NearestPoint<double> nearest(std::move(centers), 10);
  std::vector<std::uint32_t> result(quads.size(), 0u);
  parallel_for(
      quads.size(), [&](std::size_t i) { result[i] = nearest.to(stalk_of(quads[i])); }, 256);
  return result;
}

/// Sets one of sixteen phases, the same for all places in one cell: less than a quarter turn before or after the mean.
void set_phase(const glm::dvec3& place, double cell_m, WindPoint& point) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::clamp(std::floor(place[axis] / cell_m), -1e9, 1e9);
    hash = (hash ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(cell))) * 0x9e3779b97f4a7c15ull;
    hash ^= hash >> 29;
  }
  // cos of 5.625 degrees, and of every 11.25 from there. Constants, since the same bytes must result on every machine.
  constexpr std::array<float, 8> kCos{0.99518473f, 0.95694034f, 0.88192126f, 0.77301045f,
                                      0.63439328f, 0.47139674f, 0.29028468f, 0.09801714f};
  const std::size_t step = hash >> 40 & 7;
  point.phase_cos = kCos[step];
  point.phase_sin = (hash >> 44 & 1) != 0 ? kCos[7 - step] : -kCos[7 - step];
}

/// The motion of a plant before its limits.
struct Motion {
  double bend_m = 0.0;            ///< bend of the top
  double lean_m = 0.0;            ///< lean of the leaves that lean most
  std::vector<WindPoint> points;  ///< leans are shares of lean_m
  Beam stem, branches;
};

/// [ring] The loads of the leaves that it bears.
std::vector<RingLoad> leaf_loads(std::span<const Quad> quads, std::span<const std::uint32_t> bearers, std::size_t ring_count) {
  std::vector<RingLoad> loads(ring_count);
  for (std::size_t i = 0; i < quads.size(); ++i) {
    const Quad& quad = quads[i];
    const double shown_m2 = kShownShare * area_m2(quad);
    loads[bearers[i]].area_m2 += shown_m2;
    loads[bearers[i]].moment += shown_m2 * 0.25 * (glm::dvec3(quad[0]) + glm::dvec3(quad[1]) + glm::dvec3(quad[2]) + glm::dvec3(quad[3]));
  }
  return loads;
}

/// Wood bends as cantilevers do, and leaves follow the ring that bears them.
Motion wood_motion(const WindSource& source, const Stand& stand, const Box& leaf_box) {
  const std::span<const Quad> quads = leaf_quads(source);
  const double radius_m = source.sphere.radius;
  const std::vector<Ring> rings = wood_skeleton(source.wood, stand, kRingShare * radius_m);
  const std::vector<std::uint32_t> bearers = bearers_of(quads, rings);
  const glm::dvec3 extent = glm::max(leaf_box.extent(), glm::dvec3(0.0));
  const double full_m2 = quads.empty() ? std::numeric_limits<double>::infinity() : kFullShare * 0.5 * (extent.x + extent.z) * extent.y;
  const WoodBend bend = bend_wood(rings, leaf_loads(quads, bearers, rings.size()), stand, full_m2);
  // Lean of a leaf's corner relative to the stem there.
  const auto lean_m = [&](std::size_t leaf, std::size_t corner) {
    const RingBend& bearer = bend.rings[bearers[leaf]];
    const double away_m = glm::distance(glm::dvec3(quads[leaf][corner]), rings[bearers[leaf]].center);
    return bearer.is_stem ? kLeafSlope * away_m : bearer.offset_m + (bearer.slope + kLeafSlope) * away_m;
  };
  // A place takes the phase of its main branch; if the stem bears it itself, that of a large cell.
  const auto set_phase_of = [&](std::size_t ring, const glm::dvec3& place, WindPoint& point) {
    const std::uint32_t branch = bend.rings[ring].branch_ring;
    set_phase(branch == kNone ? place : rings[branch].center, radius_m / (branch == kNone ? 3.0 : 24.0), point);
  };
  std::vector<double> tips_m;
  for (std::size_t i = 0; i < quads.size(); ++i) tips_m.push_back(std::max(lean_m(i, 1), lean_m(i, 2)));
  Motion motion{bend.top_m, std::max(quantile(std::move(tips_m), 9), kMinLean * radius_m), {}, bend.stem, bend.branches};
  const auto share = [&](double own_m) { return static_cast<float>(std::sqrt(std::min(own_m / motion.lean_m, 1.0))); };
  for (std::size_t i = 0; i < rings.size(); ++i) {
    WindPoint point{glm::vec3(rings[i].center)};
    point.weight = static_cast<float>((bend.rings[i].is_stem ? kStemWeight : kBranchWeight) * 2.0 * std::numbers::pi * rings[i].radius_m *
                                      rings[i].length_m);
    point.lean = share(bend.rings[i].is_stem ? 0.0 : bend.rings[i].offset_m);
    set_phase_of(i, rings[i].center, point);
    motion.points.push_back(point);
  }
  for (std::size_t i = 0; i < quads.size(); ++i)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      WindPoint point{quads[i][corner], static_cast<float>(0.25 * area_m2(quads[i])), share(lean_m(i, corner))};
      set_phase_of(bearers[i], stalk_of(quads[i]), point);
      motion.points.push_back(point);
    }
  return motion;
}

/// Motion without wood: blades and cards lean more the higher they are, and the farther out from where the plant touches the ground.
Motion blade_motion(const WindSource& source, const Stand& stand) {
  const std::span<const Quad> quads = leaf_quads(source);
  const double radius_m = source.sphere.radius, height_m = std::max(stand.height_m(), 0.05 * radius_m);
  const auto rise_m = [&](const glm::vec3& at) { return std::max(stand.hangs ? stand.top_y_m - at.y : at.y - stand.base_y_m, 0.0); };
  glm::dvec2 center(0.0);
  double count = 0.0, spread_m = 0.0;
  const auto visit_feet = [&](const auto& visit) {
    for (const Quad& quad : quads)
      for (const glm::vec3& corner : quad)
        if (rise_m(corner) <= 0.1 * height_m) visit(glm::dvec2(corner.x, corner.z));
  };
  visit_feet([&](const glm::dvec2& foot) { center += foot, count += 1.0; });
  if (count > 0.0) center /= count;
  visit_feet([&](const glm::dvec2& foot) { spread_m += glm::distance(foot, center) / count; });

  Motion motion{kBladeSlope * height_m, kBladeSlope * height_m, {}, {height_m, height_m / 50.0}, {}};
  double farthest_m = 0.0;
  std::vector<double> reaches_m;
  for (const Quad& quad : quads)
    for (const glm::vec3& corner : quad) {
      const double out_m = std::max(glm::distance(glm::dvec2(corner.x, corner.z), center) - 1.5 * spread_m, 0.0);
      reaches_m.push_back(std::sqrt(rise_m(corner) * rise_m(corner) + out_m * out_m));
      farthest_m = std::max(farthest_m, reaches_m.back());
    }
  for (std::size_t i = 0; i < reaches_m.size(); ++i) {
    const Quad& quad = quads[i / 4];
    WindPoint point{quad[i % 4], static_cast<float>(0.25 * area_m2(quad))};
    point.lean = farthest_m > 0.0 ? static_cast<float>(reaches_m[i] / farthest_m) : 0.0f;
    set_phase(stalk_of(quad), radius_m / 3.0, point);
    motion.points.push_back(point);
  }
  return motion;
}

/// Replaces a leaf's corners by those of its vertices that have a weight.
void weigh_leaf(const Mesh& foliage, const LeafRange& leaf, std::span<WindPoint> corners, std::vector<WindPoint>& weighted) {
  const WindPoint corner = corners.front();
  const float weight = 4.0f * corner.weight / static_cast<float>(3 * std::max(leaf.triangle_count, 1u));
  for (const std::uint32_t vertex : leaf_indices(foliage, leaf)) {
    if (foliage.wind_weights[vertex] < 0.0f) continue;
    for (WindPoint& each : corners) each.weight = 0.0f;
    weighted.push_back({foliage.positions[vertex], weight, foliage.wind_weights[vertex], corner.phase_cos, corner.phase_sin});
  }
}

/// Replaces the rings by the wood's vertices. They swing with the nearest ring, and lean with it if they have no weight.
void weigh_wood(const Mesh& wood, std::span<WindPoint> rings, std::vector<WindPoint>& weighted) {
  double sum = 0.0;
  std::vector<glm::dvec3> centers;
  for (WindPoint& ring : rings) {
    sum += ring.weight;
    ring.weight = 0.0f;
    centers.emplace_back(ring.position);
  }
  const NearestPoint<double> nearest(std::move(centers), 10);
  const auto weight = static_cast<float>(sum / static_cast<double>(wood.positions.size()));
  for (std::size_t i = 0; i < wood.positions.size(); ++i) {
    const WindPoint& ring = rings[nearest.to(glm::dvec3(wood.positions[i]))];
    const float lean = wood.wind_weights[i] < 0.0f ? ring.lean : wood.wind_weights[i];
    weighted.push_back({wood.positions[i], weight, lean, ring.phase_cos, ring.phase_sin});
  }
}

/// Applies wind weights. The points are the rings', then four of each leaf.
void take_weights(const WindSource& source, std::vector<WindPoint>& points) {
  const std::size_t leaf_count = leaf_quads(source).size(), ring_count = points.size() - 4 * leaf_count;
  std::vector<WindPoint> weighted;
  for (std::size_t leaf = 0; leaf < leaf_count && !source.foliage.wind_weights.empty(); ++leaf)
    weigh_leaf(source.foliage, source.leaves[leaf], std::span(points).subspan(ring_count + 4 * leaf, 4), weighted);
  const auto says = [](float weight) { return weight >= 0.0f; };
  if (ring_count > 0 && std::ranges::any_of(source.wood.wind_weights, says))
    weigh_wood(source.wood, std::span(points).first(ring_count), weighted);
  points.insert(points.end(), weighted.begin(), weighted.end());
}

/// Limits `value` smoothly: nearly unchanged far below `max`, and never above it.
double held_below(double value, double max) {
  return value > 0.0 && max > 0.0 ? value / std::sqrt(1.0 + value / max * (value / max)) : 0.0;
}

double tree_period_s(const Beam& beam) {
  const double frequency_hz = 0.0766 + 3.1219 * 100.0 * beam.diameter_m / (beam.length_m * beam.length_m);
  return 1.0 / frequency_hz;
}

/// Bend of the top in a gale. Grasses and crops bend by a third of their height, trees by a twentieth. Stems of models are often thicker
/// than real ones, and what they bend by goes with the fourth power of that: the root keeps their order and evens them out.
/// computed_m: by wood_bending.h
double shown_bend_m(double computed_m, double softness, double height_m, double radius_m) {
  const double grown = std::clamp((height_m - kHerb_m) / (kTree_m - kHerb_m), 0.0, 1.0);
  const double max_m = std::min((kHerbBend + grown * (kTreeBend - kHerbBend)) * height_m, kRadiusBend * radius_m);
  return held_below(softness * std::sqrt(computed_m / (kUsualBend * height_m)) * max_m, max_m);
}

/// What a force of about its weight bends as far swings as a pendulum of this length.
double pendulum_period_s(double bend_m) {
  return 1.4 * std::numbers::pi * std::sqrt(bend_m / 9.81);
}

float believed_period(double period_s) {
  return static_cast<float>(std::clamp(period_s, kMinPeriod_s, kMaxPeriod_s));
}

void set_box(const Box& all, const Stand& stand, double min_m, coppice_file_wind& head) {
  glm::dvec3 low = all.low, high = all.high;
  if (!stand.hangs) low.y = stand.base_y_m;  // anything below is still
  for (int axis = 0; axis < 3; ++axis) {
    const double missing_m = std::max(min_m - (high[axis] - low[axis]), 0.0);
    const double below = axis == 1 ? 0.0 : 0.5;
    head.box_min[axis] = static_cast<float>(low[axis] - below * missing_m);
    head.box_max[axis] = static_cast<float>(high[axis] + (1.0 - below) * missing_m);
    // Far from the origin floats are farther apart.
    if (!(head.box_max[axis] > head.box_min[axis]))
      head.box_max[axis] = std::nextafter(head.box_min[axis], std::numeric_limits<float>::max());
  }
}

/// Rounding may have exceeded a limit again.
void keep_within_limits(double radius_m, Wind& wind) {
  const auto keeps = [&] {
    const WindField field{wind.head, wind.nodes};
    return field.head.bend_m <= COPPICE_MAX_WIND_BEND * field.head.height_m && max_wind_move_m(field) <= COPPICE_MAX_WIND_MOVE * radius_m &&
           max_wind_growth(field) <= COPPICE_MAX_WIND_GROWTH;
  };
  const auto shrink = [&](float share) { wind.head.bend_m *= share, wind.head.lean_m *= share, wind.head.sway_m *= share; };
  for (int i = 0; i < 100 && !keeps(); ++i) shrink(0.99f);
  if (!keeps()) shrink(0.0f);
}

}  // namespace

std::uint32_t wind_node_side(std::size_t leaf_count) {
  return leaf_count >= 1024 ? 8 : leaf_count >= 128 ? 4 : leaf_count >= 16 ? 2 : 0;
}

Wind wind_of(const WindSource& source, const WindOptions& options) {
  const double radius_m = source.sphere.radius;
  const Box leaves = leaf_box(source);
  Box all = leaves;
  for (const glm::vec3& position : source.wood.positions) all.add(position);
  Wind wind;
  if (!(radius_m > 0.0) || !(all.high.y >= all.low.y)) return wind;
  const Stand stand = stand_of(all.low.y, all.high.y);
  const bool has_wood = !source.wood.indices.empty();
  Motion motion = has_wood ? wood_motion(source, stand, leaves) : blade_motion(source, stand);
  take_weights(source, motion.points);

  coppice_file_wind& head = wind.head;
  head.base_y_m = static_cast<float>(stand.base_y_m);
  head.height_m = static_cast<float>(std::max(stand.height_m(), 0.01 * radius_m));
  const double softness = 1.0 / std::min(options.stiffness, 1.0f);
  const double bend_m = stand.hangs ? 0.0 : shown_bend_m(motion.bend_m, softness, head.height_m, radius_m);
  head.stem_period_s = believed_period(std::max(motion.stem.length_m > 0.0 ? tree_period_s(motion.stem) : 1.0, pendulum_period_s(bend_m)));
  head.branch_period_s = believed_period(motion.branches.length_m > 0.0 ? 2.0 * tree_period_s(motion.branches) : 0.5 * head.stem_period_s);
  set_box(all, stand, 0.05 * radius_m, head);
  if (!options.moves) return wind;

  head.node_side = wind_node_side(source.leaves.size());
  head.bend_m = static_cast<float>(bend_m);
  const double lean_m = held_below(softness * kShownLean * motion.lean_m, kMaxLean * radius_m);
  if (head.node_side > 0) {
    head.lean_m = head.sway_m = static_cast<float>(0.5 * lean_m);
    wind = wind_grid(motion.points, {head, radius_m, stand.hangs});
  }
  keep_within_limits(radius_m, wind);
  const float harder = std::max(options.stiffness, 1.0f);
  wind.head.bend_m /= harder;
  wind.head.lean_m /= harder;
  wind.head.sway_m /= harder;
  return wind;
}

}  // namespace coppice::bake
