#pragma once

// Tells a level, in which like plants stand again and again, from one plant.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gltf_nodes.h"

namespace coppice::bake {

/// Plants that a file holds several times.
struct PlantCopies {
  std::string name;                        ///< the first node's
  std::size_t count = 0;                   ///< all copies of all plants that have any
  std::vector<std::uint32_t> other_items;  ///< items of the copies but the first of each plant, ascending
};

/// Finds whether some of `items` are copies of whole plants: at least three nodes show the same meshes, as instances too, stand upright and
/// mostly apart, and are as large as plants. A plant's own twigs, stems and leaves are close together, turned, small, or a few triangles.
std::optional<PlantCopies> find_copies(const GltfNodes& scene, std::span<const std::uint32_t> items);

}  // namespace coppice::bake
