#pragma once

// Packs handles of the engine into 64 bits, so that a handle that is stale, of another kind or of another context is recognised. From the
// highest bit: 3 of the kind, 12 of the context, 21 of the generation, 28 of the index. 0 is never a handle.

#include <cstdint>

namespace coppice {

enum class HandleKind : std::uint8_t { none = 0, plant = 1, instance = 2, scene = 3, view = 4 };

inline constexpr std::uint32_t kHandleIndexBits = 28, kHandleGenerationBits = 21, kHandleContextBits = 12;
inline constexpr std::uint32_t kMaxHandleIndex = (1u << kHandleIndexBits) - 1;

/// pack_handle takes generations and contexts modulo their range.
struct Handle {
  HandleKind kind = HandleKind::none;
  std::uint32_t context = 0;
  std::uint32_t generation = 0;
  std::uint32_t index = 0;  ///< <= kMaxHandleIndex

  bool operator==(const Handle&) const = default;
};

constexpr std::uint64_t low_bits(std::uint64_t value, std::uint32_t count) {
  return value & ((std::uint64_t{1} << count) - 1);
}

constexpr std::uint64_t pack_handle(const Handle& handle) {
  std::uint64_t packed = static_cast<std::uint64_t>(handle.kind);
  packed = packed << kHandleContextBits | low_bits(handle.context, kHandleContextBits);
  packed = packed << kHandleGenerationBits | low_bits(handle.generation, kHandleGenerationBits);
  return packed << kHandleIndexBits | low_bits(handle.index, kHandleIndexBits);
}

/// Unpacks any 64 bits. pack_handle(unpack_handle(x)) == x.
constexpr Handle unpack_handle(std::uint64_t packed) {
  Handle handle;
  handle.index = static_cast<std::uint32_t>(low_bits(packed, kHandleIndexBits));
  packed >>= kHandleIndexBits;
  handle.generation = static_cast<std::uint32_t>(low_bits(packed, kHandleGenerationBits));
  packed >>= kHandleGenerationBits;
  handle.context = static_cast<std::uint32_t>(low_bits(packed, kHandleContextBits));
  handle.kind = static_cast<HandleKind>(packed >> kHandleContextBits);
  return handle;
}

static_assert(3 + kHandleContextBits + kHandleGenerationBits + kHandleIndexBits == 64);

}  // namespace coppice
