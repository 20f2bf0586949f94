#include "demand.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "cells.h"
#include "check.h"

namespace coppice {

namespace {

/// For an oblique projection, whose near plane may lie behind the eye.
constexpr float kObliqueNear_m = 0.1f;

/// Distance of the nearer clip plane. Depth 0 and 1 are at b / a and b / (a + 1): the direction of depth decides which is near, and one may
/// be infinitely far.
float near_distance_m(std::span<const float, 16> clip_from_view) {
  const float a = clip_from_view[10], b = clip_from_view[14];
  float near_m = INFINITY;
  for (float distance : {b / a, b / (a + 1.0f)})
    if (distance > 0.0f && distance < near_m) near_m = distance;
  return near_m;
}

/// Uses the inverse: engines round their rotations to floats, and far from the origin an error of 1e-7 puts the transpose metres off.
dvec3 eye_of(std::span<const double, 16> m) {
  const dvec3 x{m[0], m[1], m[2]}, y{m[4], m[5], m[6]}, z{m[8], m[9], m[10]}, moved{m[12], m[13], m[14]};
  const double volume = dot(x, cross(y, z));
  return dvec3{dot(moved, cross(y, z)), dot(moved, cross(z, x)), dot(moved, cross(x, y))} * (-1.0 / volume);
}

/// View space from places relative to the eye on the GPU, which is `off` from the exact eye.
mat4 view_from_eye(std::span<const double, 16> view_from_world, const dvec3& off) {
  const auto column = [&](std::size_t i) { return dvec3(std::span<const double, 3>(view_from_world.data() + 4 * i, 3)); };
  mat4 turn;
  for (std::size_t i = 0; i < 3; ++i) turn.column[i] = {column(i).rounded(), 0.0f};
  turn.column[3] = {(column(0) * off.x + column(1) * off.y + column(2) * off.z).rounded(), 1.0f};
  return turn;
}

/// Scales a projection so that w is the depth along the axis, m, or 1 in a parallel view.
mat4 scaled_projection(std::span<const float, 16> clip_from_view, bool parallel) {
  mat4 scaled(clip_from_view);
  const float factor = 1.0f / (parallel ? clip_from_view[15] : -clip_from_view[11]);
  if (factor != 1.0f)
    for (vec4& column : scaled.column) column = column * factor;
  return scaled;
}

/// LodEye::key_row in view space. With reversed depth nearer places have larger depth, and the key is depth itself.
vec4 view_key_row(const mat4& clip_from_view, bool parallel) {
  const mat4 rows = transpose(clip_from_view);
  const bool reversed = (parallel ? rows.column[2].z : rows.column[2].w) > 0.0f;
  return reversed ? rows.column[2] : rows.column[3] - rows.column[2];
}

/// Converts a row of a matrix from view space to world space.
vec4 world_row(const vec4& row, const mat4& view_from_world) {
  const mat4 columns = view_from_world;
  const auto along = [&](const vec4& column) { return row.x * column.x + row.y * column.y + row.z * column.z + row.w * column.w; };
  return {along(columns.column[0]), along(columns.column[1]), along(columns.column[2]), along(columns.column[3])};
}

/// The fields of a camera that describe an eye.
struct EyeInput {
  std::span<const double, 16> view_from_world;
  std::span<const float, 16> clip_from_view;
  std::int32_t x_px = 0, y_px = 0;
};

Result<void> check_eye(const EyeInput& eye) {
  const bool finite = std::ranges::all_of(eye.view_from_world, [](double x) { return std::isfinite(x); }) &&
                      std::ranges::all_of(eye.clip_from_view, [](float x) { return std::isfinite(x); });
  if (!finite) return Error{Status::invalid_argument, "view: a matrix is not finite"};
  const bool perspective = eye.clip_from_view[11] < 0.0f && eye.clip_from_view[15] == 0.0f;
  if (!perspective && !is_parallel(eye.clip_from_view))
    return Error{Status::invalid_argument, "view: clip_from_view is neither a perspective that looks down -z nor orthographic"};
  return {};
}

/// LodView::near_m for an eye.
float nearest_m(std::span<const float, 16> clip_from_view, bool parallel) {
  const bool oblique = clip_from_view[2] != 0.0f || clip_from_view[6] != 0.0f;
  return parallel ? 1.0f : oblique ? kObliqueNear_m : near_distance_m(clip_from_view);
}

/// view: eye_m, origin_m and parallel are set
LodEye lod_eye(const EyeInput& eye, const mat4& clip_from_view, const LodView& view) {
  const dvec3 place_m = eye_of(eye.view_from_world) + view.origin_m - view.eye_m;
  const mat4 turn = view_from_eye(eye.view_from_world, place_m * -1.0);
  LodEye result{.clip_from_world = clip_from_view * turn,
                .key_row = world_row(view_key_row(clip_from_view, view.parallel), turn),
                .place_m = place_m.rounded(),
                .x_px = eye.x_px,
                .y_px = eye.y_px};
  result.planes = frustum_planes(result.clip_from_world, result.key_row);
  return result;
}

enum class Side : std::uint8_t { in, across, out };

/// The side of the view's planes on which a sphere lies.
Side side_of(const dvec3& center_m, float radius_m, const LodView& view) {
  const float depth_m = depth_in_view(view, center_m);
  if (depth_m < -radius_m) return Side::out;
  return depth_m < radius_m ? Side::across : Side::in;
}

/// floor(2 log2(size)) from the bits of a float: the exponent, and whether the mantissa is above that of the square root of 2.
std::uint32_t bin_of(float size_px) {
  if (!(size_px > 1.0f)) return 0;
  constexpr std::uint32_t kMantissaBits = 23, kExponentBias = 127, kMantissa = (1u << kMantissaBits) - 1;
  const auto bits = std::bit_cast<std::uint32_t>(size_px);
  const std::uint32_t half = (bits & kMantissa) >= (std::bit_cast<std::uint32_t>(1.41421356f) & kMantissa) ? 1 : 0;
  return std::min(2 * ((bits >> kMantissaBits) - kExponentBias) + half, kSizeBinCount - 1);
}

/// The share of its size that an instance on this side counts with, and its weight.
float size_share(Side side) {
  return side == Side::out ? 0.5f : 1.0f;
}
float weight_of(Side side) {
  return side == Side::out ? kOutsideWeight : 1.0f;
}

/// of_block: the side of a block that the instance is in
void count_instance(const InstanceSphere& instance, Side of_block, const LodView& view, std::span<PlantDemand> demands) {
  if (instance.plant == InstanceSphere::kNoPlant || (instance.layer_mask & view.layer_mask) == 0) return;
  COPPICE_ASSERT(instance.plant < demands.size());
  const Side side =
      of_block != Side::across ? of_block : side_of(instance.center_m, instance.radius_m + wind_reach_m(view, instance.radius_m), view);
  if (side == Side::out && !view.looks_around) return;
  const float size_px = size_share(side) * lod::coppice_projected_size_px(size_distance_m(view, instance.center_m),
                                                                          demand_radius_m(instance), view.near_m, view.focal_px);
  PlantDemand& demand = demands[instance.plant];
  demand.max_size_px = std::max(demand.max_size_px, size_px);
  demand.instances[bin_of(size_px)] += weight_of(side);
}

/// A block is measured as a whole from this many of its radii on: sizes in it then differ by less than a bin.
constexpr float kFarRadii = 8.0f;

/// Counts instances of a block in which all distances are about the same. Sizes are proportional to radii: one division is for all.
struct FarBlock {
  const LodView& view;
  float nearest_m, share, weight;
  float at_center_px, at_most_px;  ///< size of 1 m at the block's centre, and in front of all instances

  FarBlock(const InstanceBounds& block, Side side, const LodView& of_view)
      : view(of_view), share(size_share(side)), weight(weight_of(side)) {
    const float center_m = size_distance_m(view, block.center_m);
    nearest_m = center_m - block.radius_m;
    at_center_px = size_px(1.0f, center_m);
    at_most_px = size_px(1.0f, nearest_m);
  }

  [[nodiscard]] float size_px(float radius_m, float distance_m) const {
    return share * lod::coppice_projected_size_px(distance_m, radius_m, view.near_m, view.focal_px);
  }
  void count(PlantDemand& demand, float mean_radius_m, float max_radius_m, std::uint32_t instance_count) const {
    if (max_radius_m * at_most_px > demand.max_size_px)
      demand.max_size_px = std::max(demand.max_size_px, size_px(max_radius_m, nearest_m + max_radius_m));
    demand.instances[bin_of(mean_radius_m * at_center_px)] += weight * static_cast<float>(instance_count);
  }
};

void count_far_block(std::span<const InstanceSphere> members, const InstanceBounds& block, Side side, const LodView& view,
                     std::span<PlantDemand> demands) {
  const FarBlock far(block, side, view);
  if (block.plant != InstanceBounds::kMixedPlants && (block.all_layers & view.layer_mask) != 0) {
    COPPICE_ASSERT(block.plant < demands.size());
    return far.count(demands[block.plant], block.mean_demand_radius_m, block.max_demand_radius_m, block.instance_count);
  }
  for (const InstanceSphere& instance : members) {
    if (instance.plant == InstanceSphere::kNoPlant || (instance.layer_mask & view.layer_mask) == 0) continue;
    COPPICE_ASSERT(instance.plant < demands.size());
    far.count(demands[instance.plant], demand_radius_m(instance), demand_radius_m(instance), 1);
  }
}

}  // namespace

Result<LodView> demand_view(const coppice_camera& camera, const dvec3& origin_m) {
  if (!(camera.error_px > 0.0f) || !std::isfinite(camera.error_px)) return Error{Status::invalid_argument, "view: error_px must be > 0"};
  const EyeInput first{camera.view_from_world, camera.clip_from_view, camera.x_px, camera.y_px};
  std::array<EyeInput, kMaxEyes> inputs{first, first};
  LodView result;
  if (camera.second_eye != nullptr) {
    const coppice_eye& second = *camera.second_eye;
    inputs[result.eye_count++] = {second.view_from_world, second.clip_from_view, second.x_px, second.y_px};
  }
  const auto eyes = std::span<const EyeInput>(inputs).first(result.eye_count);
  for (const EyeInput& eye : eyes) COPPICE_CHECK(check_eye(eye));
  dvec3 exact_eye_m = eye_of(eyes.front().view_from_world) + origin_m;
  if (eyes.size() > 1) exact_eye_m = (exact_eye_m + eye_of(eyes.back().view_from_world) + origin_m) * 0.5;
  // Rounded as on the GPU, so that both compute the same to the last bits.
  result.eye_m = gpu::world_place(gpu::cell_place(exact_eye_m));
  result.origin_m = origin_m;
  result.layer_mask = camera.layer_mask;
  result.parallel = is_parallel(eyes.front().clip_from_view);
  result.error_px = camera.error_px;
  result.full = camera.lod == COPPICE_LOD_FULL;
  result.discrete = camera.lod == COPPICE_LOD_DISCRETE;
  result.focal_px = 0.0f;
  result.near_m = INFINITY;
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const mat4 clip_from_view = scaled_projection(eyes[i].clip_from_view, result.parallel);
    result.eyes[i] = lod_eye(eyes[i], clip_from_view, result);
    result.focal_px = std::max(result.focal_px, 0.5f * static_cast<float>(camera.height_px) * std::abs(clip_from_view.column[1].y));
    result.near_m = std::min(result.near_m, nearest_m(eyes[i].clip_from_view, result.parallel));
  }
  if (!(result.focal_px > 0.0f) || !std::isfinite(result.near_m))
    return Error{Status::invalid_argument, "view: clip_from_view has no height or no near plane"};
  const double* m = camera.view_from_world;
  result.toward_viewer = dvec3{m[2], m[6], m[10]}.rounded();
  if (result.parallel) {
    const mat4 clip_rows = transpose(result.eyes[0].clip_from_world);
    const vec3 along = normalize(cross(clip_rows.column[0].xyz(), clip_rows.column[1].xyz()));
    result.toward_viewer = dot(along, result.toward_viewer) < 0.0f ? -1.0f * along : along;
  }
  return result;
}

float size_bin_px(std::uint32_t bin) {
  return std::exp2(0.5f * static_cast<float>(bin + 1));
}

void measure_demand(const InstanceBlocks& instances, const LodView& view, std::span<PlantDemand> demands) {
  std::ranges::fill(demands, PlantDemand{});
  add_demand(instances, 0, instances.bounds.size(), view, demands);
}

void add_demand(const InstanceBlocks& instances, std::size_t first_block, std::size_t end_block, const LodView& view,
                std::span<PlantDemand> demands) {
  COPPICE_ASSERT(instances.bounds.size() * kInstanceBlockSlots >= instances.slots.size());
  for (std::size_t i = first_block; i < std::min(end_block, instances.bounds.size()); ++i) {
    const InstanceBounds& block = instances.bounds[i];
    if (block.radius_m < 0.0f || (block.any_layer & view.layer_mask) == 0) continue;
    const std::size_t first = i * kInstanceBlockSlots;
    const auto members = instances.slots.subspan(first, std::min<std::size_t>(kInstanceBlockSlots, instances.slots.size() - first));
    const Side side = side_of(block.center_m, block.radius_m + wind_reach_m(view, block.max_instance_radius_m), view);
    if (side == Side::out && !view.looks_around) continue;
    const bool alike = view.parallel || size_distance_m(view, block.center_m) > kFarRadii * block.radius_m;
    if (side != Side::across && alike)
      count_far_block(members, block, side, view, demands);
    else
      for (const InstanceSphere& instance : members) count_instance(instance, side, view, demands);
  }
}

}  // namespace coppice
