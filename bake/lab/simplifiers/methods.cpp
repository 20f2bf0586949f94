#include "methods.h"

#include <array>

#include "bake.h"
#include "collapse_geometric.h"
#include "collapse_image.h"
#include "collapse_information.h"
#include "fsa.h"
#include "gltf_write.h"
#include "information_prune.h"
#include "leaves_union.h"
#include "mesh_simplify.h"
#include "needle_lines.h"
#include "organs_union.h"
#include "stochastic_prune.h"
#include "tree_order.h"
#include "viewpoints.h"
#include "voxel_cloud.h"

namespace coppice::bake {
namespace {

constexpr std::array kMethods{Method::default_metric, Method::mi,  Method::geometric, Method::stochastic, Method::prune, Method::meshopt,
                              Method::meshopt_sloppy, Method::fsa, Method::plu,       Method::huo,        Method::lines, Method::voxels};
constexpr std::size_t kDefaultMethodCount = 7;
constexpr std::uint64_t kStochasticSeed = 1;

/// Runs the collapse of `coppice bake --metric` with default options.
Result<CollapseSequence> bake_collapse(Metric metric, const SimplifyInput& input, const ProgressFunction& progress) {
  const Foliage& foliage = input.shown.foliage;
  CollapseOptions collapse = BakeOptions{}.collapse;
  collapse.resolution_px = metric_resolution_px(metric, foliage, collapse.resolution_px);
  COPPICE_TRY(views, viewpoints(metric_view_count(metric, foliage.leaf_count())));
  if (metric == Metric::mi)
    for (Viewpoint& view : views) view.distance_radii = input.view_distance_radii;
  COPPICE_TRY(result, metric == Metric::mi ? collapse_by_mutual_information(input.shown, views, collapse, progress)
                                           : collapse_by_image_error(input.shown, views, collapse, ImageErrorOptions{}, progress));
  return std::move(result.sequence);
}

std::vector<Variant> one_variant(std::vector<Mesh> meshes) {
  Variant variant;
  for (Mesh& mesh : meshes) {
    std::vector<LeafShade> shades;
    for (std::size_t vertex = 0; vertex < mesh.vertex_fades.size(); vertex += 4)
      shades.push_back({static_cast<float>(opacity_of(mesh.vertex_fades[vertex])) / kOpaque, linear_brightness(mesh.vertex_fades[vertex])});
    variant.levels.push_back(Level{std::move(mesh), std::move(shades)});
  }
  std::vector<Variant> variants;
  variants.push_back(std::move(variant));
  return variants;
}

std::vector<Mesh> cuts(const SimplifyInput& input, const CollapseSequence& sequence) {
  const Tree tree = build_tree(input.shown.foliage, sequence);
  std::vector<Mesh> meshes;
  for (const std::uint32_t count : input.leaf_counts)
    meshes.push_back(foliage_mesh(cut_foliage(tree, input.shown.foliage.card_table, count)));
  return meshes;
}

Result<std::vector<Mesh>> baked_cuts(Metric metric, const SimplifyInput& input, const ProgressFunction& progress) {
  COPPICE_TRY(sequence, bake_collapse(metric, input, progress));
  return cuts(input, sequence);
}

std::vector<Mesh> stochastic_levels(const SimplifyInput& input) {
  std::vector<Mesh> meshes;
  for (const std::uint32_t count : input.leaf_counts)
    meshes.push_back(foliage_mesh(prune_stochastically(input.shown.foliage, count, kStochasticSeed)));
  return meshes;
}

Result<std::vector<Mesh>> pruned_levels(const SimplifyInput& input, const ProgressFunction& progress) {
  const BakeOptions options;
  COPPICE_TRY(views, viewpoints(metric_view_count(Metric::mi, input.shown.foliage.leaf_count())));
  COPPICE_TRY(result, prune_by_mutual_information(input.shown, views, options.collapse, input.leaf_counts, progress));
  std::vector<Mesh> meshes;
  for (const Foliage& level : result.levels) meshes.push_back(foliage_mesh(level));
  return meshes;
}

std::vector<Mesh> mesh_levels(const SimplifyInput& input, MeshSimplifier simplifier) {
  const Mesh source = foliage_mesh(input.shown.foliage);
  std::vector<Mesh> meshes;
  for (const std::uint32_t count : input.leaf_counts) meshes.push_back(simplify_mesh(source, 2 * count, simplifier));
  return meshes;
}

}  // namespace

std::span<const Method> all_methods() {
  return kMethods;
}

std::span<const Method> default_methods() {
  return std::span<const Method>(kMethods).first(kDefaultMethodCount);
}

const char* method_name(Method method) {
  switch (method) {
    case Method::default_metric:
      return "default";
    case Method::mi:
      return "mi";
    case Method::geometric:
      return "geometric";
    case Method::stochastic:
      return "stochastic";
    case Method::prune:
      return "prune";
    case Method::meshopt:
      return "meshopt";
    case Method::meshopt_sloppy:
      return "meshopt_sloppy";
    case Method::fsa:
      return "fsa";
    case Method::plu:
      return "plu";
    case Method::huo:
      return "huo";
    case Method::lines:
      return "lines";
    case Method::voxels:
      return "voxels";
  }
  return "";
}

Result<Method> method_from_name(std::string_view name) {
  std::string names;
  for (const Method method : kMethods) {
    if (name == method_name(method)) return method;
    names += (names.empty() ? "" : ", ") + std::string(method_name(method));
  }
  return Error{Status::invalid_argument, "no such method", Error::kNoOffset, "'" + std::string(name) + "'; there are " + names};
}

Result<std::vector<Variant>> simplify_foliage(Method method, const SimplifyInput& input, const ProgressFunction& progress) {
  switch (method) {
    case Method::default_metric: {
      COPPICE_TRY(meshes, baked_cuts(Metric::default_metric, input, progress));
      return one_variant(std::move(meshes));
    }
    case Method::mi: {
      COPPICE_TRY(meshes, baked_cuts(Metric::mi, input, progress));
      return one_variant(std::move(meshes));
    }
    case Method::geometric:
      return one_variant(cuts(input, collapse_by_similarity(input.shown.foliage, progress)));
    case Method::stochastic:
      return one_variant(stochastic_levels(input));
    case Method::prune: {
      COPPICE_TRY(meshes, pruned_levels(input, progress));
      return one_variant(std::move(meshes));
    }
    case Method::meshopt:
      return one_variant(mesh_levels(input, MeshSimplifier::collapse));
    case Method::meshopt_sloppy:
      return one_variant(mesh_levels(input, MeshSimplifier::sloppy));
    case Method::fsa:
      return simplify_fsa(input.shown.foliage, input.leaf_counts);
    case Method::plu:
      return unite_leaves(input.shown.foliage, input.leaf_counts);
    case Method::huo:
      return unite_organs(input.shown.foliage, input.leaf_counts);
    case Method::lines:
      return needle_lines(input.shown.foliage, input.shown.materials, input.shown.images, input.leaf_counts);
    case Method::voxels:
      return voxel_cloud(input.shown.foliage, input.shown.materials, input.shown.images, input.leaf_counts);
  }
  return Error{Status::internal, "no such method"};
}

}  // namespace coppice::bake
