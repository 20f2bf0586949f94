#include "demand.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "check.h"

namespace coppice {

namespace {

using Row = std::array<float, 4>;
using Matrix = std::array<float, 16>;  // column-major

/// Row `i` of a * b.
Row product_row(const float* a, const float* b, std::size_t i) {
  Row row{};
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t k = 0; k < 4; ++k) row[column] += a[4 * k + i] * b[4 * column + k];
  return row;
}

/// The plane row3 + sign * row, unit normal.
Row side_plane(const Row& w, const Row& row, float sign) {
  Row plane{};
  for (std::size_t i = 0; i < 4; ++i) plane[i] = w[i] + sign * row[i];
  const float length = std::sqrt(plane[0] * plane[0] + plane[1] * plane[1] + plane[2] * plane[2]);
  for (float& value : plane) value /= length;
  return plane;
}

/// Distance of the nearer clip plane. Depth 0 and 1 are at b / a and b / (a + 1): which is near depends on the depth direction, and one may
/// be infinitely far.
float near_distance_m(const float* clip_from_view) {
  const float a = clip_from_view[10], b = clip_from_view[14];
  float near_m = INFINITY;
  for (float distance : {b / a, b / (a + 1.0f)})
    if (distance > 0.0f && distance < near_m) near_m = distance;
  return near_m;
}

std::array<float, 3> eye_of(const float* view_from_world) {
  std::array<float, 3> eye{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < 3; ++i) eye[axis] -= view_from_world[4 * axis + i] * view_from_world[12 + i];
  return eye;
}

enum class Side : std::uint8_t { in, across, out };

/// On which side of the view's planes a sphere lies.
Side side_of(const std::array<float, 3>& center_m, float radius_m, const DemandView& view) {
  float nearest_m = INFINITY;
  for (const Row& plane : view.planes)
    nearest_m = std::min(nearest_m, plane[0] * center_m[0] + plane[1] * center_m[1] + plane[2] * center_m[2] + plane[3]);
  if (nearest_m < -radius_m) return Side::out;
  return nearest_m < radius_m ? Side::across : Side::in;
}

float distance_m(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z);
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

void count_instance(const InstanceSphere& instance, const DemandView& view, std::span<PlantDemand> demands) {
  if (instance.plant == InstanceSphere::kNoPlant) return;
  COPPICE_ASSERT(instance.plant < demands.size());
  const LodView& camera = view.lod;
  const Side side = side_of(instance.center_m, instance.radius_m, view);
  const float size_px = size_share(side) * lod::coppice_projected_size_px(distance_m(instance.center_m, camera.eye_m), instance.radius_m,
                                                                          camera.near_m, camera.focal_px);
  PlantDemand& demand = demands[instance.plant];
  demand.max_size_px = std::max(demand.max_size_px, size_px);
  demand.instances[bin_of(size_px)] += weight_of(side);
}

/// A block counts as a whole from this many of its radii on: sizes within it then differ by less than a bin.
constexpr float kFarRadii = 8.0f;

void count_far_block(std::span<const InstanceSphere> members, const InstanceBounds& block, Side side, const DemandView& view,
                     std::span<PlantDemand> demands) {
  const LodView& camera = view.lod;
  const float block_m = distance_m(block.center_m, camera.eye_m);
  const auto count = [&](std::uint32_t plant, float mean_radius_m, float max_radius_m, std::uint32_t instance_count) {
    COPPICE_ASSERT(plant < demands.size());
    const auto size_px = [&](float radius_m, float at_m) {
      return size_share(side) * lod::coppice_projected_size_px(at_m, radius_m, camera.near_m, camera.focal_px);
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

Result<DemandView> demand_view(const coppice_view& view) {
  const bool finite = std::ranges::all_of(view.view_from_world, [](float x) { return std::isfinite(x); }) &&
                      std::ranges::all_of(view.clip_from_view, [](float x) { return std::isfinite(x); });
  if (!finite) return Error{Status::invalid_argument, "view: a matrix is not finite"};
  if (!(view.clip_from_view[11] < 0.0f) || view.clip_from_view[15] != 0.0f)
    return Error{Status::invalid_argument, "view: clip_from_view is not a perspective projection looking down -z"};
  if (!(view.error_px > 0.0f) || !std::isfinite(view.error_px)) return Error{Status::invalid_argument, "view: error_px must be > 0"};
  DemandView result;
  result.lod.eye_m = eye_of(view.view_from_world);
  result.lod.focal_px = 0.5f * static_cast<float>(view.height_px) * std::abs(view.clip_from_view[5]);
  result.lod.near_m = near_distance_m(view.clip_from_view);
  result.lod.error_px = view.error_px;
  result.lod.full = view.lod == COPPICE_LOD_FULL;
  result.lod.discrete = view.lod == COPPICE_LOD_DISCRETE;
  if (!(result.lod.focal_px > 0.0f) || !std::isfinite(result.lod.near_m))
    return Error{Status::invalid_argument, "view: clip_from_view has no height or no near plane"};
  const Row x = product_row(view.clip_from_view, view.view_from_world, 0);
  const Row y = product_row(view.clip_from_view, view.view_from_world, 1);
  const Row w = product_row(view.clip_from_view, view.view_from_world, 3);
  result.planes = {side_plane(w, x, 1.0f), side_plane(w, x, -1.0f), side_plane(w, y, 1.0f), side_plane(w, y, -1.0f)};
  return result;
}

float size_bin_px(std::uint32_t bin) {
  return std::exp2(0.5f * static_cast<float>(bin + 1));
}

void measure_demand(const InstanceBlocks& instances, const DemandView& view, std::span<PlantDemand> demands) {
  std::ranges::fill(demands, PlantDemand{});
  add_demand(instances, 0, instances.bounds.size(), view, demands);
}

void add_demand(const InstanceBlocks& instances, std::size_t first_block, std::size_t end_block, const DemandView& view,
                std::span<PlantDemand> demands) {
  COPPICE_ASSERT(instances.bounds.size() * kInstanceBlockSlots >= instances.slots.size());
  for (std::size_t i = first_block; i < std::min(end_block, instances.bounds.size()); ++i) {
    const InstanceBounds& block = instances.bounds[i];
    if (block.radius_m < 0.0f) continue;
    const std::size_t first = i * kInstanceBlockSlots;
    const auto members = instances.slots.subspan(first, std::min<std::size_t>(kInstanceBlockSlots, instances.slots.size() - first));
    const Side side = side_of(block.center_m, block.radius_m, view);
    if (side != Side::across && distance_m(block.center_m, view.lod.eye_m) > kFarRadii * block.radius_m)
      count_far_block(members, block, side, view, demands);
    else
      for (const InstanceSphere& instance : members) count_instance(instance, view, demands);
  }
}

}  // namespace coppice
