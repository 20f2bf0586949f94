#pragma once

// A streamer whose every hook is a fake, and the GPU that follows it.

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "fake_gpu.h"
#include "fake_hooks.h"
#include "streamer.h"

namespace coppice::test {

class StreamerFixture : public testing::Test {
 protected:
  StreamerFixture() { options.clock_ns = hurried_clock_ns; }
  /// With io.files and options as they are now.
  void start() {
    ledger = Ledger(ledger.budget());
    auto created = Streamer::create({allocator.hook(), jobs.hook(), io.hook(), log.hook()}, ledger, options);
    ASSERT_TRUE(created) << created.error().message();
    streamer = *std::move(created);
    gpu = std::make_unique<FakeGpu>(*streamer, ledger);
  }
  std::uint32_t open(const char* path) {
    auto plant = streamer->open_plant(path);
    EXPECT_TRUE(plant) << plant.error().message();
    return plant ? *plant : 0;
  }
  /// All of the plant is resident.
  void expect_whole(std::uint32_t plant) const {
    const coppice_file_plant& file = streamer->file(plant).plant;
    const PlantState state = streamer->state(plant);
    EXPECT_EQ(state.resident_leaf_count, file.leaf_count);
    EXPECT_EQ(state.resident_wood_mask, (1u << file.wood_lod_count) - 1);
    EXPECT_EQ(state.resident_texture_count, file.texture_count);
  }
  void frames(int count, std::vector<PlantDemand> demands) {
    for (int i = 0; i < count; ++i) gpu->frame(view, demands);
  }

  FakeAllocator allocator;
  FakeJobs jobs;
  FakeIo io;
  FakeLog log;
  StreamerOptions options;
  Ledger ledger{256ull << 20};
  LodView view;
  std::unique_ptr<Streamer> streamer;
  std::unique_ptr<FakeGpu> gpu;
};

}  // namespace coppice::test
