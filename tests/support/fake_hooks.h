#pragma once

// Hooks for tests: files in memory, jobs and reads that run inline or when the test says so, an allocator that counts and can fail.

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "hooks.h"

namespace coppice {

inline void PrintTo(Reading reading, std::ostream* out) {
  *out << (reading == Reading::automatic ? "automatic" : "thread_pool");
}

namespace test {

/// May be called by any thread.
struct FakeAllocator {
  std::atomic<std::size_t> live_bytes = 0, live_count = 0, calls = 0;
  std::size_t fail_at = SIZE_MAX;  ///< index of the call that returns null
  bool fail_for_good = false;      ///< and all that follow

  coppice_allocator hook() { return {sizeof(coppice_allocator), this, allocate, free}; }

 private:
  static void* allocate(void* user, std::size_t bytes, std::size_t align) {
    auto* self = static_cast<FakeAllocator*>(user);
    const std::size_t call = self->calls++;
    if (call == self->fail_at || (self->fail_for_good && call > self->fail_at)) return nullptr;
    void* pointer = std::aligned_alloc(align, (bytes + align - 1) / align * align);
    self->live_bytes += bytes;
    ++self->live_count;
    return pointer;
  }
  static void free(void* user, void* pointer, std::size_t bytes) {
    auto* self = static_cast<FakeAllocator*>(user);
    self->live_bytes -= bytes;
    --self->live_count;
    std::free(pointer);
  }
};

/// Runs jobs inline, or keeps them until run_all().
struct FakeJobs {
  bool deferred = false;
  std::deque<coppice_job> waiting;

  coppice_jobs hook() { return {sizeof(coppice_jobs), this, submit}; }
  void run_one() {
    const coppice_job job = waiting.front();
    waiting.pop_front();
    job.function(job.argument);
  }
  void run_all() {
    while (!waiting.empty()) run_one();
  }
  /// Runs all, and what comes then at once.
  void finish() {
    deferred = false;
    run_all();
  }

 private:
  static void submit(void* user, const coppice_job* job) {
    auto* self = static_cast<FakeJobs*>(user);
    if (self->deferred)
      self->waiting.push_back(*job);
    else
      job->function(job->argument);
  }
};

struct FakeRead {
  std::int64_t file = 0;
  std::uint64_t offset = 0;
  void* destination = nullptr;
  std::size_t bytes = 0;
  void (*done)(void*, std::int64_t) = nullptr;
  void* argument = nullptr;
};

/// Goes on by a second whenever it is read: no test has to sit through the pauses between the attempts at a read.
inline std::uint64_t hurried_clock_ns() {
  static std::atomic<std::uint64_t> now = 0;
  return now += 1'000'000'000;
}

/// What goes wrong with a read.
enum class ReadFault : std::uint8_t { none, fails, comes_short, returns_wrong_bytes };

/// Files by path. Reads are answered inline, or kept until answer_all().
struct FakeIo {
  std::map<std::string, std::vector<std::uint8_t>> files;
  std::vector<std::string> handles;  ///< paths by handle
  std::size_t open_count = 0;
  bool deferred = false;
  bool cancels = false;  ///< its hook can cancel reads; one that waits then ends with -ECANCELED
  std::deque<FakeRead> waiting;
  std::vector<FakeRead> log;               ///< every read, in order
  std::uint64_t fail_offset = UINT64_MAX;  ///< a read from here fails
  std::int64_t failing_result = -1;
  ReadFault fault = ReadFault::none;
  std::size_t fault_at = 0;        ///< index of the read that goes wrong, in order of answers
  std::size_t fault_attempts = 1;  ///< how often that place goes wrong
  std::size_t answered = 0;
  std::size_t cancelled = 0;

  coppice_io hook() { return {sizeof(coppice_io), this, open, close, read, cancels ? cancel : nullptr}; }
  void answer(const FakeRead& wanted) {
    if (wanted.offset == fail_offset) return wanted.done(wanted.argument, failing_result);
    const std::vector<std::uint8_t>& file = files.at(handles.at(static_cast<std::size_t>(wanted.file)));
    const std::size_t there = wanted.offset > file.size() ? 0 : std::min<std::size_t>(wanted.bytes, file.size() - wanted.offset);
    if (there > 0) std::memcpy(wanted.destination, file.data() + wanted.offset, there);
    const bool wrong = goes_wrong(wanted);
    if (wrong && fault == ReadFault::fails) return wanted.done(wanted.argument, -EIO);
    if (wrong && fault == ReadFault::comes_short) return wanted.done(wanted.argument, static_cast<std::int64_t>(there / 2));
    if (wrong && fault == ReadFault::returns_wrong_bytes) static_cast<std::uint8_t*>(wanted.destination)[there / 2] ^= 0x10;
    wanted.done(wanted.argument, static_cast<std::int64_t>(there));
  }
  void answer_first() {
    const FakeRead next = waiting.front();
    waiting.pop_front();
    answer(next);
  }
  void answer_all() {
    while (!waiting.empty()) answer_first();
  }

 private:
  FakeRead faulty_;
  std::size_t attempts_left_ = 0;

  bool goes_wrong(const FakeRead& wanted) {
    if (answered++ == fault_at) {
      faulty_ = wanted;
      attempts_left_ = fault_attempts;
    }
    if (attempts_left_ == 0 || wanted.file != faulty_.file || wanted.offset != faulty_.offset || wanted.bytes != faulty_.bytes)
      return false;
    --attempts_left_;
    return true;
  }
  static std::int64_t open(void* user, const char* path, std::uint64_t* file_bytes) {
    auto* self = static_cast<FakeIo*>(user);
    if (!self->files.contains(path)) return -ENOENT;
    *file_bytes = self->files.at(path).size();
    self->handles.push_back(path);
    ++self->open_count;
    return static_cast<std::int64_t>(self->handles.size() - 1);
  }
  static void close(void* user, std::int64_t) { --static_cast<FakeIo*>(user)->open_count; }
  static void cancel(void* user, std::int64_t file, void* argument) {
    auto* self = static_cast<FakeIo*>(user);
    const auto it =
        std::ranges::find_if(self->waiting, [&](const FakeRead& read) { return read.file == file && read.argument == argument; });
    if (it == self->waiting.end()) return;
    const FakeRead read = *it;
    self->waiting.erase(it);
    ++self->cancelled;
    read.done(argument, -ECANCELED);
  }
  static void read(void* user, std::int64_t file, std::uint64_t offset, void* destination, std::size_t bytes,
                   void (*done)(void*, std::int64_t), void* argument) {
    auto* self = static_cast<FakeIo*>(user);
    const FakeRead wanted{file, offset, destination, bytes, done, argument};
    self->log.push_back(wanted);
    if (self->deferred)
      self->waiting.push_back(wanted);
    else
      self->answer(wanted);
  }
};

struct FakeLog {
  std::vector<std::string> lines;
  coppice_log hook() {
    return {sizeof(coppice_log), this,
            [](void* user, coppice_log_level, const char* line) { static_cast<FakeLog*>(user)->lines.emplace_back(line); }};
  }
};

}  // namespace test
}  // namespace coppice
