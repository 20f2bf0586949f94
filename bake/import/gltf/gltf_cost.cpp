#include "gltf_cost.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "usable_memory.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kTriangles = 4;  // the first `mode` of glTF that is neither points nor lines

std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  std::uint64_t value = 0;
  return __builtin_mul_overflow(a, b, &value) ? kMost : value;
}

std::uint64_t sum(std::uint64_t a, std::uint64_t b) {
  return b > kMost - a ? kMost : a + b;
}

/// Three vertices take about as much as a triangle.
std::uint64_t thirds(std::uint64_t vertices) {
  return vertices / 3 + (vertices % 3 != 0 ? 1 : 0);
}

std::uint64_t count_of(const Json& accessor, std::span<const std::uint64_t> counts) {
  return counts[accessor.get<std::size_t>()];
}

const Json& list_of(const Json& document, const char* name) {
  static const Json empty = Json::array();
  const auto found = document.find(name);
  return found == document.end() ? empty : *found;
}

/// The nodes of the scene that is read, as scene_nodes (gltf_instances.h) finds them, in any order.
std::vector<std::size_t> scene_nodes(const Json& document) {
  std::vector<std::size_t> nodes;
  const Json& scenes = list_of(document, "scenes");
  if (scenes.empty()) {
    nodes.resize(list_of(document, "nodes").size());
    std::iota(nodes.begin(), nodes.end(), std::size_t{0});
    return nodes;
  }
  nodes = scenes[document.value("scene", std::size_t{0})].value("nodes", nodes);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (const Json& child : list_of(document["nodes"][nodes[i]], "children")) nodes.push_back(child.get<std::size_t>());
  return nodes;
}

std::uint64_t instances_of(const Json& node, std::span<const std::uint64_t> counts) {
  static const Json::json_pointer attributes("/extensions/EXT_mesh_gpu_instancing/attributes");
  return node.contains(attributes) ? count_of(*node[attributes].begin(), counts) : 1;
}

/// Vertices and displacements that are read to pose a node's mesh (gltf_pose.h).
std::uint64_t posed_values(const Json& node, const Json& mesh, const MeshCost& cost) {
  const Json& weights = list_of(list_of(node, "weights").empty() ? mesh : node, "weights");
  const auto used = std::ranges::count_if(weights, [](const Json& weight) { return weight != 0; });
  if (used == 0 && !node.contains("skin")) return 0;
  return sum(cost.values, product(cost.vertices, static_cast<std::uint64_t>(used)));
}

/// A sum and the largest of its parts.
struct Total {
  std::uint64_t triangles = 0, largest = 0;
  std::string place;

  /// place()  names the part
  template <class Place>
  void add(std::uint64_t part, const Place& place_of) {
    triangles = sum(triangles, part);
    if (part > largest) largest = part, place = place_of();
  }
};

std::string at(const char* list, std::size_t index) {
  return std::string(list) + "[" + std::to_string(index) + "]";
}

}  // namespace

std::uint64_t CostLimit::triangles() const {
  if (max_triangles > 0) return max_triangles;
  return std::clamp<std::uint64_t>(usable_memory_bytes() / kBytesOfATriangle, 1, kMaxSourceTriangles);
}

std::uint64_t MeshCost::add(const Json& primitive, std::span<const std::uint64_t> counts) {
  const Json& attributes = primitive["attributes"];
  const std::uint64_t own = attributes.contains("POSITION") ? count_of(attributes["POSITION"], counts) : 0;
  const std::uint64_t corners = primitive.contains("indices") ? count_of(primitive["indices"], counts) : own;
  const auto mode = primitive.value("mode", kTriangles);
  // A line becomes two triangles for each of its segments, and separate lines have a segment for two indices. A strip has a triangle for
  // each index but two.
  const std::uint64_t drawn = mode == 0                        ? 0
                              : mode == kTriangles             ? corners / 3
                              : mode == 1 || mode > kTriangles ? corners
                                                               : product(2, corners);
  const std::uint64_t added = std::max({std::uint64_t{1}, drawn, mode == 0 ? 0 : thirds(own)});
  triangles = sum(triangles, added);
  if (mode > 0 && mode < kTriangles) lines = sum(lines, added);
  if (mode > 0) vertices = sum(vertices, own);
  values = sum(values, mode == 0 ? 1 : product(own, attributes.size()));
  return added;
}

Result<std::uint64_t> check_cost(const Json& document, std::span<const MeshCost> meshes, std::span<const std::uint64_t> counts,
                                 const CostLimit& limit) {
  Total total;
  std::vector<std::uint64_t> instances(meshes.size(), 0);
  for (const std::size_t i : scene_nodes(document)) {
    const Json& node = document["nodes"][i];
    if (!node.contains("mesh")) continue;
    const auto mesh = node["mesh"].get<std::size_t>();
    instances[mesh] = sum(instances[mesh], instances_of(node, counts));
    const std::uint64_t values = posed_values(node, document["meshes"][mesh], meshes[mesh]);
    total.add(thirds(values), [&] { return at("nodes", i) + ": " + std::to_string(values) + " vertices and displacements to pose"; });
  }
  std::uint64_t placed = 0;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const std::uint64_t each = limit.places_only ? 1 : std::max<std::uint64_t>(1, meshes[m].triangles);
    placed = sum(placed, product(instances[m], each));
    total.add(product(instances[m], each), [&] {
      return at("meshes", m) + ": " + std::to_string(instances[m]) + " instances of " + std::to_string(each) + " triangles";
    });
    if (!limit.places_only) total.add(meshes[m].lines, [&] { return at("meshes", m) + ": its lines"; });
  }
  const Json &skins = list_of(document, "skins"), &buffers = list_of(document, "buffers");
  for (std::size_t i = 0; i < skins.size(); ++i)
    if (skins[i].contains("inverseBindMatrices"))
      total.add(count_of(skins[i]["inverseBindMatrices"], counts), [&] { return at("skins", i) + ".inverseBindMatrices"; });
  for (std::size_t i = 0; i < buffers.size(); ++i)
    if (buffers[i].contains("uri") && !buffers[i]["uri"].get_ref<const std::string&>().starts_with("data:"))
      total.add(buffers[i]["byteLength"].get<std::uint64_t>() / kBytesOfATriangle, [&] { return at("buffers", i) + ".byteLength"; });
  if (total.triangles <= limit.triangles()) return placed;
  return Error{Status::unsupported, "more triangles than are read", Error::kNoOffset,
               total.place + "; all together counts as " + std::to_string(total.triangles) + " triangles, at most " +
                   std::to_string(limit.triangles()) + " (--max-source-triangles)"};
}

}  // namespace coppice::bake
