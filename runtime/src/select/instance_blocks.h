#pragma once

// Instances in blocks of consecutive slots: what is true of a whole block, far away or out of view, costs one test and not one an instance.

#include <array>
#include <cstdint>
#include <span>

#include "select.h"

namespace coppice {

/// Slots of a block; the GPU culls the same ones.
inline constexpr std::uint32_t kInstanceBlockSlots = 32;

/// What is known of a block's instances together.
struct InstanceBounds {
  dvec3 center_m{0, 0, 0};  ///< of a sphere round all of their spheres, world space
  float radius_m = -1.0f;   ///< of it; negative: no instance
  float max_instance_radius_m = 0.0f;
  // Larger for instances that want a lower threshold: what demand takes for their size.
  float max_wanted_radius_m = 0.0f;
  float mean_wanted_radius_m = 0.0f;
  std::uint32_t all_layers = 0xffffffffu, any_layer = 0;  ///< bits that all instances have, and that some have
  std::uint32_t instance_count = 0;
  std::uint32_t plant = kMixedPlants;  ///< of all instances, if they are of one

  static constexpr std::uint32_t kMixedPlants = 0xfffffffeu;
};

/// The radius of one with the view's own threshold that wants about as much.
inline float wanted_radius_m(const InstanceSphere& sphere) {
  return sphere.radius_m / sphere.threshold_share;
}

/// slots  of one block; holes are skipped
InstanceBounds instance_bounds(std::span<const InstanceSphere> slots);

/// Instances and their blocks: blocks[i] bounds slots [i, i + 1) * kInstanceBlockSlots, the last block may be shorter.
struct InstanceBlocks {
  std::span<const InstanceSphere> slots;
  std::span<const InstanceBounds> bounds;
};

}  // namespace coppice
