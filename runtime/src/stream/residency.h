#pragma once

#include <cstdint>

namespace coppice {

/// States of a chunk between the file and the GPU. The table of allowed steps is in residency.cpp and in ARCHITECTURE.md.
enum class Residency : std::uint8_t {
  absent,    ///< only in the file
  reading,   ///< the I/O hook reads it, or it waits for its predecessor or for another attempt at a failed read
  decoding,  ///< a job decodes it
  decoded,   ///< in CPU memory, for the GPU side to upload
  resident,  ///< the GPU side has acknowledged the upload
  evicting,  ///< no longer drawn, but unfinished frames of the GPU may still read it
  failed,    ///< damaged, or unreadable in kReadAttempts attempts: logged once, not requested
};
inline constexpr std::uint32_t kResidencyCount = 7;

enum class ChunkKind : std::uint8_t { page, wood, texture, leaf_mesh };
inline constexpr std::size_t kChunkKindCount = 4;

/// A chunk of an open plant.
struct ChunkId {
  std::uint32_t plant = 0;
  ChunkKind kind = ChunkKind::page;
  std::uint32_t index = 0;

  friend bool operator==(const ChunkId&, const ChunkId&) = default;
};

struct Chunk {
  ChunkId id;
  Residency residency = Residency::absent;
  bool pinned = false;                     ///< page 0 and the coarsest wood: never evicted while the plant is open
  bool unreadable = false;                 ///< its last read failed for good: it is read again later, in one attempt and without a log line
  std::uint32_t file_chunk = 0xffffffffu;  ///< index into PlantFile::chunks
  std::uint64_t bytes = 0;                 ///< all memory that it takes now
  std::uint64_t reserved_bytes = 0;        ///< the part of these that the streamer has reserved; the rest is in device memory
  float value = 0.0f;                      ///< px of error that it removes per byte, as computed in frame value_frame
  std::uint64_t value_frame = 0;
  std::uint64_t last_used_frame = 0;  ///< evicting: last frame that may refer to it
  Chunk* next_evicting = nullptr;
  bool pending = false;           ///< a host has it, decoded or evicting, and has not acknowledged it
  bool eviction_planned = false;  ///< chosen in the evictions that are being planned
};

/// True if the table allows the step.
bool may_advance(Residency from, Residency to);

/// Changes chunk.residency; nothing else does. Returns false without a change if the step is not in the table.
[[nodiscard]] bool advance(Chunk& chunk, Residency to);

const char* residency_name(Residency residency);
const char* chunk_kind_name(ChunkKind kind);

}  // namespace coppice
