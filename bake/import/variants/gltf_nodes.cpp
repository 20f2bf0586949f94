#include "gltf_nodes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <tiny_gltf.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "gltf_accessor.h"

namespace coppice::bake {
namespace {

constexpr std::uint64_t kMaxBaseVertices = std::uint64_t{1} << 24;

/// Facts of a mesh, wherever it stands. The box of its outermost points in 26 directions is nearly the box of all points, however the mesh
/// is turned.
struct MeshFacts {
  bool is_known = false;
  std::vector<glm::vec3> outermost;
  std::uint64_t triangles = 0;
  std::vector<glm::vec3> few_corners;  ///< 3 a triangle, if there are few
  std::vector<std::uint32_t> materials;
};

Result<std::vector<glm::vec3>> positions_of(const tinygltf::Model& model, const tinygltf::Primitive& primitive) {
  const auto position = primitive.attributes.find("POSITION");
  if (primitive.mode < TINYGLTF_MODE_TRIANGLES || position == primitive.attributes.end()) return std::vector<glm::vec3>();
  return read_vec3(model, position->second);
}

void add_outermost(const std::vector<glm::vec3>& points, std::vector<glm::vec3>& outermost) {
  for (int code = 0; code < 27; ++code) {
    const glm::vec3 direction(glm::ivec3(code % 3, code / 3 % 3, code / 9) - 1);
    if (direction == glm::vec3(0.0f)) continue;
    const glm::vec3* best = nullptr;
    float best_reach = -std::numeric_limits<float>::infinity();
    for (const glm::vec3& point : points)
      if (const float reach = glm::dot(point, direction); reach > best_reach && std::isfinite(reach)) best = &point, best_reach = reach;
    if (best != nullptr) outermost.push_back(*best);
  }
}

/// Adds the corners of few triangles.
Result<void> add_corners(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const std::vector<glm::vec3>& points,
                         std::vector<glm::vec3>& corners) {
  if (primitive.mode != TINYGLTF_MODE_TRIANGLES) return {};
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  if (primitive.indices >= 0) {
    COPPICE_TRY(read, read_indices(model, primitive.indices));
    order = std::move(read);
  }
  for (const std::uint32_t index : order)
    if (index < points.size()) corners.push_back(points[index]);
  return {};
}

Result<MeshFacts> mesh_facts(const tinygltf::Model& model, const tinygltf::Mesh& mesh) {
  MeshFacts facts;
  facts.is_known = true;
  for (const tinygltf::Primitive& primitive : mesh.primitives) {
    COPPICE_TRY(points, positions_of(model, primitive));
    if (points.empty()) continue;
    const std::size_t corners =
        primitive.indices >= 0 ? model.accessors.at(static_cast<std::size_t>(primitive.indices)).count : points.size();
    facts.triangles += primitive.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners - std::min<std::size_t>(corners, 2);
    add_outermost(points, facts.outermost);
    if (corners <= 3 * kFewTriangles) COPPICE_CHECK(add_corners(model, primitive, points, facts.few_corners));
    facts.materials.push_back(primitive.material < 0 ? kNone : static_cast<std::uint32_t>(primitive.material));
  }
  std::ranges::sort(facts.materials);
  facts.materials.erase(std::unique(facts.materials.begin(), facts.materials.end()), facts.materials.end());
  return facts;
}

double mean_triangle_m2(const MeshFacts& facts, const glm::dmat4& scene_from_mesh) {
  const auto placed = [&](std::size_t i) { return glm::dvec3(scene_from_mesh * glm::dvec4(facts.few_corners[i], 1.0)); };
  double area_m2 = 0.0;
  for (std::size_t i = 0; i + 2 < facts.few_corners.size(); i += 3)
    area_m2 += 0.5 * glm::length(glm::cross(placed(i + 1) - placed(i), placed(i + 2) - placed(i)));
  return area_m2 / static_cast<double>(facts.triangles);
}

NodeItem make_item(const MeshFacts& facts, std::uint32_t position, std::span<const MeshInstance> placed) {
  NodeItem item;
  item.position = position;
  item.mesh = placed.front().mesh;
  item.placed = placed;
  for (const MeshInstance& instance : placed)
    for (const glm::vec3& point : facts.outermost) item.box.add(glm::dvec3(instance.scene_from_mesh * glm::dvec4(point, 1.0)));
  item.triangles = facts.triangles * placed.size();
  if (placed.size() == 1 && item.triangles <= kFewTriangles && facts.few_corners.size() == 3 * facts.triangles)
    item.mean_triangle_m2 = mean_triangle_m2(facts, placed.front().scene_from_mesh);
  item.materials = facts.materials;
  return item;
}

}  // namespace

void NodeBox::add(const glm::dvec3& point) {
  low = glm::min(low, point);
  high = glm::max(high, point);
}
void NodeBox::add(const NodeBox& box) {
  low = glm::min(low, box.low);
  high = glm::max(high, box.high);
}
glm::dvec3 NodeBox::size() const {
  return glm::max(high - low, glm::dvec3(0.0));
}
double NodeBox::width() const {
  return std::max(size().x, size().z);
}
glm::dvec2 NodeBox::centre() const {
  return {0.5 * (low.x + high.x), 0.5 * (low.z + high.z)};
}

bool overlap(const NodeBox& a, const NodeBox& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (a.low[axis] > b.high[axis] || b.low[axis] > a.high[axis]) return false;
  return true;
}

bool covers(const NodeBox& outer, const NodeBox& box, double share) {
  if (!overlap(outer, box)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    const double common = std::min(outer.high[axis], box.high[axis]) - std::max(outer.low[axis], box.low[axis]);
    if (common < share * (box.high[axis] - box.low[axis])) return false;
  }
  return true;
}

Result<GltfNodes> read_gltf_nodes(const tinygltf::Model& model, std::span<const MeshInstance> instances) {
  GltfNodes scene;
  std::vector<MeshFacts> facts(model.meshes.size());
  std::size_t next = 0;
  for (const SceneNode& each : scene_nodes(model)) {
    const tinygltf::Node& node = model.nodes.at(each.node);
    GltfNode& added = scene.nodes.emplace_back(GltfNode{each.node, each.parent, kNone, node.name, {}});
    if (node.mesh < 0) continue;
    const auto mesh = static_cast<std::size_t>(node.mesh);
    added.mesh_name = model.meshes.at(mesh).name;
    const std::size_t first = next;
    while (next < instances.size() && instances[next].node == each.node) ++next;
    if (first == next) continue;
    if (!facts[mesh].is_known) {
      COPPICE_TRY(read, mesh_facts(model, model.meshes[mesh]));
      facts[mesh] = std::move(read);
    }
    if (facts[mesh].triangles == 0) continue;
    added.item = static_cast<std::uint32_t>(scene.items.size());
    scene.items.push_back(
        make_item(facts[mesh], static_cast<std::uint32_t>(scene.nodes.size() - 1), instances.subspan(first, next - first)));
  }
  return scene;
}

NodeBox base_of(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items) {
  constexpr double kSlice = 0.15;
  NodeBox all, base;
  for (const std::uint32_t item : items) all.add(scene.items[item].box);
  const double top = all.low.y + kSlice * all.height();
  std::uint64_t vertices = 0;
  for (const std::uint32_t i : items) {
    const NodeItem& item = scene.items[i];
    if (item.box.low.y > top) continue;
    for (const tinygltf::Primitive& primitive : model.meshes.at(item.mesh).primitives) {
      const Result<std::vector<glm::vec3>> points = positions_of(model, primitive);
      if (!points) continue;  // not reached: read_gltf_nodes has read them all
      vertices += points->size() * item.placed.size();
      if (vertices > kMaxBaseVertices) break;
      for (const MeshInstance& instance : item.placed)
        for (const glm::vec3& point : *points) {
          const glm::dvec3 placed(instance.scene_from_mesh * glm::dvec4(point, 1.0));
          if (placed.y <= top) base.add(placed);
        }
    }
  }
  if (vertices <= kMaxBaseVertices && base.low.x <= base.high.x) return base;
  const glm::dvec2 middle = all.centre();
  base = {};
  base.add({middle.x, all.low.y, middle.y});
  return base;
}

std::string shown_name(const GltfNode& node) {
  if (!node.name.empty()) return node.name;
  return node.mesh_name.empty() ? "nodes[" + std::to_string(node.node) + "]" : node.mesh_name;
}

}  // namespace coppice::bake
