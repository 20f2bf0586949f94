#pragma once

// Memory that lives from frame to frame: what waits for the GPU to be done with it, and the staging ring.

#include <cstdint>
#include <deque>
#include <vector>

#include "device.h"
#include "result.h"

namespace coppice::gpu {

/// Destroys things once the GPU has finished the frame that used them last.
class Garbage {
 public:
  void retire(std::uint64_t last_frame, const Buffer& buffer) { items_.push_back({last_frame, buffer, {}, VK_NULL_HANDLE}); }
  void retire(std::uint64_t last_frame, const Texture& texture) { items_.push_back({last_frame, {}, texture, VK_NULL_HANDLE}); }
  void retire(std::uint64_t last_frame, VkDescriptorPool pool) { items_.push_back({last_frame, {}, {}, pool}); }
  void collect(Device& device, std::uint64_t completed_frame);

 private:
  struct Item {
    std::uint64_t last_frame;
    Buffer buffer;
    Texture texture;
    VkDescriptorPool pool;
  };
  std::vector<Item> items_;
};

/// A buffer whose size follows how many of something there are.
struct BufferSize {
  Buffer* buffer = nullptr;
  std::uint64_t bytes = 0;
  VkBufferUsageFlags usage = 0;
  bool kept = false;  ///< a larger one begins with what this one holds; it can be copied from and to
};

/// Where to write bytes that a recorded copy will read.
struct StagingSlice {
  VkBuffer buffer = VK_NULL_HANDLE;
  std::uint64_t offset = 0;
  std::uint8_t* data = nullptr;  ///< aligned to 16
};

/// A ring of mapped, coherent memory. What does not fit gets a buffer of its own, retired with the frame: a first upload of many instances
/// or a large texture, not the steady state.
class Staging {
 public:
  /// There is a run of this in the ring while little of it is in use.
  static constexpr std::uint64_t kSliceBytes = 3ull << 20;

  static Result<Staging> create(Device& device, std::uint64_t capacity_bytes);
  void destroy(Device& device);

  /// errors  out_of_memory
  Result<StagingSlice> allocate(Device& device, Garbage& garbage, std::uint64_t frame, std::uint64_t bytes);
  void recycle(std::uint64_t completed_frame);
  /// Slices of together so many bytes come out of the ring.
  [[nodiscard]] std::uint64_t room_bytes() const;

 private:
  struct Mark {
    std::uint64_t frame, head;
  };
  Buffer ring_;
  std::uint64_t head_ = 0, tail_ = 0;  ///< grow for ever; the place in the ring is the remainder
  std::deque<Mark> marks_;
};

}  // namespace coppice::gpu
