#pragma once

// Leaves out nodes that show a plant once more, or are no part of its look: levels, billboards, collision shapes. The rules are in
// gltf_variants.h.

#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "gltf_nodes.h"
#include "source_contents.h"

namespace coppice::bake {

/// The items that are left out so far: why, and the position of the node that says so.
struct LeftOut {
  std::vector<LeftReason> reason;  ///< [items] none: the item is taken
  std::vector<std::uint32_t> by;   ///< [items]
};

std::vector<std::uint32_t> taken_items(const LeftOut& left);

/// The model's nodes that any node's MSFT_lod names as coarser.
std::set<std::uint32_t> msft_coarser_nodes(const tinygltf::Model& model);

/// Each of these leaves out what its rule finds among the taken items, but never all of them.
void leave_collision_shapes(const GltfNodes& scene, LeftOut& left);
void leave_coarser_levels(const tinygltf::Model& model, const GltfNodes& scene, LeftOut& left);
void leave_named_billboards(const GltfNodes& scene, LeftOut& left);

/// Whether a material, which may be kNone, has holes or is blended.
bool is_masked(const tinygltf::Model& model, std::uint32_t material);

/// Whether an item is a few large masked triangles: a billboard by its shape, if a plant stands in the same place.
bool is_billboard_shaped(const tinygltf::Model& model, const NodeItem& item);
/// Leaves out those of `items`, which are one plant, that are billboard-shaped, if the rest is as large and has leaves of its own.
void leave_shaped_billboards(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items, LeftOut& left);

}  // namespace coppice::bake
