#pragma once

// The nodes of a glTF scene with what they show: boxes, triangles, materials. gltf_variants.h decides by them.

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
  [[nodiscard]] double width() const;       ///< the plan's larger side
  [[nodiscard]] glm::dvec2 centre() const;  ///< the plan's, x and z
};

bool overlap(const NodeBox& a, const NodeBox& b);
/// Whether `outer` reaches over at least `share` of `box` along each axis.
bool covers(const NodeBox& outer, const NodeBox& box, double share);

/// A node that shows a mesh, once or as often as its instances say.
struct NodeItem {
  std::uint32_t position = 0;  ///< index into GltfNodes::nodes
  std::uint32_t mesh = 0;
  std::span<const MeshInstance> placed;
  NodeBox box;
  std::uint64_t triangles = 0;           ///< all placed triangles
  double mean_triangle_m2 = 0.0;         ///< for few triangles (kFewTriangles) that are placed once; otherwise 0
  std::vector<std::uint32_t> materials;  ///< the model's, ascending; kNone for none
};

/// How many triangles a billboard may have.
inline constexpr std::uint64_t kFewTriangles = 32;

struct GltfNode {
  std::uint32_t node = 0;        ///< index in the model
  std::uint32_t parent = kNone;  ///< the parent's position, which is smaller
  std::uint32_t item = kNone;    ///< the item that the node itself shows
  std::string name, mesh_name;
};

struct GltfNodes {
  std::vector<GltfNode> nodes;  ///< as scene_nodes lists them
  std::vector<NodeItem> items;  ///< in the order of nodes; items without triangles are left out
};

/// instances  from mesh_instances; they must outlive the result
/// errors     those of read_vec3 and read_indices
Result<GltfNodes> read_gltf_nodes(const tinygltf::Model& model, std::span<const MeshInstance> instances);

/// The foot of the items: the box of their vertices in the lowest 15 % of their height; with more than 2^24 vertices, the middle of their
/// box.
NodeBox base_of(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items);

/// The name that messages use.
std::string shown_name(const GltfNode& node);

}  // namespace coppice::bake
