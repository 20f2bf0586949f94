#include "fresh_memory.h"

#include <malloc.h>

#include <cstddef>
#include <cstring>

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

namespace {

std::uint8_t fill = 0;

// A large block of calloc is fresh from the system, and the sanitizer does not clear it after the hook: those are left alone.
constexpr std::size_t kMost = 200u << 10;

void filled(const volatile void* pointer, std::size_t bytes) {
  if (bytes <= kMost) std::memset(const_cast<void*>(pointer), fill, bytes);
}

}  // namespace
#endif

namespace coppice::test {

void fill_fresh_memory(std::uint8_t byte) {
#ifdef COPPICE_ADDRESS_SANITIZER
  static const int kInstalled = __sanitizer_install_malloc_and_free_hooks(filled, [](const volatile void*) {});
  static_cast<void>(kInstalled);
  fill = byte;
#else
  ::mallopt(M_PERTURB, byte);
#endif
}

}  // namespace coppice::test
