#include "transfer.h"

#include "plant_stream.h"

namespace coppice {

void CompletionQueue::expect(std::uint32_t count) {
  const std::lock_guard lock(mutex_);
  expected_ += count;
}

// Notifies under the lock: the waiter may destroy the queue as soon as it can take it.
void CompletionQueue::push(Transfer* transfer) {
  const std::lock_guard lock(mutex_);
  transfer->next = nullptr;
  (last_ != nullptr ? last_->next : first_) = transfer;
  last_ = transfer;
  if (--expected_ == 0) all_back_.notify_all();
}

Transfer* CompletionQueue::take_all() {
  const std::lock_guard lock(mutex_);
  last_ = nullptr;
  return std::exchange(first_, nullptr);
}

void CompletionQueue::wait_for_all() {
  std::unique_lock lock(mutex_);
  all_back_.wait(lock, [this] { return expected_ == 0; });
}

namespace {

void trace_transfer(const Transfer& transfer, coppice_trace_kind kind, std::uint64_t start_ns) {
  const PlantStream& plant = *transfer.plant;
  trace_end(plant.hooks.trace, {kind, plant.path.c_str(), chunk_kind_name(transfer.chunk->id.kind), transfer.chunk->id.index,
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
    Transfer* next = transfer->next_in_run;  // once pushed, the transfer belongs to the frame's thread
    transfer->skipped = skip;
    const std::uint64_t start = now_ns();
    if (!skip) transfer->outcome = decode_chunk(*transfer);
    transfer->decode_ns = now_ns() - start;
    if (!skip) trace_transfer(*transfer, COPPICE_TRACE_DECODE, start);
    skip = skip || !transfer->outcome;
    transfer->queue->push(transfer);
    transfer = next;
  }
}

struct BlockingRead {
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  std::int64_t bytes_read = 0;
};

void on_blocking_read_done(void* argument, std::int64_t bytes_read) {
  auto* read = static_cast<BlockingRead*>(argument);
  const std::lock_guard lock(read->mutex);
  read->done = true;
  read->bytes_read = bytes_read;
  read->changed.notify_all();
}

}  // namespace

void start_read(Transfer& transfer, const coppice_io& io, std::int64_t file, std::uint64_t offset) {
  transfer.stage = TransferStage::reading;
  transfer.read_start_ns = trace_start(transfer.plant->hooks.trace);
  transfer.queue->expect(1);
  io.read(io.user, file, offset, transfer.bytes.data(), transfer.bytes.size(), on_read_done, &transfer);
}

void start_decode(Transfer& first, const coppice_jobs& jobs) {
  std::uint32_t count = 0;
  for (Transfer* transfer = &first; transfer != nullptr; transfer = transfer->next_in_run) {
    transfer->stage = TransferStage::decoding;
    ++count;
  }
  first.queue->expect(count);
  jobs.submit(jobs.user, run_decodes, &first);
}

Result<void> read_now(const coppice_io& io, std::int64_t file, std::uint64_t offset, std::span<std::uint8_t> out) {
  BlockingRead read;
  io.read(io.user, file, offset, out.data(), out.size(), on_blocking_read_done, &read);
  std::unique_lock lock(read.mutex);
  read.changed.wait(lock, [&] { return read.done; });
  if (read.bytes_read == static_cast<std::int64_t>(out.size())) return {};
  return Error{Status::io, "read failed", offset, std::to_string(read.bytes_read) + " of " + std::to_string(out.size()) + " bytes"};
}

}  // namespace coppice
