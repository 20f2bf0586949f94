#pragma once

#include <cstdint>

namespace coppice {

/// Where a chunk is between the file and the GPU. The table of allowed steps is in residency.cpp and in ARCHITECTURE.md.
enum class Residency : std::uint8_t {
  absent,    ///< only in the file
  reading,   ///< the I/O hook has it, or it waits for its predecessor or for another try of a read that failed
  decoding,  ///< a job has it
  decoded,   ///< in CPU memory, for the GPU side to upload
  resident,  ///< the GPU side has confirmed the upload
  evicting,  ///< no longer drawn, but frames the GPU has not finished may still read it
  failed,    ///< damaged, or not readable in kReadTries tries: reported once, never asked for again
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
  bool affordable = true;                  ///< a texture: false where the budget is for what is worth more
  bool pinned = false;                     ///< page 0 and the coarsest wood: never evicted while the plant is open
  std::uint32_t file_chunk = 0xffffffffu;  ///< index into PlantFile::chunks
  std::uint64_t bytes = 0;                 ///< that it takes now, wherever
  std::uint64_t taken_bytes = 0;           ///< of these, those that the streamer has taken; the rest is in device memory
  float value = 0.0f;                      ///< px of error it removes per byte, in frame value_frame
  std::uint64_t value_frame = 0;
  std::uint64_t last_used_frame = 0;  ///< evicting: last frame that may refer to it
  Chunk* next_evicting = nullptr;
  bool held = false;    ///< a host has it, decoded or evicting, until it confirms
  bool victim = false;  ///< chosen in the round of evictions being planned
};

/// Whether the table allows the step.
bool may_advance(Residency from, Residency to);

/// The only writer of chunk.residency. False, and no change: the step is not in the table.
[[nodiscard]] bool advance(Chunk& chunk, Residency to);

const char* residency_name(Residency residency);
const char* chunk_kind_name(ChunkKind kind);

}  // namespace coppice
