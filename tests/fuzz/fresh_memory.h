#pragma once

// What malloc hands out is filled with a byte of the target's choice: a result that differs with the byte holds memory that nobody wrote.
// AddressSanitizer alone does not see that.

#include <cstdint>

namespace coppice::test {

/// Fills all allocations from now on but large ones (with AddressSanitizer over 200 KiB); what calloc clears stays clear.
void fill_fresh_memory(std::uint8_t byte);

}  // namespace coppice::test
