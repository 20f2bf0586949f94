#pragma once

// A leaf, or a triangle of a mesh, before it is written into a cluster, and the writing of a cluster.

#include <array>
#include <cstdint>
#include <span>

#include "coppice_transparency.h"
#include "crown_light.h"

namespace coppice::gpu {

/// Makes an empty list with the box's quantisation.
ClusterList empty_list(const LeafBox& box);

/// Divides by the steps that are not 0.
vec3 in_steps(const vec3& offset, const vec3& step);
/// Does the same in whole numbers of at most 65535.
uvec3 quantised(const vec3& offset, const vec3& step);

/// Area of a quad's two triangles, (0, 1, 2) and (0, 2, 3).
float quad_area(const std::array<vec3, 4>& corners);

struct LeafEntry {
  Leaf leaf{};
  std::array<vec3, 4> corners{};  ///< object space, m
  std::uint32_t id = 0;           ///< breaks ties
  float size_m = 0;               ///< length of the longer diagonal
  std::array<vec3, 2> axis{};     ///< the longer of the lines that halve the leaf
  std::uint32_t grain_count = 1;  ///< number of discs along the axis; each is about twice as long as wide
  float length_m = 0;             ///< length of `axis`
  float area_m2 = 0;
  bool is_triangle = false;  ///< discs of a slender triangle lie on those of its neighbour: the count is for one point of it
  bool is_surface = false;   ///< true for a triangle without holes
  // What its splat shows.
  LeafNormals normals{vec3(0.0f), 1.0f, 0.0f};
  vec3 face{};  ///< has any length
  float roughness = 1;
  std::uint32_t look = 0;          ///< Splat::look without its upper byte
  std::uint32_t transparency = 0;  ///< in sixteenths of the leaf
  float covered_m2 = 0;            ///< area without holes, times opacity
  CrownSample light{};

  [[nodiscard]] vec3 middle() const { return (corners[0] + corners[1] + corners[2] + corners[3]) * 0.25f; }
};

/// corners: quantised in the box
LeafEntry make_entry(const std::array<uvec3, 4>& corners, const LeafBox& box);

/// Range of splits that bear the leaves of a cluster. In meshes and ready cuts all leaves are born at once.
struct Births {
  std::uint32_t first = 0, last = 0;  ///< splits of the page
};

/// Writes a cluster of the leaves in their order, 1 to kClusterLeaves of them. leaves, splats: [entries], written; the cluster's addresses
/// of them are 0.
Cluster write_cluster(std::span<const LeafEntry> entries, const Births& births, const LeafBox& box, std::span<Leaf> leaves,
                      std::span<Splat> splats);

/// The area of a node that its leaves cover: without the holes of its card and the gaps between the leaves that it stands for.
/// opacity: core/tree.h
inline float covered_area_m2(float area_m2, const CardLook& look, std::uint8_t opacity) {
  return area_m2 * look.coverage * opacity_of(transparency_of(opacity));
}

}  // namespace coppice::gpu
