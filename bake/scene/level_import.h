#pragma once

// Reads the plants of a glTF scene: nodes whose names are those of baked plants, with a mesh or with parts below them, instanced with
// EXT_mesh_gpu_instancing or placed one by one.

#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "import_gltf.h"
#include "result.h"
#include "scene_write.h"

namespace coppice::bake {

/// Meshes of a level that become no plants.
struct LeftMeshes {
  std::map<std::string, std::size_t> names;  ///< how often each stands there
  [[nodiscard]] std::size_t count() const;
};

struct LevelPlants {
  std::vector<ScenePlant> plants;
  LeftMeshes missing;               ///< instanced meshes that match no species
  LeftMeshes other;                 ///< meshes that are neither a species' nor instanced: ground, rocks
  LeftMeshes coarser;               ///< coarser levels, billboards and collision shapes of a plant that stands in the same place
  LeftMeshes hidden;                ///< meshes that KHR_node_visibility hides
  std::size_t tilted_count = 0;     ///< plants that lean by more than 3 degrees; the scene has them upright
  std::size_t stretched_count = 0;  ///< plants whose scales along their axes differ by more than 2 %; they get the mean
};

/// Reads a level. A node with a plant's name is that plant, with all that is below it; only a node without a mesh that holds such nodes in
/// several places is a group of plants.
/// species  names as from species_name; a plant's species is its index
/// options  axes and unit of the file
/// errors   as load_gltf and mesh_instances
Result<LevelPlants> import_level(const std::filesystem::path& path, std::span<const std::string> species, const ImportOptions& options);

/// The name of a plant's file: "oak" for "trees/Oak.coppice". Names of nodes and meshes are compared with it in lower case, first as they
/// are and then without what editors append: "Oak.001", "oak_LOD0", "Oak (1)", "Oak(Clone)", "SM_Oak_12"; at last by their words alone.
/// Among several levels in one place the finest is a plant; a level that stands alone is one too.
std::string species_name(const std::filesystem::path& plant);

}  // namespace coppice::bake
