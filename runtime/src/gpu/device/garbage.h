#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "descriptor_sets.h"
#include "device.h"

namespace coppice::gpu {

/// Destroys things once the GPU has finished the frame that used them last. They are few: larger buffers' predecessors, sets, and copies
/// that found no room in the staging ring.
class Garbage {
 public:
  explicit Garbage(Device& device) : device_(device) {}
  /// The GPU must be done with everything.
  ~Garbage() { begin_frame(frame_, ~std::uint64_t{0}); }
  Garbage(const Garbage&) = delete;
  Garbage& operator=(const Garbage&) = delete;

  /// What is retired from now on may be used by this frame. Destroys what completed frames used.
  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  void retire(Buffer& buffer) { items_.push_back({frame_, std::exchange(buffer, {}), {}}); }
  void retire(DescriptorSet& set) { items_.push_back({frame_, {}, std::exchange(set, {})}); }

 private:
  struct Item {
    std::uint64_t last_frame;
    Buffer buffer;
    DescriptorSet set;
  };
  Device& device_;
  std::uint64_t frame_ = 0;
  std::vector<Item> items_;
};

}  // namespace coppice::gpu
