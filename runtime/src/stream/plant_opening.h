#pragma once

// A plant that is being opened. Its header is read, then its front, then a job decodes the pinned chunks. Each step starts when the one
// before is done, so nobody has to wait.

#include <array>
#include <cstdint>
#include <memory>

#include "plant_stream.h"

namespace coppice {

struct PlantOpening {
  enum class Step : std::uint8_t { queued, header, front, read, decoding };

  HookArray<char> name;  ///< source.name
  PlantSource source;
  std::uint32_t index = 0;            ///< index of the plant
  bool blocking = false;              ///< the caller waits: it skips the queue and decodes on its own thread
  bool cancelled = false;             ///< removed once nothing is running
  std::uint32_t failed_attempts = 0;  ///< failed attempts for lack of memory
  std::uint64_t start_frame = 0;      ///< queued: do not start before this frame
  Step step = Step::queued;           ///< the step that is running
  std::unique_ptr<PlantStream> plant;
  std::array<std::uint8_t, sizeof(coppice_file_header)> header{};
  HookBuffer front;
  std::uint64_t reserved_bytes = 0;  ///< reserved for it until it is open
  ReadRetry retry;                   ///< for the read of this step
  HookArray<Transfer> pinned;        ///< chunks that are being decoded
  CompletionQueue<Transfer> decoded;
  AwaitedRead read;  ///< last: its destructor waits for a read into the rest

  PlantOpening() = default;
  PlantOpening(const PlantOpening&) = delete;
  PlantOpening& operator=(const PlantOpening&) = delete;
  ~PlantOpening() { decoded.wait_for_all(); }
  /// True if nothing is running.
  [[nodiscard]] bool idle() const { return read.back() && decoded.all_back(); }
  void wait();
  /// before: idle()
  void clear_pinned();
  /// Frees its resources, to start again. before: idle()
  void restart(std::uint64_t frame);
};

/// Opens the file and starts to read its header. errors  as open_plant_file
Result<void> start_header(PlantOpening& opening, const Hooks& hooks, const GpuSizes& gpu);

/// True if the read of the step has failed and is retried, at once or after a pause. before: opening.read is back
bool repeat_read(PlantOpening& opening, std::uint64_t (*clock_ns)());

// Each of the next functions uses a finished read (opening.read is back). errors  io, bad_file, unsupported, out_of_memory; path is not in
// the message

/// For step header; sets plant->file.header.
Result<void> take_header(PlantOpening& opening);
/// Call it after take_header.
Result<void> start_front(PlantOpening& opening);
/// For step front; fills in the plant's tables.
Result<void> take_front(PlantOpening& opening);
/// For step read; lets a job decode the pinned chunks. errors  bad_file: the front does not hold them; out_of_memory
Result<void> start_pinned(PlantOpening& opening);
/// For step decoding, and idle(). errors  bad_file, out_of_memory
Result<void> take_pinned(PlantOpening& opening);

}  // namespace coppice
