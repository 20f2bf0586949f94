#pragma once

// A leaf, or a triangle of a mesh, on its way into a cluster, and how a cluster is written.

#include <array>
#include <cstdint>
#include <span>

#include "coppice_shared.h"
#include "crown_light.h"
#include "points.h"

namespace coppice::gpu {

/// What corners are quantised in, at most `largest`; object space, m.
struct ListFrame {
  Point low{}, step{};
  std::uint32_t largest = 1;

  explicit ListFrame(const LeafBox& box)
      : low{box.min.x, box.min.y, box.min.z}, step{box.step.x, box.step.y, box.step.z}, largest(box.largest) {}
  /// That splats' places are quantised in.
  [[nodiscard]] Point splat_step() const { return step * (static_cast<float>(largest) / 65535.0f); }
  [[nodiscard]] Point at(const std::array<std::uint32_t, 3>& q) const {
    return {low[0] + step[0] * static_cast<float>(q[0]), low[1] + step[1] * static_cast<float>(q[1]),
            low[2] + step[2] * static_cast<float>(q[2])};
  }
  /// A list of nothing in it.
  [[nodiscard]] ClusterList empty_list() const;
};

/// crown_of of shading.glsl.
struct Crown {
  Point center{}, radii{};

  explicit Crown(const LeafBox& box);
  /// -1..1 along each axis
  [[nodiscard]] Point place(const Point& p) const {
    return {(p[0] - center[0]) / radii[0], (p[1] - center[1]) / radii[1], (p[2] - center[2]) / radii[2]};
  }
};

struct LeafEntry {
  Leaf leaf{};
  std::array<Point, 4> corners{};  ///< object space, m
  std::uint32_t id = 0;            ///< breaks ties
  float size_m = 0;                ///< the longer diagonal
  std::array<Point, 2> axis{};     ///< the longer of the lines that halve it
  std::uint32_t grain_count = 1;   ///< discs along it that make each about twice as long as wide
  float length_m = 0;              ///< of `axis`
  float area_m2 = 0;
  bool is_triangle = false;  ///< discs along a slender one lie on those of the one beside it: they are for a point of it
  bool is_surface = false;   ///< a triangle without holes
  // Of its splat.
  Point normal{}, face{};
  std::uint32_t look = 0;  ///< Splat::look without the sky
  float covered_m2 = 0;
  CrownSample light;
  float bulk = 0;  ///< as in Cluster::bulks, 0..1

  [[nodiscard]] Point middle() const { return (corners[0] + corners[1] + corners[2] + corners[3]) * 0.25f; }
};

/// quantised: corners, as ListFrame has them
LeafEntry make_entry(const std::array<std::array<std::uint32_t, 3>, 4>& quantised, const ListFrame& frame);

/// The normal that leaf_light of shading.glsl has for a place of a leaf. face: its own, or zero; becomes unit
Point lit_normal(const Crown& crown, const Point& middle, Point& face, float crown_normals);

/// variation of shading.glsl. place_in_crown: Crown::place of the stalk
Point variation(const Point& place_in_crown, const std::array<std::uint32_t, 3>& stalk);

/// Which splits bear the leaves of a cluster; of meshes and ready cuts all are there at once.
struct Births {
  std::uint32_t first = 0, last = 0;  ///< of the page
};

/// A cluster of the leaves in their order, 1 to kClusterLeaves of them. leaves, splats: [entries], written; the cluster's addresses of
/// them are 0.
Cluster write_cluster(std::span<const LeafEntry> entries, const Births& births, const ListFrame& frame, std::span<Leaf> leaves,
                      std::span<Splat> splats);

/// unpack_length of clusters.glsl. quarter: 0..3
float unpack_length(std::uint32_t packed, std::uint32_t quarter);

}  // namespace coppice::gpu
