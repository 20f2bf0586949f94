#include "gltf_scene.h"

#include <cmath>
#include <string>

#include <tiny_gltf.h>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

namespace coppice::bake {
namespace {

glm::dvec3 vector_or(const std::vector<double>& values, double fallback) {
  return values.size() == 3 ? glm::dvec3(values[0], values[1], values[2]) : glm::dvec3(fallback);
}

glm::dmat4 local_transform(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) return glm::make_mat4(node.matrix.data());
  glm::dmat4 transform(1.0);
  if (node.rotation.size() == 4) {
    const glm::dquat rotation(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    // Exporters round; a quaternion of length zero turns nothing.
    if (glm::dot(rotation, rotation) > 0.0) transform = glm::mat4_cast(glm::normalize(rotation));
  }
  const glm::dvec3 scale = vector_or(node.scale, 1.0);
  for (int axis = 0; axis < 3; ++axis) transform[axis] *= scale[axis];
  transform[3] = glm::dvec4(vector_or(node.translation, 0.0), 1.0);
  return transform;
}

std::vector<int> root_nodes(const tinygltf::Model& model) {
  if (!model.scenes.empty()) return model.scenes.at(static_cast<std::size_t>(std::max(model.defaultScene, 0))).nodes;
  std::vector<bool> is_child(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes)
    for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
  std::vector<int> roots;
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  return roots;
}

bool is_finite(const glm::dmat4& transform) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      if (!std::isfinite(transform[column][row])) return false;
  return true;
}

}  // namespace

Result<std::vector<MeshInstance>> mesh_instances(const tinygltf::Model& model) {
  struct Visit {
    int node;
    glm::dmat4 scene_from_parent;
  };
  std::vector<Visit> stack;
  const std::vector<int> roots = root_nodes(model);
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, glm::dmat4(1.0)});

  std::vector<MeshInstance> instances;
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const tinygltf::Node& node = model.nodes.at(static_cast<std::size_t>(visit.node));
    const glm::dmat4 scene_from_node = visit.scene_from_parent * local_transform(node);
    if (!is_finite(scene_from_node))
      return Error{Status::bad_file, "node transform is not finite", Error::kNoOffset, "nodes[" + std::to_string(visit.node) + "]"};
    if (node.mesh >= 0)
      instances.push_back({static_cast<std::uint32_t>(visit.node), static_cast<std::uint32_t>(node.mesh), scene_from_node});
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) stack.push_back({*child, scene_from_node});
  }
  return instances;
}

}  // namespace coppice::bake
