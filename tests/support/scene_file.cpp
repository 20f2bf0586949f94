#include "scene_file.h"

#include <cstdlib>
#include <cstring>
#include <random>
#include <span>

#include "layout.h"

namespace coppice::test {
namespace {

template <class T>
T get(std::span<const std::uint8_t> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void put_checksum(std::vector<std::uint8_t>& bytes, std::size_t at, std::size_t first, std::size_t count) {
  const std::uint64_t value = checksum(std::span(bytes).subspan(first, count));
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

}  // namespace

std::vector<SceneSpecies> scene_species() {
  return {{"shrub.coppice", {0, 0.5f, 0}, 1.0f}, {"trees/oak.coppice", {0, 3, 0}, 4.0f}};
}

std::vector<bake::ScenePlant> random_scene_plants(std::size_t count, float side_m, std::uint32_t seed) {
  std::mt19937 random(seed);
  // std::uniform_real_distribution differs between libraries.
  const auto share = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  std::vector<bake::ScenePlant> plants(count);
  for (std::size_t i = 0; i < count; ++i) {
    const float x = side_m * (share() - 0.5f), z = side_m * (share() - 0.5f);
    plants[i].position_m = {x, 0.01f * x, z};
    plants[i].scale = 0.5f + share();
    plants[i].species = i % 4 == 0 ? 1 : 0;
    plants[i].yaw = static_cast<std::uint16_t>(random() >> 16);
    plants[i].mirrored = i % 3 == 0;
    plants[i].tint = bake::pack_tint({0.8f + 0.4f * share(), 1.0f, share()});
  }
  return plants;
}

std::vector<std::uint8_t> random_scene(std::size_t count, float side_m, std::uint32_t seed) {
  std::vector<bake::ScenePlant> plants = random_scene_plants(count, side_m, seed);
  const std::vector<SceneSpecies> species = scene_species();
  auto bytes = bake::encode_scene(species, plants);
  if (!bytes) std::abort();
  return *std::move(bytes);
}

void fix_scene_checksums(std::vector<std::uint8_t>& file) {
  if (file.size() < kSceneHeaderBytes) return;
  const auto header = get<coppice_scene_header>(file, 0);
  const std::uint64_t front_bytes = scene_front_bytes(header);
  if (front_bytes <= file.size()) {
    const auto front = static_cast<std::size_t>(front_bytes);
    std::size_t at = front;
    for (std::size_t entry = front - header.tile_count * sizeof(coppice_scene_tile); entry < front; entry += sizeof(coppice_scene_tile)) {
      const std::size_t bytes = std::size_t{get<coppice_scene_tile>(file, entry).instance_count} * sizeof(coppice_scene_instance);
      if (bytes > file.size() - at) break;
      put_checksum(file, entry + offsetof(coppice_scene_tile, checksum), at, bytes);
      at += bytes;
    }
    put_checksum(file, offsetof(coppice_scene_header, front_checksum), kSceneHeaderBytes, front - kSceneHeaderBytes);
  }
  put_checksum(file, offsetof(coppice_scene_header, header_checksum), 0, offsetof(coppice_scene_header, header_checksum));
}

}  // namespace coppice::test
