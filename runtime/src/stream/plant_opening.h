#pragma once

// Plants that are being opened. The header of each is read, then its front, then a job decodes the pinned chunks. Each step starts when the
// one before is done, so nobody has to wait.

#include <array>
#include <cstdint>
#include <memory>

#include "budget.h"

namespace coppice {

struct PlantOpening {
  enum class Step : std::uint8_t { queued, header, front, read, decoding };

  HookArray<char> name;  ///< source.name
  PlantSource source;
  std::uint32_t index = 0;            ///< index of the plant
  bool blocking = false;              ///< the caller waits: it skips the queue and decodes on its own thread
  bool cancelled = false;             ///< see cancel()
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
  /// It is removed once nothing is running.
  void cancel();
};

struct Openings {
  Hooks hooks;
  std::uint64_t (*clock_ns)() = now_ns;
  DecoderPool decoders;                          ///< all plants share them
  HookArray<std::unique_ptr<PlantOpening>> all;  ///< by plant; null: the plant is open, or unused
  std::uint32_t first_free = 0;                  ///< plants before it are in use
  std::size_t started_count = 0;                 ///< those that are not queued
};

/// Continues as far as finished work allows. True if the plant's pinned chunks are decoded; take_opened follows. errors  io, bad_file,
/// unsupported, out_of_memory; path is not in the message
Result<bool> advance_opening(Openings& openings, PlantOpening& opening, Budget& budget, const PlantSet& plants, const CurrentFrame& frame);
/// Reserves the memory of the open plant, and returns it. before: advance_opening was true
std::unique_ptr<PlantStream> take_opened(PlantOpening& opening, Budget& budget);
/// Puts an opening back into the queue until a frame. before: idle()
void restart_opening(Openings& openings, PlantOpening& opening, Budget& budget, std::uint64_t start_frame);
/// plant: its index
void drop_opening(Openings& openings, std::uint32_t plant, Budget& budget, const PlantSet& plants);
/// Drops cancelled openings whose work has come back.
void drop_cancelled(Openings& openings, Budget& budget, const PlantSet& plants);

}  // namespace coppice
