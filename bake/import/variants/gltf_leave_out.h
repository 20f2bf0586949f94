#pragma once

// What of a file shows a plant once more, coarser or not at all: levels, billboards, shapes to collide with. The rules are in
// gltf_variants.h.

#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "gltf_nodes.h"
#include "source_contents.h"

namespace coppice::bake {

/// What is left out so far: of each item why, and the position of the node that says so.
struct LeftOut {
  std::vector<LeftReason> reason;  ///< [items] none: it is taken
  std::vector<std::uint32_t> by;   ///< [items]
};

/// Indices of the items that are taken.
std::vector<std::uint32_t> taken_items(const LeftOut& left);

/// The model's nodes that MSFT_lod of any other names as coarser.
std::set<std::uint32_t> msft_coarser_nodes(const tinygltf::Model& model);

/// Each leaves out what its rule finds among what is taken, and never all of it.
void leave_collision_shapes(const GltfNodes& scene, LeftOut& left);
void leave_coarser_levels(const tinygltf::Model& model, const GltfNodes& scene, LeftOut& left);
void leave_named_billboards(const GltfNodes& scene, LeftOut& left);

/// Whether a material, which may be kNone, has holes or is blended.
bool is_masked(const tinygltf::Model& model, std::uint32_t material);

/// Whether an item is a few large masked triangles: a billboard by its shape, if a plant stands where it does.
bool is_billboard_shaped(const tinygltf::Model& model, const NodeItem& item);
/// Of `items`, which are one plant, leaves out those that is_billboard_shaped if the rest is as large as they are and has leaves of its
/// own.
void leave_shaped_billboards(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items, LeftOut& left);

}  // namespace coppice::bake
