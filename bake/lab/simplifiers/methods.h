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
  stochastic,      ///< stochastic_prune.h
  prune,           ///< information_prune.h
  meshopt,         ///< mesh_simplify.h, at equal triangle count
  meshopt_sloppy,
  fsa,     ///< fsa.h
  plu,     ///< leaves_union.h
  huo,     ///< organs_union.h
  lines,   ///< needle_lines.h, at equal vertex count
  voxels,  ///< voxel_cloud.h, at equal bytes
};

/// All of them, in the order of reports.
std::span<const Method> all_methods();
/// Those that are measured unless others are asked for.
std::span<const Method> default_methods();
/// As on the command line: "default", "mi", ...
const char* method_name(Method method);
/// errors  invalid_argument: no such method (all are listed)
Result<Method> method_from_name(std::string_view name);

/// The plant to simplify. Refers to what it is made of.
struct SimplifyInput {
  ShownFoliage shown;
  std::vector<std::uint32_t> leaf_counts;  ///< each 1 .. shown.foliage.leaf_count(); any order
  float view_distance_radii = 0.0f;        ///< `mi` looks in perspective from so far; 0: orthographic, as the baker
};

/// One level per leaf count for each choice of the method's parameters, at least one: two triangles a leaf for the methods that work on
/// leaves, at most as many for the others; `lines` and `voxels` say themselves what is as much.
/// progress  may be empty
/// errors    those of the method's own function
Result<std::vector<Variant>> simplify_foliage(Method method, const SimplifyInput& input, const ProgressFunction& progress);

}  // namespace coppice::bake
