#include "growing_buffers.h"

#include <algorithm>

namespace coppice::gpu {
GrowingBuffers::~GrowingBuffers() {
  for (Successor& successor : successors_) destroy_buffer(device_, successor.buffer);
}

const Buffer& GrowingBuffers::latest(const BufferSize& size) const {
  const auto successor = std::ranges::find(successors_, size.buffer, [](const Successor& made) { return made.size.buffer; });
  return successor != successors_.end() ? successor->buffer : *size.buffer;
}

std::uint64_t GrowingBuffers::reserve_bytes(const BufferSizes& needed) const {
  constexpr std::uint64_t kRounding = 1024;  // maximum rounding of a request
  std::uint64_t bytes = 0;
  for (const BufferSize& size : needed.span())
    if (size.bytes > latest(size).size_bytes) bytes += size.bytes + kRounding;
  return bytes;
}

std::uint64_t GrowingBuffers::excess_bytes(const BufferSizes& needed) const {
  std::uint64_t bytes = 0;
  for (const BufferSize& size : needed.span())
    if (size.bytes < latest(size).size_bytes) bytes += std::max(own_bytes(device_.memory, latest(size).memory), size.bytes) - size.bytes;
  for (const Successor& successor : successors_) bytes += own_bytes(device_.memory, successor.size.buffer->memory);
  return bytes;
}

Result<void> GrowingBuffers::reserve(const BufferSizes& needed) {
  BufferSizes larger;
  for (const BufferSize& size : needed.span())
    if (size.bytes > latest(size).size_bytes) larger.add(size);
  return make(larger);
}

bool GrowingBuffers::shrink(const BufferSizes& needed) {
  BufferSizes smaller;
  for (const BufferSize& size : needed.span())
    if (size.bytes < latest(size).size_bytes) smaller.add(size);
  Ledger& ledger = *device_.memory.ledger;
  const std::uint64_t budget = ledger.budget();
  if (ledger.reserved() > budget) ledger.set_budget(Ledger::kUnlimited);
  const bool made = static_cast<bool>(make(smaller));
  ledger.set_budget(budget);
  return made;
}

Result<void> GrowingBuffers::make(const BufferSizes& needed) {
  std::vector<Successor> made;
  for (const BufferSize& size : needed.span()) {
    auto buffer = size.bytes > 0 ? create_buffer(device_, size.desc(MemoryKind::alone)) : Buffer{};
    if (!buffer) {
      for (Successor& successor : made) destroy_buffer(device_, successor.buffer);
      return buffer.error();
    }
    made.push_back({size, *buffer});
  }
  // The GPU has not seen earlier successors yet.
  for (const Successor& next : made) {
    std::erase_if(successors_, [&](Successor& before) {
      if (before.size.buffer != next.size.buffer) return false;
      destroy_buffer(device_, before.buffer);
      return true;
    });
    successors_.push_back(next);
  }
  return {};
}

void GrowingBuffers::forget(const BufferSizes& gone) {
  std::erase_if(successors_, [&](Successor& successor) {
    if (std::ranges::find(gone.items, successor.size.buffer, &BufferSize::buffer) == gone.items.end()) return false;
    destroy_buffer(device_, successor.buffer);
    return true;
  });
}

bool GrowingBuffers::replace(Uploads& uploads, DeferredDeletion& deletion) {
  const bool some = !successors_.empty();
  for (const Successor& successor : successors_) {
    Buffer& before = *successor.size.buffer;
    if (before.buffer != VK_NULL_HANDLE) {
      if (successor.size.kept && successor.buffer.buffer != VK_NULL_HANDLE) uploads.move(before, successor.buffer);
      deletion.defer(before);
    }
    before = successor.buffer;
  }
  successors_.clear();
  return some;
}

}  // namespace coppice::gpu
