#pragma once

// Counts from outside what a context takes: its allocator hook, and every vkAllocateMemory and vkFreeMemory.

#include <cstdint>

#include "context_desc.h"

namespace coppice::test {

/// Sets the hooks that count in a desc. One context counts at a time.
void count_memory(ContextDesc& desc);

/// Host and device memory that is live, together.
std::uint64_t counted_bytes();

/// Calls of vkAllocateMemory.
struct CountedCalls {
  std::uint64_t calls = 0, live = 0;
};
CountedCalls counted_device_calls();

}  // namespace coppice::test
