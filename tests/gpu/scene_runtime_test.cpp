// A scene through coppice.h: its tiles stream in, are drawn and go, under core and synchronization validation.

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>

#include "coppice/vulkan.h"
#include "golden.h"
#include "mentions.h"
#include "scene_context.h"

namespace coppice::test::scene_runtime_test {

using SceneRuntimeTest = SceneContextTest;

TEST_F(SceneRuntimeTest, TilesStreamInAreDrawnAndGo) {
  create(16384, true);
  open_scene();
  auto info = defaults(coppice_scene_info_init);
  ASSERT_EQ(coppice_scene_get_info(context_, scene_, &info), COPPICE_OK);
  EXPECT_EQ(info.instance_count, kPlants);
  EXPECT_EQ(info.species_count, 2u);
  EXPECT_EQ(info.height_max, 0.0f);
  const coppice_stats near = settle(view_from(0, 2, 0));
  EXPECT_EQ(near.scene_threshold_px, 1.0f);
  EXPECT_EQ(near.scene_instance_count, kPlants);
  EXPECT_EQ(near.scene_tiles_resident, near.scene_tiles_wanted);
  EXPECT_GT(near.instance_count, 1000u);
  EXPECT_GT(view_stats().visible_instance_count, 100u);
  EXPECT_GE(view_stats().drawn_leaf_count, view_stats().visible_instance_count);
  EXPECT_EQ(near.source_leaf_count, std::uint64_t{near.instance_count} * 600);
  const coppice_stats far = settle(view_from(0, 2, 50000));
  EXPECT_EQ(far.instance_count, 0u);
  EXPECT_EQ(far.scene_tiles_resident, 0u);
  EXPECT_EQ(settle(view_from(0, 2, 0)).instance_count, near.instance_count);
  EXPECT_EQ(coppice_scene_close(context_, scene_), COPPICE_OK);
  const coppice_stats closed = frame(view_from(0, 2, 0));
  EXPECT_EQ(closed.instance_count, 0u);
  EXPECT_EQ(closed.scene_tile_count, 0u);
  frame(view_from(0, 2, 0));
  EXPECT_EQ(coppice_scene_close(context_, scene_), COPPICE_ERROR_INVALID_ARGUMENT);
}

TEST_F(SceneRuntimeTest, WhereNotAllFitTheThresholdRises) {
  create(3000, false);
  open_scene();
  const coppice_stats stats = settle(view_from(0, 2, 0));
  EXPECT_GT(stats.scene_threshold_px, 1.0f);
  EXPECT_LE(stats.instance_count, 3000u);
  EXPECT_EQ(stats.scene_tiles_missing, 0u);
  EXPECT_GT(view_stats().visible_instance_count, 0u);
  EXPECT_EQ(log_, "");
}

TEST_F(SceneRuntimeTest, APlantOfTheSceneIsReloadedWhereItStands) {
  create(16384, true);
  open_scene();
  auto plant = defaults(coppice_scene_plant_info_init);
  ASSERT_EQ(coppice_scene_get_plant(context_, scene_, 1, &plant), COPPICE_OK);
  EXPECT_EQ(plant.path, folder_ / "plant2.coppice");
  EXPECT_EQ(plant.plant, 0u) << "nothing has wanted it yet";
  const coppice_stats before = settle(view_from(0, 2, 0));
  ASSERT_EQ(coppice_scene_get_plant(context_, scene_, 1, &plant), COPPICE_OK);
  ASSERT_NE(plant.plant, 0u);
  write_plant(folder_ / "plant2.coppice", {.leaf_count = 900, .seed = 3});
  ASSERT_EQ(coppice_plant_reload(context_, plant.plant, nullptr), COPPICE_OK) << log_;
  coppice_stats after{};
  for (int i = 0; i < 150; ++i) after = frame(view_from(0, 2, 0));
  EXPECT_EQ(info(plant.plant).leaf_count, 900u);
  EXPECT_EQ(after.instance_count, before.instance_count);
  EXPECT_GT(after.source_leaf_count, before.source_leaf_count);
  EXPECT_EQ(coppice_scene_get_plant(context_, scene_, 2, &plant), COPPICE_ERROR_INVALID_ARGUMENT);
}

TEST_F(SceneRuntimeTest, APlantThatIsNotThereIsLeftOut) {
  create(16384, false);
  ASSERT_EQ(coppice_scene_open(context_, (folder_ / "lost.forest").c_str(), nullptr, &scene_), COPPICE_OK) << log_;
  const coppice_stats stats = settle(view_from(0, 2, 0));
  EXPECT_NE(log_.find("lost.coppice"), std::string::npos) << log_;
  EXPECT_EQ(std::ranges::count(log_, '\n'), 1) << log_;
  EXPECT_EQ(stats.scene_tiles_missing, 0u);
  EXPECT_EQ(stats.scene_species_failed, 1u);
  EXPECT_GT(view_stats().visible_instance_count, 10u) << "the other one stands";
}

TEST_F(SceneRuntimeTest, WhatIsNoPlantOrNotInTheFolderIsLeftOutEachWithALine) {
  std::filesystem::create_directories(folder_ / "scenes");
  ASSERT_EQ(mkfifo((folder_ / "scenes/fifo.coppice").c_str(), 0600), 0);
  std::filesystem::create_symlink("../plant2.coppice", folder_ / "scenes/link.coppice");
  std::filesystem::copy_file(folder_ / "plant1.coppice", folder_ / "scenes/plant1.coppice");
  const std::filesystem::path scene = folder_ / "scenes/wood.forest";
  std::vector<bake::ScenePlant> plants(400);
  for (std::uint32_t i = 0; i < plants.size(); ++i) {
    plants[i].position_m = {static_cast<float>(i % 20), 0.0f, -static_cast<float>(i) / 20.0f};
    plants[i].species = static_cast<std::uint16_t>(i % 4);
  }
  write_file(scene, *bake::encode_scene(species({"plant1.coppice", "fifo.coppice", "../plant1.coppice", "link.coppice"}), plants));
  const std::string root = folder_.string();
  struct Case {
    const char* asset_root;
    VkBool32 allow_outside;
    std::uint32_t failed;
  };
  for (const Case& allowed : {Case{nullptr, VK_FALSE, 3}, Case{root.c_str(), VK_FALSE, 1}, Case{nullptr, VK_TRUE, 1}}) {
    log_.clear();
    ContextDesc with = desc();
    with.asset_root = allowed.asset_root;
    with.allow_outside = allowed.allow_outside;
    ContextTest::create(with);
    ASSERT_EQ(coppice_scene_open(context_, scene.c_str(), nullptr, &scene_), COPPICE_OK) << log_;
    const coppice_stats stats = settle(view_from(10, 2, 5));
    EXPECT_EQ(stats.scene_species_failed, allowed.failed) << log_;
    EXPECT_EQ(stats.instance_count, 100 * (4 - allowed.failed)) << log_;
    EXPECT_EQ(std::ranges::count(log_, '\n'), static_cast<std::ptrdiff_t>(allowed.failed)) << log_;
    EXPECT_EQ(lines_that_name(log_, "fifo.coppice"), 1u) << log_;
    destroy();
  }
}

/// Seen from the same place relative to it, a scene looks the same wherever it stands and however it is turned.
TEST_F(SceneRuntimeTest, ASceneStandsWhereItIsPlacedAndMoves) {
  create(16384, true);
  Shot view = view_from(0, 6, 0);
  std::copy_n(std::array{0.0f, 1.0f, 0.0f}.data(), 3, view.light.sun_direction);  // which does not turn with it
  open_scene();
  const coppice_stats there = settle(view);
  const Picture plain = ContextTest::frame(view);
  auto placement = defaults(coppice_scene_placement_init);
  // A quarter turn about +y: what lay towards -z lies towards -x.
  placement.rotation[1] = placement.rotation[3] = std::sqrt(0.5f);
  std::copy_n(std::array{40000.0, 100.0, -7000.0}.data(), 3, placement.position);
  const auto eye = [&](float x, float y, float z) {
    Shot turned = make_view({.eye_m = {x, y, z}, .target_m = {x - 10.0f, y, z}, .width_px = 128});
    std::copy_n(view.light.sun_direction, 3, turned.light.sun_direction);
    return turned;
  };
  const Shot turned = eye(40000.0f, 106.0f, -7000.0f);
  ASSERT_EQ(coppice_scene_move(context_, scene_, &placement), COPPICE_OK) << log_;
  const coppice_stats moved = settle(turned);
  EXPECT_EQ(moved.instance_count, there.instance_count);
  EXPECT_EQ(moved.bytes_read, there.bytes_read) << "nothing of a plant is read again";
  EXPECT_LT(compare_pictures(ContextTest::frame(turned), plain, 40).differing_share, 0.05) << "cuts differ with slots";
  ASSERT_EQ(coppice_scene_close(context_, scene_), COPPICE_OK);
  ASSERT_EQ(coppice_scene_open(context_, scene_path().c_str(), &placement, &scene_), COPPICE_OK) << log_;
  EXPECT_EQ(settle(turned).instance_count, there.instance_count);
  EXPECT_LT(compare_pictures(ContextTest::frame(turned), plain, 40).differing_share, 0.05) << "cuts differ with slots";
  placement.rotation[3] = 2.0f;
  EXPECT_EQ(coppice_scene_move(context_, scene_, &placement), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(mentions(log_, {"placement.rotation"}));
}

TEST_F(SceneRuntimeTest, SeveralScenesStandSideBySide) {
  create(65536, false);
  open_scene();
  const coppice_stats one = settle(view_from(0, 2, 0));
  auto aside = defaults(coppice_scene_placement_init);
  aside.position[0] = 50000.0;
  coppice_scene second = 0;
  ASSERT_EQ(coppice_scene_open(context_, scene_path().c_str(), &aside, &second), COPPICE_OK) << log_;
  EXPECT_NE(second, scene_);
  const coppice_stats here = settle(view_from(0, 2, 0)), there = settle(view_from(50000.0f, 2, 0));
  EXPECT_EQ(here.instance_count, one.instance_count);
  EXPECT_EQ(there.instance_count, one.instance_count);
  EXPECT_EQ(here.scene_instance_count, 2 * one.scene_instance_count);
  EXPECT_EQ(here.scene_tile_count, 2 * one.scene_tile_count);
  ASSERT_EQ(coppice_scene_close(context_, scene_), COPPICE_OK);
  EXPECT_EQ(coppice_scene_close(context_, scene_), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(settle(view_from(50000.0f, 2, 0)).instance_count, one.instance_count);
  EXPECT_EQ(coppice_scene_close(context_, second), COPPICE_OK);
}

TEST_F(SceneRuntimeTest, WrongFilesAreRefused) {
  create(1000, false);
  EXPECT_EQ(coppice_scene_open(context_, (folder_ / "none.forest").c_str(), nullptr, &scene_), COPPICE_ERROR_IO);
  EXPECT_EQ(coppice_scene_open(context_, (folder_ / "plant1.coppice").c_str(), nullptr, &scene_), COPPICE_ERROR_BAD_FILE);
  EXPECT_TRUE(mentions(log_, {"plant1.coppice: magic"}));
  EXPECT_EQ(std::ranges::count(log_, '\n'), 2) << log_;
  EXPECT_EQ(scene_, 0u);
  EXPECT_EQ(coppice_scene_open(context_, nullptr, nullptr, &scene_), COPPICE_ERROR_INVALID_ARGUMENT);
  open_scene();
  coppice_scene_info info{};
  EXPECT_EQ(coppice_scene_get_info(context_, scene_, &info), COPPICE_ERROR_INVALID_ARGUMENT) << "struct_size";
  frame(view_from(0, 2, 0));
  coppice_context* const other = std::exchange(context_, nullptr);
  create(1000, false);
  EXPECT_EQ(coppice_scene_close(context_, scene_), COPPICE_ERROR_INVALID_ARGUMENT) << "a scene of another context";
  EXPECT_TRUE(mentions(log_, {"coppice_scene_close: scene", "context"}));
  coppice_context_destroy(std::exchange(context_, other));
  EXPECT_EQ(coppice_scene_close(context_, scene_), COPPICE_OK) << "with reads under way";
  EXPECT_EQ(coppice_scene_open(context_, scene_path().c_str(), nullptr, &scene_), COPPICE_OK) << log_;
}

}  // namespace coppice::test::scene_runtime_test
