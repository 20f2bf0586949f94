#include "instance_blocks.h"

#include <algorithm>
#include <cmath>

namespace coppice {

InstanceBounds instance_bounds(std::span<const InstanceSphere> slots) {
  InstanceBounds bounds;
  vec3 low(INFINITY), high(-INFINITY);
  float radius_sum_m = 0.0f;
  for (const InstanceSphere& sphere : slots) {
    if (sphere.plant == InstanceSphere::kNoPlant) continue;
    low = min(low, sphere.center_m - vec3(sphere.radius_m));
    high = max(high, sphere.center_m + vec3(sphere.radius_m));
    bounds.max_instance_radius_m = std::max(bounds.max_instance_radius_m, sphere.radius_m);
    radius_sum_m += sphere.radius_m;
    const bool same = bounds.instance_count == 0 || bounds.plant == sphere.plant;
    bounds.plant = same ? sphere.plant : InstanceBounds::kMixedPlants;
    ++bounds.instance_count;
  }
  if (bounds.instance_count == 0) return bounds;
  bounds.mean_instance_radius_m = radius_sum_m / static_cast<float>(bounds.instance_count);
  bounds.center_m = 0.5f * (low + high);
  for (const InstanceSphere& sphere : slots)
    if (sphere.plant != InstanceSphere::kNoPlant)
      bounds.radius_m = std::max(bounds.radius_m, distance(sphere.center_m, bounds.center_m) + sphere.radius_m);
  return bounds;
}

}  // namespace coppice
