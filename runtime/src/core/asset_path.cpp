#include "asset_path.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "io_result.h"

namespace coppice {

namespace {

constexpr const char* kOutside = "outside the asset's folder";

Error refused(Status status, const char* what, const std::string& name, const std::string& reason = {}) {
  return Error{status, what, Error::kNoOffset, reason.empty() ? name : name + ": " + reason};
}

}  // namespace

bool stays_inside(std::string_view name) {
  const std::filesystem::path path = std::filesystem::path(name).lexically_normal();
  return path.is_relative() && !path.empty() && *path.begin() != "..";
}

Result<std::filesystem::path> resolve_inside(const std::filesystem::path& folder, const std::filesystem::path& name) {
  if (!stays_inside(name.native())) return refused(Status::invalid_argument, kOutside, name.string());
  return resolve_below(folder, folder / name, name.string());
}

Result<std::filesystem::path> resolve_below(const std::filesystem::path& folder, const std::filesystem::path& path,
                                            const std::string& name) {
  std::error_code error;
  const std::filesystem::path root = std::filesystem::canonical(folder.empty() ? "." : folder, error);
  if (error) return refused(status_of(error.value()), "cannot open folder", folder.string(), error.message());
  std::filesystem::path file = std::filesystem::canonical(path, error);
  if (error) return refused(status_of(error.value()), "cannot open file", name, error.message());
  if (std::ranges::mismatch(root, file).in1 != root.end())
    return refused(Status::invalid_argument, kOutside, name, "it is " + file.string());
  return file;
}

Result<void> check_species_path(const AssetFolder& folder, std::string_view scene_path, std::string_view species) {
  if (folder.allow_outside) return {};
  const std::filesystem::path scene_folder = std::filesystem::path(scene_path).parent_path();
  const std::filesystem::path file = scene_folder / species;
  const std::filesystem::path root = folder.root.empty() ? scene_folder : std::filesystem::path(folder.root);
  const std::filesystem::path inside =
      folder.root.empty() ? std::filesystem::path(species) : file.lexically_normal().lexically_relative(root.lexically_normal());
  // Links above the scene may lead into the root where the text does not: then the resolved path alone decides.
  const bool by_letters = !folder.real_files || folder.root.empty();
  if (by_letters && !stays_inside(inside.native())) return refused(Status::invalid_argument, kOutside, std::string(species));
  if (!folder.real_files) return {};
  if (auto resolved = resolve_below(root, file, std::string(species)); !resolved) return resolved.error();
  return {};
}

}  // namespace coppice
