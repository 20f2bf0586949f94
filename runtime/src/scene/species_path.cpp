#include "species_path.h"

#include <filesystem>

#include "asset_path.h"

namespace coppice {

Result<void> check_species_path(const AssetFolder& folder, std::string_view scene_path, std::string_view species) {
  if (folder.allow_outside) return {};
  const std::filesystem::path scene_folder = std::filesystem::path(scene_path).parent_path();
  const std::filesystem::path file = scene_folder / species;
  const std::filesystem::path root = folder.root.empty() ? scene_folder : std::filesystem::path(folder.root);
  const std::filesystem::path inside =
      folder.root.empty() ? std::filesystem::path(species) : file.lexically_normal().lexically_relative(root.lexically_normal());
  // Links above the scene may lead into the root where the text does not: then the resolved path alone decides.
  const bool by_letters = !folder.real_files || folder.root.empty();
  if (by_letters && !stays_inside(inside.native()))
    return Error{Status::invalid_argument, "outside the asset's folder", Error::kNoOffset, std::string(species)};
  if (!folder.real_files) return {};
  if (auto resolved = resolve_below(root, file, std::string(species)); !resolved) return resolved.error();
  return {};
}

}  // namespace coppice
