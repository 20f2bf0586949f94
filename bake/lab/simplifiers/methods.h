#pragma once

// The simplifiers that `coppice evaluate` compares, all as meshes at given leaf counts.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collapse.h"
#include "level.h"
#include "plant.h"
#include "progress.h"
#include "result.h"

namespace coppice::bake {

enum class Method {
  default_metric,  ///< what `coppice bake` does
  mi,              ///< the paper: collapse_by_mutual_information
  geometric,       ///< collapse_geometric.h
  stochastic,      ///< prune_stochastically
  prune,           ///< prune_by_mutual_information
  meshopt,         ///< simplify_mesh, at equal triangle count
  meshopt_sloppy,
  fsa,     ///< simplify_fsa
  plu,     ///< unite_leaves
  huo,     ///< unite_organs
  lines,   ///< needle_lines, at equal vertex count
  voxels,  ///< voxel_cloud, at equal bytes
};

/// All methods, in the order of reports.
std::span<const Method> all_methods();
/// The methods that are measured by default.
std::span<const Method> default_methods();
/// The name on the command line: "default", "mi", ...
const char* method_name(Method method);
/// errors  invalid_argument: no such method (all are listed)
Result<Method> method_from_name(std::string_view name);

/// The plant to simplify. Holds references.
struct SimplifyInput {
  ShownFoliage shown;
  std::vector<std::uint32_t> leaf_counts;  ///< each 1 .. shown.foliage.leaf_count(); any order
  float view_distance_radii = 0.0f;        ///< distance from which `mi` looks in perspective; 0: orthographic, as in the baker
};

/// Simplifies to one level per leaf count, for each choice of the method's parameters. Methods that work on leaves give two triangles a
/// leaf, the others at most as many; `lines` and `voxels` define what corresponds to that.
/// progress  may be empty
/// errors    those of the method's own function
Result<std::vector<Variant>> simplify_foliage(Method method, const SimplifyInput& input, const ProgressFunction& progress);

/// The general mesh simplifiers that a user would use first: meshoptimizer on the leaf quads as one indexed mesh.
enum class MeshSimplifier {
  /// meshopt_simplify: edge collapse by quadrics, target error 1 (the mesh's whole extent). It may stop before the target.
  collapse,
  /// meshopt_simplifySloppy, target error 1: vertices clustered on a grid, so that pieces join.
  sloppy,
};

/// Simplifies to at most triangle_count triangles, if the simplifier gets that far. Vertices stay the mesh's; a triangle shows the material
/// of its first corner's triangle. Triangles with corners in one place are left out, since they draw nothing.
/// mesh  each vertex used by triangles of one material
Mesh simplify_mesh(const Mesh& mesh, std::uint32_t triangle_count, MeshSimplifier simplifier);

}  // namespace coppice::bake
