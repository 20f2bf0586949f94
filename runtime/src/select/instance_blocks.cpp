#include "instance_blocks.h"

#include <algorithm>
#include <cmath>

namespace coppice {

InstanceBounds instance_bounds(std::span<const InstanceSphere> slots) {
  InstanceBounds bounds;
  dvec3 low(INFINITY, INFINITY, INFINITY), high(-INFINITY, -INFINITY, -INFINITY);
  float radius_sum_m = 0.0f;
  for (const InstanceSphere& sphere : slots) {
    if (sphere.plant == InstanceSphere::kNoPlant) continue;
    const double radius_m = sphere.radius_m;
    low = min(low, sphere.center_m - dvec3(radius_m, radius_m, radius_m));
    high = max(high, sphere.center_m + dvec3(radius_m, radius_m, radius_m));
    bounds.max_instance_radius_m = std::max(bounds.max_instance_radius_m, sphere.radius_m);
    bounds.max_demand_radius_m = std::max(bounds.max_demand_radius_m, demand_radius_m(sphere));
    radius_sum_m += demand_radius_m(sphere);
    bounds.all_layers &= sphere.layer_mask;
    bounds.any_layer |= sphere.layer_mask;
    const bool same = bounds.instance_count == 0 || bounds.plant == sphere.plant;
    bounds.plant = same ? sphere.plant : InstanceBounds::kMixedPlants;
    ++bounds.instance_count;
  }
  if (bounds.instance_count == 0) return bounds;
  bounds.mean_demand_radius_m = radius_sum_m / static_cast<float>(bounds.instance_count);
  bounds.center_m = (low + high) * 0.5;
  for (const InstanceSphere& sphere : slots)
    if (sphere.plant != InstanceSphere::kNoPlant)
      bounds.radius_m = std::max(bounds.radius_m, length((sphere.center_m - bounds.center_m).rounded()) + sphere.radius_m);
  return bounds;
}

}  // namespace coppice
