#include "growing_buffers.h"

#include <algorithm>

namespace coppice::gpu {

GrowingBuffers::~GrowingBuffers() {
  for (Larger& larger : larger_) destroy_buffer(device_, larger.buffer);
}

bool GrowingBuffers::grows(const BufferSize& size) const {
  const auto larger = std::ranges::find(larger_, size.buffer, [](const Larger& made) { return made.size.buffer; });
  return size.bytes > (larger != larger_.end() ? larger->buffer : *size.buffer).size_bytes;
}

std::uint64_t GrowingBuffers::reserve_bytes(const BufferSizes& needed) const {
  constexpr std::uint64_t kRounding = 1024;  // maximum rounding of a request
  std::uint64_t bytes = 0;
  for (const BufferSize& size : needed.span())
    if (grows(size)) bytes += size.bytes + kRounding;
  return bytes;
}

Result<void> GrowingBuffers::reserve(const BufferSizes& needed) {
  std::vector<Larger> made;
  for (const BufferSize& size : needed.span()) {
    if (!grows(size)) continue;
    auto buffer = create_buffer(device_, size.desc(MemoryKind::alone));
    if (!buffer) {
      for (Larger& larger : made) destroy_buffer(device_, larger.buffer);
      return buffer.error();
    }
    made.push_back({size, *buffer});
  }
  // The GPU has not seen the larger buffers yet.
  for (const Larger& next : made) {
    std::erase_if(larger_, [&](Larger& before) {
      if (before.size.buffer != next.size.buffer) return false;
      destroy_buffer(device_, before.buffer);
      return true;
    });
    larger_.push_back(next);
  }
  return {};
}

void GrowingBuffers::forget(const BufferSizes& gone) {
  std::erase_if(larger_, [&](Larger& larger) {
    if (std::ranges::find(gone.items, larger.size.buffer, &BufferSize::buffer) == gone.items.end()) return false;
    destroy_buffer(device_, larger.buffer);
    return true;
  });
}

bool GrowingBuffers::replace(Uploads& uploads, DeferredDeletion& deletion) {
  const bool some = !larger_.empty();
  for (const Larger& larger : larger_) {
    Buffer& smaller = *larger.size.buffer;
    if (smaller.buffer != VK_NULL_HANDLE) {
      if (larger.size.kept) uploads.move(smaller, larger.buffer);
      deletion.defer(smaller);
    }
    smaller = larger.buffer;
  }
  larger_.clear();
  return some;
}

}  // namespace coppice::gpu
