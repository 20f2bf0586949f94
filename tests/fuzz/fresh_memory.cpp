#include "fresh_memory.h"

#include <malloc.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <ctime>

#include "check.h"

#if defined(__SANITIZE_ADDRESS__)
#define COPPICE_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define COPPICE_ADDRESS_SANITIZER 1
#endif
#endif

#ifdef COPPICE_ADDRESS_SANITIZER
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*, std::size_t),
                                                         void (*free_hook)(const volatile void*));  // NOLINT(bugprone-reserved-identifier)
extern "C" std::size_t __sanitizer_get_allocated_size(const volatile void*);                        // NOLINT(bugprone-reserved-identifier)

namespace {

std::uint8_t fill = 0;

// The calling thread's: what other threads take for it is not counted.
thread_local std::ptrdiff_t live_bytes = 0, most_bytes = 0;

// A large block of calloc is fresh from the system, and the sanitizer does not clear it after the hook: those are left alone.
constexpr std::size_t kMost = 200u << 10;

void filled(const volatile void* pointer, std::size_t bytes) {
  if (bytes <= kMost) std::memset(const_cast<void*>(pointer), fill, bytes);
  live_bytes += static_cast<std::ptrdiff_t>(bytes);
  most_bytes = std::max(most_bytes, live_bytes);
}

void freed(const volatile void* pointer) {
  live_bytes -= static_cast<std::ptrdiff_t>(__sanitizer_get_allocated_size(pointer));
}

}  // namespace
#endif

namespace coppice::test {

void fill_fresh_memory(std::uint8_t byte) {
#ifdef COPPICE_ADDRESS_SANITIZER
  static const int kInstalled = __sanitizer_install_malloc_and_free_hooks(filled, freed);
  static_cast<void>(kInstalled);
  fill = byte;
#else
  ::mallopt(M_PERTURB, byte);
#endif
}

void check_cost([[maybe_unused]] double most_seconds, const std::function<void()>& work) {
#ifdef COPPICE_ADDRESS_SANITIZER
  const auto seconds = [] {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  };
  const double start = seconds();
  const std::ptrdiff_t before = most_bytes = live_bytes;
  work();
  COPPICE_ASSERT(seconds() - start <= most_seconds);
  COPPICE_ASSERT(most_bytes - before <= std::ptrdiff_t{512} << 20);
#else
  work();
#endif
}

}  // namespace coppice::test
