#include "methods.h"

#include <array>

#include <meshoptimizer.h>

#include "bake.h"
#include "collapse_geometric.h"
#include "collapse_image.h"
#include "collapse_information.h"
#include "gltf_write.h"
#include "leaf_unions.h"
#include "lines_and_voxels.h"
#include "pruning.h"
#include "tree_order.h"
#include "viewpoints.h"

namespace coppice::bake {
namespace {

using Variants = std::vector<Variant>;

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

/// make_mesh  the mesh at a leaf count
template <class MakeMesh>
Variants one_variant(const SimplifyInput& input, const MakeMesh& make_mesh) {
  Variants variants(1);
  for (const std::uint32_t count : input.leaf_counts) variants[0].levels.push_back(level_of(make_mesh(count)));
  return variants;
}

Variants cuts(const SimplifyInput& input, const Tree& tree) {
  return one_variant(input, [&](std::uint32_t count) { return foliage_mesh(cut_foliage(tree, input.shown.foliage.card_table, count)); });
}

/// That nodes know how the normals of their leaves lie is ours: elsewhere a merged leaf is flat.
void flatten_merged(Tree& tree) {
  for (std::size_t node = 0; node < tree.nodes.size(); ++node)
    if (tree.node_source[node] == kNone) tree.nodes[node].normals = kFlatNormals;
}

template <Metric metric>
Result<Variants> baked_levels(const SimplifyInput& input, const ProgressFunction& progress) {
  COPPICE_TRY(sequence, bake_collapse(metric, input, progress));
  Tree tree = build_tree(input.shown.foliage, sequence);
  if (input.view_distance_radii > 0.0f) flatten_merged(tree);  // the paper's set-up
  return cuts(input, tree);
}

Result<Variants> similar_levels(const SimplifyInput& input, const ProgressFunction& progress) {
  Tree tree = build_tree(input.shown.foliage, collapse_by_similarity(input.shown.foliage, progress));
  flatten_merged(tree);
  return cuts(input, tree);
}

Result<Variants> stochastic_levels(const SimplifyInput& input, const ProgressFunction&) {
  return one_variant(input,
                     [&](std::uint32_t count) { return foliage_mesh(prune_stochastically(input.shown.foliage, count, kStochasticSeed)); });
}

Result<Variants> pruned_levels(const SimplifyInput& input, const ProgressFunction& progress) {
  const BakeOptions options;
  COPPICE_TRY(views, viewpoints(metric_view_count(Metric::mi, input.shown.foliage.leaf_count())));
  COPPICE_TRY(result, prune_by_mutual_information(input.shown, views, options.collapse, input.leaf_counts, progress));
  auto level = result.levels.begin();
  return one_variant(input, [&](std::uint32_t) { return foliage_mesh(*level++); });
}

template <MeshSimplifier simplifier>
Result<Variants> mesh_levels(const SimplifyInput& input, const ProgressFunction&) {
  const Mesh source = foliage_mesh(input.shown.foliage);
  return one_variant(input, [&](std::uint32_t count) { return simplify_mesh(source, 2 * count, simplifier); });
}

/// Methods without progress: those that unite leaves, and those that show their materials in other shapes.
template <auto simplify>
Result<Variants> levels_of_leaves(const SimplifyInput& input, const ProgressFunction&) {
  return simplify(input.shown.foliage, input.leaf_counts);
}

template <auto simplify>
Result<Variants> levels_of_looks(const SimplifyInput& input, const ProgressFunction&) {
  return simplify(input.shown, input.leaf_counts);
}

struct Simplifier {
  Method method;
  const char* name;
  Result<Variants> (*simplify)(const SimplifyInput&, const ProgressFunction&);
};

/// In the order of Method.
constexpr std::array kSimplifiers{Simplifier{Method::default_metric, "default", baked_levels<Metric::default_metric>},
                                  Simplifier{Method::mi, "mi", baked_levels<Metric::mi>},
                                  Simplifier{Method::geometric, "geometric", similar_levels},
                                  Simplifier{Method::stochastic, "stochastic", stochastic_levels},
                                  Simplifier{Method::prune, "prune", pruned_levels},
                                  Simplifier{Method::meshopt, "meshopt", mesh_levels<MeshSimplifier::collapse>},
                                  Simplifier{Method::meshopt_sloppy, "meshopt_sloppy", mesh_levels<MeshSimplifier::sloppy>},
                                  Simplifier{Method::fsa, "fsa", levels_of_leaves<simplify_fsa>},
                                  Simplifier{Method::plu, "plu", levels_of_leaves<unite_leaves>},
                                  Simplifier{Method::huo, "huo", levels_of_leaves<unite_organs>},
                                  Simplifier{Method::lines, "lines", levels_of_looks<needle_lines>},
                                  Simplifier{Method::voxels, "voxels", levels_of_looks<voxel_cloud>}};

constexpr std::array kMethods = [] {
  std::array<Method, kSimplifiers.size()> methods{};
  for (std::size_t i = 0; i < methods.size(); ++i) methods[i] = kSimplifiers[i].method;
  return methods;
}();

const Simplifier& simplifier_of(Method method) {
  return kSimplifiers[static_cast<std::size_t>(method)];
}

std::size_t run_meshopt(std::vector<std::uint32_t>& indices, const Mesh& mesh, std::size_t target_index_count, MeshSimplifier simplifier) {
  constexpr float kAnyError = 1.0f;
  const std::uint32_t* source = mesh.indices.data();
  const float* positions = &mesh.positions[0].x;
  if (simplifier == MeshSimplifier::collapse)
    return meshopt_simplify(indices.data(), source, mesh.indices.size(), positions, mesh.positions.size(), sizeof(glm::vec3),
                            target_index_count, kAnyError, 0, nullptr);
  return meshopt_simplifySloppy(indices.data(), source, mesh.indices.size(), positions, mesh.positions.size(), sizeof(glm::vec3),
                                target_index_count, kAnyError, nullptr);
}

}  // namespace

std::span<const Method> all_methods() {
  return kMethods;
}

std::span<const Method> default_methods() {
  return std::span<const Method>(kMethods).first(kDefaultMethodCount);
}

const char* method_name(Method method) {
  return simplifier_of(method).name;
}

Result<Method> method_from_name(std::string_view name) {
  std::string names;
  for (const Simplifier& simplifier : kSimplifiers) {
    if (name == simplifier.name) return simplifier.method;
    names += (names.empty() ? "" : ", ") + std::string(simplifier.name);
  }
  return Error{Status::invalid_argument, "no such method", Error::kNoOffset, "'" + std::string(name) + "'; there are " + names};
}

Result<std::vector<Variant>> simplify_foliage(Method method, const SimplifyInput& input, const ProgressFunction& progress) {
  return simplifier_of(method).simplify(input, progress);
}

Mesh simplify_mesh(const Mesh& mesh, std::uint32_t triangle_count, MeshSimplifier simplifier) {
  Mesh result;
  result.positions = mesh.positions;
  result.normals = mesh.normals;
  result.uvs = mesh.uvs;
  result.vertex_alongs = mesh.vertex_alongs;
  if (mesh.indices.empty()) return result;
  std::vector<std::uint32_t> vertex_materials(mesh.positions.size(), 0);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) vertex_materials[mesh.indices[i]] = mesh.triangle_materials[i / 3];

  std::vector<std::uint32_t> indices(mesh.indices.size());
  indices.resize(run_meshopt(indices, mesh, std::size_t{triangle_count} * 3, simplifier));
  for (std::size_t t = 0; t + 2 < indices.size(); t += 3) {
    const glm::vec3 &a = mesh.positions[indices[t]], &b = mesh.positions[indices[t + 1]], &c = mesh.positions[indices[t + 2]];
    if (a == b || b == c || c == a) continue;
    result.indices.insert(result.indices.end(), {indices[t], indices[t + 1], indices[t + 2]});
    result.triangle_materials.push_back(vertex_materials[indices[t]]);
  }
  return result;
}

}  // namespace coppice::bake
