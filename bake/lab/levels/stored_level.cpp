#include "stored_level.h"

#include <cstdint>
#include <utility>

#include "bounds.h"
#include "coppice/format.h"
#include "error_table.h"
#include "gltf_write.h"
#include "leaf_cards.h"
#include "leaf_mesh_parts.h"
#include "pack.h"
#include "texture_regions.h"
#include "tree_order.h"
#include "unpack.h"

namespace coppice::bake {
namespace {

/// Collapses each leaf with its neighbour in leaf order, then the results, and so on.
CollapseSequence collapse_in_order(std::uint32_t leaf_count) {
  CollapseSequence sequence;
  for (std::uint32_t i = 0; i + 1 < leaf_count; ++i) sequence.merges.push_back({2 * i, 2 * i + 1, {0, 1, 2, 3}});
  return sequence;
}

/// A table for the packer, which nobody reads.
ErrorTable no_errors(std::uint32_t leaf_count) {
  if (leaf_count == 1) return {{1}, {1.0f}, {0.0f}};
  return {{1, leaf_count}, {1.0f}, {0.0f, 0.0f}};
}

}  // namespace

Result<StoredLevel> stored_finest_level(const Plant& plant, const Foliage& foliage) {
  BakedPlant baked;
  baked.name = plant.name;
  baked.metric = COPPICE_METRIC_GEOMETRIC;
  baked.tree = build_tree(foliage, collapse_in_order(foliage.leaf_count()));
  baked.card_table = foliage.card_table;
  baked.materials = plant.materials;
  baked.images = plant.images;
  baked.errors = no_errors(foliage.leaf_count());
  baked.leaf_meshes = keep_leaf_meshes(plant, foliage).meshes;
  if (!baked.leaf_meshes.parts.empty()) baked.leaf_meshes.error_px = {0.0f};
  baked.sphere = plant_sphere(foliage, {}, baked.leaf_meshes);
  drop_unused_materials(baked);
  PackSizes sizes;
  COPPICE_TRY(file, pack(baked, sizes));
  COPPICE_TRY(stored, unpack(file));
  const bool is_leaf_meshes = !stored.leaf_meshes.parts.empty();
  Mesh mesh = is_leaf_meshes ? whole_leaf_mesh(stored.leaf_meshes)
                             : foliage_mesh(cut_foliage(stored.tree, stored.card_table, stored.tree.leaf_count()));
  return StoredLevel{std::move(mesh), std::move(stored.materials), std::move(stored.images), is_leaf_meshes};
}

}  // namespace coppice::bake
