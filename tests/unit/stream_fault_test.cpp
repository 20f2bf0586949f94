// Everything that can go wrong with files under the streamer, one thing at a time: the plant keeps its last good cut, one line says what
// and where, other plants do not notice, and nothing is left behind.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "io_result.h"
#include "mentions.h"
#include "packed_plant.h"
#include "streamer_fixture.h"

namespace coppice::stream_fault_test {

using test::demand_of;
using test::ReadFault;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kChunks = 9;  // six pages, two wood LoDs, a texture

class StreamFault : public test::StreamerFixture {
 protected:
  void SetUp() override {
    static const Bytes a = test::packed_plant({.leaf_count = 3000, .seed = 5}), b = test::packed_plant({.leaf_count = 3000, .seed = 6});
    io.files = {{"a", a}, {"b", b}};
    options.gpu = {.plant_bytes = 1000};
  }
  void shut_down() {
    gpu.reset();
    streamer.reset();
    EXPECT_EQ(allocator.live_bytes, 0u);
    EXPECT_EQ(io.open_count, 0u);
  }
  [[nodiscard]] std::uint64_t offset_of(std::uint32_t plant, coppice_chunk_kind kind, std::uint32_t index) const {
    return find_chunk(streamer->file(plant), kind, index)->offset;
  }

  const std::vector<PlantDemand> both_ = {demand_of(5000.0f), demand_of(5000.0f)};
};

/// A read that goes wrong so many times.
struct FaultyRead {
  ReadFault fault = ReadFault::none;
  std::size_t attempts = 1;
  /// Bytes that come but are wrong are not read again: the file is damaged.
  [[nodiscard]] bool is_lasting() const { return fault == ReadFault::returns_wrong_bytes || attempts >= kReadAttempts; }
};

class NthRead : public StreamFault, public testing::WithParamInterface<FaultyRead> {
 protected:
  /// False: no read was left to go wrong.
  bool run(std::size_t n) {
    log.lines.clear();
    io.fault = GetParam().fault;
    io.fault_attempts = GetParam().attempts;
    io.fault_at = n;
    io.answered = 0;
    start();
    const std::uint32_t a = open_again("a"), b = open_again("b");
    const std::size_t failed_opens = log.lines.size();
    EXPECT_LE(failed_opens, GetParam().is_lasting() ? 1u : 0u) << n;
    frames(60, both_);
    const std::uint64_t failed = streamer->stats().all().failed;
    const bool reached = io.answered > n;
    const std::uint64_t expected = reached && GetParam().is_lasting() ? 1 : 0;
    // A texture's header is read once more with its chunk: there a wrong byte costs nothing.
    if (GetParam().fault == ReadFault::returns_wrong_bytes)
      EXPECT_LE(failed + failed_opens, expected) << n;
    else
      EXPECT_EQ(failed + failed_opens, expected) << n;
    EXPECT_EQ(streamer->stats().all().wanted, 0u) << "what can never come is not waited for, read " << n;
    EXPECT_EQ(log.lines.size(), failed_opens + failed) << "one line, read " << n;
    for (const std::string& line : log.lines)
      EXPECT_TRUE((line.starts_with("a: ") || line.starts_with("b: ")) && test::names_an_offset(line)) << line;
    if (failed > 0 && GetParam().fault != ReadFault::comes_short) {
      EXPECT_TRUE(test::mentions(log.lines.back(), {GetParam().fault == ReadFault::fails ? std::strerror(EIO) : "checksum"}));
    }
    const std::uint32_t hurt = failed > 0 && log.lines.back().starts_with("b") ? b : a;
    expect_whole(hurt == b ? a : b);
    if (failed == 0) expect_whole(hurt);
    EXPECT_GE(streamer->state(hurt).resident_leaf_count, COPPICE_PAGE_SPLITS + 1) << n;
    shut_down();
    return reached;
  }
  /// Opens; where that fails, again.
  std::uint32_t open_again(const char* path) {
    const auto plant = streamer->open_plant(path);
    if (plant) return *plant;
    EXPECT_TRUE(plant.error().status == Status::io || plant.error().status == Status::bad_file);
    return open(path);
  }
};

TEST_P(NthRead, CostsNoMoreThanWhatItWasOf) {
  std::size_t n = 0;
  while (run(n)) ++n;
  EXPECT_GE(n, 2 * (2 + kChunks - 2));
}
void PrintTo(const FaultyRead& read, std::ostream* out) {
  *out << "fault " << static_cast<int>(read.fault) << ", " << read.attempts << " attempts";
}
INSTANTIATE_TEST_SUITE_P(Faults, NthRead,
                         testing::Values(FaultyRead{ReadFault::fails, 1}, FaultyRead{ReadFault::fails, kReadAttempts - 1},
                                         FaultyRead{ReadFault::fails, kReadAttempts}, FaultyRead{ReadFault::comes_short, 1},
                                         FaultyRead{ReadFault::comes_short, kReadAttempts}, FaultyRead{ReadFault::returns_wrong_bytes, 1}));

/// A clock that stands still until the test moves it.
class PausedRead : public StreamFault {
 protected:
  void SetUp() override {
    StreamFault::SetUp();
    now_ms = 1;
    options.clock_ns = [] { return now_ms * 1'000'000; };
    start();
    plant = open("a");
    frames(3, {PlantDemand{}, PlantDemand{}});
    io.fail_offset = offset_of(plant, COPPICE_CHUNK_PAGE, 2);
    io.failing_result = -EIO;
    io.log.clear();
  }
  void wait_ms(std::uint64_t ms) {
    now_ms += ms;
    frames(3, both_);
  }
  [[nodiscard]] std::ptrdiff_t attempts() const { return std::ranges::count(io.log, io.fail_offset, &test::FakeRead::offset); }

  std::uint32_t plant = 0;

 private:
  static inline std::uint64_t now_ms = 0;
};

TEST_F(PausedRead, IsTriedAgainAfterGrowingPauses) {
  frames(5, both_);
  EXPECT_EQ(attempts(), 1);
  EXPECT_EQ(streamer->state(plant).resident_page_count, 2u) << "frames go on with what is there";
  std::ptrdiff_t tried = 1;
  for (const std::uint64_t pause_ms : {50u, 200u, 800u}) {
    wait_ms(pause_ms - 1);
    EXPECT_EQ(attempts(), tried) << pause_ms;
    EXPECT_TRUE(log.lines.empty());
    wait_ms(1);
    EXPECT_EQ(attempts(), ++tried) << pause_ms;
  }
  ASSERT_EQ(log.lines.size(), 1u);
  EXPECT_TRUE(test::mentions(log.lines[0], {"a: page 2", std::strerror(EIO), "byte " + std::to_string(io.fail_offset)}));
  EXPECT_EQ(streamer->stats().all().failed, 1u);
  for (const std::uint64_t pause_s : {5u, 10u, 20u, 40u, 60u, 60u}) {
    wait_ms(1000 * pause_s - 1);
    EXPECT_EQ(attempts(), tried) << pause_s;
    wait_ms(1);
    EXPECT_EQ(attempts(), ++tried) << "one at a time, " << pause_s;
  }
  EXPECT_EQ(log.lines.size(), 1u) << "said once";
  EXPECT_EQ(streamer->stats().all().failed, 1u);
  EXPECT_EQ(streamer->stats().all().wanted, 0u);
  EXPECT_EQ(std::ranges::count(io.log, offset_of(plant, COPPICE_CHUNK_PAGE, 1), &test::FakeRead::offset), 1);
  shut_down();
}

TEST_F(PausedRead, IsThereOnceTheDriveIsBack) {
  for (int i = 0; i < 4; ++i) wait_ms(1000);
  ASSERT_EQ(log.lines.size(), 1u);
  EXPECT_EQ(streamer->state(plant).resident_page_count, 2u);
  io.fail_offset = UINT64_MAX;
  wait_ms(5000);
  frames(5, both_);
  expect_whole(plant);
  shut_down();
}

TEST_F(PausedRead, IsTriedAtOnceWhenTheEngineSaysSo) {
  for (int i = 0; i < 4; ++i) wait_ms(1000);
  const std::ptrdiff_t tried = attempts();
  streamer->retry_failed();
  wait_ms(0);
  EXPECT_EQ(attempts(), tried + 1);
  for (int i = 0; i < 4; ++i) wait_ms(1000);
  EXPECT_EQ(attempts(), tried + 4) << "with all attempts";
  EXPECT_EQ(log.lines.size(), 2u) << "and said again";
  io.fail_offset = UINT64_MAX;
  streamer->retry_failed();
  wait_ms(0);
  frames(5, both_);
  expect_whole(plant);
  shut_down();
}

TEST_F(PausedRead, ThatSucceedsInTheEndIsNoFailure) {
  frames(5, both_);
  wait_ms(50);
  io.fail_offset = UINT64_MAX;
  wait_ms(200);
  frames(5, both_);
  expect_whole(plant);
  EXPECT_TRUE(log.lines.empty());
  EXPECT_EQ(streamer->stats().all().failed, 0u);
  shut_down();
}

TEST_F(PausedRead, IsForgottenWhereNothingWantsItAnyMore) {
  frames(5, both_);
  EXPECT_GT(streamer->stats().all().in_flight, 0u);
  frames(40, {PlantDemand{}, PlantDemand{}});
  EXPECT_EQ(streamer->stats().all().in_flight, 0u);
  wait_ms(0);  // asks again
  ledger.set_budget(ledger.reserved() / 2);
  frames(2, both_);
  streamer->close_plant(plant);
  frames(5, both_);
  EXPECT_FALSE(streamer->is_open(plant));
  EXPECT_EQ(streamer->stats().all().in_flight, 0u);
  EXPECT_TRUE(log.lines.empty());
  shut_down();
}

TEST_F(PausedRead, ALackOfMemoryInTheHookIsNoFailure) {
  io.failing_result = -ENOMEM;
  for (int i = 0; i < 20; ++i) wait_ms(1000);
  EXPECT_EQ(streamer->stats().all().failed, 0u);
  EXPECT_GT(attempts(), 1);
  io.fail_offset = UINT64_MAX;
  frames(100, both_);
  expect_whole(plant);
  shut_down();
}

// The parts of leaf meshes are loaded all or not at all: one that is damaged takes the rest with it.
TEST_F(StreamFault, WhatIsDamagedComesOnceTheFileIsMended) {
  static const Bytes with_meshes = test::packed_plant({.leaf_count = 1500, .seed = 5, .leaf_mesh_count = 2});
  io.files["a"] = with_meshes;
  start();
  const std::uint32_t a = open("a");
  std::vector<std::uint64_t> damaged;
  for (const auto kind : {COPPICE_CHUNK_PAGE, COPPICE_CHUNK_LEAF_MESH}) damaged.push_back(offset_of(a, kind, 1) + 20);
  for (const std::uint64_t byte : damaged) io.files["a"][byte] ^= 0x10;
  view.error_px = 0.001f;
  frames(100, both_);
  EXPECT_EQ(streamer->stats().all().failed, 2u);
  EXPECT_EQ(streamer->state(a).resident_page_count, 1u);
  EXPECT_FALSE(streamer->state(a).leaf_meshes_resident);
  const std::size_t reads = io.log.size();
  frames(200, both_);  // an hour by the hurried clock
  EXPECT_EQ(io.log.size(), reads) << "a damaged file does not mend itself";
  for (const std::uint64_t byte : damaged) io.files["a"][byte] ^= 0x10;
  streamer->retry_failed();
  frames(100, both_);
  expect_whole(a);
  EXPECT_TRUE(streamer->state(a).leaf_meshes_resident);
  EXPECT_EQ(log.lines.size(), 2u);
  shut_down();
}

class CancelledRead : public StreamFault {
 protected:
  void SetUp() override {
    StreamFault::SetUp();
    io.cancels = true;
    start();
    open("a");
    frames(3, {PlantDemand{}});
    reserved_before = ledger.reserved();
    io.deferred = true;
    frames(1, both_);
    EXPECT_EQ(io.waiting.size(), 7u);
  }
  std::uint64_t reserved_before = 0;
};

TEST_F(CancelledRead, EndsWithTheDemandForIt) {
  frames(40, {PlantDemand{}});
  EXPECT_EQ(io.cancelled, 7u);
  EXPECT_EQ(streamer->stats().all().cancelled, 7u);
  EXPECT_EQ(streamer->stats().all().in_flight, 0u);
  EXPECT_EQ(streamer->stats().all().failed, 0u) << "that is no failure";
  EXPECT_EQ(ledger.reserved(), reserved_before);
  io.deferred = false;
  frames(20, both_);
  expect_whole(0);
  EXPECT_TRUE(log.lines.empty());
  shut_down();
}

TEST_F(CancelledRead, EndsWithItsPlant) {
  streamer->close_plant(0);
  frames(3, {PlantDemand{}});
  EXPECT_EQ(io.cancelled, 7u);
  EXPECT_EQ(io.open_count, 0u) << "nobody waits for a slow file";
  shut_down();
}

TEST_F(CancelledRead, EndsWithAnOpening) {
  const auto opening = streamer->start_open("b");
  ASSERT_TRUE(opening);
  EXPECT_FALSE(streamer->finish_open(*opening));
  EXPECT_EQ(io.waiting.size(), 8u);
  streamer->cancel_open(*opening);
  EXPECT_EQ(io.cancelled, 1u);
  frames(1, both_);
  EXPECT_EQ(io.open_count, 1u);
  shut_down();  // does not wait for the reads of a, which nobody answers
  EXPECT_EQ(io.cancelled, 8u);
}

TEST_F(StreamFault, AFileThatIsTruncatedOrReplacedWhileOpenKeepsItsLastGoodCut) {
  for (const bool replaced : {false, true}) {
    log.lines.clear();
    start();
    const std::uint32_t a = open("a"), b = open("b");
    frames(3, {PlantDemand{}, PlantDemand{}});
    const Bytes good = io.files["a"];
    if (replaced)
      io.files["a"] = io.files["b"];
    else
      io.files["a"].resize(offset_of(a, COPPICE_CHUNK_PAGE, 3) + 10);
    frames(40, both_);
    EXPECT_EQ(streamer->state(a).resident_page_count, replaced ? 1u : 3u);
    expect_whole(b);
    const std::size_t lines = log.lines.size();
    EXPECT_GE(lines, 1u);
    EXPECT_LE(lines, kChunks);
    for (const std::string& line : log.lines) EXPECT_TRUE(line.starts_with("a: ") && test::names_an_offset(line)) << line;
    frames(100, both_);
    EXPECT_EQ(log.lines.size(), lines) << "said once";
    shut_down();
    io.files["a"] = good;
  }
}

TEST_F(StreamFault, ALostDeviceIsSaidOnce) {
  start();
  open("a");
  gpu->uploads = false;
  frames(10, both_);
  std::size_t failed = 0;
  for (int round = 0; round < 5; ++round) {
    for (const DecodedChunk& chunk : streamer->take_decoded(UINT64_MAX)) {
      if (!streamer->begin_upload(chunk.id)) continue;
      streamer->upload_failed(chunk.id, {Status::device_lost, "the device is gone"});
      ++failed;
    }
    frames(5, both_);
  }
  EXPECT_GT(failed, 2u);
  EXPECT_EQ(log.lines.size(), 1u);
  shut_down();
}

}  // namespace coppice::stream_fault_test
