#include "device_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "device.h"
#include "device_memory_hook.h"
#include "results.h"

namespace coppice::gpu::device_memory_test {

constexpr std::uint64_t kUnit = 1024, kBlock = 16 * kUnit;

class DeviceMemoryTest : public ::testing::Test {
 protected:
  DeviceMemoryTest() {
    device_.memory.hook = hook_.hook();
    device_.memory.properties.memoryTypeCount = 2;
    device_.memory.ledger = &ledger_;
    set_block_bytes(device_, kBlock, kUnit);
  }
  ~DeviceMemoryTest() override {
    for (MemoryRange& range : reserved_) release_memory(device_, range);
    close_memory(device_);
    EXPECT_EQ(hook_.live_count, 0u);
    EXPECT_EQ(hook_.misuse, "");
    EXPECT_EQ(device_.memory.allocated_bytes, 0u);
    EXPECT_EQ(ledger_.reserved(), 0u);
    EXPECT_EQ(device_.memory.free_bytes, 0u);
  }

  static MemoryRequest of(std::uint64_t bytes, std::uint64_t alignment = 4) {
    return {.requirements = {.size = bytes, .alignment = alignment, .memoryTypeBits = 1}};
  }
  MemoryRange reserve(const MemoryRequest& request) {
    auto range = test::must(reserve_memory(device_, request));
    reserved_.push_back(range);
    return range;
  }
  void release(std::size_t index) {
    release_memory(device_, reserved_[index]);
    reserved_.erase(reserved_.begin() + static_cast<std::ptrdiff_t>(index));
  }
  void give_all() {
    while (!reserved_.empty()) release(0);
  }
  /// No two ranges overlap, runs are sorted and apart, and all sums are what they say.
  void expect_consistent() {
    const DeviceMemory& memory = device_.memory;
    std::uint64_t allocated = 0, free = 0;
    std::uint32_t count = 0;
    for (std::uint32_t index = 0; index < memory.blocks.size(); ++index) {
      const MemoryBlock& block = memory.blocks[index];
      if (block.source.memory == VK_NULL_HANDLE) continue;
      ++count;
      allocated += block.bytes;
      std::vector<FreeRun> parts = block.free;
      for (std::size_t i = 0; i < block.free.size(); ++i) {
        if (block.kind == MemoryKind::device) free += block.free[i].bytes / kUnit * kUnit;
        EXPECT_TRUE(i == 0 || block.free[i].offset > block.free[i - 1].offset + block.free[i - 1].bytes);
      }
      for (const MemoryRange& range : reserved_)
        if (range.block == index) parts.push_back({range.offset, range.bytes});
      std::ranges::sort(parts, {}, &FreeRun::offset);
      std::uint64_t end = 0;
      for (const FreeRun& part : parts) {
        EXPECT_EQ(part.offset, end) << "a gap, or two on one place";
        end = part.offset + part.bytes;
      }
      EXPECT_EQ(end, block.bytes);
    }
    EXPECT_EQ(memory.allocated_bytes, allocated);
    EXPECT_EQ(memory.free_bytes, free);
    EXPECT_EQ(memory.block_count, count);
    EXPECT_EQ(hook_.live_count, count);
    EXPECT_EQ(hook_.live_bytes, allocated);
    EXPECT_EQ(committed_bytes(memory), allocated + kBlock - std::min(free, kBlock));
    EXPECT_EQ(ledger_.reserved(), committed_bytes(memory));
  }

  test::DeviceMemoryHook hook_;
  Ledger ledger_;
  Device device_;
  std::vector<MemoryRange> reserved_;
};

TEST_F(DeviceMemoryTest, ABlockIsSharedAndOneEmptyOneIsKept) {
  for (int i = 0; i < 16; ++i) EXPECT_EQ(reserve(of(kUnit)).block, 0u);
  EXPECT_EQ(hook_.calls, 1u);
  for (int i = 0; i < 32; ++i) reserve(of(kUnit));
  EXPECT_EQ(hook_.live_count, 3u);
  give_all();
  EXPECT_EQ(hook_.live_count, 1u);
  reserve(of(kUnit));
  EXPECT_EQ(hook_.calls, 3u) << "what was kept is used";
  set_block_bytes(device_, 2 * kBlock, kUnit);
  give_all();
  EXPECT_EQ(hook_.live_count, 0u) << "of another size";
}

TEST_F(DeviceMemoryTest, TheFullestBlockAndItsSmallestRunAreTaken) {
  for (int i = 0; i < 32; ++i) reserve(of(kUnit));
  release(31);  // the second block: free are 15, then 10 and 11
  release(27);
  release(26);
  release(5);  // the first: 5
  EXPECT_EQ(reserve(of(kUnit)).block, 0u);
  const MemoryRange one = reserve(of(kUnit));
  EXPECT_EQ(one.block, 1u);
  EXPECT_EQ(one.offset, 15 * kUnit);
  EXPECT_EQ(reserve(of(2 * kUnit)).offset, 10 * kUnit);
  expect_consistent();
}

TEST_F(DeviceMemoryTest, PlacesAreAlignedInTheMemoryThatTheHookGave) {
  reserve(of(100));
  for (const std::uint64_t alignment : {256u, 512u, 2048u, 4096u}) {
    const MemoryRange range = reserve(of(300, alignment));
    EXPECT_EQ((device_.memory.blocks[range.block].source.offset + range.offset) % alignment, 0u);
    EXPECT_EQ(range.bytes, 512u);
  }
  expect_consistent();
}

TEST_F(DeviceMemoryTest, WhatStaysHoldsNoBlockThatEvictionsEmpty) {
  constexpr std::uint64_t kLarge = 4 << 20;
  set_block_bytes(device_, kLarge, kUnit);
  MemoryRequest stays = of(kUnit);
  stays.kind = MemoryKind::lasting;
  for (int i = 0; i < 8; ++i) {
    reserve(stays);
    reserve(of(kLarge / 4));
  }
  EXPECT_GE(hook_.live_bytes, 2 * kLarge);
  for (std::size_t i = 8; i-- > 0;) release(2 * i + 1);
  EXPECT_EQ(committed_bytes(device_.memory), kLarge / 4 + kLarge) << "a small block, and the empty one that is kept";
  EXPECT_EQ(committed_bytes(device_.memory), lasting_bytes(device_.memory, kLarge));
  EXPECT_EQ(lasting_bytes(device_.memory, kBlock), kLarge / 4 + kBlock);
}

TEST_F(DeviceMemoryTest, WhatIsLargeOrAloneHasABlockOfItsOwn) {
  reserve(of(kUnit));
  EXPECT_EQ(reserve(of(kBlock / 2)).block, 0u);
  EXPECT_EQ(reserve(of(kBlock / 2 + 1)).block, 1u);
  EXPECT_EQ(hook_.live_bytes, kBlock + kBlock / 2 + 256);
  MemoryRequest request = of(kUnit);
  request.kind = MemoryKind::alone;
  reserve(request);
  EXPECT_EQ(hook_.sizes.rbegin()->second, kUnit);
  release(reserved_.size() - 1);
  EXPECT_EQ(hook_.live_count, 2u) << "and it goes back at once";
  expect_consistent();
}

TEST_F(DeviceMemoryTest, MappedMemoryHasBlocksOfItsOwnAndNoneIsKept) {
  reserve(of(kUnit));
  MemoryRequest request = of(kUnit);
  request.kind = MemoryKind::host;
  EXPECT_EQ(reserve(request).block, 1u);
  EXPECT_EQ(reserve(request).block, 1u);
  EXPECT_EQ(reserve(of(kUnit)).block, 0u);
  expect_consistent();
  release(1);
  release(1);
  EXPECT_EQ(hook_.live_count, 1u);
}

TEST_F(DeviceMemoryTest, MemoryTypesAndImagesAreKeptApart) {
  MemoryRequest image = of(kUnit);
  image.image = true;
  EXPECT_EQ(reserve(of(kUnit)).block, reserve(image).block);
  set_granularity(device_.memory, 65536);
  EXPECT_EQ(reserve(image).block, 1u);
  EXPECT_EQ(reserve(of(kUnit)).block, 0u);
  MemoryRequest other_type = of(kUnit);
  other_type.requirements.memoryTypeBits = 2;
  hook_.memory_type = 1;
  EXPECT_EQ(reserve(other_type).block, 2u);
  other_type.requirements.memoryTypeBits = 3;
  EXPECT_EQ(reserve(other_type).block, 0u) << "the fullest that fits";
  expect_consistent();
  set_granularity(device_.memory, 1024);
  EXPECT_EQ(reserve(of(1)).bytes, 1024u) << "so that neighbours may be of both kinds";
}

TEST_F(DeviceMemoryTest, TheBudgetHoldsAndWhatIsLackingIsWanted) {
  reserve(of(kUnit));
  ledger_.set_budget(ledger_.reserved() + 2 * kUnit);
  reserve(of(kUnit));
  reserve(of(kUnit));
  EXPECT_EQ(reserve_memory(device_, of(3 * kUnit)).error().status, Status::out_of_memory);
  EXPECT_EQ(ledger_.refused(), 3 * kUnit);
  release(0);
  reserve(of(kUnit));
  EXPECT_LE(device_.memory.allocated_bytes, ledger_.budget());
  expect_consistent();
}

/// What a streamer counts on: it reserves bytes and gets them, whatever was taken before.
TEST_F(DeviceMemoryTest, WhatFitsTheBudgetIsNeverRefused) {
  std::mt19937 random(7);
  for (int i = 0; i < 4000; ++i) {
    ledger_.set_budget(Ledger::kUnlimited);
    MemoryRequest request = of(1 + random() % (kBlock / 2 + kUnit), 4u << random() % 10);
    if (random() % 4 == 0) request.kind = MemoryKind::host;
    if (random() % 2 == 0 || reserved_.empty())
      reserve(request);
    else
      release(random() % reserved_.size());
    if (i % 100 == 0) expect_consistent();
    const std::uint64_t bytes = (request.requirements.size + 255) / 256 * 256;
    ledger_.set_budget(ledger_.reserved() + bytes);
    reserve(request);
    EXPECT_LE(ledger_.reserved(), ledger_.budget());
    if (random() % 8 != 0) release(reserved_.size() - 1);
    if (HasFailure()) return;
  }
  give_all();
  EXPECT_LE(hook_.live_count, 1u);
  expect_consistent();
}

TEST_F(DeviceMemoryTest, TheSameCallsTakeTheSamePlaces) {
  std::vector<std::uint64_t> places[2];
  for (auto& run : places) {
    std::mt19937 random(3);
    for (int i = 0; i < 500; ++i) {
      if (random() % 3 != 0 || reserved_.empty()) {
        const MemoryRange range = reserve(of(1 + random() % kBlock));
        run.insert(run.end(), {range.block, range.offset});
      } else {
        release(random() % reserved_.size());
      }
    }
    give_all();
    close_memory(device_);
    device_.memory.blocks.clear();
  }
  EXPECT_EQ(places[0], places[1]);
}

TEST_F(DeviceMemoryTest, AHookThatFailsOrGivesNonsenseIsAnError) {
  hook_.fail_at = 0;
  test::expect_error(reserve_memory(device_, of(kUnit)), Status::out_of_memory);
  hook_.memory_type = 1;
  test::expect_error(reserve_memory(device_, of(kUnit)), Status::internal, {"memory_type"});
  EXPECT_EQ(hook_.live_count, 0u) << "it gets it back";
}

}  // namespace coppice::gpu::device_memory_test
