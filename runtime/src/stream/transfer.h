#pragma once

// A running read or decode, and how its result returns to the frame's thread.

#include <cstdint>

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
  HookArray<PageScratch> scratch;  ///< page: one element while the job decodes it, here and below
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
void start_decode(Transfer& first, const coppice_jobs& jobs, coppice_priority priority);

}  // namespace coppice
