#pragma once

// Several plants in one file, told from the parts of one. The rules are in gltf_variants.h.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gltf_nodes.h"

namespace coppice::bake {

/// Items that are one plant, or a part of one.
struct NodeGroup {
  std::string name;                  ///< of the node above them, or what their names begin with
  std::vector<std::uint32_t> items;  ///< ascending
  NodeBox box;
};

/// The plants that `items` are, in the order of their first items; one if they cannot be told apart. Ground under several plants is in
/// none.
std::vector<NodeGroup> split_variants(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items);

}  // namespace coppice::bake
