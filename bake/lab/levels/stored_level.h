#pragma once

// Shows how a plant's finest level changes when it goes through a file.

#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// The finest level that a .coppice file of the plant holds: leaf meshes, or else all quads. Positions are quantised, images are as their
/// textures show them.
struct StoredLevel {
  Mesh mesh;
  std::vector<Material> materials;
  std::vector<Image> images;
  bool is_leaf_meshes = false;
};

/// Packs plant and quads with default options and unpacks them. The collapse is in leaf order, which does not affect the finest level.
/// errors  those of pack and unpack
Result<StoredLevel> stored_finest_level(const Plant& plant, const Foliage& foliage);

}  // namespace coppice::bake
