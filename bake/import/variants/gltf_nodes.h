#pragma once

// The nodes of a glTF scene with what they show: boxes, triangles, materials. Also leaves out those that show a plant once more, or are no
// part of its look: levels, billboards, collision shapes. The rules are in gltf_variants.h.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "gltf_instances.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

struct NodeBox {
  glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};

  void add(const glm::dvec3& point) { add(NodeBox{point, point}); }
  void add(const NodeBox& box) {
    low = glm::min(low, box.low);
    high = glm::max(high, box.high);
  }
  [[nodiscard]] bool is_empty() const { return low.x > high.x; }
  [[nodiscard]] glm::dvec3 size() const { return glm::max(high - low, glm::dvec3(0.0)); }
  [[nodiscard]] double height() const { return size().y; }
  [[nodiscard]] double width() const { return std::max(size().x, size().z); }                           ///< the plan's larger side
  [[nodiscard]] glm::dvec2 centre() const { return {0.5 * (low.x + high.x), 0.5 * (low.z + high.z)}; }  ///< the plan's, x and z
};

/// A node that shows a mesh, once or as often as its instances say.
struct NodeItem {
  std::uint32_t position = 0;  ///< index into GltfNodes::nodes
  std::uint32_t mesh = 0;
  std::span<const MeshInstance> placed;
  NodeBox box, first_box;                ///< all that are placed; the first alone
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
/// errors     those of read_vectors and read_indices
Result<GltfNodes> read_gltf_nodes(const tinygltf::Model& model, std::span<const MeshInstance> instances);

/// The foot of the items: the box of their vertices in the lowest 15 % of their height; with more than 2^24 vertices, the middle of their
/// box.
NodeBox base_of(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items);

/// The name that messages use.
std::string shown_name(const GltfNode& node);

/// Why a part of a file does not belong to the plant.
enum class LeftReason : std::uint8_t { none, not_chosen, hidden, collision, coarser_level, billboard, ground, other_variant };

/// The items that are left out so far: why, and the position of the node that says so.
struct LeftOut {
  std::vector<LeftReason> reason;  ///< [items] none: the item is taken
  std::vector<std::uint32_t> by;   ///< [items]
};

std::vector<std::uint32_t> taken_items(const LeftOut& left);

/// The model's nodes that any node's MSFT_lod names as coarser.
std::set<std::uint32_t> msft_coarser_nodes(const tinygltf::Model& model);

/// Each of these leaves out what its rule finds among the taken items, but never all of them.
void leave_hidden(const tinygltf::Model& model, const GltfNodes& scene, LeftOut& left);
void leave_collision_shapes(const GltfNodes& scene, LeftOut& left);
void leave_coarser_levels(const tinygltf::Model& model, const GltfNodes& scene, LeftOut& left);
void leave_named_billboards(const GltfNodes& scene, LeftOut& left);

/// Whether a material, which may be kNone, has holes or is blended.
bool is_masked(const tinygltf::Model& model, std::uint32_t material);

/// Whether an item is a few large masked triangles: a billboard by its shape, if a plant stands in the same place.
bool is_billboard_shaped(const tinygltf::Model& model, const NodeItem& item);
/// Leaves out those of `items`, which are one plant, that are billboard-shaped, if the rest is as large and has leaves of its own.
void leave_shaped_billboards(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items, LeftOut& left);

}  // namespace coppice::bake
