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
  const coppice_scene_tile& entry = tile.entry;
  COPPICE_ASSERT(instance.species < scene.species.size());
  COPPICE_ASSERT(std::isfinite(instance.scale) && instance.scale >= 0.999f * entry.scale_min && instance.scale <= 1.001f * entry.scale_max);
  COPPICE_ASSERT(instance.scale > 0.0f && std::isfinite(instance.scale * scene.species[instance.species].sphere_radius_m));
  COPPICE_ASSERT(instance.yaw_rad >= 0.0f && instance.yaw_rad < 6.2832f);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    COPPICE_ASSERT(std::isfinite(instance.position_m[axis]) && instance.tint[axis] >= 0.0f && instance.tint[axis] < 2.0f);
    const float slack_m = 1e-6f * (std::abs(entry.box_min[axis]) + std::abs(entry.box_max[axis]));
    COPPICE_ASSERT(instance.position_m[axis] >= entry.box_min[axis] - slack_m);
    COPPICE_ASSERT(instance.position_m[axis] <= entry.box_max[axis] + slack_m);
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
