#pragma once

// Levels that another tool wrote, so that anybody's simplifier can be measured like ours; and how a plant's finest level changes when it
// goes through a .coppice file.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "level.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// A folder of glTF files, one per level, named after its fraction: 0.8.glb, 0.025.glb (or .gltf). If it has folders instead, each holds
/// such files: the levels for one choice of the tool's parameters, named like the folder.
struct LevelSet {
  std::string name;  ///< the name in reports
  std::filesystem::path folder;
};

/// The name of a level's file: "0.8", "0.025".
std::string level_file_name(double fraction);

/// A level from a file: all triangles of its scene, whatever their material. They are lit by NORMAL and _SPREAD as `coppice export` writes
/// them; without _SPREAD as they lie.
struct ForeignLevel {
  std::string parameters;  ///< the name of its folder; empty if the set has no folders
  Level level;
  std::vector<Material> materials;
  std::vector<Image> images;
};

/// [fraction] Reads all files of a level, in the order of their folders' names.
/// errors  invalid_argument: a folder has no file for a level (both are named); those of import_gltf
Result<std::vector<std::vector<ForeignLevel>>> read_level_set(const LevelSet& set, std::span<const double> fractions);

/// The finest level that a .coppice file of the plant holds: leaf meshes, or else all quads. Positions are quantised, images are as their
/// textures show them.
struct StoredLevel {
  Level level;
  std::vector<Material> materials;
  std::vector<Image> images;
  bool is_leaf_meshes = false;
};

/// Packs plant and quads with default options and unpacks them. The collapse is in leaf order, which does not affect the finest level.
/// errors  those of pack and unpack
Result<StoredLevel> stored_finest_level(const Plant& plant, const Foliage& foliage);

}  // namespace coppice::bake
