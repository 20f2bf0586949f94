#include "gltf_nodes.h"

#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <tiny_gltf.h>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "gltf_accessor.h"
#include "gltf_screen.h"
#include "material_words.h"
#include "node_names.h"

namespace coppice::bake {
namespace {

constexpr std::uint64_t kMaxBaseVertices = std::uint64_t{1} << 24;
// Maximum number of pairs of billboards and other things that are compared; of more the boxes as a whole count.
constexpr std::size_t kMaxPairs = std::size_t{1} << 26;

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
  return read_vectors<glm::vec3>(model, position->second);
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
  if (primitive.indices >= 0) COPPICE_CHECK(move_into(order, read_indices(model, primitive.indices)));
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
  for (const MeshInstance& instance : placed) {
    for (const glm::vec3& point : facts.outermost) item.box.add(glm::dvec3(instance.scene_from_mesh * glm::dvec4(point, 1.0)));
    if (&instance == &placed.front()) item.first_box = item.box;
  }
  item.triangles = facts.triangles * placed.size();
  if (placed.size() == 1 && item.triangles <= kFewTriangles && facts.few_corners.size() == 3 * facts.triangles)
    item.mean_triangle_m2 = mean_triangle_m2(facts, placed.front().scene_from_mesh);
  item.materials = facts.materials;
  return item;
}

bool overlap(const NodeBox& a, const NodeBox& b) {
  return glm::all(glm::lessThanEqual(a.low, b.high)) && glm::all(glm::lessThanEqual(b.low, a.high));
}

/// Whether `outer` reaches over at least `share` of `box` along each axis.
bool covers(const NodeBox& outer, const NodeBox& box, double share) {
  const glm::dvec3 common = glm::min(outer.high, box.high) - glm::max(outer.low, box.low);
  return overlap(outer, box) && glm::all(glm::greaterThanEqual(common, share * (box.high - box.low)));
}

/// Share of a thing's extent that a plant in the same place must reach over.
constexpr double kSamePlace = 0.7;
/// Minimum triangles of a plant, as a multiple of its billboards'.
constexpr std::uint64_t kTimesABillboard = 4;

std::uint64_t triangles_of(const GltfNodes& scene, std::span<const std::uint32_t> items) {
  std::uint64_t sum = 0;
  for (const std::uint32_t item : items) sum += scene.items[item].triangles;
  return sum;
}

NodeBox box_of(const GltfNodes& scene, std::span<const std::uint32_t> items) {
  NodeBox box;
  for (const std::uint32_t item : items) box.add(scene.items[item].box);
  return box;
}

void leave(LeftOut& left, std::uint32_t item, LeftReason reason, std::uint32_t by) {
  left.reason[item] = reason;
  left.by[item] = by;
}

/// Splits the taken items into those that `is_it` holds for and the rest.
template <class Predicate>
std::pair<std::vector<std::uint32_t>, std::vector<std::uint32_t>> parted(const LeftOut& left, const Predicate& is_it) {
  std::pair<std::vector<std::uint32_t>, std::vector<std::uint32_t>> parts;
  for (const std::uint32_t item : taken_items(left)) (is_it(item) ? parts.first : parts.second).push_back(item);
  return parts;
}

/// [nodes] What a node itself says, as own(position) tells it, or the nearest parent that says something; else `none`.
template <class Value, class Own>
std::vector<Value> inherited(const GltfNodes& scene, const Value& none, const Own& own) {
  std::vector<Value> values;
  values.reserve(scene.nodes.size());
  for (std::uint32_t i = 0; i < scene.nodes.size(); ++i) {
    const std::uint32_t parent = scene.nodes[i].parent;
    const std::optional<Value> found = own(i);
    values.push_back(found ? *found : parent != kNone ? Value(values[parent]) : none);
  }
  return values;
}

/// What a node's name, or its mesh's, says that it is.
struct NamedRole {
  NodeRole role = NodeRole::shape;
  std::uint32_t by = kNone;
  std::string stem;
};
std::vector<NamedRole> named_roles(const GltfNodes& scene) {
  return inherited(scene, NamedRole{}, [&](std::uint32_t i) -> std::optional<NamedRole> {
    NodeName name = read_node_name(scene.nodes[i].name);
    if (name.role == NodeRole::shape && scene.nodes[i].item != kNone) name = read_node_name(scene.nodes[i].mesh_name);
    if (name.role == NodeRole::shape) return {};
    return NamedRole{name.role, i, name.stem};
  });
}

/// The level of a thing, and the node that says so.
struct Level {
  std::uint32_t level = 0;
  std::uint32_t by = kNone;  ///< the node whose name it is
  std::string family;        ///< equal for levels of one thing; empty: no level
};

/// What stands at a node and below.
struct NodeContent {
  NodeBox box;
  std::uint64_t triangles = 0;
};

std::vector<NodeContent> taken_contents(const GltfNodes& scene, const LeftOut& left) {
  std::vector<NodeContent> contents(scene.nodes.size());
  for (const std::uint32_t item : taken_items(left)) {
    contents[scene.items[item].position].box.add(scene.items[item].box);
    contents[scene.items[item].position].triangles += scene.items[item].triangles;
  }
  for (std::size_t i = contents.size(); i-- > 0;)
    if (const std::uint32_t parent = scene.nodes[i].parent; parent != kNone) {
      contents[parent].box.add(contents[i].box);
      contents[parent].triangles += contents[i].triangles;
    }
  return contents;
}

/// Nodes by rising level.
using Series = std::map<std::uint32_t, std::uint32_t>;

/// Whether "trunk_L0", "trunk_L1" and so on get coarser and stay as large. "leaves_low" may be what is low on the plant: words count only
/// for things of nearly one size and height.
bool is_series(const std::vector<NodeContent>& contents, const Series& series, bool is_words) {
  const double same_size = is_words ? 0.7 : 0.6;
  if (series.size() < 2 || (!is_words && (series.begin()->first != 0 || series.rbegin()->first + 1 != series.size()))) return false;
  const NodeContent* before = nullptr;
  for (const auto& [level, node] : series) {
    const NodeContent& next = contents[node];
    if (before != nullptr) {
      if (4 * next.triangles > 3 * before->triangles) return false;
      const glm::dvec3 a = before->box.size(), b = next.box.size();
      if (glm::any(glm::lessThan(glm::min(a, b), same_size * glm::max(a, b)))) return false;
      if (is_words && std::abs(before->box.low.y - next.box.low.y) > (1.0 - same_size) * std::max(a.y, b.y)) return false;
    }
    before = &next;
  }
  return true;
}

/// The weak level of a node, by its name or its mesh's; "oak" is level 0 of "oak_L1" and "oak_low".
WeakLevel weak_level_of(const GltfNode& node, bool is_word) {
  for (const std::string& name : {node.name, node.mesh_name})
    if (const NodeName read = read_node_name(name); read.weak_level && read.weak_level->is_word == is_word) return *read.weak_level;
  return {0, is_word, read_node_name(node.name).stem};
}

/// Adds levels such as "_L1" and "_mid", which count only in a series of nodes below one parent.
void add_weak_levels(const GltfNodes& scene, const LeftOut& left, std::vector<Level>& levels) {
  const std::vector<NodeContent> contents = taken_contents(scene, left);
  for (const bool is_word : {false, true}) {
    std::map<std::pair<std::uint32_t, std::string>, Series> all;
    for (std::uint32_t i = 0; i < scene.nodes.size(); ++i) {
      if (contents[i].triangles == 0 || !levels[i].family.empty()) continue;
      const WeakLevel weak = weak_level_of(scene.nodes[i], is_word);
      if (weak.level == 0 && scene.nodes[i].name.empty() && scene.nodes[i].mesh_name.empty()) continue;
      all[{scene.nodes[i].parent, weak.stem}].try_emplace(weak.level, i);
    }
    for (const auto& [key, series] : all) {
      if (!is_series(contents, series, is_word)) continue;
      for (const auto& [level, node] : series)
        levels[node] = {level, node, (is_word ? "word " : "number ") + std::to_string(key.first) + " " + key.second};
    }
    for (std::size_t i = 0; i < levels.size(); ++i)
      if (const std::uint32_t parent = scene.nodes[i].parent; parent != kNone && levels[i].family.empty()) levels[i] = levels[parent];
  }
}

/// [nodes] The level that each node's name says.
std::vector<Level> named_levels(const GltfNodes& scene, const LeftOut& left) {
  std::vector<Level> levels = inherited(scene, Level{}, [&](std::uint32_t i) -> std::optional<Level> {
    const GltfNode& node = scene.nodes[i];
    NodeName name = read_node_name(node.name);
    if (!name.level && node.item != kNone) name = read_node_name(node.mesh_name);
    if (!name.level) return {};
    // Levels with nothing else in their names are of one thing only below one parent.
    return Level{*name.level, i, name.stem.empty() ? "#" + std::to_string(node.parent) : name.stem};
  });
  add_weak_levels(scene, left, levels);
  return levels;
}

/// The finest level of each family. "oak" beside "oak_LOD1" is its level 0.
std::map<std::string, std::uint32_t> finest_levels(const GltfNodes& scene, const std::vector<std::uint32_t>& items,
                                                   const std::vector<Level>& levels) {
  std::map<std::string, std::uint32_t> finest;
  for (const std::uint32_t item : items) {
    const Level& level = levels[scene.items[item].position];
    if (level.family.empty()) continue;
    const auto [found, is_new] = finest.try_emplace(level.family, level.level);
    if (!is_new) found->second = std::min(found->second, level.level);
  }
  for (const std::uint32_t item : items) {
    const GltfNode& node = scene.nodes[scene.items[item].position];
    if (!levels[scene.items[item].position].family.empty()) continue;
    for (const std::string& name : {node.name, node.mesh_name})
      if (const auto found = finest.find(read_node_name(name).stem); found != finest.end()) found->second = 0;
  }
  return finest;
}

/// Whether finer levels of other names stand in the same place as one node's items: "Tree_LOD1" for "Trunk_LOD0" and "Leaves_LOD0".
bool is_shown_finer(const NodeBox& box, std::uint32_t level, const std::map<std::uint32_t, std::pair<std::uint32_t, NodeBox>>& levels) {
  NodeBox finer;
  for (const auto& [by, other] : levels)
    if (other.first < level && overlap(other.second, box)) finer.add(other.second);
  return covers(finer, box, kSamePlace);
}

void leave_named_levels(const GltfNodes& scene, LeftOut& left) {
  constexpr std::size_t kMaxNames = 2000;
  const std::vector<std::uint32_t> items = taken_items(left);
  const std::vector<Level> levels = named_levels(scene, left);
  const std::map<std::string, std::uint32_t> finest = finest_levels(scene, items, levels);
  std::map<std::uint32_t, std::pair<std::uint32_t, NodeBox>> of_node;
  for (const std::uint32_t item : items)
    if (const Level& level = levels[scene.items[item].position]; !level.family.empty()) {
      of_node[level.by].first = level.level;
      of_node[level.by].second.add(scene.items[item].box);
    }
  std::map<std::uint32_t, bool> is_coarse;
  for (const std::uint32_t item : items) {
    const Level& level = levels[scene.items[item].position];
    if (level.family.empty()) continue;
    const auto [coarse, is_new] = is_coarse.try_emplace(level.by, level.level > finest.at(level.family));
    if (is_new && !coarse->second && level.level > 0 && of_node.size() <= kMaxNames)
      coarse->second = is_shown_finer(of_node[level.by].second, level.level, of_node);
    if (coarse->second) leave(left, item, LeftReason::coarser_level, level.by);
  }
}

/// Leaves out what is below nodes of the model for which `is_it` holds, unless that is all.
template <class Predicate>
void leave_below(const GltfNodes& scene, LeftReason reason, const Predicate& is_it, LeftOut& left) {
  const auto by = inherited(scene, kNone, [&](std::uint32_t i) { return is_it(scene.nodes[i].node) ? std::optional(i) : std::nullopt; });
  const auto [below, rest] = parted(left, [&](std::uint32_t item) { return by[scene.items[item].position] != kNone; });
  if (rest.empty()) return;
  for (const std::uint32_t item : below) leave(left, item, reason, by[scene.items[item].position]);
}

}  // namespace

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
    if (!facts[mesh].is_known) COPPICE_CHECK(move_into(facts[mesh], mesh_facts(model, model.meshes[mesh])));
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
  if (vertices <= kMaxBaseVertices && !base.is_empty()) return base;
  const glm::dvec2 middle = all.centre();
  base = {};
  base.add({middle.x, all.low.y, middle.y});
  return base;
}

std::string shown_name(const GltfNode& node) {
  if (!node.name.empty()) return node.name;
  return node.mesh_name.empty() ? "nodes[" + std::to_string(node.node) + "]" : node.mesh_name;
}

std::vector<std::uint32_t> taken_items(const LeftOut& left) {
  std::vector<std::uint32_t> items;
  for (std::uint32_t i = 0; i < left.reason.size(); ++i)
    if (left.reason[i] == LeftReason::none) items.push_back(i);
  return items;
}

std::set<std::uint32_t> msft_coarser_nodes(const tinygltf::Model& model) {
  std::set<std::uint32_t> coarse;
  for (const tinygltf::Node& node : model.nodes) {
    const auto found = node.extensions.find(kLevelsExtension);
    if (found == node.extensions.end() || !found->second.Has("ids")) continue;
    const tinygltf::Value& ids = found->second.Get("ids");
    for (std::size_t i = 0; i < ids.ArrayLen(); ++i)
      coarse.insert(static_cast<std::uint32_t>(ids.Get(static_cast<int>(i)).GetNumberAsInt()));
  }
  return coarse;
}

void leave_hidden(const tinygltf::Model& model, const GltfNodes& scene, LeftOut& left) {
  leave_below(
      scene, LeftReason::hidden, [&](std::uint32_t node) { return hides(model.nodes.at(node)); }, left);
}

void leave_collision_shapes(const GltfNodes& scene, LeftOut& left) {
  const std::vector<NamedRole> roles = named_roles(scene);
  const auto role_of = [&](std::uint32_t item) -> const NamedRole& { return roles[scene.items[item].position]; };
  const auto [shapes, rest] = parted(left, [&](std::uint32_t item) {
    return role_of(item).role == NodeRole::collision || role_of(item).role == NodeRole::maybe_collision;
  });
  if (shapes.empty() || rest.empty()) return;
  const NodeBox box = box_of(scene, rest);
  std::set<std::string> stems;
  for (const std::uint32_t item : rest) {
    const GltfNode& node = scene.nodes[scene.items[item].position];
    stems.insert(read_node_name(node.name).stem);
    stems.insert(read_node_name(node.mesh_name).stem);
  }
  for (const std::uint32_t item : shapes) {
    const NamedRole& role = role_of(item);
    const NodeItem& shape = scene.items[item];
    // "trunk_col" may be the trunk in its colours. A collision shape has no material, or stands beside the thing whose shape it is.
    const bool bare = shape.materials == std::vector{kNone};
    const bool is_one = role.role == NodeRole::collision || ((bare || stems.contains(role.stem)) && covers(box, shape.box, kSamePlace));
    if (is_one) leave(left, item, LeftReason::collision, role.by);
  }
}

void leave_coarser_levels(const tinygltf::Model& model, const GltfNodes& scene, LeftOut& left) {
  const std::set<std::uint32_t> coarse = msft_coarser_nodes(model);
  leave_below(
      scene, LeftReason::coarser_level, [&](std::uint32_t node) { return coarse.contains(node); }, left);
  leave_named_levels(scene, left);
}

void leave_named_billboards(const GltfNodes& scene, LeftOut& left) {
  const std::vector<NamedRole> roles = named_roles(scene);
  const auto [named, rest] =
      parted(left, [&](std::uint32_t item) { return roles[scene.items[item].position].role == NodeRole::billboard; });
  if (named.empty() || rest.empty()) return;
  // Leaves are called billboards too: they stand in the plant, but are not as large. What stands alone is no billboard.
  std::map<std::uint32_t, std::vector<std::uint32_t>> by_node;
  for (const std::uint32_t item : named) by_node[roles[scene.items[item].position].by].push_back(item);
  const std::uint64_t rest_triangles = triangles_of(scene, rest);
  const NodeBox rest_box = box_of(scene, rest);
  const bool are_many = by_node.size() > kMaxPairs / rest.size();
  for (const auto& [by, items] : by_node) {
    if (kTimesABillboard * triangles_of(scene, items) > rest_triangles) continue;
    const NodeBox box = box_of(scene, items);
    NodeBox beside;
    if (are_many && overlap(rest_box, box)) beside = rest_box;
    for (std::size_t i = 0; i < rest.size() && !are_many; ++i)
      if (overlap(scene.items[rest[i]].box, box)) beside.add(scene.items[rest[i]].box);
    const bool alone = beside.is_empty();
    if (!alone && (!covers(beside, box, kSamePlace) || triangles_of(scene, items) > kFewTriangles * items.size())) continue;
    for (const std::uint32_t item : items) leave(left, item, LeftReason::billboard, by);
  }
}

bool is_masked(const tinygltf::Model& model, std::uint32_t material) {
  return material != kNone && model.materials.at(material).alphaMode != "OPAQUE";
}

bool is_billboard_shaped(const tinygltf::Model& model, const NodeItem& item) {
  // A quad is two triangles, each half of the box if the quad is as wide as that; crossed quads lie across it.
  constexpr double kLargeShare = 0.15;
  const double face_m2 = item.box.height() * item.box.width();
  return item.mean_triangle_m2 > 0.0 && item.mean_triangle_m2 >= kLargeShare * face_m2 &&
         std::ranges::all_of(item.materials, [&](std::uint32_t material) { return is_masked(model, material); });
}

void leave_shaped_billboards(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items, LeftOut& left) {
  constexpr std::uint64_t kTimesTheTriangles = 10;
  constexpr double kSameExtent = 0.85;
  std::vector<std::uint32_t> shaped, rest;
  for (const std::uint32_t item : items) (is_billboard_shaped(model, scene.items[item]) ? shaped : rest).push_back(item);
  if (shaped.empty() || triangles_of(scene, rest) < kTimesTheTriangles * triangles_of(scene, shaped)) return;
  const NodeBox box = box_of(scene, rest);
  const bool has_leaves = std::ranges::any_of(rest, [&](std::uint32_t item) {
    return std::ranges::any_of(scene.items[item].materials, [&](std::uint32_t material) {
      return is_masked(model, material) || (material != kNone && name_evidence(model.materials[material].name) > 0.0);
    });
  });
  if (!has_leaves) return;
  for (const std::uint32_t item : shaped) {
    const NodeBox& board = scene.items[item].box;
    if (!covers(box, board, kSameExtent) || board.height() < kSamePlace * box.height() || board.width() < kSamePlace * box.width())
      continue;
    leave(left, item, LeftReason::billboard, scene.items[item].position);
  }
}

}  // namespace coppice::bake
