#pragma once

// Reads through the I/O hook: errors with the system's reason, when to retry a failed read, and waiting for one.

#include <cstddef>
#include <cstdint>
#include <span>

#include "completion_queue.h"
#include "coppice/coppice.h"
#include "result.h"

namespace coppice {

/// Maps an operating system's error to a status: out_of_memory for ENOMEM, else io. reason: its number, positive
Status status_of(int reason);

/// Error of a failed open. result: the hook's, negative. -1 gives no reason
Error open_error(std::int64_t result);

/// Error of a read that failed (negative, with the reason) or came short of `expected`. -ENOMEM is out_of_memory
Error read_error(std::int64_t bytes_read, std::size_t expected, std::uint64_t offset);

/// Says that nobody needs the bytes of a running read. argument: the read's
inline void cancel_read(const coppice_io& io, std::int64_t file, void* argument) {
  if (io.cancel != nullptr) io.cancel(io.user, file, argument);
}

/// Number of attempts at a read. The pauses between them are 50, 200 and 800 ms.
inline constexpr std::uint32_t kReadAttempts = 4;

/// Counts the attempts at one read, or at several that are waited for together. Every failure is retried: a hook need not know which ones
/// are temporary.
struct ReadRetry {
  std::uint32_t failed_attempts = 0;
  std::uint64_t again_ns = 0;  ///< time of the next attempt; 0: none is scheduled

  /// Notes a failed attempt and schedules the next one at again_ns. False if it was the last.
  bool pause(std::uint64_t now_ns);
};

/// Says when something that no attempt could read is read again: after 5, 10, 20 and 40 s, then once a minute.
struct Reread {
  std::uint64_t at_ns = 0;  ///< 0: nothing waits
  std::uint32_t count = 0;  ///< rereads since the last first failure

  /// Schedules a reread, unless one is scheduled. again: what has failed had failed before
  void schedule(std::uint64_t now_ns, bool again);
  /// True if it is time; that reread is done then.
  [[nodiscard]] bool take(std::uint64_t (*clock_ns)());
};

/// Sleeps until the clock reaches a time, for callers that may block.
void wait_until(std::uint64_t (*clock_ns)(), std::uint64_t until_ns);

/// A read that is awaited, one at a time. It may end on any thread; all functions are the frame's thread's.
class AwaitedRead {
 public:
  AwaitedRead() = default;
  AwaitedRead(const AwaitedRead&) = delete;
  AwaitedRead& operator=(const AwaitedRead&) = delete;
  ~AwaitedRead() { wait(); }

  /// out: does not move until the read is back
  void start(const coppice_io& io, std::int64_t file, std::uint64_t offset, std::span<std::uint8_t> out);
  /// True if it has returned.
  [[nodiscard]] bool back() const { return queue_.all_back(); }
  void wait() const { queue_.wait_for_all(); }
  void cancel(const coppice_io& io, std::int64_t file) {
    if (!back()) cancel_read(io, file, &read_);
  }
  /// True if it gave all its bytes. before: back(), here and below
  [[nodiscard]] bool whole() const { return read_.bytes_read == static_cast<std::int64_t>(read_.out.size()); }
  /// Starts the same read again.
  void repeat(const coppice_io& io, std::int64_t file) { start(io, file, read_.offset, read_.out); }
  /// errors  as read_error
  [[nodiscard]] Result<void> result() const;

 private:
  struct Read {
    CompletionQueue<Read>* queue = nullptr;
    std::uint64_t offset = 0;
    std::span<std::uint8_t> out;
    std::int64_t bytes_read = 0;
    Read* next = nullptr;  ///< in the queue
  };
  static void on_done(void* argument, std::int64_t bytes_read);

  Read read_;
  CompletionQueue<Read> queue_;
};

/// Reads the start of a file and waits, also for the pauses of ReadRetry. errors  as read_error
Result<void> read_now(const coppice_io& io, std::int64_t file, std::span<std::uint8_t> out, std::uint64_t (*clock_ns)());

}  // namespace coppice
