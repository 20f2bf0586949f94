#include "gltf_instances.h"

#include <algorithm>
#include <string>
#include <utility>

#include <tiny_gltf.h>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "gltf_accessor.h"
#include "gltf_screen.h"

namespace coppice::bake {
namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

glm::dvec3 vector_or(const std::vector<double>& values, double fallback) {
  return values.size() == 3 ? glm::dvec3(values[0], values[1], values[2]) : glm::dvec3(fallback);
}

glm::dmat4 from_parts(const glm::dvec3& translation, const glm::dquat& rotation, const glm::dvec3& scale) {
  // Exporters round; a quaternion of length zero means no rotation.
  glm::dmat4 transform = glm::dot(rotation, rotation) > 0.0 ? glm::mat4_cast(glm::normalize(rotation)) : glm::dmat4(1.0);
  for (int axis = 0; axis < 3; ++axis) transform[axis] *= scale[axis];
  transform[3] = glm::dvec4(translation, 1.0);
  return transform;
}

glm::dmat4 local_transform(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) return glm::make_mat4(node.matrix.data());
  glm::dquat rotation(0.0, 0.0, 0.0, 0.0);
  if (node.rotation.size() == 4) rotation = glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
  return from_parts(vector_or(node.translation, 0.0), rotation, vector_or(node.scale, 1.0));
}

std::vector<int> nodes_without_parents(const tinygltf::Model& model) {
  std::vector<bool> is_child(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes)
    for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
  std::vector<int> roots;
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  return roots;
}

/// Lists what is below `roots`, depth-first, parents before children.
std::vector<SceneNode> nodes_below(const tinygltf::Model& model, const std::vector<int>& roots) {
  std::vector<SceneNode> nodes, stack;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({static_cast<std::uint32_t>(*root)});
  while (!stack.empty()) {
    const auto position = static_cast<std::uint32_t>(nodes.size());
    nodes.push_back(stack.back());
    stack.pop_back();
    const std::vector<int>& children = model.nodes.at(nodes.back().node).children;
    for (auto child = children.rbegin(); child != children.rend(); ++child) stack.push_back({static_cast<std::uint32_t>(*child), position});
  }
  return nodes;
}

/// glTF: what is scaled to nothing along all axes is not shown; animations hide things so.
bool is_shrunk_away(const glm::dmat4& transform) {
  constexpr double kNothing = 1e-6;
  return glm::length(transform[0]) < kNothing && glm::length(transform[1]) < kNothing && glm::length(transform[2]) < kNothing;
}

bool is_usable(const glm::dmat4& transform) {
  return is_finite(transform[0]) && is_finite(transform[1]) && is_finite(transform[2]) && is_finite(transform[3]);
}

std::string instancing_place(int node) {
  return "nodes[" + std::to_string(node) + "].extensions." + kInstancing;
}

/// How often a node places its mesh. gltf_screen.h has checked that its instances' attributes have equal lengths.
std::size_t instance_count(const tinygltf::Model& model, const tinygltf::Node& node) {
  const auto extension = node.extensions.find(kInstancing);
  if (extension == node.extensions.end()) return 1;
  const tinygltf::Value& attributes = extension->second.Get("attributes");
  const int any = attributes.Get(attributes.Keys().front()).GetNumberAsInt();
  return model.accessors.at(static_cast<std::size_t>(any)).count;
}

/// Reads EXT_mesh_gpu_instancing of a node: one transform an instance.
Result<std::vector<glm::dmat4>> read_instances(const tinygltf::Model& model, const tinygltf::Value& extension, std::size_t count) {
  const tinygltf::Value& attributes = extension.Get("attributes");
  std::vector<glm::vec3> translations(count, glm::vec3(0.0f)), scales(count, glm::vec3(1.0f));
  std::vector<glm::vec4> rotations(count, glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
  const auto read = [&]<class Vector>(const std::string& name, std::vector<Vector>& values) {
    return attributes.Has(name) ? move_into(values, read_vectors<Vector>(model, attributes.Get(name).GetNumberAsInt())) : Result<void>();
  };
  COPPICE_CHECK(read("TRANSLATION", translations));
  COPPICE_CHECK(read("ROTATION", rotations));
  COPPICE_CHECK(read("SCALE", scales));
  std::vector<glm::dmat4> transforms;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec4 r(rotations[i]);
    transforms.push_back(from_parts(glm::dvec3(translations[i]), glm::dquat(r.w, r.x, r.y, r.z), glm::dvec3(scales[i])));
  }
  return transforms;
}

/// Appends a node's mesh, once or for each of its instances.
Result<void> append_node(const tinygltf::Model& model, int node_index, const glm::dmat4& scene_from_node,
                         std::vector<MeshInstance>& instances) {
  const tinygltf::Node& node = model.nodes.at(static_cast<std::size_t>(node_index));
  std::vector<glm::dmat4> transforms{glm::dmat4(1.0)};
  if (const auto extension = node.extensions.find(kInstancing); extension != node.extensions.end()) {
    Result<std::vector<glm::dmat4>> read = read_instances(model, extension->second, instance_count(model, node));
    if (!read) return at_place(instancing_place(node_index), read.error());
    transforms = *std::move(read);
  }
  for (std::size_t i = 0; i < transforms.size(); ++i) {
    const glm::dmat4 scene_from_mesh = scene_from_node * transforms[i];
    if (!is_usable(scene_from_mesh))
      return Error{Status::bad_file, "instance transform is not finite", Error::kNoOffset,
                   instancing_place(node_index) + " instance " + std::to_string(i)};
    if (is_shrunk_away(scene_from_mesh)) continue;
    instances.push_back({static_cast<std::uint32_t>(node_index), static_cast<std::uint32_t>(node.mesh), scene_from_mesh});
  }
  return {};
}

}  // namespace

std::vector<SceneNode> scene_nodes(const tinygltf::Model& model) {
  if (model.scenes.empty()) return nodes_below(model, nodes_without_parents(model));
  return nodes_below(model, model.scenes.at(static_cast<std::size_t>(std::max(model.defaultScene, 0))).nodes);
}

std::vector<glm::dmat4> file_from_nodes(const tinygltf::Model& model) {
  std::vector<glm::dmat4> transforms(model.nodes.size());
  const std::vector<SceneNode> nodes = nodes_below(model, nodes_without_parents(model));
  for (const SceneNode& each : nodes) {
    const glm::dmat4 parent = each.parent == kNone ? glm::dmat4(1.0) : transforms[nodes[each.parent].node];
    transforms[each.node] = parent * local_transform(model.nodes.at(each.node));
  }
  return transforms;
}

bool hides(const tinygltf::Node& node) {
  const auto visibility = node.extensions.find(kVisibilityExtension);
  return visibility != node.extensions.end() && visibility->second.Has("visible") && !visibility->second.Get("visible").Get<bool>();
}

Result<std::vector<MeshInstance>> mesh_instances(const tinygltf::Model& model, const glm::dmat4& scene_from_file) {
  const std::vector<SceneNode> nodes = scene_nodes(model);
  std::vector<glm::dmat4> scene_from_node;
  scene_from_node.reserve(nodes.size());
  std::vector<MeshInstance> instances;
  for (const SceneNode& each : nodes) {
    const glm::dmat4& scene_from_parent = each.parent < scene_from_node.size() ? scene_from_node[each.parent] : scene_from_file;
    scene_from_node.push_back(scene_from_parent * local_transform(model.nodes.at(each.node)));
    if (!is_usable(scene_from_node.back()))
      return Error{Status::bad_file, "node transform is not finite", Error::kNoOffset, "nodes[" + std::to_string(each.node) + "]"};
    const tinygltf::Node& node = model.nodes.at(each.node);
    if (node.mesh < 0) continue;
    COPPICE_CHECK(append_node(model, static_cast<int>(each.node), node.skin >= 0 ? scene_from_file : scene_from_node.back(), instances));
  }
  return instances;
}

}  // namespace coppice::bake
