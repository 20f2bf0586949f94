#include "deferred_deletion.h"

namespace coppice::gpu {

void DeferredDeletion::begin_frame(std::uint64_t frame_number, std::uint64_t completed_number) {
  frame_ = frame_number;
  std::erase_if(items_, [&](Item& item) {
    if (item.last_frame > completed_number) return false;
    destroy_buffer(device_, item.buffer);
    destroy_set(device_, item.set);
    destroy_texture(device_, item.texture);
    return true;
  });
}

std::uint64_t DeferredDeletion::bytes() const {
  std::uint64_t bytes = 0;
  for (const Item& item : items_) bytes += own_bytes(device_.memory, item.buffer.memory) + own_bytes(device_.memory, item.texture.memory);
  return bytes;
}

}  // namespace coppice::gpu
