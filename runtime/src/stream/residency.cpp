#include "residency.h"

#include <array>
#include <cstddef>

namespace coppice {

namespace {

constexpr std::uint8_t bit(Residency residency) {
  return static_cast<std::uint8_t>(1u << static_cast<unsigned>(residency));
}

/// Row: from; bits: to.
constexpr std::array<std::uint8_t, kResidencyCount> kAllowed = {
    bit(Residency::reading),                                                     // absent: requested
    bit(Residency::absent) | bit(Residency::decoding) | bit(Residency::failed),  // reading: stale, read, or unreadable in every attempt
    bit(Residency::absent) | bit(Residency::decoded) | bit(Residency::failed),   // decoding: stale, done, or damaged
    bit(Residency::absent) | bit(Residency::resident) | bit(Residency::failed),  // decoded: evicted early, uploaded, or refused
    bit(Residency::evicting),                                                    // resident
    bit(Residency::absent),                                                      // evicting: the GPU is done with it
    bit(Residency::absent),                                                      // failed: tried again
};

}  // namespace

bool may_advance(Residency from, Residency to) {
  return (kAllowed[static_cast<std::size_t>(from)] & bit(to)) != 0;
}

bool advance(Chunk& chunk, Residency to) {
  if (!may_advance(chunk.residency, to)) return false;
  chunk.residency = to;
  return true;
}

const char* residency_name(Residency residency) {
  constexpr std::array<const char*, kResidencyCount> kNames = {"absent",   "reading",  "decoding", "decoded",
                                                               "resident", "evicting", "failed"};
  return kNames[static_cast<std::size_t>(residency)];
}

const char* chunk_kind_name(ChunkKind kind) {
  constexpr std::array<const char*, 4> kNames = {"page", "wood", "texture", "leaf mesh"};
  return kNames[static_cast<std::size_t>(kind)];
}

}  // namespace coppice
