#include "demand.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "check.h"

namespace coppice {

namespace {

/// Distance of the nearer clip plane. Depth 0 and 1 are at b / a and b / (a + 1): which is near depends on the depth direction, and one may
/// be infinitely far.
float near_distance_m(const float* clip_from_view) {
  const float a = clip_from_view[10], b = clip_from_view[14];
  float near_m = INFINITY;
  for (float distance : {b / a, b / (a + 1.0f)})
    if (distance > 0.0f && distance < near_m) near_m = distance;
  return near_m;
}

vec3 eye_of(const mat4& view_from_world) {
  const auto& [x, y, z, moved] = view_from_world.column;
  return -1.0f * vec3(dot(x.xyz(), moved.xyz()), dot(y.xyz(), moved.xyz()), dot(z.xyz(), moved.xyz()));
}

enum class Side : std::uint8_t { in, across, out };

/// On which side of the view's planes a sphere lies.
Side side_of(const vec3& center_m, float radius_m, const LodView& view) {
  float nearest_m = INFINITY;
  for (const vec4& plane : view.planes) nearest_m = std::min(nearest_m, dot(plane.xyz(), center_m) + plane.w);
  if (nearest_m < -radius_m) return Side::out;
  return nearest_m < radius_m ? Side::across : Side::in;
}

/// floor(2 log2(size)), off the bits of a float: the exponent, and whether the mantissa is above that of the root of 2.
std::uint32_t bin_of(float size_px) {
  if (!(size_px > 1.0f)) return 0;
  constexpr std::uint32_t kMantissaBits = 23, kExponentBias = 127, kMantissa = (1u << kMantissaBits) - 1;
  const auto bits = std::bit_cast<std::uint32_t>(size_px);
  const std::uint32_t half = (bits & kMantissa) >= (std::bit_cast<std::uint32_t>(1.41421356f) & kMantissa) ? 1 : 0;
  return std::min(2 * ((bits >> kMantissaBits) - kExponentBias) + half, kSizeBinCount - 1);
}

/// How much of its size an instance on this side counts as, and how much it weighs.
float size_share(Side side) {
  return side == Side::out ? 0.5f : 1.0f;
}
float weight_of(Side side) {
  return side == Side::out ? kOutsideWeight : 1.0f;
}

void count_instance(const InstanceSphere& instance, const LodView& view, std::span<PlantDemand> demands) {
  if (instance.plant == InstanceSphere::kNoPlant) return;
  COPPICE_ASSERT(instance.plant < demands.size());
  const Side side = side_of(instance.center_m, instance.radius_m, view);
  if (side == Side::out && !view.looks_around) return;
  const float size_px = size_share(side) * lod::coppice_projected_size_px(distance(instance.center_m, view.eye_m), instance.radius_m,
                                                                          view.near_m, view.focal_px);
  PlantDemand& demand = demands[instance.plant];
  demand.max_size_px = std::max(demand.max_size_px, size_px);
  demand.instances[bin_of(size_px)] += weight_of(side);
}

/// A block counts as a whole from this many of its radii on: sizes within it then differ by less than a bin.
constexpr float kFarRadii = 8.0f;

void count_far_block(std::span<const InstanceSphere> members, const InstanceBounds& block, Side side, const LodView& view,
                     std::span<PlantDemand> demands) {
  const float block_m = distance(block.center_m, view.eye_m);
  const auto count = [&](std::uint32_t plant, float mean_radius_m, float max_radius_m, std::uint32_t instance_count) {
    COPPICE_ASSERT(plant < demands.size());
    const auto size_px = [&](float radius_m, float at_m) {
      return size_share(side) * lod::coppice_projected_size_px(at_m, radius_m, view.near_m, view.focal_px);
    };
    PlantDemand& demand = demands[plant];
    demand.max_size_px = std::max(demand.max_size_px, size_px(max_radius_m, block_m - block.radius_m + max_radius_m));
    demand.instances[bin_of(size_px(mean_radius_m, block_m))] += weight_of(side) * static_cast<float>(instance_count);
  };
  if (block.plant != InstanceBounds::kMixedPlants)
    return count(block.plant, block.mean_instance_radius_m, block.max_instance_radius_m, block.instance_count);
  for (const InstanceSphere& instance : members)
    if (instance.plant != InstanceSphere::kNoPlant) count(instance.plant, instance.radius_m, instance.radius_m, 1);
}

}  // namespace

Result<LodView> demand_view(const coppice_camera& view) {
  const bool finite = std::ranges::all_of(view.view_from_world, [](float x) { return std::isfinite(x); }) &&
                      std::ranges::all_of(view.clip_from_view, [](float x) { return std::isfinite(x); });
  if (!finite) return Error{Status::invalid_argument, "view: a matrix is not finite"};
  if (!(view.clip_from_view[11] < 0.0f) || view.clip_from_view[15] != 0.0f)
    return Error{Status::invalid_argument, "view: clip_from_view is not a perspective projection looking down -z"};
  if (!(view.error_px > 0.0f) || !std::isfinite(view.error_px)) return Error{Status::invalid_argument, "view: error_px must be > 0"};
  LodView result;
  result.eye_m = eye_of(mat4(view.view_from_world));
  result.focal_px = 0.5f * static_cast<float>(view.height_px) * std::abs(view.clip_from_view[5]);
  result.near_m = near_distance_m(view.clip_from_view);
  result.error_px = view.error_px;
  result.full = view.lod == COPPICE_LOD_FULL;
  result.discrete = view.lod == COPPICE_LOD_DISCRETE;
  if (!(result.focal_px > 0.0f) || !std::isfinite(result.near_m))
    return Error{Status::invalid_argument, "view: clip_from_view has no height or no near plane"};
  result.clip_from_world = mat4(view.clip_from_view) * mat4(view.view_from_world);
  result.planes = frustum_planes(result.clip_from_world);
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
    if (block.radius_m < 0.0f) continue;
    const std::size_t first = i * kInstanceBlockSlots;
    const auto members = instances.slots.subspan(first, std::min<std::size_t>(kInstanceBlockSlots, instances.slots.size() - first));
    const Side side = side_of(block.center_m, block.radius_m, view);
    if (side == Side::out && !view.looks_around) continue;
    if (side != Side::across && distance(block.center_m, view.eye_m) > kFarRadii * block.radius_m)
      count_far_block(members, block, side, view, demands);
    else
      for (const InstanceSphere& instance : members) count_instance(instance, view, demands);
  }
}

}  // namespace coppice
