// The runtime through coppice.h: a file is opened, streams in, is drawn, moved, closed, under core and synchronization validation.

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numeric>
#include <span>
#include <string>

#include <glm/common.hpp>

#include "context_fixture.h"
#include "coppice/vulkan.h"
#include "counted_memory.h"
#include "device_memory_hook.h"
#include "fake_hooks.h"
#include "mentions.h"

namespace coppice::test::runtime_test {

constexpr std::uint32_t kSidePx = 128;

coppice_placement at(float x, float z) {
  return placement_at({x, 0.0f, z});
}

Shot front_view() {
  return make_view({.eye_m = {0.0f, 0.3f, 5.0f}, .width_px = kSidePx});
}

class RuntimeTest : public ContextTest {
 protected:
  void SetUp() override {
    ContextTest::SetUp();
    plant_path_ = temporary_plant({.leaf_count = 3000, .seed = 5}, "runtime_test");
  }

  void TearDown() override {
    std::filesystem::remove(plant_path_);
    ContextTest::TearDown();
  }

  /// A context, and the plant before its camera.
  coppice_plant create_planted(const ContextDesc& with) {
    create(with);
    const coppice_plant plant = open(plant_path_);
    add(plant, at(0.0f, 0.0f));
    return plant;
  }

  std::string plant_path_;
};

TEST_F(RuntimeTest, StreamsInAndDraws) {
  const coppice_plant plant = create_planted(desc());

  Shot view = front_view();
  EXPECT_GT(drawn_pixels(frame(view)), 100u) << "the first frame already shows the plant";
  view.lod = COPPICE_LOD_FULL;
  const Picture full = settle(view);
  EXPECT_EQ(info(plant).resident_leaf_count, 3000u);
  frame(view);
  EXPECT_EQ(view_stats().drawn_leaf_count, 3000u);
  EXPECT_EQ(view_stats().visible_instance_count, 1u);
  EXPECT_GT(view_stats().drawn_wood_triangle_count, 0u);
  EXPECT_LE(stats().memory_bytes, stats().memory_budget_bytes);
  EXPECT_GT(drawn_pixels(full), std::size_t{kSidePx} * kSidePx / 20);
}

TEST_F(RuntimeTest, TheBoxHoldsLeavesAndTheCoarsestWood) {
  create(desc());
  const coppice_plant_info now = info(open(plant_path_));
  const bake::BakedPlant source = random_plant({.leaf_count = 3000, .seed = 5});
  glm::vec3 low(INFINITY), high(-INFINITY);
  for (const auto* points : {&source.tree.vertices, &source.wood.lods.back().positions})
    for (const glm::vec3& point : *points) {
      low = glm::min(low, point);
      high = glm::max(high, point);
    }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(now.box_min[axis], low[axis], 1e-3f);
    EXPECT_NEAR(now.box_max[axis], high[axis], 1e-3f);
  }
}

TEST_F(RuntimeTest, CutsFollowTheThreshold) {
  create_planted(desc());
  Shot view = front_view();
  std::uint64_t finer = ~std::uint64_t{0};
  for (const float error_px : {0.01f, 0.3f, 1.0f, 1000.0f}) {
    view.error_px = error_px;
    settle(view);
    frame(view);
    EXPECT_LE(view_stats().drawn_leaf_count, finer) << error_px;
    finer = view_stats().drawn_leaf_count;
  }
  EXPECT_EQ(finer, 1u);
}

TEST_F(RuntimeTest, ALeafBudgetMakesAllPlantsCoarser) {
  for (const VkBool32 compute_raster : {VK_FALSE, VK_TRUE}) {
    ContextDesc with = desc();
    with.compute_raster = compute_raster;
    create(with);
    const coppice_plant plant = open(plant_path_);
    std::vector<coppice_placement> placements;
    for (int i = 0; i < 60; ++i) placements.push_back(at(static_cast<float>(i % 6) - 2.5f, -0.5f * static_cast<float>(i)));
    add(plant, placements);
    Shot view = front_view();
    view.error_px = 0.5f;
    settle(view);
    const coppice_view_stats unlimited = view_stats();
    EXPECT_EQ(unlimited.threshold_px, 0.5f);

    view.leaf_budget = static_cast<std::uint32_t>(unlimited.drawn_leaf_count / 4);
    for (int i = 0; i < 80; ++i) frame(view);
    const coppice_view_stats limited = view_stats();
    EXPECT_GT(limited.threshold_px, 0.5f);
    EXPECT_LE(limited.drawn_leaf_count, view.leaf_budget);
    EXPECT_GE(limited.visible_instance_count, unlimited.visible_instance_count / 2) << "occlusion changes, plants do not go";

    view.leaf_budget = 0;
    frame(view);
    EXPECT_EQ(view_stats().threshold_px, 0.5f);
    destroy();
  }
}

TEST_F(RuntimeTest, InstancesComeMoveAndGo) {
  create(desc());
  const coppice_plant plant = open(plant_path_);
  std::vector<coppice_placement> placements;
  for (int i = 0; i < 200; ++i) {
    const int row = i / 20, column = i % 20;
    placements.push_back(at(static_cast<float>(column - 10), static_cast<float>(-row)));
  }
  const std::vector<coppice_instance> handles = add(plant, placements);
  const Shot view = front_view();
  settle(view);
  frame(view);
  const std::uint32_t visible = view_stats().visible_instance_count;
  EXPECT_GT(visible, 10u);
  EXPECT_LT(visible, 200u) << "those at the sides are culled";

  const coppice_placement behind = at(0.0f, 50.0f);
  for (const coppice_instance handle : handles) move(handle, behind);
  frame(view);
  EXPECT_EQ(drawn_pixels(frame(view)), 0u);
  EXPECT_EQ(view_stats().visible_instance_count, 0u);

  remove(std::span(handles).first(150));
  EXPECT_EQ(coppice_instances_remove(context_, handles.data(), 1), COPPICE_ERROR_INVALID_ARGUMENT) << "a handle is dead once removed";
  add(plant, placements[0]);
  EXPECT_EQ(coppice_instances_move(context_, &handles[149], &behind, sizeof(coppice_placement), 1), COPPICE_ERROR_INVALID_ARGUMENT)
      << "its slot now belongs to another";
  EXPECT_EQ(stats().instance_count, 51u);
}

TEST_F(RuntimeTest, APlantCanBeClosedAndOpenedAgain) {
  create(desc());
  const Shot view = front_view();
  for (int round = 0; round < 3; ++round) {
    const coppice_plant plant = open(plant_path_);
    add(plant, at(0.0f, 0.0f));
    EXPECT_GT(drawn_pixels(settle(view)), 100u) << round;
    ASSERT_EQ(coppice_plant_close(context_, plant), COPPICE_OK);
    EXPECT_EQ(coppice_plant_close(context_, plant), COPPICE_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(drawn_pixels(frame(view)), 0u) << round;
    EXPECT_EQ(stats().instance_count, 0u);
  }
}

/// The rasteriser's lists of fine cuts come from jobs: until then coarser ones are drawn, whatever happens to the plant meanwhile.
TEST_F(RuntimeTest, LeavesAreSortedByJobs) {
  FakeJobs jobs{.deferred = true, .waiting = {}};
  ContextDesc with = desc();
  with.compute_raster = VK_TRUE;
  with.hooks.jobs = jobs.hook();
  coppice_plant plant = create_planted(with);
  Shot view = front_view();
  view.error_px = 1e-4f;
  const auto work = [&](int frames, const auto& goes_on) {
    for (int i = 0; i < frames && goes_on(i); ++i) {
      jobs.run_all();
      frame(view);
      usleep(1000);
    }
  };
  work(200, [&](int) { return info(plant).resident_leaf_count < 3000; });
  ASSERT_EQ(info(plant).resident_leaf_count, 3000u);
  EXPECT_GT(drawn_pixels(frame(view)), 100u);
  work(20, [&](int) { return streamed().in_flight > 0; });
  EXPECT_EQ(streamed().in_flight, 0u);
  frame(view);
  EXPECT_EQ(view_stats().drawn_leaf_count, 3000u);

  // A plant that goes while its lists are being built, and another in its place.
  for (int i = 0; i < 3; ++i) {
    coppice_plant_close(context_, plant);
    for (int j = 0; j < 4; ++j) frame(view);
    plant = open(plant_path_);
    add(plant, at(0.0f, 0.0f));
    work(30 + i, [&](int) { return jobs.waiting.empty() || info(plant).resident_leaf_count < 3000; });
  }
  work(100, [&](int i) { return i < 3 || streamed().in_flight > 0; });
  frame(view);
  EXPECT_EQ(view_stats().drawn_leaf_count, 3000u);
  jobs.finish();
}

/// With lists, draw commands, a larger picture, plants and instances that come at any time: counted by who gives the memory.
TEST_F(RuntimeTest, TheBudgetHoldsWhateverGrows) {
  const std::string large_path = temporary_plant({.leaf_count = 20000, .seed = 6}, "runtime_test_large");
  ContextDesc tight = desc();
  tight.compute_raster = VK_TRUE;
  tight.memory_budget_bytes = 64ull << 20;
  count_memory(tight);
  create(tight);
  const std::uint64_t budget_bytes = counted_bytes() + (9ull << 20);  // 3 are the rasteriser's lists, with the first instance
  ASSERT_EQ(coppice_set_memory_budget(context_, budget_bytes), COPPICE_OK);
  struct Arrival {
    int frame;
    const std::string* path;
    std::size_t count;
  };
  // One after the other; where there is no room yet, some frames later.
  std::vector<Arrival> arrivals{{100, &plant_path_, 600}, {60, &large_path, 1}, {30, &plant_path_, 1}, {0, &large_path, 1}};
  std::uint64_t most_bytes = 0;
  for (int i = 0; i < 160; ++i) {
    coppice_plant plant = 0;
    if (!arrivals.empty() && i >= arrivals.back().frame &&
        coppice_plant_open(context_, arrivals.back().path->c_str(), &plant) == COPPICE_OK) {
      add(plant, std::vector(arrivals.back().count, at(static_cast<float>(arrivals.size()) - 2.5f, 0.0f)));
      arrivals.pop_back();
    }
    Shot view = make_view(
        {.eye_m = {0.0f, 0.3f, 4.0f + static_cast<float>(i % 40)}, .width_px = i < 80 ? kSidePx : 3 * kSidePx, .height_px = kSidePx});
    view.error_px = 0.02f;
    frame(view);
    most_bytes = std::max(most_bytes, counted_bytes());
    ASSERT_LE(counted_bytes(), budget_bytes) << "frame " << i;
    ASSERT_LE(stats().memory_bytes, budget_bytes) << "frame " << i;
    usleep(500);
  }
  EXPECT_TRUE(arrivals.empty()) << log_;
  EXPECT_LE(stats().memory_peak_bytes, budget_bytes);
  EXPECT_GT(most_bytes, budget_bytes - (3ull << 20)) << "the budget is not tight: nothing was tested";
  EXPECT_GT(streamed().evicted, 0u);
  std::filesystem::remove(large_path);
}

TEST_F(RuntimeTest, TwoHundredPlantsTakeFewBlocksOfDeviceMemoryAndAStillCameraNone) {
  const std::string mesh_path =
      temporary_plant({.leaf_count = 1500, .seed = 8, .texture_side = 100, .leaf_mesh_count = 2}, "runtime_test_meshes");
  DeviceMemoryHook memory{.gpu = &gpu()};
  ContextDesc with = desc();
  with.compute_raster = VK_TRUE;
  with.max_plants = 200;
  with.hooks.device_memory = memory.hook();
  create(with);
  const std::size_t of_creation = memory.live_count;
  std::vector<coppice_plant> plants;
  for (int i = 0; i < 200; ++i) {
    plants.push_back(open(i % 2 == 0 ? plant_path_ : mesh_path));
    add(plants.back(), at(0.5f * static_cast<float>(i % 20) - 5.0f, -0.5f * static_cast<float>(i / 20)));
  }
  Shot view = front_view();
  view.error_px = 0.01f;
  const auto pump_until_settled = [&] {
    const auto is_building = [&] { return stats().pipelines_built < stats().pipelines_wanted; };
    for (int i = 0; i < 400 && (i < 3 || streamed().wanted + streamed().in_flight > 0 || is_building()); ++i) pump(view);
  };
  pump_until_settled();
  EXPECT_GT(streamed().loaded, 1000u);
  EXPECT_EQ(stats().device_allocations, memory.live_count);
  EXPECT_LT(memory.live_count, 60u);
  EXPECT_LT(memory.live_bytes, stats().memory_bytes);
  const std::size_t calls = memory.calls;
  for (int i = 0; i < 20; ++i) pump(view);
  EXPECT_EQ(memory.calls, calls);

  for (const coppice_plant plant : plants) ASSERT_EQ(coppice_plant_close(context_, plant), COPPICE_OK);
  pump_until_settled();
  EXPECT_LE(memory.live_count, of_creation + 15)
      << "one empty block, and what grew: two by instance, four by plant, six of the rasteriser, its picture and tiles";
  destroy();
  EXPECT_EQ(memory.live_count, 0u);
  EXPECT_EQ(memory.misuse, "");
  std::filesystem::remove(mesh_path);
}

TEST_F(RuntimeTest, AReloadShowsTheNewFileAndKeepsTheInstances) {
  create(desc());
  const coppice_plant plant = open(plant_path_);
  const std::vector<coppice_instance> instances = add(plant, std::array{at(0.0f, 0.0f), at(0.5f, 0.0f)});
  Shot view = front_view();
  view.lod = COPPICE_LOD_FULL;
  settle(view);
  ASSERT_EQ(info(plant).resident_leaf_count, 3000u);
  for (const std::uint32_t leaf_count : {2000u, 4000u}) {
    const std::string other = temporary_plant({.leaf_count = leaf_count, .seed = leaf_count}, "runtime_test_new");
    std::filesystem::rename(other, plant_path_);
    ASSERT_EQ(coppice_plant_reload(context_, plant, nullptr), COPPICE_OK) << log_;
    for (int i = 0; i < 200 && info(plant).leaf_count != leaf_count; ++i) {
      EXPECT_GT(drawn_pixels(frame(view)), 100u) << "a frame without the plant: " << i;
      EXPECT_GE(info(plant).resident_leaf_count, 2000u) << "and it is fine all the time";
    }
    frame(view);
    EXPECT_EQ(info(plant).leaf_count, leaf_count);
    EXPECT_EQ(info(plant).resident_leaf_count, leaf_count);
    EXPECT_GT(drawn_pixels(frame(view)), 100u);
    EXPECT_EQ(view_stats().drawn_leaf_count, 2 * leaf_count);
  }
  EXPECT_EQ(stats().instance_count, 2u);
  move(instances[1], at(0.0f, 0.0f));
  remove(instances);  // handles are what they were
  frame(view);
  EXPECT_EQ(drawn_pixels(frame(view)), 0u);
}

TEST_F(RuntimeTest, AReloadThatFailsLeavesThePlantAsItWas) {
  const coppice_plant plant = create_planted(desc());
  const Shot view = front_view();
  settle(view);
  const std::string text = plant_path_ + ".text";
  std::ofstream(text) << std::string(1000, 'x');
  log_.clear();
  EXPECT_EQ(coppice_plant_reload(context_, plant, text.c_str()), COPPICE_ERROR_BAD_FILE);
  EXPECT_EQ(coppice_plant_reload(context_, plant, "/nonexistent/plant.coppice"), COPPICE_ERROR_IO);
  EXPECT_EQ(std::ranges::count(log_, '\n'), 2) << log_;
  EXPECT_EQ(coppice_plant_reload(context_, 0, nullptr), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_GT(drawn_pixels(settle(view)), 100u);
  EXPECT_EQ(info(plant).leaf_count, 3000u);
  std::filesystem::remove(text);
  // Closing in the middle of a reload gives back both.
  ASSERT_EQ(coppice_plant_reload(context_, plant, nullptr), COPPICE_OK) << log_;
  ASSERT_EQ(coppice_plant_reload(context_, plant, nullptr), COPPICE_OK) << log_;
  ASSERT_EQ(coppice_plant_close(context_, plant), COPPICE_OK);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(drawn_pixels(frame(view)), 0u);
  open(plant_path_);
}

TEST_F(RuntimeTest, InstancesThatCouldNotBeDrawnAreRefusedAndTheOthersAreDrawn) {
  ContextDesc with = desc();
  with.max_instances = 400000;
  create(with);
  const coppice_plant plant = open(plant_path_);
  std::vector<coppice_placement> placements(20000, at(0.0f, 400.0f));
  placements[0] = at(0.0f, 0.0f);
  add(plant, placements);
  Shot view = front_view();
  view.lod = COPPICE_LOD_FULL;
  settle(view);
  const std::uint64_t budget = stats().memory_bytes + (4 << 20);
  ASSERT_EQ(coppice_set_memory_budget(context_, budget), COPPICE_OK);
  coppice_status status = COPPICE_OK;
  for (int i = 0; i < 19 && status == COPPICE_OK; ++i) {
    status = try_add(plant, placements);
    EXPECT_GT(drawn_pixels(frame(view)), 100u) << i;
    EXPECT_LE(stats().memory_bytes, budget) << i;
  }
  EXPECT_EQ(status, COPPICE_ERROR_OUT_OF_MEMORY);
  EXPECT_TRUE(mentions(log_, {"coppice_instances_add", "budget"}));
  const std::uint32_t count = stats().instance_count;
  for (int i = 0; i < 20; ++i) EXPECT_GT(drawn_pixels(frame(view)), 100u) << i;
  EXPECT_EQ(stats().instance_count, count);
  EXPECT_LE(stats().memory_bytes, budget);
}

/// Wherever the budget runs out within a block of device memory, a camera that stands still comes to rest.
TEST_F(RuntimeTest, AStillCameraStopsLoadingAndEvicting) {
  ContextDesc tight = desc();
  tight.memory_budget_bytes = 14'000'000;
  create(tight);
  for (int i = 0; i < 6; ++i) add(open(plant_path_), at(0.0f, 0.0f));  // 36 pages; a block of the pool holds 16
  Shot view = front_view();
  view.lod = COPPICE_LOD_FULL;
  for (std::uint64_t budget = 11'800'000; budget <= 12'900'000; budget += 100'000) {
    ASSERT_EQ(coppice_set_memory_budget(context_, budget), COPPICE_OK);
    for (int i = 0; i < 40; ++i) pump(view);
    const coppice_streamed_stats settled = streamed();
    EXPECT_GT(view_stats().threshold_px, 0.0f) << "the budget is not tight: " << budget;
    for (int i = 0; i < 40; ++i) pump(view);
    EXPECT_EQ(streamed().evicted, settled.evicted) << budget;
    EXPECT_EQ(streamed().loaded, settled.loaded) << budget;
    EXPECT_LE(stats().memory_bytes, budget);
  }
}

TEST_F(RuntimeTest, WithNextToNoTimeAChunkAFrameIsUploadedAfterThePinnedOnes) {
  ContextDesc hurried = desc();
  hurried.streaming_ms = 1e-6f;
  const coppice_plant plant = create_planted(hurried);
  Shot view = front_view();
  view.lod = COPPICE_LOD_FULL;
  pump(view);  // what every plant is drawn from is uploaded at once, whatever the time
  std::uint64_t loaded = streamed().loaded;
  ASSERT_LT(info(plant).resident_leaf_count, 3000u);
  for (int i = 0; i < 100 && info(plant).resident_leaf_count < 3000; ++i) {
    pump(view);
    EXPECT_LE(streamed().loaded, loaded + 1);
    loaded = streamed().loaded;
  }
  EXPECT_EQ(info(plant).resident_leaf_count, 3000u);
}

/// The three ways a texture gets to the screen: as blocks, decoded from blocks, never compressed.
TEST_F(RuntimeTest, BlockTexturesLookAlikeReadByTheGpuAndDecoded) {
  if (!gpu().texture_compression_bc) GTEST_SKIP() << "the device has no textureCompressionBC";
  struct Way {
    bake::TextureCoding coding;
    VkBool32 blocks_on_gpu;
    Picture picture;
    std::uint64_t bytes = 0;
  };
  std::array<Way, 3> ways{
      {{bake::TextureCoding::bc, VK_TRUE, {}}, {bake::TextureCoding::bc, VK_FALSE, {}}, {bake::TextureCoding::rgba8, VK_TRUE, {}}}};
  for (Way& way : ways) {
    const std::string path = temporary_plant({.leaf_count = 600, .seed = 5, .texture_side = 501}, "painted", way.coding);
    ContextDesc with = desc();
    with.texture_compression_bc = way.blocks_on_gpu;
    create(with);
    add(open(path), at(0.0f, 0.0f));
    Shot view = front_view();
    view.lod = COPPICE_LOD_FULL;
    way.picture = settle(view);
    way.bytes = stats().memory_bytes;
    EXPECT_EQ(streamed().failed, 0u) << log_;
    destroy();
    std::filesystem::remove(path);
  }
  const auto mean_difference = [](const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
    const double sum = std::transform_reduce(a.begin(), a.end(), b.begin(), 0.0, std::plus(), [](int x, int y) { return std::abs(x - y); });
    return sum / static_cast<double>(a.size());
  };
  ASSERT_GT(drawn_pixels(ways[0].picture), 500u);
  EXPECT_LT(mean_difference(ways[0].picture.rgba, ways[1].picture.rgba), 0.05) << "decoders round differently, no more";
  EXPECT_LT(mean_difference(ways[0].picture.rgba, ways[2].picture.rgba), 1.0);
  const std::uint64_t rgba_bytes = 501 * 501 * 4 * 4 / 3;
  EXPECT_LT(ways[0].bytes + rgba_bytes / 2, ways[1].bytes);
  EXPECT_NEAR(static_cast<double>(ways[1].bytes), static_cast<double>(ways[2].bytes), 100e3);
}

TEST_F(RuntimeTest, AFrameIsRecordedInOrder) {
  create(desc());
  const Shot view = front_view();
  const auto refused = [&](VkCommandBuffer cmd) {
    EXPECT_EQ(coppice_record_cull(context_, cmd, view_, &view.light), COPPICE_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(coppice_record_draw(context_, cmd, view_, 0), COPPICE_ERROR_INVALID_ARGUMENT);
  };
  submit(gpu(), [&](VkCommandBuffer cmd) {
    EXPECT_EQ(coppice_record_upload(context_, cmd), COPPICE_ERROR_INVALID_ARGUMENT) << "no frame has begun";
    refused(cmd);
  });
  frame(view);
  submit(gpu(), [&](VkCommandBuffer cmd) {
    EXPECT_EQ(coppice_record_upload(context_, cmd), COPPICE_ERROR_INVALID_ARGUMENT) << "the frame before has had its upload";
    begin(view);
    log_.clear();
    refused(cmd);
  });
  EXPECT_TRUE(mentions(log_, {"coppice_record_cull", "coppice_record_draw", "coppice_record_upload"}));
}

TEST_F(RuntimeTest, AFileThatIsNotThereIsNamedOnceAndThereIsRoomForSoManyInstances) {
  create(desc());
  coppice_plant plant = 0;
  EXPECT_EQ(coppice_plant_open(context_, "/nonexistent/plant.coppice", &plant), COPPICE_ERROR_IO);
  EXPECT_EQ(plant, 0u);
  EXPECT_TRUE(mentions(log_, {"/nonexistent/plant.coppice"}));
  EXPECT_EQ(std::ranges::count(log_, '\n'), 1) << "one line for each error\n" << log_;
  EXPECT_EQ(try_add(open(plant_path_), std::vector(4097, at(0.0f, 0.0f))), COPPICE_ERROR_OUT_OF_MEMORY);
  EXPECT_EQ(stats().instance_count, 0u);
}

}  // namespace coppice::test::runtime_test
