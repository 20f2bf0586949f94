#include "demand.h"

#include <algorithm>
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

bool in_view(const InstanceSphere& instance, const DemandView& view) {
  return std::ranges::all_of(view.planes, [&](const Row& plane) {
    return plane[0] * instance.center_m[0] + plane[1] * instance.center_m[1] + plane[2] * instance.center_m[2] + plane[3] >=
           -instance.radius_m;
  });
}

std::uint32_t bin_of(float size_px) {
  if (!(size_px > 1.0f)) return 0;
  return std::min(static_cast<std::uint32_t>(2.0f * std::log2(size_px)), kSizeBinCount - 1);
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

void measure_demand(std::span<const InstanceSphere> instances, const DemandView& view, std::span<PlantDemand> demands) {
  std::ranges::fill(demands, PlantDemand{});
  const LodView& camera = view.lod;
  for (const InstanceSphere& instance : instances) {
    if (instance.plant == InstanceSphere::kNoPlant) continue;
    COPPICE_ASSERT(instance.plant < demands.size());
    const float x = instance.center_m[0] - camera.eye_m[0], y = instance.center_m[1] - camera.eye_m[1],
                z = instance.center_m[2] - camera.eye_m[2];
    float size_px = lod::coppice_projected_size_px(std::sqrt(x * x + y * y + z * z), instance.radius_m, camera.near_m, camera.focal_px);
    float weight = 1.0f;
    if (!in_view(instance, view)) {
      size_px *= 0.5f;
      weight = kOutsideWeight;
    }
    PlantDemand& demand = demands[instance.plant];
    demand.max_size_px = std::max(demand.max_size_px, size_px);
    demand.instances[bin_of(size_px)] += weight;
  }
}

}  // namespace coppice
