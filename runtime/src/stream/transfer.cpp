#include "transfer.h"

#include "plant_stream.h"

namespace coppice {

namespace {

void trace_transfer(const Transfer& transfer, coppice_trace_kind kind, std::uint64_t start_ns) {
  const PlantStream& plant = *transfer.plant;
  trace_end(plant.hooks.trace, {0, kind, plant.path.data(), chunk_kind_name(transfer.chunk->id.kind), transfer.chunk->id.index,
                                plant.file_chunk(*transfer.chunk).bytes, start_ns, 0});
}

void on_read_done(void* argument, std::int64_t bytes_read) {
  auto* transfer = static_cast<Transfer*>(argument);
  transfer->bytes_read = bytes_read;
  trace_transfer(*transfer, COPPICE_TRACE_READ, transfer->read_start_ns);
  transfer->queue->push(transfer);
}

void run_decodes(void* argument) {
  bool skip = false;
  for (auto* transfer = static_cast<Transfer*>(argument); transfer != nullptr;) {
    Transfer* next = transfer->next_in_run;  // read before the push: afterwards the transfer belongs to the frame's thread
    transfer->skipped = skip;
    const std::uint64_t start = now_ns();
    if (!skip) transfer->outcome = decode_chunk(*transfer);
    transfer->decode_ns = now_ns() - start;
    if (!skip) trace_transfer(*transfer, COPPICE_TRACE_DECODE, start);
    // Here and not on the frame's thread, which a large block would hold up.
    transfer->scratch.reset();
    transfer->cluster_scratch.reset();
    if (!keeps_bytes(*transfer)) transfer->bytes.reset();
    skip = skip || !transfer->outcome;
    transfer->queue->push(transfer);
    transfer = next;
  }
}

}  // namespace

void start_read(Transfer& transfer, const coppice_io& io, std::int64_t file, std::uint64_t offset) {
  transfer.stage = TransferStage::reading;
  transfer.read_start_ns = trace_start(transfer.plant->hooks.trace);
  transfer.queue->expect();
  io.read(io.user, file, offset, transfer.bytes.data(), transfer.bytes.size(), on_read_done, &transfer);
}

void start_decode(Transfer& first, const coppice_jobs& jobs, coppice_priority priority) {
  std::uint32_t count = 0;
  for (Transfer* transfer = &first; transfer != nullptr; transfer = transfer->next_in_run) {
    transfer->stage = TransferStage::decoding;
    ++count;
  }
  first.queue->expect(count);
  const coppice_job job = make_job(COPPICE_JOB_DECODE, priority, run_decodes, &first);
  jobs.submit(jobs.user, &job);
}

}  // namespace coppice
