#pragma once

// A plant that is being opened: its header is read, then its front, then, where the GPU does not read blocks, its textures' headers. Every
// step starts when the reads of the one before are back, so that nobody has to wait.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "plant_stream.h"

namespace coppice {

struct PlantOpening {
  enum class Step : std::uint8_t { header, front, textures, read };
  struct TextureHeader {
    std::uint32_t texture = 0;
    std::array<std::uint8_t, sizeof(coppice_file_texture)> bytes{};
  };

  Step step = Step::header;  ///< whose reads are under way
  std::unique_ptr<PlantStream> plant;
  std::array<std::uint8_t, sizeof(coppice_file_header)> header{};
  HookBuffer front;
  std::vector<TextureHeader> texture_headers;
  std::uint64_t reserved_bytes = 0;  ///< counted for it until it is open
  ReadRetry retry;                   ///< of the step's reads
  ReadGroup reads;                   ///< last: its destructor waits for reads into the rest
};

/// Opens the file and starts to read its header. errors  as open_plant_file
Result<std::unique_ptr<PlantOpening>> start_opening(const Hooks& hooks, const GpuSizes& gpu, const char* path, std::uint32_t index);

/// Whether reads of the step have failed and are tried again, at once or after a pause. opening.reads is back.
bool repeat_reads(PlantOpening& opening, std::uint64_t (*clock_ns)());

// Each takes what was read: opening.reads is back. errors  io, bad_file, unsupported, out_of_memory; path is not in the message

/// step: header; plant->file.header is set.
Result<void> take_header(PlantOpening& opening);
/// After take_header.
Result<void> start_front(PlantOpening& opening);
/// step: front. Fills in the plant's tables.
Result<void> take_front(PlantOpening& opening);
/// After take_front and all that can fail: whoever ends an opening waits for its reads. Reads the textures' headers, if any are needed.
void start_texture_headers(PlantOpening& opening);
/// step: textures; after it everything is read.
Result<void> take_texture_headers(PlantOpening& opening);

}  // namespace coppice
