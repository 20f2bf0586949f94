#include "gltf_pose.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <tiny_gltf.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "gltf_accessor.h"
#include "gltf_instances.h"

namespace coppice::bake {
namespace {

using Points = std::vector<glm::vec3>;

Error bad(const char* what, std::string detail) {
  return Error{Status::bad_file, what, Error::kNoOffset, std::move(detail)};
}

/// The accessor of an attribute, whose count is that of the positions; -1 if it is absent.
Result<int> accessor_of(const tinygltf::Model& model, const std::map<std::string, int>& attributes, const std::string& name,
                        std::size_t vertex_count) {
  const auto found = attributes.find(name);
  if (found == attributes.end()) return -1;
  const std::size_t count = model.accessors.at(static_cast<std::size_t>(found->second)).count;
  if (count == vertex_count) return found->second;
  return bad("attributes of unequal length", name + " has " + std::to_string(count) + ", POSITION " + std::to_string(vertex_count));
}

bool is_used(double weight) {
  return weight != 0.0;
}

/// Adds the weighted displacements of one attribute's morph targets.
Result<void> morph(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                   const std::string& name, Points& values) {
  for (std::size_t t = 0; t < std::min(primitive.targets.size(), weights.size()); ++t) {
    if (weights[t] == 0.0) continue;
    COPPICE_TRY(accessor, accessor_of(model, primitive.targets[t], name, values.size()));
    if (accessor < 0) continue;
    COPPICE_TRY(displacements, read_vectors<glm::vec3>(model, accessor));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += static_cast<float>(weights[t]) * displacements[i];
  }
  return {};
}

/// Four joints of each vertex and how far it follows them: JOINTS_n and WEIGHTS_n.
struct JointSet {
  std::vector<glm::vec4> joints, weights;
};

Result<std::vector<JointSet>> read_joint_sets(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                                              std::size_t vertex_count) {
  std::vector<JointSet> sets;
  while (true) {
    const std::string number = std::to_string(sets.size());
    COPPICE_TRY(joints, accessor_of(model, primitive.attributes, "JOINTS_" + number, vertex_count));
    COPPICE_TRY(weights, accessor_of(model, primitive.attributes, "WEIGHTS_" + number, vertex_count));
    if (joints < 0 || weights < 0) return sets;
    JointSet& set = sets.emplace_back();
    COPPICE_CHECK(move_into(set.joints, read_vectors<glm::vec4>(model, joints)));
    COPPICE_CHECK(move_into(set.weights, read_vectors<glm::vec4>(model, weights)));
  }
}

/// The mean of a vertex's joint transforms: exporters round weights, so their sum need not be 1.
Result<glm::dmat4> blended(const std::vector<JointSet>& sets, std::size_t vertex, const std::vector<glm::dmat4>& joints) {
  glm::dmat4 sum(0.0);
  double total = 0.0;
  for (const JointSet& set : sets)
    for (int k = 0; k < 4; ++k) {
      const double weight = set.weights[vertex][k], joint = set.joints[vertex][k];
      if (!(weight > 0.0)) continue;  // also for NaN
      if (!(joint >= 0.0 && joint < static_cast<double>(joints.size())))
        return bad("joint that the skin does not have", "vertex " + std::to_string(vertex));
      sum += weight * joints[static_cast<std::size_t>(joint)];
      total += weight;
    }
  if (total > 0.0) return sum / total;
  const auto first = static_cast<double>(sets.front().joints[vertex].x);
  return joints[first > 0.0 && first < static_cast<double>(joints.size()) ? static_cast<std::size_t>(first) : 0];
}

/// Moves a vertex. The cofactors turn its normal, with the sign that a mirroring transform takes from them.
void place(const glm::dmat4& transform, glm::vec3& position, glm::vec3* normal) {
  position = glm::vec3(transform * glm::dvec4(position, 1.0));
  if (normal == nullptr) return;
  const glm::dmat3 m(transform);
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  const glm::dvec3 turned = (glm::determinant(m) < 0.0 ? -1.0 : 1.0) * (cofactors * glm::dvec3(*normal));
  const double length = glm::length(turned);
  *normal = length > 0.0 ? glm::vec3(turned / length) : *normal;
}

/// How a node shows its mesh.
struct NodePose {
  const std::vector<glm::dmat4>* joints = nullptr;  ///< file space from the skin's mesh space; null: no skin
  glm::dmat4 file_from_node{1.0};                   ///< for primitives without joints
  std::vector<double> weights;                      ///< one for each morph target
};

bool has_joints(const tinygltf::Primitive& primitive) {
  return primitive.attributes.contains("JOINTS_0") && primitive.attributes.contains("WEIGHTS_0");
}

/// Lines too: they become strips once they are posed.
bool is_shown(const tinygltf::Primitive& primitive) {
  return primitive.mode != TINYGLTF_MODE_POINTS && primitive.attributes.contains("POSITION");
}

Result<void> move_vertices(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const NodePose& pose, Points& positions,
                           Points& normals) {
  COPPICE_TRY(sets, read_joint_sets(model, primitive, positions.size()));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    glm::dmat4 transform = pose.file_from_node;
    if (!sets.empty()) COPPICE_CHECK(move_into(transform, blended(sets, i, *pose.joints)));
    place(transform, positions[i], normals.empty() ? nullptr : &normals[i]);
    if (!is_finite(positions[i])) return bad("position is not finite", "vertex " + std::to_string(i));
  }
  return {};
}

Result<void> pose_primitive(tinygltf::Model& model, const NodePose& pose, tinygltf::Primitive& primitive) {
  COPPICE_TRY(positions, read_vectors<glm::vec3>(model, primitive.attributes.at("POSITION")));
  COPPICE_TRY(normal, accessor_of(model, primitive.attributes, "NORMAL", positions.size()));
  Points normals;
  if (normal >= 0) COPPICE_CHECK(move_into(normals, read_vectors<glm::vec3>(model, normal)));
  COPPICE_CHECK(morph(model, primitive, pose.weights, "POSITION", positions));
  if (!normals.empty()) COPPICE_CHECK(morph(model, primitive, pose.weights, "NORMAL", normals));
  if (pose.joints != nullptr) COPPICE_CHECK(move_vertices(model, primitive, pose, positions, normals));
  primitive.attributes["POSITION"] = add_vec3(model, positions);
  if (!normals.empty()) primitive.attributes["NORMAL"] = add_vec3(model, normals);
  return {};
}

class Posing {
 public:
  explicit Posing(tinygltf::Model& model) : model_(model), file_from_node_(file_from_nodes(model)), joints_(model.skins.size()) {
    for (const SceneNode& each : scene_nodes(model))
      if (const int mesh = model.nodes.at(each.node).mesh; mesh >= 0) ++shown_[mesh];
  }

  Result<void> pose(std::uint32_t node_index) {
    tinygltf::Node& node = model_.nodes.at(node_index);
    if (node.mesh < 0) return {};
    const tinygltf::Mesh& source = model_.meshes.at(static_cast<std::size_t>(node.mesh));
    if (std::ranges::none_of(source.primitives, has_joints)) node.skin = -1;
    NodePose pose{nullptr, file_from_node_[node_index], node.weights.empty() ? source.weights : node.weights};
    if (node.skin < 0 && std::ranges::none_of(pose.weights, is_used)) return {};
    if (node.skin >= 0) COPPICE_CHECK(move_into(pose.joints, joint_transforms(node.skin)));
    // Nodes without weights of their own show the mesh alike.
    const std::pair key{node.mesh, node.skin};
    const auto done = node.weights.empty() ? posed_.find(key) : posed_.end();
    if (done != posed_.end()) return node.mesh = done->second, Result<void>();
    tinygltf::Mesh mesh = source;
    for (std::size_t p = 0; p < mesh.primitives.size(); ++p) COPPICE_CHECK(pose_in_mesh(pose, key.first, p, mesh));
    const bool is_alone = shown_[key.first] == 1;
    if (!is_alone) node.mesh = static_cast<int>(model_.meshes.size());
    if (node.weights.empty()) posed_[key] = node.mesh;
    if (is_alone)
      model_.meshes[static_cast<std::size_t>(node.mesh)] = std::move(mesh);
    else
      model_.meshes.push_back(std::move(mesh));
    return {};
  }

 private:
  Result<void> pose_in_mesh(const NodePose& pose, int mesh_index, std::size_t p, tinygltf::Mesh& mesh) {
    tinygltf::Primitive& primitive = mesh.primitives[p];
    if (!is_shown(primitive)) return {};
    const std::string place = primitive_place(static_cast<std::size_t>(mesh_index), p);
    const Result<void> done = pose_primitive(model_, pose, primitive);
    return done ? Result<void>() : at_place(place, done.error());
  }

  Result<const std::vector<glm::dmat4>*> joint_transforms(int skin_index) {
    const tinygltf::Skin& skin = model_.skins.at(static_cast<std::size_t>(skin_index));
    std::vector<glm::dmat4>& joints = joints_[static_cast<std::size_t>(skin_index)];
    if (!joints.empty()) return &joints;
    std::vector<glm::mat4> inverse_bind(skin.joints.size(), glm::mat4(1.0f));
    if (skin.inverseBindMatrices >= 0) COPPICE_CHECK(move_into(inverse_bind, read_mat4(model_, skin.inverseBindMatrices)));
    for (std::size_t i = 0; i < skin.joints.size(); ++i)
      joints.push_back(file_from_node_[static_cast<std::size_t>(skin.joints[i])] * glm::dmat4(inverse_bind[i]));
    return &joints;
  }

  tinygltf::Model& model_;
  std::vector<glm::dmat4> file_from_node_;
  std::vector<std::vector<glm::dmat4>> joints_;  ///< [skins] empty until one is used
  std::map<int, int> shown_;                     ///< how many nodes show a mesh
  std::map<std::pair<int, int>, int> posed_;     ///< by mesh and skin
};

}  // namespace

Result<void> apply_rest_pose(tinygltf::Model& model) {
  const auto is_posed = [](const tinygltf::Mesh& mesh) { return !mesh.weights.empty(); };
  const auto poses = [](const tinygltf::Node& node) { return node.skin >= 0 || !node.weights.empty(); };
  if (std::ranges::none_of(model.nodes, poses) && std::ranges::none_of(model.meshes, is_posed)) return {};
  Posing posing(model);
  for (const SceneNode& each : scene_nodes(model)) COPPICE_CHECK(posing.pose(each.node));
  return {};
}

std::string pose_line(const tinygltf::Model& model) {
  std::size_t skinned = 0, morphed = 0;
  for (const SceneNode& each : scene_nodes(model)) {
    const tinygltf::Node& node = model.nodes.at(each.node);
    if (node.mesh < 0) continue;
    const auto& weights = node.weights.empty() ? model.meshes.at(static_cast<std::size_t>(node.mesh)).weights : node.weights;
    if (node.skin >= 0) ++skinned;
    if (std::ranges::any_of(weights, is_used)) ++morphed;
  }
  std::string text;
  const auto add = [&](std::size_t count, const char* how) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + (count > 1 ? " meshes " : " mesh ") + how;
  };
  add(skinned, "posed by skins");
  add(morphed, "posed by morph weights");
  if (!model.animations.empty()) text += text.empty() ? "animation is not kept" : "; animation is not kept";
  return text.empty() ? text : "the plant has the file's rest pose: " + text;
}

}  // namespace coppice::bake
