#include "verify_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "atomic_file.h"
#include "inspect.h"
#include "printable.h"
#include "reader.h"
#include "scene_reader.h"

namespace coppice::bake {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// Checks the sphere: the scene's tiles were chosen by the sphere of the plant at that time. A plant that has changed since appears too
/// early or too late.
Result<void> check_sphere(const SceneFileSpecies& species, const coppice_file_plant& plant) {
  const float slack_m = 0.01f * species.sphere_radius_m;
  float offset_m = 0.0f;
  for (std::size_t axis = 0; axis < 3; ++axis)
    offset_m = std::max(offset_m, std::abs(plant.sphere_center[axis] - species.sphere_center[axis]));
  if (offset_m <= slack_m && std::abs(plant.sphere_radius - species.sphere_radius_m) <= slack_m) return {};
  return Error{Status::bad_file, "its bounding sphere is not the one in the scene: make the scene again", Error::kNoOffset,
               "radius " + std::to_string(plant.sphere_radius) + " m, in the scene " + std::to_string(species.sphere_radius_m) + " m"};
}

Result<void> check_species(const SceneFileSpecies& species, const std::filesystem::path& folder, OutsideFiles outside) {
  if (!is_printable(species.path)) return Error{Status::bad_file, "control characters in its path"};
  std::filesystem::path path = folder / species.path;
  if (outside == OutsideFiles::refused) {
    COPPICE_TRY(inside, resolve_inside(folder, species.path));
    path = std::move(inside);
  }
  COPPICE_TRY(bytes, read_file(path));
  COPPICE_CHECK(verify(bytes));
  COPPICE_TRY(front, read_front(bytes, bytes.size()));
  return check_sphere(species, front.plant);
}

/// Prepends "species 3, oaks/large.coppice: ".
Error about_species(std::uint32_t index, const SceneFileSpecies& species, const Error& error) {
  return Error{error.status, "a species of the scene", Error::kNoOffset,
               std::to_string(index) + ", " + std::string(species.path) + ": " + error.message()};
}

}  // namespace

bool is_scene(Bytes file) {
  constexpr std::size_t kMagicBytes = sizeof(coppice_scene_header::magic);
  return file.size() >= kMagicBytes && std::memcmp(file.data(), COPPICE_SCENE_MAGIC, kMagicBytes) == 0;
}

SceneVerifyReport verify_scene(Bytes file, const std::filesystem::path& folder, OutsideFiles outside) {
  SceneVerifyReport report;
  const auto scene = read_scene_front(file, file.size());
  if (!scene) {
    report.errors.push_back(scene.error());
    return report;
  }
  for (const SceneFileSpecies& species : scene->species) {
    if (const auto checked = check_species(species, folder, outside); !checked)
      report.errors.push_back(about_species(report.species_checked, species, checked.error()));
    ++report.species_checked;
  }
  std::vector<SceneInstance> instances(COPPICE_MAX_TILE_INSTANCES);
  for (const SceneTile& tile : scene->tiles) {
    const Bytes bytes = file.subspan(static_cast<std::size_t>(tile.offset), tile.bytes);
    if (const auto read = read_scene_tile(*scene, tile, bytes, instances); !read) report.errors.push_back(read.error());
    ++report.tiles_checked;
    report.plants_checked += tile.entry.instance_count;
  }
  report.bytes_checked = file.size();
  return report;
}

}  // namespace coppice::bake
