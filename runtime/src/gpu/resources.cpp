#include "resources.h"

#include <algorithm>

namespace coppice::gpu {

void Garbage::collect(Device& device, std::uint64_t completed_frame) {
  std::erase_if(items_, [&](Item& item) {
    if (item.last_frame > completed_frame) return false;
    if (item.buffer.buffer != VK_NULL_HANDLE) destroy_buffer(device, item.buffer);
    if (item.texture.image != VK_NULL_HANDLE) destroy_texture(device, item.texture);
    device.vk.vkDestroyDescriptorPool(device.device, item.pool, nullptr);
    return true;
  });
}

Result<Staging> Staging::create(Device& device, std::uint64_t capacity_bytes) {
  COPPICE_TRY(ring, create_buffer(device, capacity_bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::host));
  Staging staging;
  staging.ring_ = ring;
  return staging;
}

void Staging::destroy(Device& device) {
  if (ring_.buffer != VK_NULL_HANDLE) destroy_buffer(device, ring_);
}

Result<StagingSlice> Staging::allocate(Device& device, Garbage& garbage, std::uint64_t frame, std::uint64_t bytes) {
  const std::uint64_t capacity = ring_.size_bytes;
  const std::uint64_t rounded = (bytes + 15) / 16 * 16;
  std::uint64_t start = head_;
  if (start % capacity + rounded > capacity) start += capacity - start % capacity;
  if (start + rounded - tail_ <= capacity) {
    head_ = start + rounded;
    if (!marks_.empty() && marks_.back().frame == frame)
      marks_.back().head = head_;
    else
      marks_.push_back({frame, head_});
    return StagingSlice{ring_.buffer, start % capacity, ring_.mapped + start % capacity};
  }
  COPPICE_TRY(buffer, create_buffer(device, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::host));
  garbage.retire(frame, buffer);
  return StagingSlice{buffer.buffer, 0, buffer.mapped};
}

void Staging::recycle(std::uint64_t completed_frame) {
  while (!marks_.empty() && marks_.front().frame <= completed_frame) {
    tail_ = marks_.front().head;
    marks_.pop_front();
  }
  if (marks_.empty()) head_ = tail_ = 0;
}

// Slices do not wrap: what is free is a run up to the ring's end and one from its start.
std::uint64_t Staging::room_bytes() const {
  const std::uint64_t capacity = ring_.size_bytes;
  const std::uint64_t free = capacity - (head_ - tail_);
  const std::uint64_t to_end = std::min(free, capacity - head_ % capacity);
  return std::max(to_end, free - to_end);
}

}  // namespace coppice::gpu
