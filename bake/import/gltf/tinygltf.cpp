// Only this translation unit compiles tinygltf and stb's image writer; others include their headers. tinygltf is built without an image
// reader: image_decode.h is ours. We do not link the packaged shared library, so that we ship what we tested.

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>

// stb allocates with `new`, so that running out of memory ends here as it does everywhere. With malloc it would go on with a null pointer.
static void* resized(void* block, std::size_t old_bytes, std::size_t new_bytes) {
  void* const larger = ::operator new(new_bytes);
  if (block != nullptr) std::memcpy(larger, block, std::min(old_bytes, new_bytes));
  ::operator delete(block);
  return larger;
}
// This is a function because clang 14 would parse `array ? ::operator delete(...), 0 : 0`, to which stb's macro expands, as a call in
// either case.
static void freed(void* block) {
  ::operator delete(block);
}
#define STBIW_MALLOC(bytes) ::operator new(bytes)
#define STBIW_REALLOC_SIZED(block, old_bytes, new_bytes) resized(block, old_bytes, new_bytes)
#define STBIW_FREE(block) freed(block)
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define TINYGLTF_IMPLEMENTATION
// stb casts its allocations.
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#include <tiny_gltf.h>
