#include "hooks.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>

#include "fake_hooks.h"
#include "io_result.h"
#include "mentions.h"
#include "process.h"
#include "results.h"
#include "transfer.h"

namespace coppice::hooks_test {

/// One attempt.
Result<void> read_once(const coppice_io& io, std::int64_t file, std::uint64_t offset, std::span<std::uint8_t> out) {
  AwaitedRead read;
  read.start(io, file, offset, out);
  read.wait();
  return read.result();
}

TEST(HookArray, GivesBackWhatItTookAndDestroysItsElements) {
  test::FakeAllocator allocator;
  {
    auto outer = test::must(HookArray<HookBuffer>::allocate(allocator.hook(), 3));
    outer[1] = test::must(HookBuffer::allocate(allocator.hook(), 100));
    EXPECT_GE(allocator.live_bytes, 100u);
  }
  EXPECT_EQ(allocator.live_bytes, 0u);
  {
    auto array = test::must(HookArray<std::uint32_t>::allocate(allocator.hook(), 10));
    EXPECT_EQ(allocator.live_bytes, 40u);
    EXPECT_EQ(array[9], 0u);
    HookArray<std::uint32_t> moved = std::move(array);
    EXPECT_EQ(moved.bytes(), 40u);
    moved = HookArray<std::uint32_t>();
    EXPECT_EQ(allocator.live_bytes, 0u);
  }
  EXPECT_EQ(allocator.live_bytes, 0u);
}

TEST(HookArray, ReportsWhatCannotBeHad) {
  test::FakeAllocator allocator{.fail_at = 0};
  EXPECT_EQ(HookBuffer::allocate(allocator.hook(), 1).error().status, Status::out_of_memory);
  EXPECT_EQ(HookArray<std::uint64_t>::allocate(allocator.hook(), SIZE_MAX / 4).error().status, Status::out_of_memory);
  EXPECT_EQ(allocator.calls, 1u) << "a size that overflows must not reach the hook";
  EXPECT_TRUE(test::must(HookBuffer::allocate(allocator.hook(), 0)).empty());
}

TEST(CompleteHooks, RefusesHooksSetInPart) {
  Hooks half_allocator;
  half_allocator.allocator.allocate = [](void*, std::size_t, std::size_t) -> void* { return nullptr; };
  EXPECT_EQ(complete_hooks(half_allocator).error().status, Status::invalid_argument);
  Hooks half_io;
  half_io.io.close = [](void*, std::int64_t) {};
  EXPECT_EQ(complete_hooks(half_io).error().status, Status::invalid_argument);
}

TEST(CompleteHooks, StartsNoThreadForAnEngineThatBringsItsOwn) {
  Hooks own;
  own.jobs.submit = [](void*, const coppice_job* job) { job->function(job->argument); };
  own.io = {
      sizeof(coppice_io),
      nullptr,
      [](void*, const char*, std::uint64_t*) -> std::int64_t { return -1; },
      [](void*, std::int64_t) {},
      [](void*, std::int64_t, std::uint64_t, void*, std::size_t, void (*done)(void*, std::int64_t), void* argument) { done(argument, -1); },
      nullptr};
  auto set = test::must(complete_hooks(own));
  EXPECT_EQ(set.defaults, nullptr);
  static std::thread::id ran;
  const coppice_job job = make_job(
      COPPICE_JOB_DECODE, COPPICE_PRIORITY_NORMAL, [](void*) { ran = std::this_thread::get_id(); }, nullptr);
  set.hooks.jobs.submit(set.hooks.jobs.user, &job);
  EXPECT_EQ(ran, std::this_thread::get_id());
  EXPECT_NE(set.hooks.allocator.allocate, nullptr);
}

class DefaultIo : public testing::TestWithParam<Reading> {
 protected:
  void SetUp() override {
    std::ofstream(path_, std::ios::binary) << "0123456789";
    set_ = test::must(complete_hooks({}, GetParam()));
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "file";
  HookSet set_;
};

TEST_P(DefaultIo, ReadsFromTheOffset) {
  const coppice_io& io = set_.hooks.io;
  std::uint64_t bytes = 0;
  const std::int64_t file = io.open(io.user, path_.c_str(), &bytes);
  ASSERT_GE(file, 0);
  EXPECT_EQ(bytes, 10u);
  std::array<std::uint8_t, 4> four{};
  EXPECT_TRUE(read_once(io, file, 3, four));
  EXPECT_EQ(std::string(four.begin(), four.end()), "3456");
  const auto past_the_end = read_once(io, file, 8, four);
  EXPECT_EQ(past_the_end.error().status, Status::io);
  EXPECT_EQ(past_the_end.error().offset, 8u);
  std::ofstream(folder_ / "other") << "abcdefghij";
  std::filesystem::rename(folder_ / "other", path_);
  EXPECT_TRUE(read_once(io, file, 3, four));
  EXPECT_EQ(std::string(four.begin(), four.end()), "3456") << "the file that was opened";
  io.close(io.user, file);
}

TEST_P(DefaultIo, DoesNotOpenWhatIsNotAFile) {
  const coppice_io& io = set_.hooks.io;
  std::uint64_t bytes = 0;
  EXPECT_EQ(io.open(io.user, (path_.string() + ".missing").c_str(), &bytes), -ENOENT);
  EXPECT_EQ(io.open(io.user, folder_.path().c_str(), &bytes), -EISDIR);
  const std::string fifo = path_.string() + ".fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_EQ(io.open(io.user, fifo.c_str(), &bytes), -EINVAL) << "and does not wait for a writer";
  EXPECT_EQ(io.open(io.user, "/dev/zero", &bytes), -EINVAL);
}

TEST_P(DefaultIo, AFailingAllocatorFailsTheRead) {
  test::FakeAllocator allocator{.fail_at = 0};
  auto set = test::must(complete_hooks({.allocator = allocator.hook()}, GetParam()));
  const coppice_io& io = set.hooks.io;
  std::uint64_t bytes = 0;
  const std::int64_t file = io.open(io.user, path_.c_str(), &bytes);
  std::array<std::uint8_t, 4> four{};
  EXPECT_EQ(read_once(io, file, 0, four).error().status, Status::out_of_memory);
  EXPECT_TRUE(read_once(io, file, 0, four));
  io.close(io.user, file);
  EXPECT_EQ(allocator.live_bytes, 0u);
}

TEST_P(DefaultIo, ReadsManyAtOnceAndNoneTwice) {
  const std::string large = path_.string() + ".large";
  std::string text(std::size_t{1} << 20, '\0');
  for (std::size_t i = 0; i < text.size(); ++i) text[i] = static_cast<char>(i * i / 7 % 251);
  std::ofstream(large, std::ios::binary) << text;
  const coppice_io& io = set_.hooks.io;
  std::uint64_t bytes = 0;
  const std::int64_t file = io.open(io.user, large.c_str(), &bytes);
  ASSERT_GE(file, 0);
  struct Reads {
    std::mutex mutex;
    std::condition_variable changed;
    std::size_t done = 0, whole = 0;
  } reads;
  constexpr std::size_t kReads = 600, kBytes = 1500;
  std::string read(kReads * kBytes, '\0');
  for (std::size_t i = 0; i < kReads; ++i)
    io.read(
        io.user, file, i * kBytes, read.data() + i * kBytes, kBytes,
        [](void* argument, std::int64_t bytes_read) {
          auto& all = *static_cast<Reads*>(argument);
          const std::lock_guard lock(all.mutex);
          ++all.done;
          all.whole += bytes_read == static_cast<std::int64_t>(kBytes);
          all.changed.notify_all();
        },
        &reads);
  {
    std::unique_lock lock(reads.mutex);
    reads.changed.wait(lock, [&] { return reads.done >= kReads; });
    EXPECT_EQ(reads.whole, kReads);
  }
  EXPECT_EQ(read, text.substr(0, read.size()));
  io.close(io.user, file);
}

INSTANTIATE_TEST_SUITE_P(Automatic, DefaultIo, testing::Values(Reading::automatic));
INSTANTIATE_TEST_SUITE_P(ThreadPool, DefaultIo, testing::Values(Reading::thread_pool));

TEST(CompleteHooks, ReadsByTheKernelWhereItCan) {
  auto set = test::must(complete_hooks({}));
  EXPECT_EQ(set.defaults->uring != nullptr, bool(UringIo::create(set.hooks.allocator)));
  auto by_pool = test::must(complete_hooks({}, Reading::thread_pool));
  EXPECT_EQ(by_pool.defaults->uring, nullptr);
  auto own_jobs =
      complete_hooks({.jobs = {sizeof(coppice_jobs), nullptr, [](void*, const coppice_job* job) { job->function(job->argument); }}});
  ASSERT_TRUE(own_jobs);
  EXPECT_EQ(own_jobs->defaults->pool == nullptr, own_jobs->defaults->uring != nullptr) << "no thread that nobody needs";
}

TEST(Log, ALineIsOneLineAndTellsATerminalNothing) {
  test::FakeLog log;
  const auto written = [&](const auto&... values) {
    log_line(log.hook(), COPPICE_LOG_WARNING, values...);
    return log.lines.back();
  };
  EXPECT_EQ(written("%s: page %u", "oak", 3u), "oak: page 3");
  EXPECT_EQ(written("%s: %s", "oak\n\x1b[2J", "gone"), "oak\\x0a\\x1b[2J: gone");
  EXPECT_EQ(written("%s: gone", "\xc3\xa9rable.coppice"), "\xc3\xa9rable.coppice: gone");
  EXPECT_EQ(written("%s: reason", std::string(4000, 'x').c_str()).size(), 4008u) << "a long path leaves room for what is wrong";
  log_line({}, COPPICE_LOG_ERROR, "nobody listens");
}

TEST(IoResult, SaysTheSystemsReason) {
  for (const int reason : {ENOENT, EACCES, EISDIR}) EXPECT_EQ(open_error(-reason).detail, std::strerror(reason));
  EXPECT_NE(open_error(-EINVAL).detail, "");
  EXPECT_NE(open_error(-EINVAL).detail, std::strerror(EINVAL)) << "of a file that is no regular one";
  EXPECT_EQ(open_error(-1).detail, "") << "a hook that knows no more";
  EXPECT_EQ(open_error(INT64_MIN).detail, "");
  EXPECT_EQ(open_error(-ENOENT).status, Status::io);
  EXPECT_EQ(read_error(-EIO, 8, 4096).status, Status::io);
  EXPECT_TRUE(test::mentions(read_error(-EIO, 8, 4096).message(), {std::strerror(EIO), "byte 4096"}));
  EXPECT_TRUE(test::mentions(read_error(3, 8, 4096).message(), {"3", "8", "byte 4096"}));
  EXPECT_EQ(read_error(-ENOMEM, 8, 0).status, Status::out_of_memory);
}

}  // namespace coppice::hooks_test
