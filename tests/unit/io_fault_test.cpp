// Faults of the system under the default hooks, on real files: reads that the kernel fails or cuts short, through io_uring and through
// pread, and threads that cannot be started. The linker puts this program's pread, io_uring_submit and pthread_create before the library's
// (--wrap): the product knows nothing of it.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <liburing.h>
#include <pthread.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "fake_gpu.h"
#include "fake_hooks.h"
#include "mentions.h"
#include "places.h"
#include "results.h"
#include "scene_stream.h"
#include "streamer.h"

namespace {

enum class Fault { none, fails, comes_short };

/// Reads [first, first + count) of the process go wrong.
struct Faults {
  std::atomic<Fault> fault = Fault::none;
  std::atomic<std::size_t> first = 0, count = 0, reads = 0;
  std::atomic<std::size_t> refused_thread = SIZE_MAX, threads = 0;
} faults;

Fault next_read() {
  const std::size_t read = faults.reads++;
  return read >= faults.first && read - faults.first < faults.count ? faults.fault.load() : Fault::none;
}

/// Reads of it at 0 are EIO: no memory is there.
int unreadable_file() {
  static const int file = ::open("/proc/self/mem", O_RDONLY | O_CLOEXEC);
  return file;
}

}  // namespace

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): the names that the linker's --wrap has
extern "C" {

ssize_t __real_pread(int file, void* destination, size_t bytes, off_t offset);
int __real_io_uring_submit(io_uring* ring);
int __real_pthread_create(pthread_t*, const pthread_attr_t*, void* (*start)(void*), void*);

ssize_t __wrap_pread(int file, void* destination, size_t bytes, off_t offset) {
  const Fault fault = next_read();
  if (fault == Fault::fails) return __real_pread(unreadable_file(), destination, bytes, 0);
  return __real_pread(file, destination, fault == Fault::comes_short ? (bytes + 1) / 2 : bytes, offset);
}

// What is about to be submitted is made a read that the kernel fails, or a shorter one.
int __wrap_io_uring_submit(io_uring* ring) {
  for (unsigned i = ring->sq.sqe_head; i != ring->sq.sqe_tail; ++i) {
    io_uring_sqe& entry = ring->sq.sqes[i & ring->sq.ring_mask];
    if (entry.opcode != IORING_OP_READ) continue;
    const Fault fault = next_read();
    if (fault == Fault::comes_short) entry.len = (entry.len + 1) / 2;
    if (fault != Fault::fails) continue;
    entry.fd = unreadable_file();
    entry.off = 0;
  }
  return __real_io_uring_submit(ring);
}

int __wrap_pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*), void* argument) {
  if (faults.threads++ == faults.refused_thread) return EAGAIN;
  return __real_pthread_create(thread, attributes, start, argument);
}

}  // extern "C"
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

namespace coppice {
namespace {

const std::string kPlant = std::string(test::kTestData) + "/plants/two_pages.coppice";
const std::string kScene = std::string(test::kTestData) + "/scene_v1/small.forest";

class IoFault : public testing::TestWithParam<Reading> {
 protected:
  void TearDown() override { set_fault(Fault::none, 0, 0); }
  static void set_fault(Fault fault, std::size_t first, std::size_t count) {
    faults.fault = fault;
    faults.first = first;
    faults.count = count;
    faults.reads = 0;
  }
  /// Plant and scene are opened, all is streamed in 60 frames and more, and closed. What came of it.
  struct Outcome {
    bool opened = false;
    std::uint64_t failed = 0;
    std::uint32_t resident_pages = 0, resident_tiles = 0;
    std::vector<std::string> lines;

    void expect_all_there() const {
      EXPECT_TRUE(opened);
      EXPECT_EQ(failed, 0u);
      EXPECT_EQ(resident_pages, 2u);
      EXPECT_EQ(resident_tiles, 1u);
    }
  };
  static Outcome run(const coppice_allocator& allocator = {}) {
    Outcome outcome;
    test::FakeLog log;
    auto set = test::must(complete_hooks({.allocator = allocator, .log = log.hook()}, GetParam()));
    Ledger ledger(256ull << 20);
    {
      auto created = Streamer::create(set.hooks, ledger, {.gpu = {.block_textures = true}});
      if (!created) {
        EXPECT_EQ(created.error().status, Status::out_of_memory);
        return outcome;
      }
      const auto streamer = *std::move(created);
      test::FakeGpu gpu(*streamer, ledger);
      const auto plant = streamer->open_plant(kPlant.c_str());
      auto scene = SceneStream::open(set.hooks, ledger, kScene.c_str(), {});
      outcome.opened = plant && scene;
      if (outcome.opened) stream(*streamer, gpu, **scene, outcome);
      if (plant) streamer->close_plant(*plant);
      const LodView view;
      for (int i = 0; i < 5; ++i) gpu.frame(view, {});
    }
    outcome.lines = log.lines;
    return outcome;
  }

 private:
  static void stream(Streamer& streamer, test::FakeGpu& gpu, SceneStream& scene, Outcome& outcome) {
    LodView view;
    view.full = true;
    const std::vector<PlantDemand> demands = {test::demand_of(5000.0f)};
    for (int i = 0; i < 4000; ++i) {
      gpu.frame(view, demands);
      scene.begin_frame(std::array{SceneEye{{0.0f, 2.0f, 0.0f}, 600.0f, 0.1f}}, 1000);
      while (const auto species = scene.next_species()) scene.species_opened(species->species, true);
      while (const auto ready = scene.next_ready()) scene.placed(ready->tile);
      const StreamStats stats = streamer.stats();
      if (i > 60 && stats.all().wanted == 0 && stats.all().in_flight == 0 && scene.stats().missing_tiles == 0) break;
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    outcome.failed = streamer.stats().all().failed + scene.stats().tiles_failed;
    outcome.resident_pages = streamer.state(0).resident_page_count;
    outcome.resident_tiles = scene.stats().resident_tiles;
  }
};

INSTANTIATE_TEST_SUITE_P(Default, IoFault, testing::Values(Reading::automatic, Reading::thread_pool),
                         [](const auto& reading) { return std::string(reading.param == Reading::automatic ? "Automatic" : "ThreadPool"); });

TEST_P(IoFault, AnErrorOfTheNthReadIsTriedAgain) {
  for (std::size_t n = 0;; ++n) {
    set_fault(Fault::fails, n, 1);
    SCOPED_TRACE(n);
    const Outcome outcome = run();
    outcome.expect_all_there();
    EXPECT_TRUE(outcome.lines.empty()) << outcome.lines[0];
    if (faults.reads <= n) break;
    ASSERT_LT(n, 100u);
  }
}

TEST_P(IoFault, TheNthAllocationThatFailsCostsNothingThatCouldComeLater) {
  std::size_t opened = 0;
  for (std::size_t n = 0;; ++n) {
    test::FakeAllocator allocator{.fail_at = n};
    const Outcome outcome = run(allocator.hook());
    EXPECT_EQ(allocator.live_count, 0u) << n << ": a leak";
    EXPECT_EQ(outcome.failed, 0u) << n << ": a lack of memory is no damage";
    opened += outcome.opened ? 1u : 0u;
    if (outcome.opened) outcome.expect_all_there();
    EXPECT_LE(outcome.lines.size(), 1u) << n << ": " << outcome.lines[1];
    if (allocator.calls <= n) break;
    ASSERT_LT(n, 500u);
  }
  EXPECT_GT(opened, 5u) << "those of reads and pages among them";
}

TEST_P(IoFault, EveryReadThatComesShortIsReadToItsEnd) {
  set_fault(Fault::comes_short, 0, SIZE_MAX);
  const Outcome outcome = run();
  outcome.expect_all_there();
  EXPECT_TRUE(outcome.lines.empty());
  EXPECT_GT(faults.reads, 20u) << "halves of halves";
}

TEST_P(IoFault, AnErrorFromTheFifthReadOnIsOneLineForEachThingThatFails) {
  set_fault(Fault::fails, 4, SIZE_MAX);  // header and front of the plant, and of the scene, come
  const Outcome outcome = run();
  ASSERT_TRUE(outcome.opened);
  EXPECT_EQ(outcome.resident_pages, 1u) << "what came with the front";
  EXPECT_EQ(outcome.resident_tiles, 0u);
  EXPECT_GE(outcome.failed, 2u);
  EXPECT_EQ(outcome.lines.size(), outcome.failed);
  for (const std::string& line : outcome.lines) {
    EXPECT_TRUE(test::mentions(line, {std::strerror(EIO)}));
    EXPECT_TRUE(test::names_an_offset(line)) << line;
  }
}

TEST_P(IoFault, AFileThatCannotBeReadIsNotOpened) {
  set_fault(Fault::fails, 0, SIZE_MAX);
  const Outcome outcome = run();
  EXPECT_FALSE(outcome.opened);
  ASSERT_EQ(outcome.lines.size(), 2u);
  EXPECT_TRUE(test::mentions(outcome.lines[0], {kPlant + ": ", std::strerror(EIO), "byte 0"}));
  EXPECT_TRUE(test::mentions(outcome.lines[1], {kScene + ": ", std::strerror(EIO), "byte 0"}));
}

TEST_P(IoFault, AThreadThatCannotBeStartedIsSaid) {
  bool said = false;
  for (std::size_t n = 0;; ++n) {
    faults.threads = 0;
    faults.refused_thread = n;
    const auto set = complete_hooks({}, GetParam());
    const bool reached = faults.threads > n;
    faults.refused_thread = SIZE_MAX;
    if (!set) {
      said = true;
      EXPECT_EQ(set.error().status, Status::out_of_memory);
      EXPECT_TRUE(test::mentions(set.error().message(), {std::strerror(EAGAIN)}));
    }
    if (!reached) break;
  }
  EXPECT_TRUE(said || std::thread::hardware_concurrency() > 2) << "a pool needs one thread";
}

}  // namespace
}  // namespace coppice
