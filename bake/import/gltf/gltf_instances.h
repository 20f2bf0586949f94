#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>

#include "plant.h"
#include "result.h"

namespace tinygltf {
class Model;
class Node;
}  // namespace tinygltf

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

/// [nodes] The transforms of all nodes, also of those outside the scene. model  from load_gltf, or about to be posed by it
std::vector<glm::dmat4> file_from_nodes(const tinygltf::Model& model);

/// Whether KHR_node_visibility hides the node, and with it all that is below.
bool hides(const tinygltf::Node& node);

/// Lists the meshes of scene_nodes, in their order, but for those that a scale of 0 hides. Skinned meshes stand in the file's world space
/// (gltf_pose.h).
/// model            from load_gltf
/// scene_from_file  the transform above the root nodes: the file's axes and unit
/// errors  bad_file: a transform that is not finite, or instances that are not transforms, naming the node
Result<std::vector<MeshInstance>> mesh_instances(const tinygltf::Model& model, const glm::dmat4& scene_from_file);

}  // namespace coppice::bake
