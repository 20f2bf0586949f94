#include "transfer.h"

#include <algorithm>

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

void ReadGroup::start(const coppice_io& io, std::int64_t file, std::uint64_t offset, std::span<std::uint8_t> out) {
  issue(reads_.emplace_back(Read{this, offset, out, 0}), io, file);
}

void ReadGroup::issue(Read& read, const coppice_io& io, std::int64_t file) {
  {
    const std::lock_guard lock(mutex_);
    ++expected_;
  }
  io.read(io.user, file, read.offset, read.out.data(), read.out.size(), on_done, &read);
}

// Notifies under the lock: the waiter may destroy the group as soon as it can take it.
void ReadGroup::on_done(void* argument, std::int64_t bytes_read) {
  auto* read = static_cast<Read*>(argument);
  ReadGroup& group = *read->group;
  const std::lock_guard lock(group.mutex_);
  read->bytes_read = bytes_read;
  if (--group.expected_ == 0) group.all_back_.notify_all();
}

bool ReadGroup::back() const {
  const std::lock_guard lock(mutex_);
  return expected_ == 0;
}

void ReadGroup::wait() {
  std::unique_lock lock(mutex_);
  all_back_.wait(lock, [this] { return expected_ == 0; });
}

bool ReadGroup::whole() const {
  return std::ranges::all_of(reads_, &Read::whole);
}

void ReadGroup::repeat_failed(const coppice_io& io, std::int64_t file) {
  for (Read& read : reads_)
    if (!read.whole()) issue(read, io, file);
}

Result<void> ReadGroup::take() {
  const std::deque<Read> reads = std::exchange(reads_, {});
  for (const Read& read : reads)
    if (!read.whole()) return read_error(read.bytes_read, read.out.size(), read.offset);
  return {};
}

Result<void> read_now(const coppice_io& io, std::int64_t file, std::uint64_t offset, std::span<std::uint8_t> out) {
  ReadGroup read;
  read.start(io, file, offset, out);
  read.wait();
  return read.take();
}

}  // namespace coppice
