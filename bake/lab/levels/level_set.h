#pragma once

// Levels that another tool wrote: anybody's simplifier can be measured like ours.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "level.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// A folder of glTF files, one per level, named after its fraction: 0.8.glb, 0.025.glb (or .gltf). Where it has folders instead, each holds
/// such files: the levels under one choice of the tool's parameters, named like the folder.
struct LevelSet {
  std::string name;  ///< in reports
  std::filesystem::path folder;
};

/// "0.8", "0.025": how files of a level are named.
std::string level_file_name(double fraction);

/// A level as a file gives it: all triangles of its scene, whatever their material.
struct ForeignLevel {
  std::string parameters;  ///< name of the folder that it was in; empty where the set has none
  Level level;
  std::vector<Material> materials;
  std::vector<Image> images;
};

/// By fraction all of its files, in the order of their folders' names.
/// errors  invalid_argument: a folder has no file for a level (both are named); those of import_gltf
Result<std::vector<std::vector<ForeignLevel>>> read_level_set(const LevelSet& set, std::span<const double> fractions);

}  // namespace coppice::bake
