#pragma once

// Shared by reader and writer, beyond the structs: the order of the chunks, their names, the checksum.

#include <cstdint>
#include <span>

#include "coppice/format.h"

namespace coppice {

struct ChunkKey {
  coppice_chunk_kind kind;
  std::uint32_t index;
};

// The counts of `plant` must be within their limits, here and below.

/// Number of chunks in a file.
std::uint32_t chunk_count(const coppice_file_plant& plant);
/// The chunk at a position in file order. position: < chunk_count
ChunkKey chunk_at(const coppice_file_plant& plant, std::uint32_t position);
/// Number of chunks in the first read, counted from the start of the file.
std::uint32_t first_read_chunk_count(const coppice_file_plant& plant);

/// Returns "PAGE" and the like; static storage. "unknown" for a value that is no kind.
const char* chunk_kind_name(std::uint32_t kind);

/// XXH3-64.
std::uint64_t checksum(std::span<const std::uint8_t> bytes);

}  // namespace coppice
