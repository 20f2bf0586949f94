#pragma once

// What the I/O hook gives back: errors with the system's reason, and when a read that failed is tried again.

#include <cstddef>
#include <cstdint>

#include "result.h"

namespace coppice {

/// What an error of the operating system is. reason: its number, positive. out_of_memory for ENOMEM, else io
Status status_of(int reason);

/// The error of an open that failed. result: the hook's, negative. No reason where it gives none, -1
Error open_error(std::int64_t result);

/// The error of a read that did not give all its bytes: negative, with the reason, or fewer than `wanted`. -ENOMEM is out_of_memory
Error read_error(std::int64_t bytes_read, std::size_t wanted, std::uint64_t offset);

/// How often a read is tried. The pauses between are 50, 200 and 800 ms.
inline constexpr std::uint32_t kReadTries = 4;

/// The tries of one read, or of several that are waited for together. Whatever the reason: a hook need not know what passes by itself.
struct ReadRetry {
  std::uint32_t failed_tries = 0;
  std::uint64_t again_ns = 0;  ///< on the clock; 0: nothing is waited for

  /// A try has failed: the next is at again_ns. False: it was the last.
  bool pause(std::uint64_t now_ns);
};

/// Sleeps until the clock is there, for those that may block.
void wait_until(std::uint64_t (*clock_ns)(), std::uint64_t until_ns);

}  // namespace coppice
