#include "instance_blocks.h"

#include <algorithm>
#include <cmath>

namespace coppice {

InstanceBounds instance_bounds(std::span<const InstanceSphere> slots) {
  InstanceBounds bounds;
  std::array<float, 3> low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  float radius_sum_m = 0.0f;
  for (const InstanceSphere& sphere : slots) {
    if (sphere.plant == InstanceSphere::kNoPlant) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], sphere.center_m[axis] - sphere.radius_m);
      high[axis] = std::max(high[axis], sphere.center_m[axis] + sphere.radius_m);
    }
    bounds.max_instance_radius_m = std::max(bounds.max_instance_radius_m, sphere.radius_m);
    radius_sum_m += sphere.radius_m;
    const bool same = bounds.instance_count == 0 || bounds.plant == sphere.plant;
    bounds.plant = same ? sphere.plant : InstanceBounds::kMixedPlants;
    ++bounds.instance_count;
  }
  if (bounds.instance_count == 0) return bounds;
  bounds.mean_instance_radius_m = radius_sum_m / static_cast<float>(bounds.instance_count);
  for (std::size_t axis = 0; axis < 3; ++axis) bounds.center_m[axis] = 0.5f * (low[axis] + high[axis]);
  for (const InstanceSphere& sphere : slots) {
    if (sphere.plant == InstanceSphere::kNoPlant) continue;
    const float x = sphere.center_m[0] - bounds.center_m[0], y = sphere.center_m[1] - bounds.center_m[1],
                z = sphere.center_m[2] - bounds.center_m[2];
    bounds.radius_m = std::max(bounds.radius_m, std::sqrt(x * x + y * y + z * z) + sphere.radius_m);
  }
  return bounds;
}

}  // namespace coppice
