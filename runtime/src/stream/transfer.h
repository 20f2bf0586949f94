#pragma once

// A running read or decode, and how its result returns to the frame's thread.

#include <cstdint>
#include <span>

#include "completion_queue.h"
#include "hooks.h"
#include "io_result.h"
#include "mesh_clusters.h"
#include "page_clusters.h"
#include "page_codec.h"
#include "residency.h"

namespace coppice {

struct PlantStream;

enum class TransferStage : std::uint8_t {
  idle,      ///< free
  reading,   ///< the I/O hook owns it
  paused,    ///< the read failed and is tried again later
  read,      ///< the bytes have arrived; a page waits for its predecessor
  decoding,  ///< a job owns it
};

/// A slot for one transfer. While a hook owns it, the frame's thread only touches `cancelled`.
struct Transfer {
  TransferStage stage = TransferStage::idle;
  bool cancelled = false;  ///< set by the frame's thread: drop it at the next step
  CompletionQueue<Transfer>* queue = nullptr;
  PlantStream* plant = nullptr;
  Chunk* chunk = nullptr;

  HookBuffer bytes;                 ///< the chunk as stored
  std::uint64_t read_start_ns = 0;  ///< set if there is a trace hook
  std::int64_t bytes_read = 0;
  ReadRetry retry;

  PageOutput page;                 ///< page: where the job decodes it to
  HookArray<PageScratch> scratch;  ///< page: one element, here and below
  HookArray<gpu::ClusterScratch> cluster_scratch;
  gpu::MeshBlock mesh;          ///< wood, leaf mesh: the job's result
  HookBuffer texels;            ///< a texture that is decoded: the job's result, a TEXTURE chunk of RGBA8
  Result<void> outcome;         ///< the job's outcome
  std::uint64_t decode_ns = 0;  ///< the job's duration
  bool skipped = false;         ///< page: the one before it in the run failed, so it was not decoded

  Transfer* next_in_run = nullptr;  ///< pages that one job decodes one after the other
  Transfer* next = nullptr;         ///< in the completion queue
};

/// Hands the read of transfer.bytes at `offset` to the I/O hook.
void start_read(Transfer& transfer, const coppice_io& io, std::int64_t file, std::uint64_t offset);

/// Hands a run of transfers (linked by next_in_run, stage read) to one job.
void start_decode(Transfer& first, const coppice_jobs& jobs);

/// A read that is awaited, one at a time. It may end on any thread; all functions are the frame's thread's.
class AwaitedRead {
 public:
  AwaitedRead() = default;
  AwaitedRead(const AwaitedRead&) = delete;
  AwaitedRead& operator=(const AwaitedRead&) = delete;
  ~AwaitedRead() { wait(); }

  /// out: does not move until the read is back
  void start(const coppice_io& io, std::int64_t file, std::uint64_t offset, std::span<std::uint8_t> out);
  /// True if it has returned.
  [[nodiscard]] bool back() const { return queue_.all_back(); }
  void wait() const { queue_.wait_for_all(); }
  /// True if it gave all its bytes. before: back(), here and below
  [[nodiscard]] bool whole() const { return read_.bytes_read == static_cast<std::int64_t>(read_.out.size()); }
  /// Starts the same read again.
  void repeat(const coppice_io& io, std::int64_t file) { start(io, file, read_.offset, read_.out); }
  /// errors  as read_error
  [[nodiscard]] Result<void> result() const;

 private:
  struct Read {
    CompletionQueue<Read>* queue = nullptr;
    std::uint64_t offset = 0;
    std::span<std::uint8_t> out;
    std::int64_t bytes_read = 0;
    Read* next = nullptr;  ///< in the queue
  };
  static void on_done(void* argument, std::int64_t bytes_read);

  Read read_;
  CompletionQueue<Read> queue_;
};

/// Reads through the hook and waits, one attempt. errors  as read_error
Result<void> read_now(const coppice_io& io, std::int64_t file, std::uint64_t offset, std::span<std::uint8_t> out);

}  // namespace coppice
