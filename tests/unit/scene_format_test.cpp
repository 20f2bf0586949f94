// The .forest file: writer and reader.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include "atomic_file.h"
#include "gltf_builder.h"
#include "mentions.h"
#include "places.h"
#include "results.h"
#include "scene_file.h"
#include "scene_reader.h"
#include "scene_write.h"

namespace coppice::scene_format_test {

using Bytes = std::vector<std::uint8_t>;

/// From a heap block of exactly its size, so that a sanitizer sees a read past the end. Every tile is read.
Result<std::vector<std::vector<SceneInstance>>> read_all(const Bytes& bytes, SceneFile* scene_out = nullptr) {
  const auto block = std::make_unique<std::uint8_t[]>(bytes.size());
  std::ranges::copy(bytes, block.get());
  const std::span<const std::uint8_t> file(block.get(), bytes.size());
  COPPICE_TRY(scene, read_scene_front(file, file.size()));
  std::vector<std::vector<SceneInstance>> tiles;
  for (const SceneTile& tile : scene.tiles) {
    std::vector<SceneInstance> instances(tile.entry.instance_count);
    COPPICE_CHECK(read_scene_tile(scene, tile, file.subspan(static_cast<std::size_t>(tile.offset), tile.bytes), instances));
    tiles.push_back(std::move(instances));
  }
  if (scene_out != nullptr) *scene_out = std::move(scene);
  return tiles;
}

/// Bytes before the first instance; the entries of tiles end there.
std::size_t front_bytes(const Bytes& scene) {
  return static_cast<std::size_t>(scene_front_bytes(test::must(read_scene_front(scene, scene.size())).header));
}

TEST(SceneFile, HoldsEveryPlantOnceWithinHalfAStep) {
  std::vector<bake::ScenePlant> plants = test::random_scene_plants(30000, 3000, 1);
  SceneFile scene;
  const auto tiles = test::must(read_all(test::random_scene(30000, 3000, 1), &scene));
  EXPECT_EQ(scene.header.instance_count, plants.size());
  ASSERT_EQ(scene.species.size(), 2u);
  EXPECT_EQ(scene.species[1].path, "trees/oak.coppice");
  EXPECT_EQ(scene.species[1].sphere_radius_m, 4.0f);
  EXPECT_EQ(scene.species[1].sphere_center, (std::array<float, 3>{0, 3, 0}));
  // Each read plant is nearest to the one written: 30,000 on 3 km stand metres apart, a step of the root tile is 5 cm.
  std::vector<bool> found(plants.size());
  std::ranges::sort(plants, {}, [](const bake::ScenePlant& plant) { return plant.position_m[0]; });
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const coppice_scene_tile& entry = scene.tiles[t].entry;
    const float step_m = std::max(entry.box_max[0] - entry.box_min[0], entry.box_max[2] - entry.box_min[2]) / 65535.0f;
    for (const SceneInstance& instance : tiles[t]) {
      auto at =
          std::ranges::lower_bound(plants, instance.position_m[0] - step_m, {}, [](const auto& plant) { return plant.position_m[0]; });
      for (; at != plants.end() && std::abs(at->position_m[2] - instance.position_m[2]) > step_m; ++at) {
      }
      ASSERT_NE(at, plants.end());
      EXPECT_NEAR(at->position_m[0], instance.position_m[0], 0.51f * step_m + 1e-4f);
      EXPECT_NEAR(at->position_m[1], instance.position_m[1], 1e-3f);
      EXPECT_EQ(at->species, instance.species);
      EXPECT_EQ(at->mirrored, instance.mirrored);
      const float scale_step = std::pow(entry.scale_max / entry.scale_min, 1.0f / 255.0f);
      EXPECT_LE(instance.scale, at->scale * 1.0001f);
      EXPECT_GE(instance.scale * scale_step, at->scale * 0.9999f);
      const float turn = std::abs(instance.yaw_rad / (2 * std::numbers::pi_v<float>)-static_cast<float>(at->yaw) / 65536.0f);
      EXPECT_LE(std::min(turn, 1 - turn), 0.5f / 256 + 1e-5f);
      EXPECT_EQ(bake::pack_tint(instance.tint), at->tint);
      const auto index = static_cast<std::size_t>(at - plants.begin());
      EXPECT_FALSE(found[index]) << "twice";
      found[index] = true;
    }
  }
  EXPECT_EQ(std::ranges::count(found, true), 30000);
}

TEST(SceneFile, ATileHoldsTheLargestOfItsSquareAndSomeOfEveryPart) {
  SceneFile scene;
  const auto tiles = test::must(read_all(test::random_scene(30000, 3000, 2), &scene));
  ASSERT_GT(scene.tiles.size(), 15u);
  EXPECT_GT(scene.tiles[0].entry.instance_count, COPPICE_MAX_TILE_INSTANCES - 8) << "no cell of the grid is likely to be empty";
  const auto radius_m = [&](const SceneInstance& instance) { return instance.scale * scene.species[instance.species].sphere_radius_m; };
  for (std::size_t t = 0; t < scene.tiles.size(); ++t) {
    const SceneTile& tile = scene.tiles[t];
    float largest_m = 0.0f;
    for (const SceneInstance& instance : tiles[t]) {
      largest_m = std::max(largest_m, radius_m(instance));
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_GE(instance.position_m[2 * i], tile.square_min_m[i]);
        EXPECT_LE(instance.position_m[2 * i], tile.square_min_m[i] + tile.square_side_m);
      }
    }
    EXPECT_NEAR(largest_m, tile.entry.max_radius, 1e-2f * largest_m);
    const auto children = static_cast<std::uint32_t>(std::popcount(tile.entry.child_mask));
    for (std::uint32_t child = 0; child < children; ++child)
      EXPECT_LE(scene.tiles[tile.entry.first_child + child].entry.max_radius, tile.entry.max_radius);
  }
  // 3,000 plants are larger than 4.4 m; the root has a thousand of them, and its other thousand stands all over the square.
  std::array<int, 64> cells{};
  for (const SceneInstance& instance : tiles[0]) {
    const auto cell = [](float at) { return static_cast<std::size_t>(std::clamp((at + 1500.0f) / 3000.0f * 8.0f, 0.0f, 7.0f)); };
    ++cells[cell(instance.position_m[2]) * 8 + cell(instance.position_m[0])];
  }
  for (const int count : cells) EXPECT_GT(count, 10);
}

TEST(SceneFile, IsAFunctionOfItsPlantsWhateverTheirOrder) {
  const std::vector<SceneSpecies> species = test::scene_species();
  std::vector<bake::ScenePlant> plants = test::random_scene_plants(9000, 500, 3);
  std::vector<bake::ScenePlant> reversed(plants.rbegin(), plants.rend());
  EXPECT_EQ(*bake::encode_scene(species, plants), *bake::encode_scene(species, reversed));
}

TEST(SceneFile, OnePlantIsAScene) {
  std::vector<bake::ScenePlant> plants(1);
  plants[0].position_m = {-7.25f, 3.0f, 1e5f};
  plants[0].scale = 2.0f;
  const auto tiles = test::must(read_all(*bake::encode_scene(test::scene_species(), plants)));
  EXPECT_EQ(tiles[0][0].position_m, plants[0].position_m);
  EXPECT_EQ(tiles[0][0].scale, 2.0f);
  EXPECT_EQ(tiles[0][0].tint, (std::array<float, 3>{1, 1, 1})) << "no tint is exactly none";
}

TEST(SceneFile, WhatIsNoSceneIsNotWritten) {
  const auto species = test::scene_species();
  const auto refusal = [&](std::vector<bake::ScenePlant> plants) {
    const auto bytes = bake::encode_scene(species, plants);
    return bytes ? std::string("written") : bytes.error().message();
  };
  EXPECT_NE(refusal({}), "written");
  std::vector<bake::ScenePlant> plants(3);
  plants[1].species = 2;
  EXPECT_TRUE(test::mentions(refusal(plants), {"plant 1"}));
  plants[1] = {};
  plants[2].position_m[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(test::mentions(refusal(plants), {"plant 2"}));
  EXPECT_NE(refusal(std::vector<bake::ScenePlant>(60000)), "written") << "all in one place";
  // What the reader would refuse.
  plants = std::vector<bake::ScenePlant>(2);
  plants[0].scale = 1e-24f;
  EXPECT_NE(refusal(plants), "written");
  plants[0].scale = 1e-23f;
  plants[1].scale = 1e6f;
  EXPECT_TRUE(read_all(test::must(bake::encode_scene(species, plants))));
}

TEST(SceneFile, EveryTruncationIsRefused) {
  const Bytes good = test::random_scene(40, 100, 4);
  ASSERT_TRUE(read_all(good));
  for (std::size_t n = 0; n < good.size(); ++n)
    EXPECT_FALSE(read_all(Bytes(good.data(), good.data() + n))) << n << " of " << good.size() << " bytes accepted";
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_FALSE(read_all(longer));
}

TEST(SceneFile, EveryFlippedByteIsRefused) {
  const Bytes good = test::random_scene(40, 100, 4);
  for (std::size_t i = 0; i < good.size(); ++i) {
    Bytes flipped = good;
    flipped[i] ^= 0xff;
    const auto read = read_all(flipped);
    ASSERT_FALSE(read) << "byte " << i << " of " << good.size();
    EXPECT_NE(read.error().offset, Error::kNoOffset) << i;
  }
}

TEST(SceneFile, EveryFlippedByteUnderRightChecksumsIsRefusedOrValid) {
  const Bytes good = test::random_scene(5000, 100, 5);
  const std::size_t front = front_bytes(good);
  int refused = 0;
  for (std::size_t i = 0; i < front + 2 * sizeof(coppice_scene_instance); ++i)
    for (const std::uint8_t flip : {std::uint8_t{0x80}, std::uint8_t{0xff}, std::uint8_t{0x01}}) {
      Bytes flipped = good;
      flipped[i] ^= flip;
      test::fix_scene_checksums(flipped);
      const auto read = read_all(flipped);
      refused += read ? 0 : 1;
      if (!read) continue;
      for (const auto& tile : *read)
        for (const SceneInstance& instance : tile)
          ASSERT_TRUE(instance.species < 2 && instance.scale > 0.0f && std::isfinite(instance.scale) &&
                      std::isfinite(instance.position_m[0]));
    }
  EXPECT_GT(refused, static_cast<int>(front)) << "a third of them at least";
}

/// What an error names before its colon: "tile max_radius" of "tile max_radius: larger than its parent's".
std::string field_of(const Error& error) {
  const std::string what = error.what;
  return what.substr(0, what.find(':'));
}

/// Puts a value into a file, under right checksums.
template <class T>
Bytes with_value(Bytes bytes, std::size_t at, const T& value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
  test::fix_scene_checksums(bytes);
  return bytes;
}

TEST(SceneFile, RefusalsNameTheFieldAndItsPlace) {
  const Bytes good = test::random_scene(5000, 100, 6);
  const std::size_t species = kSceneHeaderBytes, first = front_bytes(good);
  const std::size_t tiles = first - read_scene_front(good, good.size())->header.tile_count * sizeof(coppice_scene_tile);
  // One value changed under right checksums, and the field of the error it must give.
  struct Damage {
    const char* field;
    std::size_t at;
    std::uint32_t value;
  };
  const Damage damages[] = {
      {"magic", 0, 0x4c454c41},
      {"version", offsetof(coppice_scene_header, version), 2},
      {"species_count", offsetof(coppice_scene_header, species_count), 0},
      {"tile_count", offsetof(coppice_scene_header, tile_count), 0xffffffff},
      {"path_bytes", offsetof(coppice_scene_header, path_bytes), 1},
      {"instance_count", offsetof(coppice_scene_header, instance_count), 0},
      {"file_bytes", offsetof(coppice_scene_header, file_bytes), 1},
      {"square_min", offsetof(coppice_scene_header, square_min), 0x7fc00000},
      {"square_side", offsetof(coppice_scene_header, square_side), 0x80000000},
      {"reserved", offsetof(coppice_scene_header, reserved), 1},
      {"species path_offset", species, 1},
      {"species path_bytes", species + offsetof(coppice_scene_species, path_bytes), 2000},
      {"species sphere_center", species + offsetof(coppice_scene_species, sphere_center), 0x7f800000},
      {"species sphere_radius", species + offsetof(coppice_scene_species, sphere_radius), 0},
      {"tile box", tiles, 0x7f800000},
      {"tile scale_min, scale_max", tiles + offsetof(coppice_scene_tile, scale_min), 0},
      {"tile max_radius", tiles + offsetof(coppice_scene_tile, max_radius), 0x7fc00000},
      {"tile instance_count", tiles + offsetof(coppice_scene_tile, instance_count), 0},
      {"tile first_child", tiles + offsetof(coppice_scene_tile, first_child), 2},
      {"tile child_mask", tiles + offsetof(coppice_scene_tile, child_mask), 0x1f},
      {"tile max_radius", tiles + sizeof(coppice_scene_tile) + offsetof(coppice_scene_tile, max_radius), 0x447a0000},
      {"instance species", first + offsetof(coppice_scene_instance, species), 7},
  };
  for (const Damage& damage : damages) {
    const auto read = read_all(with_value(good, damage.at, damage.value));
    EXPECT_EQ(field_of(read.error()), damage.field);
    EXPECT_EQ(read.error().status, Status::bad_file) << damage.field;
    EXPECT_EQ(read.error().offset, damage.at) << damage.field;
  }
  const std::size_t path = kSceneHeaderBytes + 2 * sizeof(coppice_scene_species);
  EXPECT_EQ(field_of(read_all(with_value(good, path, '/')).error()), "species path") << "it is absolute";
}

// Each is in range; their ratio is infinite, and an instance of scale 0 would stand at NaN.
TEST(SceneFile, ScalesThatAreTooFarApartAreRefused) {
  const Bytes good = test::random_scene(60, 100, 7);
  const std::size_t tile = front_bytes(good) - sizeof(coppice_scene_tile);
  const auto with_scales = [&](float scale_min, float scale_max) {
    Bytes bytes = good;
    for (std::size_t instance = tile + sizeof(coppice_scene_tile); instance < bytes.size(); instance += sizeof(coppice_scene_instance))
      bytes[instance + offsetof(coppice_scene_instance, scale)] = 0;
    bytes = with_value(bytes, tile + offsetof(coppice_scene_tile, scale_min), scale_min);
    return with_value(bytes, tile + offsetof(coppice_scene_tile, scale_max), scale_max);
  };
  for (const float scale_min : {1e-45f, 1e-38f, 1e-33f}) {
    const auto read = read_all(with_scales(scale_min, 1e6f));
    EXPECT_EQ(field_of(read.error()), "tile scale_min, scale_max") << scale_min;
    EXPECT_EQ(read.error().offset, tile + offsetof(coppice_scene_tile, scale_min));
  }
  for (const auto& [scale_min, scale_max] : {std::pair{1e-23f, 1e6f}, std::pair{1e-45f, 1e-44f}}) {
    const auto read = test::must(read_all(with_scales(scale_min, scale_max)));
    for (const SceneInstance& instance : read.front()) ASSERT_GT(instance.scale, 0.0f);
  }
}

// One float of the front at a time is NaN, under right checksums.
TEST(SceneFile, NoFloatMayBeNaN) {
  const Bytes good = test::random_scene(60, 100, 7);
  const std::size_t tile = front_bytes(good) - sizeof(coppice_scene_tile);
  std::vector<std::size_t> floats;
  for (std::size_t i = 0; i < 3; ++i) floats.push_back(offsetof(coppice_scene_header, square_min) + 4 * i);
  for (std::size_t species = 0; species < 2; ++species)
    for (std::size_t i = 0; i < 4; ++i)
      floats.push_back(kSceneHeaderBytes + species * sizeof(coppice_scene_species) + offsetof(coppice_scene_species, sphere_center) +
                       4 * i);
  for (std::size_t i = 0; i < 9; ++i) floats.push_back(tile + 4 * i);
  for (const std::size_t at : floats)
    EXPECT_FALSE(read_all(with_value(good, at, std::numeric_limits<float>::quiet_NaN()))) << "byte " << at;
}

TEST(SceneFile, Version1IsReadForEver) {
  const std::filesystem::path path = std::filesystem::path(test::kTestData) / "scene_v1" / "small.forest";
  if (std::getenv("COPPICE_UPDATE_GOLDEN") != nullptr && !std::filesystem::exists(path)) {
    std::filesystem::create_directories(path.parent_path());
    test::write_file(path, test::random_scene(60, 100, 7));
  }
  const Bytes bytes = *bake::read_file(path);
  SceneFile scene;
  const auto tiles = test::must(read_all(bytes, &scene));
  EXPECT_EQ(scene.species[0].path, "shrub.coppice");
  ASSERT_EQ(tiles.size(), 1u);
  EXPECT_EQ(tiles.front().size(), 60u);
  EXPECT_EQ(bytes, test::random_scene(60, 100, 7)) << "the writer still writes it";
}

}  // namespace coppice::scene_format_test
