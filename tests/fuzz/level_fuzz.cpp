// libFuzzer: any bytes as the level of `coppice scene` are refused with a named error, or are plants that a scene takes, or says why it
// does not, and that a reader then finds in it.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "check.h"
#include "level_import.h"
#include "scene_reader.h"
#include "scratch_file.h"

namespace {

const std::vector<std::string> kNames = {"oak", "shrub"};

void check_scene(std::vector<coppice::bake::ScenePlant>& plants) {
  const std::vector<coppice::SceneSpecies> species = {{"oak.coppice", {0, 3, 0}, 4.0f}, {"shrub.coppice", {0, 0.5f, 0}, 1.0f}};
  const std::size_t count = plants.size();
  const auto bytes = coppice::bake::encode_scene(species, plants);
  if (!bytes) {
    COPPICE_ASSERT(bytes.error().status == coppice::Status::invalid_argument);
    return;
  }
  const auto scene = coppice::read_scene_front(*bytes, bytes->size());
  COPPICE_ASSERT(scene && scene->header.instance_count == count);
  for (const coppice::SceneTile& tile : scene->tiles) {
    std::vector<coppice::SceneInstance> instances(tile.entry.instance_count);
    const auto stored = std::span(*bytes).subspan(static_cast<std::size_t>(tile.offset), tile.bytes);
    COPPICE_ASSERT(coppice::read_scene_tile(*scene, tile, stored, instances));
    for (const coppice::SceneInstance& instance : instances) COPPICE_ASSERT(std::isfinite(instance.scale) && instance.scale > 0.0f);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path path = coppice::test::scratch_file("level.glb", {data, size});
  auto scene = coppice::bake::import_level(path, kNames, {});
  if (!scene) {
    COPPICE_ASSERT(!scene.error().message().empty());
    return 0;
  }
  COPPICE_ASSERT(scene->tilted_count <= scene->plants.size() && scene->stretched_count <= scene->plants.size());
  for (const coppice::bake::ScenePlant& plant : scene->plants) COPPICE_ASSERT(plant.species < kNames.size());
  if (!scene->plants.empty() && scene->plants.size() <= 1u << 14) check_scene(scene->plants);
  return 0;
}
