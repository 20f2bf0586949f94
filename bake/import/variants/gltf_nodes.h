#pragma once

// The nodes of a glTF scene with what they show: boxes, triangles, materials. What gltf_variants.h weighs.

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "gltf_instances.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

struct NodeBox {
  glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};

  void add(const glm::dvec3& point);
  void add(const NodeBox& box);
  [[nodiscard]] glm::dvec3 size() const;
  [[nodiscard]] double height() const { return size().y; }
  [[nodiscard]] double width() const;       ///< the larger side of the plan
  [[nodiscard]] glm::dvec2 centre() const;  ///< of the plan, x and z
};

bool overlap(const NodeBox& a, const NodeBox& b);
/// Whether `cover` reaches over at least `share` of the other along each axis.
bool covers(const NodeBox& cover, const NodeBox& box, double share);

/// A node that shows a mesh, once or as often as its instances say.
struct NodeItem {
  std::uint32_t position = 0;  ///< in GltfNodes::nodes
  std::uint32_t mesh = 0;
  std::span<const MeshInstance> placed;
  NodeBox box;
  std::uint64_t triangles = 0;           ///< of all that is placed
  double mean_triangle_m2 = 0.0;         ///< of few triangles (kFewTriangles) that are placed once; otherwise 0
  std::vector<std::uint32_t> materials;  ///< of the model, ascending; kNone for none
};

/// Of so many triangles a billboard may be made.
inline constexpr std::uint64_t kFewTriangles = 32;

struct GltfNode {
  std::uint32_t node = 0;        ///< of the model
  std::uint32_t parent = kNone;  ///< position of the parent, which is before
  std::uint32_t item = kNone;    ///< what the node shows itself
  std::string name, mesh_name;
};

struct GltfNodes {
  std::vector<GltfNode> nodes;  ///< as scene_nodes lists them
  std::vector<NodeItem> items;  ///< in the order of nodes; without those that have no triangle
};

/// errors  of read_vec3 and read_indices. `instances` are of mesh_instances and must outlive the result.
Result<GltfNodes> read_gltf_nodes(const tinygltf::Model& model, std::span<const MeshInstance> instances);

/// Where items stand: the box of what is in the lowest 15 % of their height, the middle of the box where there are more than 2^24 vertices.
NodeBox base_of(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items);

/// As messages call it.
std::string shown_name(const GltfNode& node);

}  // namespace coppice::bake
