#pragma once

// Results of the I/O hook: errors with the system's reason, and when to retry a failed read.

#include <cstddef>
#include <cstdint>

#include "result.h"

namespace coppice {

/// Maps an operating system's error to a status: out_of_memory for ENOMEM, else io. reason: its number, positive
Status status_of(int reason);

/// Error of a failed open. result: the hook's, negative. -1 gives no reason
Error open_error(std::int64_t result);

/// Error of a read that failed (negative, with the reason) or came short of `expected`. -ENOMEM is out_of_memory
Error read_error(std::int64_t bytes_read, std::size_t expected, std::uint64_t offset);

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

/// Sleeps until the clock reaches a time, for callers that may block.
void wait_until(std::uint64_t (*clock_ns)(), std::uint64_t until_ns);

}  // namespace coppice
