// The one translation unit that compiles tinygltf and stb's image writer; everyone else includes their headers only. tinygltf is built
// without an image reader: image_decode.h is ours. Compiled here rather than taken from the packaged shared library, so that what we are
// built with is what we were tested with.

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>

// stb takes its memory by `new`, so that memory which runs out ends here as it does everywhere. Left to malloc, it goes on with a null
// pointer.
static void* resized(void* block, std::size_t old_bytes, std::size_t new_bytes) {
  void* const larger = ::operator new(new_bytes);
  if (block != nullptr) std::memcpy(larger, block, std::min(old_bytes, new_bytes));
  ::operator delete(block);
  return larger;
}
// A function, since clang 14 takes `array ? ::operator delete(...), 0 : 0`, as stb's macro would read, for a call in either case.
static void freed(void* block) {
  ::operator delete(block);
}
#define STBIW_MALLOC(bytes) ::operator new(bytes)
#define STBIW_REALLOC_SIZED(block, old_bytes, new_bytes) resized(block, old_bytes, new_bytes)
#define STBIW_FREE(block) freed(block)
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define TINYGLTF_IMPLEMENTATION
// The casts round its allocations are stb's.
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#include <tiny_gltf.h>
