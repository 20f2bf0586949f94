#pragma once

// What malloc hands out is filled with a byte of the target's choice: a result that differs with the byte holds memory that nobody wrote.
// AddressSanitizer alone does not see that. What is handed out is also counted.

#include <cstdint>
#include <functional>

namespace coppice::test {

/// Fills all allocations from now on but large ones (with AddressSanitizer over 200 KiB); what calloc clears stays clear.
void fill_fresh_memory(std::uint8_t byte);

/// Runs `work`. With AddressSanitizer it traps where that has taken over 512 MiB at a time, or more of this thread's time than
/// most_seconds.
void check_cost(double most_seconds, const std::function<void()>& work);

}  // namespace coppice::test
