#pragma once

// A leaf, or a triangle of a mesh, on its way into a cluster, and how a cluster is written.

#include <array>
#include <cstdint>
#include <span>

#include "coppice_thinning.h"
#include "crown_light.h"

namespace coppice::gpu {

/// A list of nothing in a box.
ClusterList empty_list(const LeafBox& box);

/// In steps, where they have a length.
vec3 in_steps(const vec3& offset, const vec3& step);
/// Likewise, as whole numbers of at most 65535.
uvec3 quantised(const vec3& offset, const vec3& step);

/// Of a quad's two triangles, (0, 1, 2) and (0, 2, 3).
float quad_area(const std::array<vec3, 4>& corners);

struct LeafEntry {
  Leaf leaf{};
  std::array<vec3, 4> corners{};  ///< object space, m
  std::uint32_t id = 0;           ///< breaks ties
  float size_m = 0;               ///< the longer diagonal
  std::array<vec3, 2> axis{};     ///< the longer of the lines that halve it
  std::uint32_t grain_count = 1;  ///< discs along it that make each about twice as long as wide
  float length_m = 0;             ///< of `axis`
  float area_m2 = 0;
  bool is_triangle = false;  ///< discs along a slender one lie on those of the one beside it: they are for a point of it
  bool is_surface = false;   ///< a triangle without holes
  // Of its splat.
  vec3 normal{}, face{};
  float roughness = 1;
  std::uint32_t look = 0;  ///< Splat::look without the bulk
  std::uint32_t gaps = 0;  ///< sixteenths of it
  float covered_m2 = 0;    ///< without holes and gaps
  CrownSample light{};
  float bulk = 0;  ///< of Splat::look, 0..1

  [[nodiscard]] vec3 middle() const { return (corners[0] + corners[1] + corners[2] + corners[3]) * 0.25f; }
};

/// corners: in the box
LeafEntry make_entry(const std::array<uvec3, 4>& corners, const LeafBox& box);

/// Which splits bear the leaves of a cluster; of meshes and ready cuts all are there at once.
struct Births {
  std::uint32_t first = 0, last = 0;  ///< of the page
};

/// A cluster of the leaves in their order, 1 to kClusterLeaves of them. leaves, splats: [entries], written; the cluster's addresses of
/// them are 0.
Cluster write_cluster(std::span<const LeafEntry> entries, const Births& births, const LeafBox& box, std::span<Leaf> leaves,
                      std::span<Splat> splats);

/// What of a node's area its leaves cover: not the holes of its card, nor the gaps between leaves that a merged one stands for.
inline float covered_area_m2(float area_m2, const CardLook& look, std::uint8_t fade) {
  return area_m2 * look.coverage * opacity_of(gaps_of(fade));
}

}  // namespace coppice::gpu
