#pragma once

// A plant that is being opened: its header is read, then its front; then a job decodes what is pinned. Every step starts when the one
// before is done, so that nobody has to wait.

#include <array>
#include <cstdint>
#include <memory>

#include "plant_stream.h"

namespace coppice {

struct PlantOpening {
  enum class Step : std::uint8_t { queued, header, front, read, decoding };

  HookArray<char> name;  ///< source.name
  PlantSource source;
  std::uint32_t index = 0;         ///< the plant's
  bool blocking = false;           ///< somebody waits: it takes no turn and nobody else's thread
  bool cancelled = false;          ///< goes once nothing is under way
  std::uint32_t failed_tries = 0;  ///< that found no memory
  std::uint64_t start_frame = 0;   ///< queued: not before
  Step step = Step::queued;        ///< what is under way
  std::unique_ptr<PlantStream> plant;
  std::array<std::uint8_t, sizeof(coppice_file_header)> header{};
  HookBuffer front;
  std::uint64_t reserved_bytes = 0;  ///< counted for it until it is open
  ReadRetry retry;                   ///< of the step's read
  HookArray<Transfer> pinned;        ///< being decoded
  CompletionQueue<Transfer> decoded;
  AwaitedRead read;  ///< last: its destructor waits for a read into the rest

  PlantOpening() = default;
  PlantOpening(const PlantOpening&) = delete;
  PlantOpening& operator=(const PlantOpening&) = delete;
  ~PlantOpening() { decoded.wait_for_all(); }
  /// Whether nothing is under way.
  [[nodiscard]] bool idle() const { return read.back() && decoded.all_back(); }
  void wait();
  /// idle()
  void clear_pinned();
  /// Gives up what it has, to start again; idle().
  void restart(std::uint64_t frame);
};

/// Opens the file and starts to read its header. errors  as open_plant_file
Result<void> start_header(PlantOpening& opening, const Hooks& hooks, const GpuSizes& gpu);

/// Whether the read of the step has failed and is tried again, at once or after a pause. opening.read is back.
bool repeat_read(PlantOpening& opening, std::uint64_t (*clock_ns)());

// Each takes what was read: opening.read is back. errors  io, bad_file, unsupported, out_of_memory; path is not in the message

/// step: header; plant->file.header is set.
Result<void> take_header(PlantOpening& opening);
/// After take_header.
Result<void> start_front(PlantOpening& opening);
/// step: front. Fills in the plant's tables.
Result<void> take_front(PlantOpening& opening);
/// step: read. Has a job decode what is pinned. errors  bad_file: the front does not hold it; out_of_memory
Result<void> start_pinned(PlantOpening& opening);
/// step: decoding, and idle(). errors  bad_file, out_of_memory
Result<void> take_pinned(PlantOpening& opening);

}  // namespace coppice
