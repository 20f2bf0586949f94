#pragma once

// The data that the baker works on, from the imported file to the finished tree. Plain structs; each stage has a module of its own. Lengths
// are metres, axes glTF's (right-handed, +Y up), colours linear.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "coppice/format.h"
#include "normal_sum.h"
#include "still_wind.h"
#include "tree.h"

namespace coppice::bake {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// What becomes of a piece of the source's surface.
enum class PlantPart : std::uint8_t { leaf, wood, dropped };

/// Evidence for leaves (above 0) or for wood (below): see find_leaves.h.
struct LeafEvidence {
  double name = 0.0, holes = 0.0, colour = 0.0, flatness = 0.0, repetition = 0.0, size = 0.0, company = 0.0;
  [[nodiscard]] double sum() const { return name + holes + colour + flatness + repetition + size + company; }
};

/// The pieces of one material that have equal numbers of triangles and of points, and what became of them.
struct PieceClass {
  std::uint32_t material = 0;
  std::uint32_t triangle_count = 0, point_count = 0;  ///< each piece has so many; 0 for the class of pieces without area
  std::uint32_t piece_count = 0;
  std::uint64_t total_triangles = 0;
  double length_m = 0.0, elongation = 0.0, flatness = 0.0;  ///< medians; see piece_shape.h, elongation is length over width
  double slenderness = 0.0;                                 ///< median of length^2 over area: bends do not change it much
  double low_m = 0.0, high_m = 0.0;                         ///< heights: 2 % of the pieces reach below low_m, and above high_m
  LeafEvidence evidence;                                    ///< 0 where a rule decided
  PlantPart part = PlantPart::wood;
  bool is_shell = false;      ///< its material speaks for leaves, but it cannot be split into them
  bool against_name = false;  ///< leaves by their form, though their material's name says wood
  std::string reason;         ///< why, for a person
};

/// RGBA8, rows top to bottom; colour in sRGB, alpha linear.
struct Image {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
  /// The image is a normal map: RGB is a unit vector, 0..255 for -1..1, x along u, y against v, z off the surface; alpha means nothing.
  bool is_normal_map = false;
  /// How much of the plant's surface shows each texel, relative (measure_shown_texels); empty: all texels alike.
  std::vector<float> shown = {};
};

struct Material {
  std::string name;
  glm::vec4 base_color{1.0f};   ///< linear factor
  std::uint32_t image = kNone;  ///< base colour image
  float alpha_cutoff = 0.0f;    ///< 0: opaque
  float roughness = 1.0f;
  bool double_sided = true;
  bool sided_normals = false;        ///< leaves: the normals of their vertices say which side is lit, whoever looks
  std::uint32_t normal_map = kNone;  ///< image; wood and leaf meshes show it, quads are too small for it
};

/// An indexed triangle mesh; the attribute arrays have one entry per vertex.
struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;                   ///< unit
  std::vector<glm::vec2> uvs;                       ///< (0, 0) where the source has none
  std::vector<std::uint32_t> indices;               ///< 3 per triangle
  std::vector<std::uint32_t> triangle_materials;    ///< 1 per triangle
  std::vector<std::uint8_t> vertex_opacities = {};  ///< 1 per vertex, the same for all of a triangle: core/tree.h; empty: kOpaque
  /// 1 per vertex, 0..1: how far the normals of the leaves that the triangle stands for lie along `normals` (core/tree.h); negative, -0
  /// too, where `normals` is on the front of the leaves, which is lit whoever looks; empty: flat triangles
  std::vector<float> vertex_alongs = {};
  std::vector<glm::vec3> triangle_tints = {};  ///< 1 per triangle, a linear factor of the material's colour; empty: none
  std::vector<float> wind_weights = {};        ///< 1 per vertex, 0 stiff .. 1 flexible, < 0 where the source has none; empty: nowhere
};

/// What the corners of the triangle show whose first index is indices[first].
template <class Value>
[[nodiscard]] std::array<Value, 3> at_corners(const std::vector<Value>& values, const std::vector<std::uint32_t>& indices,
                                              std::size_t first) {
  return {values[indices[first]], values[indices[first + 1]], values[indices[first + 2]]};
}

/// A leaf as a run of the foliage mesh's triangles.
struct LeafRange {
  std::uint32_t first_triangle = 0;
  std::uint32_t triangle_count = 0;
};

[[nodiscard]] inline std::span<const std::uint32_t> leaf_indices(const Mesh& foliage, const LeafRange& leaf) {
  return std::span(foliage.indices).subspan(3 * std::size_t{leaf.first_triangle}, 3 * std::size_t{leaf.triangle_count});
}

/// One species as imported: leaves are pieces of the foliage mesh (find_leaves.h), wood is everything else.
struct Plant {
  std::string name;
  std::vector<Material> materials;
  std::vector<Image> images;
  Mesh foliage;
  std::vector<LeafRange> leaves;      ///< in file order; together they are all triangles of `foliage`
  Mesh wood;                          ///< may be empty
  std::vector<PieceClass> classes;    ///< why pieces became leaves or wood, grouped by material
  std::vector<std::string> warnings;  ///< what was guessed or dropped, one line each, for a person
};

/// What a leaf quad shows: corner i shows texture coordinate uv[i] of the material.
struct Card {
  std::uint32_t material = 0;
  std::array<glm::vec2, 4> uv{};
};

/// Corners in ring order: 0 and 3 at the stalk, 1 and 2 at the tip; triangles (0, 1, 2) and (0, 2, 3).
using Quad = std::array<glm::vec3, 4>;

/// The plant's leaves as quads: the unit of collapse.
struct Foliage {
  std::vector<Quad> quads;                   ///< [leaf_count]
  std::vector<std::uint32_t> cards;          ///< [leaf_count] index into card_table
  std::vector<std::uint8_t> opacities = {};  ///< [leaf_count] core/tree.h; empty: kOpaque
  std::vector<std::uint16_t> normals = {};   ///< [leaf_count] core/tree.h; empty: kFlatNormals
  std::vector<NormalSum> normal_sums = {};   ///< [leaf_count] source leaves' own, before rounding; empty: those of the quads
  std::vector<Card> card_table;              ///< at most COPPICE_MAX_CARDS
  [[nodiscard]] std::uint32_t leaf_count() const { return static_cast<std::uint32_t>(quads.size()); }
};

[[nodiscard]] inline NormalSum source_normal_sum(const Foliage& foliage, std::uint32_t leaf) {
  return foliage.normal_sums.empty() ? quad_normal_sum(foliage.quads[leaf]) : foliage.normal_sums[leaf];
}

/// Leaf quads and what they show. Holds references.
struct ShownFoliage {
  const Foliage& foliage;
  const std::vector<Material>& materials;
  const std::vector<Image>& images;
};

/// Replaces two live nodes by one. Ids: source leaves are 0..N-1, the result of merge i is N+i.
struct Merge {
  std::uint32_t first = 0, second = 0;    ///< first < second
  std::array<std::uint8_t, 4> corners{};  ///< result corner i is corner corners[i] of the pair: 0..3 of first, 4..7 of second
  std::uint8_t opacity = kOpaque;         ///< the result's: core/tree.h
};

/// The collapse sequence, N - 1 merges down to one leaf, and what it cost.
struct CollapseSequence {
  std::vector<Merge> merges;
  std::uint64_t evaluations = 0;  ///< pairs whose cost was computed
};

/// A collapse sequence in refinement order: see core/tree.h. Vertices are the 4N source vertices, shared by all levels.
struct Tree {
  struct Node {
    std::array<std::uint32_t, 4> vertices{};  ///< indices into `vertices`
    std::uint32_t card = 0;
    std::uint8_t opacity = kOpaque;        ///< see core/tree.h
    std::uint16_t normals = kFlatNormals;  ///< see core/tree.h
  };
  std::vector<glm::vec3> vertices;          ///< [4N]
  std::vector<Node> nodes;                  ///< [2N - 1]
  std::vector<std::uint32_t> split_parent;  ///< [N - 1] node replaced by nodes 2s+1 and 2s+2
  std::vector<std::uint32_t> node_split;    ///< [2N - 1] split that replaces the node; kNone for a source leaf
  std::vector<std::uint32_t> node_source;   ///< [2N - 1] source leaf of a leaf node; kNone otherwise
  [[nodiscard]] std::uint32_t leaf_count() const { return static_cast<std::uint32_t>(split_parent.size() + 1); }
};

/// Measured image error of cuts: see "error table" in ARCHITECTURE.md.
struct ErrorTable {
  std::vector<std::uint32_t> leaf_counts;  ///< [L] ascending, 1 .. N
  std::vector<float> sizes_px;             ///< [S] ascending, projected diameter of the bounding sphere
  std::vector<float> error_px;             ///< [L * S] row per level, non-increasing down a column
};

/// Levels of detail of the wood, finest first.
struct WoodLods {
  std::vector<Mesh> lods;
  std::vector<float> error_px;  ///< [lods * sizes] errors against the finest, at ErrorTable::sizes_px; non-decreasing down a column
};

/// Whole leaves as they were modelled: what one LEAF_MESH chunk holds.
struct LeafMeshPart {
  Mesh mesh;
  std::vector<glm::vec3> stalks;  ///< [vertices] corner 0 of the quad of the vertex's leaf: it identifies leaves, and tints them
};

/// The leaves as they were modelled, for close views; no parts if the quads are the same.
struct LeafMeshes {
  std::vector<LeafMeshPart> parts;
  std::vector<float> error_px;  ///< [sizes] error of all quads against them, at ErrorTable::sizes_px; non-decreasing
};

/// How wind moves a plant: format.h.
struct Wind {
  coppice_file_wind head = kStillWind;
  std::vector<coppice_file_wind_node> nodes;  ///< [head.node_side^3] x fastest, then y, then z
};

/// A bounding sphere about the centre of a bounding box.
struct Sphere {
  glm::vec3 center{0.0f};
  float radius = 0.0f;
};

/// Everything that goes into a .coppice file.
struct BakedPlant {
  std::string name;
  std::uint32_t metric = 0;  ///< coppice_metric
  Tree tree;
  std::vector<Card> card_table;
  std::vector<Material> materials;
  std::vector<Image> images;
  ErrorTable errors;
  WoodLods wood;
  LeafMeshes leaf_meshes;
  Wind wind;
  Sphere sphere;  ///< bounds leaves, leaf meshes and wood: what the error table's sizes measure, and what the runtime culls
};

}  // namespace coppice::bake
