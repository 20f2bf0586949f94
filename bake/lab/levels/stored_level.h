#pragma once

// What is left of a plant's finest level once it has been through a file.

#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// The finest level that a .coppice file of the plant holds: leaf meshes, or where it has none, all quads; positions quantised, images as
/// their textures show them.
struct StoredLevel {
  Mesh mesh;
  std::vector<Material> materials;
  std::vector<Image> images;
  bool is_leaf_meshes = false;
};

/// Packs plant and quads with the default options, under a collapse in leaf order, which the finest level does not show, and unpacks them.
/// errors  those of pack and unpack
Result<StoredLevel> stored_finest_level(const Plant& plant, const Foliage& foliage);

}  // namespace coppice::bake
