#pragma once

// Reads the plants of a glTF scene: nodes whose names are those of baked plants, instanced with EXT_mesh_gpu_instancing or placed one by
// one.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "import_gltf.h"
#include "result.h"
#include "scene_write.h"

namespace coppice::bake {

struct LevelPlants {
  std::vector<ScenePlant> plants;
  std::vector<std::string> missing;  ///< names of instanced meshes that match no species, sorted, with their number of instances
  std::size_t missing_count = 0;     ///< number of these instances
  std::size_t other_count = 0;       ///< meshes that are neither a species' nor instanced: ground, rocks
  std::size_t coarser_count = 0;     ///< coarser levels, billboards and collision shapes of a plant that stands in the same place
  std::size_t tilted_count = 0;      ///< plants that lean by more than 3 degrees; the scene has them upright
  std::size_t stretched_count = 0;   ///< plants whose scales along their axes differ by more than 2 %; they get the mean
};

/// Reads a level.
/// species  names as from species_name; a plant's species is its index
/// options  axes and unit of the file
/// errors   as load_gltf and mesh_instances
Result<LevelPlants> import_level(const std::filesystem::path& path, std::span<const std::string> species, const ImportOptions& options);

/// The name of a plant's file: "oak" for "trees/Oak.coppice". Names of nodes and meshes are compared with it in lower case, first as they
/// are and then without what editors append: "Oak.001", "oak_LOD0". Among several levels in one place the finest is a plant; a level that
/// stands alone is one too.
std::string species_name(const std::filesystem::path& plant);

}  // namespace coppice::bake
