#include "streamer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "chunk_value.h"
#include "decoded_pages.h"
#include "gltf_builder.h"
#include "mentions.h"
#include "packed_plant.h"
#include "process.h"
#include "results.h"
#include "streamer_fixture.h"

namespace coppice::streamer_test {

using test::demand_of;

/// Six pages, two wood LoDs, a texture. Its table asks for m = (size / 20)^2 leaves at the default threshold.
const std::vector<std::uint8_t>& plant_file() {
  static const std::vector<std::uint8_t> file = test::packed_plant({.leaf_count = 3000, .seed = 5});
  return file;
}

/// Few leaves and a large texture.
std::vector<std::uint8_t> poster_file(std::uint32_t texture_side) {
  return test::packed_plant({.leaf_count = 40, .seed = 7, .wood_lod_count = 0, .texture_side = texture_side}, bake::TextureCoding::rgba8);
}

const GpuSizes kGpuSizes = {.plant_bytes = 1000, .block_textures = true};

class StreamerTest : public test::StreamerFixture {
 protected:
  void SetUp() override {
    io.files["a"] = plant_file();
    io.files["b"] = plant_file();
    io.files["small"] = test::packed_plant({.leaf_count = 40, .seed = 6, .texture_side = 0});
    options.gpu = kGpuSizes;
  }

  void start() {
    StreamerFixture::start();
    empty_bytes = ledger.reserved();
  }
  /// A streamer with one plant in it.
  std::uint32_t start_with(const char* path) {
    start();
    return open(path);
  }
  /// A streamer with the plant "a" in it, of which all is resident.
  std::uint32_t start_with_whole_plant() {
    const std::uint32_t plant = start_with("a");
    frames(20, {demand_of(5000.0f)});
    expect_whole(plant);
    return plant;
  }
  /// `count` plants "a" that are whole, and their demands.
  std::vector<PlantDemand> start_with_whole_plants(std::size_t count) {
    start();
    for (std::size_t i = 0; i < count; ++i) open("a");
    std::vector<PlantDemand> demands(count, demand_of(5000.0f));
    for (int i = 0; i < 200 && (i < 3 || streamer->stats().all().wanted > 0); ++i) frames(1, demands);
    EXPECT_EQ(streamer->stats().all().wanted, 0u);
    return demands;
  }
  [[nodiscard]] coppice_file_chunk page_chunk(std::uint32_t plant, std::uint32_t page) const {
    return *find_chunk(streamer->file(plant), COPPICE_CHUNK_PAGE, page);
  }
  /// Error, px, of a plant's resident leaves at a size; of those that one page less would leave.
  [[nodiscard]] float error_px(std::uint32_t plant, float size_px, std::uint32_t pages_less = 0) const {
    const std::uint32_t pages = streamer->state(plant).resident_page_count - pages_less;
    const std::uint32_t leaves = std::min(pages * COPPICE_PAGE_SPLITS + 1, streamer->file(plant).plant.leaf_count);
    return error_px_at(lod_table(streamer->file(plant), streamer->lod_words(plant)), static_cast<float>(leaves), size_px);
  }

  std::uint64_t empty_bytes = 0;
};

TEST_F(StreamerTest, OpensWithTheFirstPageAndTheCoarsestWood) {
  const std::uint32_t plant = start_with("a");
  EXPECT_EQ(streamer->file(plant).plant.leaf_count, 3000u);
  EXPECT_EQ(streamer->state(plant).resident_leaf_count, 1u);
  EXPECT_EQ(streamer->state(plant).resident_wood_mask, 0u);
  io.log.clear();
  frames(3, {PlantDemand{}});
  EXPECT_EQ(streamer->state(plant).resident_leaf_count, 513u);
  EXPECT_EQ(streamer->state(plant).resident_wood_mask, 0b10u);
  EXPECT_TRUE(io.log.empty()) << "nobody looks: nothing is read";
  EXPECT_EQ(streamer->stats().all().wanted, 0u);
}

TEST_F(StreamerTest, LoadsExactlyWhatTheViewWants) {
  const std::uint32_t plant = start_with("a");
  frames(20, {demand_of(700.0f)});  // about 1,240 leaves
  EXPECT_EQ(streamer->state(plant).resident_page_count, 3u);
  EXPECT_EQ(streamer->state(plant).resident_texture_count, 1u);
  frames(20, {demand_of(5000.0f)});
  expect_whole(plant);
  EXPECT_EQ(streamer->stats().all().wanted, 0u);
  EXPECT_EQ(streamer->stats().all().loaded, 6u + 2u + 1u);
}

TEST_F(StreamerTest, EveryCutOfWhatArrivedIsAWholePlant) {
  const std::uint32_t plant = start_with("a");
  for (float size_px = 100.0f; size_px < 6000.0f; size_px *= 1.5f) {
    frames(6, {demand_of(size_px)});
    const std::uint32_t leaves = streamer->state(plant).resident_leaf_count;
    const std::vector<std::uint32_t> node_split = gpu->plants[plant].node_split();
    for (std::uint32_t m = 1; m <= leaves; m += 37) {
      std::vector<std::uint32_t> nodes(m + 1);
      EXPECT_EQ(select_cut(node_split, m, nodes), m);
    }
  }
  EXPECT_EQ(streamer->state(plant).resident_leaf_count, 3000u);
}

TEST_F(StreamerTest, HandsOutWhatTheCodecDecodes) {
  const std::uint32_t plant = start_with_whole_plant();
  const PlantFile& file = streamer->file(plant);
  bake::DecodedPages pages(root_node(file.plant), file.plant.leaf_count, file.plant.card_count, quantised_max(file.plant));
  const test::FakeGpuPlant& uploaded = gpu->plants[plant];
  for (std::uint32_t page = 0; page < file.plant.page_count; ++page) {
    const coppice_file_chunk chunk = page_chunk(plant, page);
    ASSERT_TRUE(pages.add(std::span(plant_file()).subspan(chunk.offset, chunk.bytes)));
  }
  const std::vector<PageNode> nodes = pages.nodes();
  ASSERT_EQ(uploaded.nodes.size(), nodes.size());
  for (std::size_t node = 1; node < nodes.size(); ++node) {  // the root is in no page
    EXPECT_EQ(uploaded.nodes[node].corners, nodes[node].corners);
    EXPECT_EQ(uploaded.nodes[node].card, nodes[node].card);
    EXPECT_EQ(uploaded.nodes[node].split, nodes[node].split);
  }
}

TEST_F(StreamerTest, AsksFirstForWhatRemovesMoreError) {
  options.max_in_flight = 1;
  start();
  const std::uint32_t much = open("a"), little = open("b");
  frames(1, {PlantDemand{}, PlantDemand{}});
  io.log.clear();
  frames(40, {demand_of(5000.0f, 50.0f), demand_of(700.0f)});
  EXPECT_EQ(streamer->state(much).resident_leaf_count, 3000u);
  EXPECT_EQ(streamer->state(little).resident_page_count, 3u);
  const std::uint64_t first_page_offset = page_chunk(0, 1).offset;  // the same in both files
  std::vector<std::int64_t> page_reads;
  for (const test::FakeRead& read : io.log)
    if (read.offset >= first_page_offset) page_reads.push_back(read.file);
  EXPECT_EQ(page_reads, (std::vector<std::int64_t>{0, 0, 0, 0, 0, 1, 1})) << "every page of a is worth more than any of b";
}

TEST_F(StreamerTest, LaterPagesAreWorthLess) {
  start_with("a");
  const ValuedPlant valued{lod_table(streamer->file(0), streamer->lod_words(0)), 3000, 61440};
  const PlantDemand demand = demand_of(5000.0f), twice = demand_of(5000.0f, 2.0f);
  const DemandedDetail demanded = demanded_detail(valued, demand, view);
  ASSERT_EQ(demanded.page_count, 6u);
  for (std::uint32_t page = 0; page < 6; ++page) {
    const float value = page_value(valued, demanded, demand, view, page);
    EXPECT_GT(value, 0.0f);
    EXPECT_NEAR(page_value(valued, demanded, twice, view, page), 2.0f * value, 1e-3f * value) << "two see twice as much";
  }
  for (std::uint32_t page = 0; page < 3; ++page)
    EXPECT_GT(page_value(valued, demanded, demand, view, page), page_value(valued, demanded, demand, view, page + 1));
  // From 1 leaf to 513 at 5000 px: the table's 0.1 * size / sqrt(m), per byte.
  const float gain_px = error_px_at(valued.table, 1.0f, 5000.0f) - error_px_at(valued.table, 513.0f, 5000.0f);
  EXPECT_NEAR(page_value(valued, demanded, demand, view, 0), gain_px / 61440.0f, 1e-3f * gain_px / 61440.0f);
  EXPECT_EQ(page_value(valued, demanded, demand, view, 6), 0.0f);
}

TEST_F(StreamerTest, DropsAReadThatNobodyWantsAnyMore) {
  const std::uint32_t plant = start_with("a");
  frames(3, {PlantDemand{}});
  const std::uint64_t before = ledger.reserved();
  io.deferred = true;
  frames(1, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->stats().all().in_flight, 7u);
  EXPECT_GT(ledger.reserved(), before);
  frames(20, {PlantDemand{}});
  io.answer_all();
  frames(1, {PlantDemand{}});
  EXPECT_EQ(streamer->stats().all().in_flight, 0u);
  EXPECT_EQ(streamer->stats().all().cancelled, 7u);
  EXPECT_EQ(ledger.reserved(), before);
  EXPECT_EQ(streamer->state(plant).resident_page_count, 1u);
  io.deferred = false;
  frames(10, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->state(plant).resident_page_count, 6u) << "what was dropped can be asked for again";
}

TEST_F(StreamerTest, AGlanceAsideDropsNothing) {
  start_with("a");
  frames(3, {PlantDemand{}});
  io.deferred = true;
  frames(1, {demand_of(5000.0f)});
  frames(4, {PlantDemand{}});
  io.answer_all();
  io.deferred = false;
  frames(2, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->stats().all().cancelled, 0u);
}

TEST_F(StreamerTest, PagesThatReturnOutOfOrderAreDecodedInOrder) {
  const std::uint32_t plant = start_with("a");
  frames(1, {PlantDemand{}});
  io.deferred = true;
  frames(1, {demand_of(5000.0f)});
  std::ranges::reverse(io.waiting);
  while (!io.waiting.empty()) {
    io.answer_first();
    frames(1, {demand_of(5000.0f)});
  }
  EXPECT_EQ(streamer->state(plant).resident_leaf_count, 3000u);
}

TEST_F(StreamerTest, AShrinkingBudgetRaisesTheThresholdForAllAlikeWithinAFrame) {
  start();
  const std::uint32_t plant = open("a"), other = open("b");
  frames(1, {PlantDemand{}, PlantDemand{}});
  const std::uint64_t floor_bytes = ledger.reserved();
  const std::vector<PlantDemand> demands = {demand_of(5000.0f, 10.0f), demand_of(5000.0f, 1.0f)};
  frames(20, demands);
  expect_whole(plant);
  expect_whole(other);
  EXPECT_FLOAT_EQ(streamer->threshold_px(0), 2.0f) << "the view's own while everything fits";
  float threshold_px = 2.0f;
  for (std::uint64_t budget = ledger.reserved(); budget > floor_bytes; budget = std::max(floor_bytes, budget - 40000)) {
    ledger.set_budget(budget);
    frames(1, demands);
    const float raised_px = streamer->threshold_px(0);
    frames(1, demands);
    EXPECT_LE(ledger.reserved(), budget) << "what went is released in the next frame";
    EXPECT_EQ(streamer->threshold_px(0), raised_px) << "at once as far as it must";
    EXPECT_GE(streamer->threshold_px(0), threshold_px);
    EXPECT_EQ(streamer->stats().all().wanted, 0u) << "what goes is what the threshold no longer asks for";
    threshold_px = streamer->threshold_px(0);
    for (const std::uint32_t each : {plant, other}) EXPECT_LE(error_px(each, 5000.0f), std::max(threshold_px, 9.2f)) << each;
  }
  ledger.set_budget(floor_bytes);
  frames(1, demands);
  EXPECT_EQ(streamer->state(plant).resident_page_count, 1u);
  EXPECT_EQ(streamer->state(other).resident_page_count, 1u);
  EXPECT_GT(streamer->threshold_px(0), 20.0f) << "513 leaves at 5000 px are wrong by 22 px";
  ledger.set_budget(1);
  frames(3, demands);
  EXPECT_EQ(ledger.reserved(), floor_bytes) << "what is pinned stays";
  EXPECT_GE(streamer->state(plant).resident_leaf_count, 513u);
}

TEST_F(StreamerTest, TheThresholdFallsByStepsOnceThereIsRoomAgain) {
  const std::uint32_t plant = start_with("a");
  frames(1, {PlantDemand{}});
  const std::uint64_t floor_bytes = ledger.reserved();
  ledger.set_budget(floor_bytes + 1000);
  frames(2, {demand_of(2000.0f)});
  float threshold_px = streamer->threshold_px(0);
  EXPECT_GT(threshold_px, 8.0f);
  ledger.set_budget(floor_bytes + 1000000);
  for (int i = 0; i < 200; ++i) {
    frames(1, {demand_of(2000.0f)});
    EXPECT_GE(streamer->threshold_px(0), 0.91f * threshold_px);
    EXPECT_LE(streamer->threshold_px(0), threshold_px);
    threshold_px = streamer->threshold_px(0);
  }
  EXPECT_FLOAT_EQ(threshold_px, 2.0f);
  frames(5, {demand_of(2000.0f)});
  EXPECT_GE(streamer->state(plant).resident_leaf_count, 2561u);
  EXPECT_EQ(streamer->stats().all().wanted, 0u);
}

TEST_F(StreamerTest, MemoryCountsUntilTheGpuIsDoneWithIt) {
  start_with_whole_plant();
  const std::uint64_t full = ledger.reserved();
  gpu->frames_behind = 3;
  ledger.set_budget(full - 100000);
  frames(1, {demand_of(5000.0f)});
  ASSERT_GE(gpu->evicted.size(), 2u);
  EXPECT_TRUE(gpu->released.empty());
  const std::size_t evicted = gpu->evicted.size();
  frames(2, {demand_of(5000.0f)});
  EXPECT_TRUE(gpu->released.empty());
  EXPECT_EQ(gpu->evicted.size(), evicted) << "what is on its way out counts as room to come";
  frames(1, {demand_of(5000.0f)});
  EXPECT_EQ(gpu->released.size(), evicted);
  EXPECT_LE(ledger.reserved(), full - 100000);
}

class TightBudget : public StreamerTest, public testing::WithParamInterface<std::uint64_t> {};

TEST_P(TightBudget, IsNeverExceededAndNothingThrashes) {
  start_with("a");
  gpu->frames_behind = GetParam();
  open("b");
  frames(1, {PlantDemand{}, PlantDemand{}});
  const std::uint64_t budget = ledger.reserved() + 560000;
  ledger.set_budget(budget);
  std::size_t evicted_before = 0;
  for (std::uint32_t turn = 0; turn < 4; ++turn) {
    const float a_px = turn % 2 == 0 ? 4000.0f : 900.0f, b_px = turn % 2 == 0 ? 900.0f : 4000.0f;
    for (int i = 0; i < 60; ++i) {
      frames(1, {demand_of(a_px), demand_of(b_px)});
      ASSERT_LE(ledger.reserved(), budget);
    }
    const std::size_t settled = gpu->evicted.size();
    const std::uint64_t loaded = streamer->stats().all().loaded;
    EXPECT_GT(settled + 1, evicted_before + (turn > 0 ? 1u : 0u)) << "memory follows the view";
    EXPECT_GT(streamer->state(turn % 2).resident_page_count, streamer->state(1 - turn % 2).resident_page_count);
    EXPECT_GT(streamer->threshold_px(0), 2.0f);
    EXPECT_LE(error_px(1 - turn % 2, 900.0f), streamer->threshold_px(0));
    frames(100, {demand_of(a_px), demand_of(b_px)});
    EXPECT_EQ(gpu->evicted.size(), settled) << "a view that stands still moves nothing";
    EXPECT_EQ(streamer->stats().all().loaded, loaded);
    EXPECT_EQ(streamer->stats().all().wanted, 0u) << "what is asked for fits";
    EXPECT_LE(settled - evicted_before, 9u) << "no more goes than one plant has";
    evicted_before = settled;
  }
  EXPECT_LE(ledger.max_reserved(), budget);
}
INSTANTIATE_TEST_SUITE_P(GpuFramesBehind, TightBudget, testing::Values(0, 3), testing::PrintToStringParamName());

/// 24 plants of 40 pages, seen at 150 to 6,000 px by 1 to 500 instances, in a twentieth of the memory that they want.
class ATwentieth : public StreamerTest {
 protected:
  static constexpr std::uint32_t kPlants = 24;
  static constexpr float kEvenFactor = 1.5f;  ///< the last page of 512 leaves that a plant has may take it this much below the threshold

  void SetUp() override {
    StreamerTest::SetUp();
    static const std::vector<std::uint8_t> file = test::packed_plant({.leaf_count = 20000, .seed = 8});
    io.files["large"] = file;
    start();
    for (std::uint32_t i = 0; i < kPlants; ++i) open("large");
    frames(1, {});
    const std::uint64_t floor_bytes = ledger.reserved();
    frames(300, demands());
    ASSERT_EQ(streamer->stats().all().wanted, 0u);
    wanted_bytes = ledger.reserved() - floor_bytes;
    budget = floor_bytes + wanted_bytes / 20;
  }
  /// jitter  share by which sizes differ from what they are at rest
  static std::vector<PlantDemand> demands(float jitter = 0.0f) {
    std::vector<PlantDemand> result;
    for (std::uint32_t i = 0; i < kPlants; ++i)
      result.push_back(demand_of(size_px(i) * (1.0f + jitter), 1.0f + static_cast<float>(i * i % 500)));
    return result;
  }
  static float size_px(std::uint32_t plant) { return 150.0f * std::pow(40.0f, static_cast<float>(plant * 7 % kPlants) / (kPlants - 1)); }

  std::uint64_t wanted_bytes = 0, budget = 0;
};

TEST_F(ATwentieth, IsEvenlyCoarse) {
  ledger.set_budget(budget);
  frames(200, demands());
  const float threshold_px = streamer->threshold_px(0);
  EXPECT_GT(threshold_px, 3.0f);
  std::uint32_t refined = 0;
  for (std::uint32_t plant = 0; plant < kPlants; ++plant) {
    EXPECT_LE(error_px(plant, size_px(plant)), threshold_px) << plant << " is coarser than the others";
    if (streamer->state(plant).resident_page_count == 1) continue;  // that one is pinned
    ++refined;
    EXPECT_GE(error_px(plant, size_px(plant), 1) * kEvenFactor, threshold_px) << plant << " is finer than the others";
  }
  EXPECT_GE(refined, 3u);
  EXPECT_GE(ledger.reserved() + wanted_bytes / 80, budget) << "a quarter of the room is left unused";
}

TEST_F(ATwentieth, IsNeverExceededAndComesToRest) {
  ledger.set_budget(budget);
  frames(1, demands());
  for (int i = 0; i < 100; ++i) {
    frames(1, demands());
    ASSERT_LE(ledger.reserved(), budget) << i;
  }
  const std::uint64_t loaded = streamer->stats().all().loaded, evicted = streamer->stats().all().evicted;
  frames(300, demands());
  EXPECT_EQ(streamer->stats().all().loaded, loaded);
  EXPECT_EQ(streamer->stats().all().evicted, evicted);
  for (int i = 0; i < 20; ++i) frames(1, demands(i % 2 == 0 ? 0.05f : -0.05f));  // a camera that shakes: what it takes at most is kept
  const std::uint64_t loaded_by_shaking = streamer->stats().all().loaded;
  for (int i = 0; i < 300; ++i) {
    frames(1, demands(i % 2 == 0 ? 0.05f : -0.05f));
    ASSERT_LE(ledger.reserved(), budget) << i;
  }
  EXPECT_EQ(streamer->stats().all().loaded, loaded_by_shaking);
}

TEST_F(ATwentieth, ColdStartReadsOnlyWhatStays) {
  gpu.reset();
  streamer.reset();
  start();
  for (std::uint32_t i = 0; i < kPlants; ++i) {
    open("large");
    frames(1, {});  // what is on its way to the GPU of all of them would be more
  }
  ledger.set_budget(budget);
  frames(200, demands());
  EXPECT_EQ(streamer->stats().all().wanted, 0u);
  EXPECT_EQ(streamer->stats().all().evicted, 0u);
  EXPECT_LE(ledger.max_reserved(), budget);
}

TEST_F(StreamerTest, EqualDemandsShareAFullBudgetWithoutSwapping) {
  start_with("a");
  open("b");
  frames(1, {PlantDemand{}, PlantDemand{}});
  ledger.set_budget(ledger.reserved() + 600000);
  frames(100, {demand_of(4000.0f), demand_of(4000.0f)});
  EXPECT_EQ(streamer->state(0).resident_page_count, streamer->state(1).resident_page_count);
  EXPECT_GE(streamer->state(0).resident_page_count, 2u);
  EXPECT_TRUE(gpu->evicted.empty());
}

TEST_F(StreamerTest, WhatOthersTakeEvicts) {
  const std::uint32_t plant = start_with_whole_plant();
  const std::uint64_t budget = ledger.reserved() + 430000;  // a load takes more than what it leaves behind
  ledger.set_budget(budget);
  ledger.reserve(500000);
  frames(2, {demand_of(5000.0f)});
  EXPECT_LE(ledger.reserved(), budget);
  EXPECT_LT(streamer->state(plant).resident_page_count, 6u);
  ledger.release(500000);
  frames(200, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->state(plant).resident_page_count, 6u);
}

TEST_F(StreamerTest, ATextureLargerThanItsShareCostsTheOthersNothing) {
  io.files["poster"] = poster_file(1024);
  std::vector<PlantDemand> demands = start_with_whole_plants(10);
  const std::uint32_t poster = open("poster");
  demands.push_back(demand_of(5000.0f, 1e4f));
  ASSERT_GT(find_chunk(streamer->file(poster), COPPICE_CHUNK_TEXTURE, 0)->bytes, 10 * 5 * 62000u);
  ledger.set_budget(ledger.reserved() + 1000);
  frames(40, demands);
  EXPECT_EQ(streamer->stats().all().evicted, 0u);
  EXPECT_EQ(streamer->state(poster).resident_texture_count, 0u);
  EXPECT_EQ(streamer->stats().all().wanted, 0u) << "what cannot be had is not waited for";
  EXPECT_LT(streamer->threshold_px(0), 20.0f) << "the others stay fine";
}

TEST_F(StreamerTest, OfManyTexturesThoseThatFitTogetherAreWanted) {
  constexpr std::uint32_t kPosters = 8;
  io.files["poster"] = poster_file(256);
  start();
  std::vector<PlantDemand> demands;
  for (std::uint32_t i = 0; i < kPosters; ++i) {
    open("poster");
    demands.push_back(demand_of(500.0f + 10.0f * static_cast<float>(i)));
  }
  frames(1, {});
  const std::uint64_t texture_bytes = find_chunk(streamer->file(0), COPPICE_CHUNK_TEXTURE, 0)->bytes;
  ledger.set_budget(ledger.reserved() + 4 * texture_bytes);
  frames(100, demands);
  EXPECT_EQ(streamer->stats().all().wanted, 0u) << "each alone would fit";
  EXPECT_EQ(streamer->stats().all().evicted, 0u);
  std::uint64_t resident = 0;
  for (std::uint32_t i = 0; i < kPosters; ++i) resident += streamer->state(i).resident_texture_count;
  EXPECT_GE(resident, 2u);
  EXPECT_LE(resident, 4u);
  EXPECT_EQ(streamer->state(kPosters - 1).resident_texture_count, 1u) << "it is the largest";
}

TEST_F(StreamerTest, ARequestThatNeedsManyEvictionsIsGranted) {
  io.files["poster"] = poster_file(1024);
  std::vector<PlantDemand> demands = start_with_whole_plants(40);
  const std::uint32_t poster = open("poster");
  demands.push_back(demand_of(5000.0f, 1e6f));
  ledger.set_budget(ledger.reserved());
  frames(20, demands);
  EXPECT_EQ(streamer->state(poster).resident_texture_count, 1u);
  EXPECT_GT(streamer->stats().all().evicted, 64u);
}

TEST_F(StreamerTest, AnUploadThatFailsEndsThePrefixThere) {
  const std::uint32_t plant = start_with("a");
  gpu->uploads = false;
  frames(10, {demand_of(5000.0f)});
  const std::uint64_t decoded_bytes = ledger.reserved();
  for (const DecodedChunk& chunk : streamer->take_decoded(UINT64_MAX)) {
    if (chunk.id.kind != ChunkKind::page) continue;
    if (chunk.id.index < 3) {
      gpu->upload(chunk);
      continue;
    }
    EXPECT_EQ(streamer->begin_upload(chunk.id), chunk.id.index == 3);
    if (chunk.id.index == 3) streamer->upload_failed(chunk.id, {Status::unsupported, "too large"});
  }
  frames(10, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->state(plant).resident_page_count, 3u);
  EXPECT_EQ(streamer->stats().all().failed, 1u);
  EXPECT_LT(ledger.reserved(), decoded_bytes - 2 * 32768);
}

TEST_F(StreamerTest, AnUploadWithoutDeviceMemoryIsTriedAgain) {
  const std::uint32_t plant = start_with("a");
  gpu->uploads = false;
  for (int round = 0; round < 2; ++round) {  // what is pinned first; then a page in the middle, a wood LoD and the texture
    frames(10, {demand_of(5000.0f)});
    for (const DecodedChunk& chunk : streamer->take_decoded(UINT64_MAX)) {
      if (chunk.id.kind == ChunkKind::page && chunk.id.index < 3 * static_cast<std::uint32_t>(round))
        gpu->upload(chunk);
      else if (streamer->begin_upload(chunk.id))
        streamer->upload_failed(chunk.id, {Status::out_of_memory, "device memory"});
    }
    EXPECT_EQ(streamer->state(plant).resident_page_count, 3u * static_cast<std::uint32_t>(round));
    frames(40, {demand_of(5000.0f)});
  }
  for (const DecodedChunk& chunk : streamer->take_decoded(UINT64_MAX)) gpu->upload(chunk);
  expect_whole(plant);
  EXPECT_EQ(streamer->stats().all().failed, 0u);
  EXPECT_EQ(log.lines.size(), 2u) << "one line for each time the device had nothing";
}

/// A clock on which everything takes a millisecond.
std::uint64_t slow_clock_ns() {
  static std::uint64_t now = 0;
  return now += 1'000'000;
}

TEST_F(StreamerTest, AFrameStartsAndTakesOverOnlyWhatItHasTimeFor) {
  options.clock_ns = slow_clock_ns;
  options.hand_over_budget_ns = 4'500'000;
  const std::uint32_t plant = start_with("a");
  frames(3, {PlantDemand{}});
  io.deferred = true;
  frames(1, {demand_of(5000.0f)});
  EXPECT_GT(io.waiting.size(), 0u);
  EXPECT_LT(io.waiting.size(), 7u);
  frames(2, {demand_of(5000.0f)});
  EXPECT_EQ(io.waiting.size(), 7u);
  io.answer_all();
  jobs.deferred = true;
  frames(1, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->stats().all().in_flight, 7u);
  EXPECT_GE(streamer->stats().hand_over_ns, 4'500'000u);
  const std::uint64_t taken_over = streamer->stats().bytes_read;
  EXPECT_GT(taken_over, 0u);
  frames(1, {demand_of(5000.0f)});
  EXPECT_GT(streamer->stats().bytes_read, taken_over) << "the rest in the next frame";
  jobs.run_all();
  jobs.deferred = io.deferred = false;
  frames(12, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->state(plant).resident_leaf_count, 3000u) << "nothing is lost";
}

TEST_F(StreamerTest, WithoutTimeOneChunkAFrameIsTakenOver) {
  options.clock_ns = slow_clock_ns;
  options.hand_over_budget_ns = 1;
  const std::uint32_t plant = start_with("a");
  frames(3, {PlantDemand{}});
  std::uint32_t steps = 0;
  for (; streamer->state(plant).resident_leaf_count < 3000 && steps < 40; ++steps) frames(1, {demand_of(5000.0f)});
  EXPECT_GE(steps, 9u) << "a read and a decode each of five pages, a texture and wood, and several pages to a job";
  EXPECT_LE(steps, 16u);
}

TEST_F(StreamerTest, HandsOutFirstWhatIsWorthMost) {
  start_with("a");
  open("b");
  gpu->uploads = false;
  frames(10, {demand_of(5000.0f, 1.0f), demand_of(5000.0f, 500.0f)});
  std::vector<std::uint32_t> pages;
  for (auto chunks = streamer->take_decoded(1); !chunks.empty(); chunks = streamer->take_decoded(1)) {
    ASSERT_EQ(chunks.size(), 1u) << "at least one, however small the limit";
    if (chunks[0].id.kind == ChunkKind::page) pages.push_back(chunks[0].id.plant);
    gpu->upload(chunks[0]);
  }
  EXPECT_EQ(pages, (std::vector<std::uint32_t>{0, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0})) << "first what is pinned, then what more see";
}

TEST_F(StreamerTest, AClosedPlantIsThereUntilTheGpuIsDoneWithIt) {
  const std::uint32_t plant = start_with("a");
  gpu->uploads = false;  // it has no chunk whose memory would be waited for
  gpu->frames_behind = 4;
  frames(8, {demand_of(700.0f)});
  streamer->close_plant(plant);
  const std::uint64_t last_frame = gpu->frame_number;
  while (gpu->closed.empty() && gpu->frame_number < 100) {
    EXPECT_LE(gpu->frame_number, last_frame + gpu->frames_behind);
    frames(1, {});
  }
  EXPECT_EQ(gpu->closed, (std::vector<std::uint32_t>{plant}));
  EXPECT_GT(gpu->frame_number, last_frame + gpu->frames_behind);
}

TEST_F(StreamerTest, ClosingGivesEverythingBackEvenWithReadsInFlight) {
  const std::uint32_t plant = start_with("a");
  frames(3, {demand_of(700.0f)});
  io.deferred = true;
  jobs.deferred = true;
  frames(1, {demand_of(5000.0f)});
  streamer->close_plant(plant);
  EXPECT_FALSE(streamer->is_open(plant));
  gpu->frames_behind = 2;
  frames(2, {demand_of(5000.0f)});
  EXPECT_TRUE(gpu->closed.empty());
  io.answer_all();
  frames(1, {});
  jobs.run_all();
  frames(3, {});
  EXPECT_EQ(gpu->closed, (std::vector<std::uint32_t>{plant}));
  EXPECT_EQ(gpu->released.size(), gpu->evicted.size());
  EXPECT_EQ(ledger.reserved(), empty_bytes);
  EXPECT_EQ(io.open_count, 0u);
  io.deferred = jobs.deferred = false;
  EXPECT_EQ(open("b"), plant) << "the index is free again";
  frames(20, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->state(plant).resident_leaf_count, 3000u);
}

TEST_F(StreamerTest, AJobUnderWayKeepsTheQuadsItReads) {
  const std::uint32_t plant = start_with("a");
  frames(5, {demand_of(700.0f)});
  jobs.deferred = true;
  frames(2, {demand_of(5000.0f)});
  ASSERT_FALSE(jobs.waiting.empty());
  ledger.set_budget(1);
  frames(2, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->state(plant).resident_page_count, 3u) << "pages that a job reads stay";
  jobs.run_all();
  jobs.deferred = false;
  frames(3, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->state(plant).resident_page_count, 1u);
}

TEST_F(StreamerTest, OpeningsTakeTheirTurnAndWaitForNothing) {
  options.max_plants = 12;
  start();
  io.deferred = jobs.deferred = true;
  std::vector<std::uint32_t> opening;
  for (int i = 0; i < 12; ++i) opening.push_back(*streamer->start_open(i % 2 == 0 ? "a" : "small"));
  EXPECT_EQ(streamer->start_open("a").error().status, Status::out_of_memory);
  EXPECT_EQ(io.open_count, 0u) << "nothing is touched by the call";
  std::size_t max_open = 0, max_opening = 0, decodes = 0;
  for (int i = 0; i < 40 && !opening.empty(); ++i) {
    frames(1, {});
    std::erase_if(opening, [&](std::uint32_t plant) {
      const auto finished = streamer->finish_open(plant);
      EXPECT_TRUE(!finished || *finished) << finished->error().message();
      EXPECT_EQ(finished.has_value(), streamer->is_open(plant));
      return finished.has_value();
    });
    max_open = std::max(max_open, io.open_count);
    max_opening = std::max(max_opening, io.open_count - (12 - opening.size()));
    decodes += jobs.waiting.size();
    if (i % 2 == 0) io.answer_all();
    if (i % 3 == 0) jobs.run_all();
  }
  EXPECT_TRUE(opening.empty());
  EXPECT_EQ(max_open, 12u);
  EXPECT_EQ(max_opening, Streamer::kMaxOpening);
  EXPECT_GE(decodes, 12u) << "what is pinned is decoded by jobs";
  for (std::uint32_t plant = 0; plant < 12; ++plant) streamer->close_plant(plant);
  frames(5, {});
  EXPECT_EQ(io.open_count, 0u);
  EXPECT_EQ(ledger.reserved(), empty_bytes);
}

TEST_F(StreamerTest, RoomForPlantsGrowsAsTheyAreOpened) {
  options.max_plants = 1000;
  start();
  std::vector<std::uint32_t> plants(1000);
  std::iota(plants.begin(), plants.end(), 0u);
  for (const std::uint32_t plant : plants) {
    if (plant == 64 || plant == 512)
      for (std::size_t n = 0; n < 3; ++n) {
        allocator.fail_at = allocator.calls + n;
        EXPECT_EQ(streamer->start_open("small").error().status, Status::out_of_memory) << n;
        allocator.fail_at = SIZE_MAX;
      }
    EXPECT_EQ(*streamer->start_open("small"), plant);
  }
  EXPECT_EQ(streamer->start_open("small").error().status, Status::out_of_memory);
  EXPECT_GT(ledger.reserved(), empty_bytes);
  streamer->cancel_open(700);
  streamer->cancel_open(70);
  EXPECT_EQ(*streamer->start_open("small"), 70u);
  EXPECT_EQ(*streamer->start_open("small"), 700u);
  while (!plants.empty()) {
    frames(1, {});
    std::erase_if(plants, [&](std::uint32_t plant) { return streamer->finish_open(plant).has_value(); });
  }
  EXPECT_TRUE(streamer->is_open(999));
}

/// At each step: while it waits, reads, decodes.
TEST_F(StreamerTest, AnOpeningIsTakenBackWithoutWaiting) {
  start();
  for (int steps = 0; steps < 6; ++steps) {
    io.deferred = jobs.deferred = true;
    const std::uint32_t plant = *streamer->start_open("a");
    for (int i = 0; i < steps; ++i) {
      ASSERT_FALSE(streamer->finish_open(plant)) << i;
      if (io.waiting.empty() || i + 1 == steps) break;
      io.answer_all();
    }
    streamer->cancel_open(plant);
    frames(2, {});
    EXPECT_EQ(io.open_count, io.waiting.size() + jobs.waiting.size()) << "the file is open while something is under way";
    io.answer_all();
    jobs.run_all();
    frames(1, {});
    EXPECT_EQ(io.open_count, 0u) << steps;
    EXPECT_EQ(ledger.reserved(), empty_bytes) << steps;
    io.deferred = jobs.deferred = false;
    EXPECT_EQ(open("b"), plant) << "its index is free";
    streamer->close_plant(plant);
    frames(4, {});
  }
}

TEST_F(StreamerTest, AnOpeningWithoutRoomIsTriedAgainAndThenFails) {
  start_with_whole_plant();
  const std::uint64_t enough = ledger.budget();
  ledger.set_budget(1);
  std::uint32_t plant = *streamer->start_open("b");
  std::uint64_t waited = 0;  // frames of the last wait
  const auto wait = [&](std::uint64_t most) -> std::optional<Result<void>> {
    for (waited = 0; waited < most; ++waited) {
      if (auto finished = streamer->finish_open(plant)) return finished;
      frames(1, {});
    }
    return std::nullopt;
  };
  EXPECT_FALSE(wait(3 * Streamer::kOpenRetryFrames)) << "it failed at once";
  ledger.set_budget(enough);
  const auto opened = wait(2 * Streamer::kOpenRetryFrames);
  ASSERT_TRUE(opened && *opened);
  ledger.set_budget(1);
  plant = *streamer->start_open("b");
  const auto failed = wait(1000);
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->error().status, Status::out_of_memory);
  EXPECT_EQ(waited, (Streamer::kOpenAttempts - 1) * Streamer::kOpenRetryFrames);
}

TEST_F(StreamerTest, AnOpeningSaysWhatIsWrongOnceItKnows) {
  start();
  io.files["text"] = std::vector<std::uint8_t>(1000, 'x');
  io.files["empty"] = {};
  io.files["cut"] = plant_file();
  io.files["cut"].pop_back();
  io.files["damaged"] = plant_file();
  io.files["damaged"][static_cast<std::size_t>(page_chunk(open("a"), 0).offset) + 100] ^= 1;
  const std::size_t open_count = io.open_count;
  const std::uint64_t reserved = ledger.reserved();
  for (const char* path : {"missing", "text", "empty", "cut", "damaged"}) {
    const auto plant = test::must(streamer->start_open(path));
    const auto finished = streamer->finish_open(plant);
    ASSERT_TRUE(finished) << path;
    const Status status = io.files.contains(path) ? Status::bad_file : Status::io;
    EXPECT_EQ(finished->error().status, status) << path;
    EXPECT_EQ(streamer->open_plant(path).error().status, status) << path;
    EXPECT_TRUE(log.lines.back().starts_with(std::string(path) + ": ")) << log.lines.back();
  }
  EXPECT_TRUE(test::mentions(log.lines[0], {"missing", std::strerror(ENOENT)}));
  EXPECT_EQ(io.open_count, open_count) << "every file is closed again";
  EXPECT_EQ(ledger.reserved(), reserved);
  EXPECT_EQ(log.lines.size(), 10u);
}

TEST_F(StreamerTest, APlantInMemoryIsStreamedFromThere) {
  io.files.clear();
  start();
  const auto plant = test::must(streamer->open_plant({"archive:a", plant_file()}));
  frames(20, {demand_of(5000.0f)});
  EXPECT_EQ(streamer->state(plant).resident_leaf_count, 3000u);
  EXPECT_STREQ(streamer->path(plant), "archive:a");
  EXPECT_TRUE(io.handles.empty() && io.log.empty()) << "the io hook has been called";
  const std::vector<std::uint8_t>& exact = plant_file();
  for (std::size_t n = 1; n < exact.size(); n += n < 300 ? 1 : 997) {
    const std::vector<std::uint8_t> cut(exact.begin(), exact.begin() + static_cast<std::ptrdiff_t>(n));
    const auto refused = streamer->open_plant({"archive:cut", cut});
    ASSERT_FALSE(refused) << n;
    EXPECT_EQ(refused.error().status, Status::bad_file) << n;
    EXPECT_TRUE(log.lines.back().starts_with("archive:cut: ")) << log.lines.back();
  }
}

TEST_F(StreamerTest, APlantThatFindsNoRoomFindsItAfterAFewFrames) {
  const std::uint32_t plant = start_with_whole_plant();
  const std::uint64_t budget = ledger.reserved() + 130000;  // a page on its way takes decoders, too
  ledger.set_budget(budget);
  gpu->frames_behind = 2;
  int attempts = 0;
  for (auto other = streamer->open_plant("b"); !other; other = streamer->open_plant("b")) {
    EXPECT_EQ(other.error().status, Status::out_of_memory);
    ASSERT_LT(++attempts, 12);
    frames(1, {demand_of(5000.0f)});
    EXPECT_LE(ledger.reserved(), budget);
  }
  EXPECT_GT(attempts, 2) << "nothing is reused before the GPU is done with it";
  EXPECT_LE(ledger.reserved(), budget);
  EXPECT_LT(streamer->state(plant).resident_page_count, 6u);
}

TEST_F(StreamerTest, APlantTooLargeForTheBudgetCostsTheOthersNothing) {
  const std::uint32_t plant = start_with("a");
  frames(20, {demand_of(300.0f)});
  ASSERT_EQ(streamer->state(plant).resident_texture_count, 1u);
  const std::uint64_t loaded = streamer->stats().all().loaded;
  ledger.set_budget(ledger.reserved() + 1000);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(streamer->open_plant("b").error().status, Status::out_of_memory);
    frames(5, {demand_of(300.0f)});
  }
  EXPECT_TRUE(test::mentions(log.lines.back(), {"b"}));
  EXPECT_TRUE(gpu->evicted.empty());
  EXPECT_EQ(streamer->stats().all().loaded, loaded);
}

/// The n-th allocation fails, n = 0, 1, 2 ... until nothing fails any more. The plant has all that a file can have.
class FailingAllocator : public StreamerTest, public testing::WithParamInterface<bool> {
 protected:
  static constexpr std::uint32_t kLeaves = 1200, kLeafMeshes = 2;

  FailingAllocator() {
    static const std::vector<std::uint8_t> file = test::packed_plant({.leaf_count = kLeaves, .seed = 5, .leaf_mesh_count = kLeafMeshes});
    io.files["whole"] = file;
    options.gpu.block_textures = false;  // a job then allocates too
  }

  /// False: the allocator got as far as failing.
  bool run(std::size_t fail_at) {
    test::FakeAllocator failing;
    failing.fail_at = fail_at;
    failing.fail_for_good = GetParam();
    ledger = Ledger(256ull << 20);
    if (auto created = Streamer::create({failing.hook(), jobs.hook(), io.hook(), {}}, ledger, options))
      drive(**created, failing);
    else
      EXPECT_EQ(created.error().status, Status::out_of_memory);
    EXPECT_EQ(failing.live_bytes, 0u) << "leak when allocation " << fail_at << " fails";
    EXPECT_EQ(io.open_count, 0u) << "file left open when allocation " << fail_at << " fails";
    return failing.calls <= fail_at;
  }
  void drive(Streamer& failing, const test::FakeAllocator& allocator_of_it) {
    test::FakeGpu fake(failing, ledger);
    const auto plant = failing.open_plant("whole");
    EXPECT_EQ(bool(plant), allocator_of_it.calls <= allocator_of_it.fail_at) << "whatever fails while it opens is noticed";
    if (!plant) {
      EXPECT_EQ(plant.error().status, Status::out_of_memory);
      return;
    }
    const std::vector<PlantDemand> demands = {demand_of(5000.0f)};
    for (int i = 0; i < 5; ++i) fake.frame(view, demands);
    EXPECT_GE(failing.state(*plant).resident_page_count, 1u);
    EXPECT_EQ(failing.stats().all().failed, 0u) << "a lack of memory is no damage";
    if (GetParam()) return;
    for (int i = 0; i < 60; ++i) fake.frame(view, demands);
    const PlantState state = failing.state(*plant);
    EXPECT_EQ(state.resident_leaf_count, kLeaves) << "it recovers";
    EXPECT_EQ(state.resident_wood_mask, 0b11u);
    EXPECT_EQ(state.resident_texture_count, 2u);
    EXPECT_TRUE(state.leaf_meshes_resident);
  }
};

TEST_P(FailingAllocator, LeaksNothingAndKeepsAPrefix) {
  std::size_t n = 0;
  while (!run(n)) ++n;
  EXPECT_GT(n, 70u);
}
INSTANTIATE_TEST_SUITE_P(Once, FailingAllocator, testing::Values(false));
INSTANTIATE_TEST_SUITE_P(ForGood, FailingAllocator, testing::Values(true));

TEST_F(StreamerTest, DestructionWaitsForReadsInFlight) {
  start_with("a");
  io.deferred = true;
  frames(1, {demand_of(5000.0f)});
  ASSERT_FALSE(io.waiting.empty());
  std::thread answers([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    io.answer_all();
  });
  gpu.reset();
  streamer.reset();
  EXPECT_TRUE(io.waiting.empty()) << "destroyed before the last read was answered";
  answers.join();
  EXPECT_EQ(allocator.live_bytes, 0u);
  EXPECT_EQ(io.open_count, 0u);
}

/// The default hooks: real files, real threads. Run under the tsan preset too.
class StreamerThreads : public testing::TestWithParam<Reading> {};
INSTANTIATE_TEST_SUITE_P(Automatic, StreamerThreads, testing::Values(Reading::automatic));
INSTANTIATE_TEST_SUITE_P(ThreadPool, StreamerThreads, testing::Values(Reading::thread_pool));

TEST_P(StreamerThreads, LoadsFromDiskWhileTheViewChanges) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = test::write_file(folder / "plant.coppice", plant_file());
  auto set = test::must(complete_hooks({}, GetParam()));
  for (int round = 0; round < 5; ++round) {
    Ledger ledger;
    auto streamer = test::must(Streamer::create(set.hooks, ledger, {.gpu = kGpuSizes, .max_in_flight = 6}));
    test::FakeGpu gpu(*streamer, ledger);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(streamer->open_plant(path.c_str()));
    const std::uint64_t budget = ledger.reserved() + 560000;
    ledger.set_budget(budget);
    LodView view;
    // On a busy machine the threads that read come late.
    for (int i = 0; i < 200 || (streamer->stats().all().loaded <= 6 && i < 100'000); ++i) {
      const auto weight = [&](int plant) { return (i / 40 + round) % 3 == plant ? 20.0f : 1.0f; };
      const std::vector<PlantDemand> demands = {demand_of(4000.0f, weight(0)), demand_of(4000.0f, weight(1)), demand_of(900.0f, weight(2))};
      gpu.frame(view, demands);
      ASSERT_LE(ledger.reserved(), budget);
      if (i % 8 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(streamer->stats().all().failed, 0u);
    EXPECT_GT(streamer->stats().all().loaded, 6u);
  }
}

}  // namespace coppice::streamer_test
