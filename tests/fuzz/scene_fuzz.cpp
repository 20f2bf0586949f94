// libFuzzer: any bytes, with their checksums made right, are refused or are a valid scene. The checks trap, so that a wrong answer is found
// like a crash.

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "check.h"
#include "scene_file.h"
#include "scene_reader.h"

namespace {

void check_instance(const coppice::SceneFile& scene, const coppice::SceneTile& tile, const coppice::SceneInstance& instance) {
  COPPICE_ASSERT(instance.species < scene.species.size());
  COPPICE_ASSERT(instance.scale > 0.0f && std::isfinite(instance.scale) && std::isfinite(instance.yaw_rad));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    COPPICE_ASSERT(std::isfinite(instance.position_m[axis]) && instance.tint[axis] >= 0.0f && instance.tint[axis] < 2.0f);
    COPPICE_ASSERT(std::abs(instance.position_m[axis] - tile.entry.box_min[axis]) <=
                   1.0001f * (tile.entry.box_max[axis] - tile.entry.box_min[axis]) + 1e-6f * std::abs(tile.entry.box_min[axis]));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> file(data, data + size);
  coppice::test::fix_scene_checksums(file);
  const auto scene = coppice::read_scene_front(file, file.size());
  if (!scene) {
    COPPICE_ASSERT(scene.error().offset != coppice::Error::kNoOffset);
    return 0;
  }
  std::size_t next_child = 1;
  std::vector<coppice::SceneInstance> instances;
  for (const coppice::SceneTile& tile : scene->tiles) {
    if (tile.entry.child_mask != 0) COPPICE_ASSERT(tile.entry.first_child == next_child);
    next_child += static_cast<std::size_t>(std::popcount(tile.entry.child_mask));
    COPPICE_ASSERT(tile.offset + tile.bytes <= file.size());
    instances.resize(tile.entry.instance_count);
    const auto bytes = std::span(file).subspan(static_cast<std::size_t>(tile.offset), tile.bytes);
    if (!coppice::read_scene_tile(*scene, tile, bytes, instances)) continue;
    for (const coppice::SceneInstance& instance : instances) check_instance(*scene, tile, instance);
  }
  COPPICE_ASSERT(next_child == scene->tiles.size());
  return 0;
}
