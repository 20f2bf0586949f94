// What a growing memory budget does to the picture: it never gets worse, and memory does not stay unused while something is wanted.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "packed_plant.h"
#include "streamer_fixture.h"

namespace coppice::budget_sweep_test {

using test::demand_of;

/// Reserved by others, as the buffers of a renderer are.
constexpr std::uint64_t kOthersBytes = 16u << 20;
constexpr std::array<float, kMaxViewGroups> kError_px = {2.0f, 1.5f, 3.0f, 4.0f};
constexpr std::array kFiles = {"plain", "meshes", "poster"};

/// Plants of three kinds: pages and wood; leaf meshes that take more than their pages; a texture of a third of a megabyte.
std::vector<std::uint8_t> plant_file(const std::string& kind) {
  if (kind == "plain") return test::packed_plant({.leaf_count = 12000, .seed = 5});
  if (kind == "meshes") return test::packed_plant({.leaf_count = 3000, .seed = 6, .leaf_mesh_count = 4});
  return test::packed_plant({.leaf_count = 4000, .seed = 7, .texture_side = 256}, bake::TextureCoding::rgba8);
}

struct Size {
  std::uint32_t plants = 1, views = 1;
};

class BudgetSweep : public test::StreamerFixture, public testing::WithParamInterface<std::uint32_t> {
 protected:
  /// What a budget shows.
  struct Picture {
    std::array<float, kMaxViewGroups> threshold_px{};
    std::vector<PlantState> plants;
    float worst_px = 0.0f;  ///< error of the plant that is most wrong: of its cut, or for lack of its texture
    bool all_textures = true;
    bool complete = false;
  };

  void SetUp() override {
    for (const char* file : kFiles) {
      static std::map<std::string, std::vector<std::uint8_t>> made;
      if (!made.contains(file)) made[file] = plant_file(file);
      io.files[file] = made[file];
    }
    options.gpu = {.plant_bytes = 1000, .block_textures = true};
  }
  void restart() {
    gpu.reset();
    streamer.reset();
    ledger = Ledger(UINT64_MAX / 2);
    start();
    ledger.reserve(kOthersBytes);
    for (std::uint32_t i = 0; i < size.plants; ++i) open(kFiles[i % kFiles.size()]);
    run(2, false);
  }
  /// Sizes from 200 to 3,000 px, in another order in each view.
  static float size_px(std::uint32_t plant, std::uint32_t group) {
    return 200.0f * std::pow(15.0f, static_cast<float>((plant * 7 + group * 5) % 20) / 19.0f);
  }
  void run(int count, bool seen) {
    std::array<std::vector<PlantDemand>, kMaxViewGroups> demands;
    test::FakeGpu::Groups groups;
    for (std::uint32_t group = 0; group < size.views && seen; ++group) {
      for (std::uint32_t plant = 0; plant < size.plants; ++plant)
        demands[group].push_back(demand_of(size_px(plant, group), static_cast<float>(1 + plant)));
      LodView of = view;
      of.error_px = kError_px[group];
      groups[group] = ViewGroup{of, demands[group]};
    }
    for (int i = 0; i < count; ++i) gpu->frame(groups);
  }
  /// Runs until nothing has changed for some frames. Takes as many as the thresholds need to fall by steps.
  void rest() {
    std::uint64_t before = 0;
    for (int still = 0, i = 0; still < 3 && i < 200; ++i) {
      run(4, true);
      const ChunkCounts all = streamer->stats().all();
      const std::uint64_t now = all.loaded + all.evicted + all.wanted;
      const bool moves = now != before || std::exchange(threshold_px_, streamer->threshold_px(0)) != streamer->threshold_px(0);
      still = moves ? 0 : still + 1;
      before = now;
    }
  }
  [[nodiscard]] Picture picture() const {
    Picture shown;
    shown.complete = true;
    for (std::uint32_t group = 0; group < size.views; ++group) {
      shown.threshold_px[group] = streamer->threshold_px(group);
      shown.complete = shown.complete && shown.threshold_px[group] == kError_px[group];
    }
    for (std::uint32_t plant = 0; plant < size.plants; ++plant) {
      const PlantState state = streamer->state(plant);
      const PlantFile& file = streamer->file(plant);
      const std::uint64_t own_textures = file.plant.texture_count - (file.plant.leaf_mesh_count > 0 ? 1 : 0);
      shown.plants.push_back(state);
      shown.all_textures = shown.all_textures && state.resident_texture_count >= own_textures;
      for (std::uint32_t group = 0; group < size.views; ++group) {
        const float px = size_px(plant, group) * kError_px[0] / kError_px[group];
        const float cut_px = error_px_at(lod_table(file, streamer->lod_words(plant)), static_cast<float>(state.resident_leaf_count), px);
        shown.worst_px = std::max({shown.worst_px, cut_px, state.resident_texture_count < own_textures ? 0.25f * px : 0.0f});
      }
    }
    return shown;
  }
  void expect_no_worse(const Picture& now, const Picture& before) const {
    for (std::uint32_t group = 0; group < size.views; ++group) EXPECT_LE(now.threshold_px[group], before.threshold_px[group]);
    EXPECT_LE(now.worst_px, 1.01f * before.worst_px);
    for (std::uint32_t plant = 0; plant < size.plants; ++plant) {
      const PlantState &has = now.plants[plant], &had = before.plants[plant];
      EXPECT_GE(has.resident_texture_count, had.resident_texture_count) << plant;
      EXPECT_GE(has.leaf_meshes_resident, had.leaf_meshes_resident) << plant;
      EXPECT_EQ(has.resident_wood_mask & had.resident_wood_mask, had.resident_wood_mask) << plant;
      if (before.all_textures) {
        EXPECT_GE(has.resident_page_count, had.resident_page_count) << plant;
      }
    }
  }

  /// Budgets from the least that open plants take to more than the whole, in steps of 2 %. restarts: every how many begin with nothing
  /// loaded; others go on from the one before
  void sweep(std::uint32_t restarts) {
    restart();
    rest();
    const std::uint64_t whole_bytes = ledger.reserved();
    restart();
    Picture before;
    std::uint32_t count = 0;
    for (std::uint64_t budget = ledger.reserved() + ledger.reserved() / 50; budget < whole_bytes + whole_bytes / 10;
         budget += budget / 50) {
      SCOPED_TRACE(std::to_string(size.plants) + " plants, " + std::to_string(size.views) + " views, " + std::to_string(budget) +
                   " bytes of " + std::to_string(whole_bytes));
      if (count % restarts == 0) restart();
      ledger.set_budget(budget);
      rest();
      const Picture now = picture();
      EXPECT_EQ(streamer->stats().all().wanted, 0u) << "what is in demand fits";
      EXPECT_LE(ledger.reserved(), budget);
      if (!now.complete) {
        EXPECT_GE(ledger.reserved(), budget - budget / 20);
      }
      if (count++ > 0) expect_no_worse(now, before);
      before = now;
    }
    EXPECT_TRUE(before.complete);
  }

  Size size;

 private:
  float threshold_px_ = 0.0f;
};

TEST_P(BudgetSweep, MoreMemoryIsNeverWorseAndIsUsed) {
  constexpr std::array kSizes = {Size{1, 1}, Size{3, 3}, Size{5, 4}};
  size = kSizes[GetParam()];
  sweep(1);
}
INSTANTIATE_TEST_SUITE_P(Few, BudgetSweep, testing::Range(0u, 3u));

using EveryBudgetSweep = BudgetSweep;
TEST_P(EveryBudgetSweep, MoreMemoryIsNeverWorseAndIsUsed) {
  for (std::uint32_t plants = 1; plants <= 20; ++plants) {
    size = {plants, GetParam()};
    sweep(6);
  }
}
INSTANTIATE_TEST_SUITE_P(Views, EveryBudgetSweep, testing::Range(1u, 5u));

}  // namespace coppice::budget_sweep_test
