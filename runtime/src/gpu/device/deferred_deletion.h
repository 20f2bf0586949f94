#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "descriptor_sets.h"
#include "device.h"

namespace coppice::gpu {

/// Defers the deletion of objects until the GPU has finished the last frame that used them. They are few: predecessors of buffers that
/// grew, sets, copies that did not fit into the staging ring, and uploads that were given up.
class DeferredDeletion {
 public:
  explicit DeferredDeletion(Device& device) : device_(device) {}
  /// Before: the GPU is done with everything.
  ~DeferredDeletion() { begin_frame(frame_, ~std::uint64_t{0}); }
  DeferredDeletion(const DeferredDeletion&) = delete;
  DeferredDeletion& operator=(const DeferredDeletion&) = delete;

  /// Deletes what completed frames used. Objects that are added from now on may be in use by this frame.
  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  void defer(Buffer& buffer) { items_.push_back({frame_, std::exchange(buffer, {}), {}, {}}); }
  void defer(DescriptorSet& set) { items_.push_back({frame_, {}, std::exchange(set, {}), {}}); }
  void defer(Texture& texture) { items_.push_back({frame_, {}, {}, std::exchange(texture, {})}); }
  /// Bytes that waiting buffers and textures will give back.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  struct Item {
    std::uint64_t last_frame;
    Buffer buffer;
    DescriptorSet set;
    Texture texture;
  };
  Device& device_;
  std::uint64_t frame_ = 0;
  std::vector<Item> items_;
};

}  // namespace coppice::gpu
