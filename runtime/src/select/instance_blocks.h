#pragma once

// Instances in blocks of consecutive slots. A test of a whole block, such as far away or out of view, costs as much as a test of one
// instance.

#include <array>
#include <cstdint>
#include <span>

#include "select.h"

namespace coppice {

/// Slots in a block; the GPU culls the same blocks.
inline constexpr std::uint32_t kInstanceBlockSlots = 32;

/// Bounds of a block's instances.
struct InstanceBounds {
  dvec3 center_m{0, 0, 0};  ///< centre of a sphere around all of their spheres, world space
  float radius_m = -1.0f;   ///< its radius; negative: no instance
  float max_instance_radius_m = 0.0f;
  // Counts instances with a lower threshold as larger; demand uses it as their size.
  float max_demand_radius_m = 0.0f;
  float mean_demand_radius_m = 0.0f;
  std::uint32_t all_layers = 0xffffffffu, any_layer = 0;  ///< bits that all instances have, and bits that some have
  std::uint32_t instance_count = 0;
  std::uint32_t plant = kMixedPlants;  ///< the plant of all instances, if they share one

  static constexpr std::uint32_t kMixedPlants = 0xfffffffeu;
};

/// The radius of an instance with the view's own threshold that has about the same demand.
inline float demand_radius_m(const InstanceSphere& sphere) {
  return sphere.radius_m / sphere.threshold_share;
}

/// slots  of one block; empty ones are skipped
InstanceBounds instance_bounds(std::span<const InstanceSphere> slots);

/// Instances and their blocks: blocks[i] bounds slots [i, i + 1) * kInstanceBlockSlots, the last block may be shorter.
struct InstanceBlocks {
  std::span<const InstanceSphere> slots;
  std::span<const InstanceBounds> bounds;
};

}  // namespace coppice
