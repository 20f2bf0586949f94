#pragma once

// Decides whether a file's nodes are several plants or the parts of one. The rules are in gltf_variants.h.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gltf_nodes.h"

namespace coppice::bake {

/// Items that are one plant, or a part of one.
struct NodeGroup {
  std::string name;                  ///< the node's above them, or the beginning that their names share
  std::vector<std::uint32_t> items;  ///< ascending
  NodeBox box;
};

/// Finds the plants that `items` are, in the order of their first items; one if they cannot be separated. Ground under several plants is in
/// none.
std::vector<NodeGroup> split_variants(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items);

}  // namespace coppice::bake
