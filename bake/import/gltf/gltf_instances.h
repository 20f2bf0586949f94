#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>

#include "plant.h"
#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

/// A mesh as a node places it; with EXT_mesh_gpu_instancing a node places it many times.
struct MeshInstance {
  std::uint32_t node = 0;
  std::uint32_t mesh = 0;
  glm::dmat4 scene_from_mesh{1.0};
};

/// A node of the default scene, and its parent's place in the list.
struct SceneNode {
  std::uint32_t node = 0;
  std::uint32_t parent = kNone;  ///< kNone for a root
};

/// Lists the nodes of the default scene, else of the first, else (without scenes) all nodes; depth-first, parents before children.
/// model  from load_gltf: its nodes are trees
std::vector<SceneNode> scene_nodes(const tinygltf::Model& model);

/// [meshes] How often each mesh stands in the default scene, read from the document alone: nothing is allocated for an instance.
/// errors  unsupported: more than 2^22 instances, naming the node
Result<std::vector<std::uint64_t>> mesh_instance_counts(const tinygltf::Model& model);

/// Lists the meshes of scene_nodes, in their order.
/// model            from load_gltf
/// scene_from_file  the transform above the root nodes: the file's axes and unit
/// errors  bad_file: a transform that is not finite, or instances that are not transforms, naming the node; unsupported: more than 2^22
Result<std::vector<MeshInstance>> mesh_instances(const tinygltf::Model& model, const glm::dmat4& scene_from_file);

}  // namespace coppice::bake
