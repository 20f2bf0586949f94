#include "level_set.h"

#include <algorithm>
#include <cstdio>
#include <system_error>
#include <utility>

#include "import_gltf.h"

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
  return ForeignLevel{"", Level{std::move(plant.foliage)}, std::move(plant.materials), std::move(plant.images)};
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

}  // namespace coppice::bake
