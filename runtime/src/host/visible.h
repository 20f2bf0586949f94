#pragma once

// Finds the instances that a view sees, first by blocks and then one by one, as the shaders do.

#include <algorithm>
#include <cstddef>

#include "instance_blocks.h"
#include "select.h"

namespace coppice {

/// Calls take(slot), in order, for each instance of the view's layers whose sphere, enlarged by the motion of wind, reaches into the view.
template <class Take>
void for_each_visible(const InstanceBlocks& instances, const LodView& view, const Take& take) {
  for (std::size_t block = 0; block < instances.bounds.size(); ++block) {
    const InstanceBounds& bounds = instances.bounds[block];
    if (bounds.radius_m < 0.0f || (bounds.any_layer & view.layer_mask) == 0) continue;
    const float block_depth_m = depth_in_view(view, bounds.center_m);
    const float block_reach_m = bounds.radius_m + wind_reach_m(view, bounds.max_instance_radius_m);
    if (block_depth_m < -block_reach_m) continue;
    const bool whole = block_depth_m >= block_reach_m;
    const std::size_t first = block * kInstanceBlockSlots, end = std::min(first + kInstanceBlockSlots, instances.slots.size());
    for (std::size_t slot = first; slot < end; ++slot) {
      const InstanceSphere& sphere = instances.slots[slot];
      if (sphere.plant == InstanceSphere::kNoPlant || (sphere.layer_mask & view.layer_mask) == 0) continue;
      const float reach_m = sphere.radius_m + wind_reach_m(view, sphere.radius_m);
      if (whole || depth_in_view(view, sphere.center_m) >= -reach_m) take(static_cast<std::uint32_t>(slot));
    }
  }
}

}  // namespace coppice
