#include "level_files.h"

#include <algorithm>
#include <cstdio>
#include <system_error>
#include <utility>

#include "bounds.h"
#include "coppice/format.h"
#include "error_table.h"
#include "gltf_write.h"
#include "import_gltf.h"
#include "leaf_cards.h"
#include "leaf_mesh_parts.h"
#include "pack.h"
#include "texture_regions.h"
#include "tree_order.h"
#include "unpack.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

/// The set's folders, sorted by name; the set's own folder if it has none.
Result<std::vector<fs::path>> variant_folders(const LevelSet& set) {
  std::error_code error;
  std::vector<fs::path> folders;
  for (fs::directory_iterator entry(set.folder, error); !error && entry != fs::directory_iterator(); entry.increment(error))
    if (entry->is_directory()) folders.push_back(entry->path());
  if (error)
    return Error{Status::io, "cannot read the folder of a level set", Error::kNoOffset, set.folder.string() + ": " + error.message()};
  std::ranges::sort(folders);
  if (folders.empty()) folders.push_back(set.folder);
  return folders;
}

Result<ForeignLevel> read_level(const fs::path& folder, double fraction) {
  fs::path file = folder / (level_file_name(fraction) + ".glb");
  if (!fs::exists(file)) file.replace_extension(".gltf");
  if (!fs::exists(file))
    return Error{Status::invalid_argument, "a level set has no file for a level", Error::kNoOffset,
                 (folder / (level_file_name(fraction) + ".glb")).string()};
  ImportOptions options;
  options.leaf_material = "";  // this matches every name
  COPPICE_TRY(plant, import_gltf(file, options));
  return ForeignLevel{"", level_of(std::move(plant.foliage)), std::move(plant.materials), std::move(plant.images)};
}

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

std::string level_file_name(double fraction) {
  char text[32];
  static_cast<void>(std::snprintf(text, sizeof text, "%.10g", fraction));
  return text;
}

Result<std::vector<std::vector<ForeignLevel>>> read_level_set(const LevelSet& set, std::span<const double> fractions) {
  COPPICE_TRY(folders, variant_folders(set));
  std::vector<std::vector<ForeignLevel>> levels(fractions.size());
  for (const fs::path& folder : folders)
    for (std::size_t i = 0; i < fractions.size(); ++i) {
      COPPICE_TRY(level, read_level(folder, fractions[i]));
      if (folder != set.folder) level.parameters = folder.filename().string();
      levels[i].push_back(std::move(level));
    }
  return levels;
}

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
  Level level = is_leaf_meshes ? modelled_level(whole_leaf_mesh(stored.leaf_meshes), stored.materials)
                               : level_of(foliage_mesh(cut_foliage(stored.tree, stored.card_table, stored.tree.leaf_count())));
  return StoredLevel{std::move(level), std::move(stored.materials), std::move(stored.images), is_leaf_meshes};
}

}  // namespace coppice::bake
