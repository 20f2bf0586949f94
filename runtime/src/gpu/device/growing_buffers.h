#pragma once

// Buffers whose size follows how many of something there are. A larger one waits until the next upload: between that and the draws of a
// frame nothing is replaced.

#include <cstdint>
#include <span>
#include <vector>

#include "uploads.h"

namespace coppice::gpu {

struct BufferSize {
  Buffer* buffer = nullptr;
  const char* name = "";  ///< static storage
  std::uint64_t bytes = 0;
  VkBufferUsageFlags usage = 0;
  bool kept = false;  ///< a larger one begins with what this one holds; it can be copied from and to
  VkFormat texels = VK_FORMAT_R32_UINT;

  [[nodiscard]] BufferDesc desc(MemoryKind kind) const { return {name, bytes, usage, kind, texels}; }
};

/// All whose size follows something.
struct BufferSizes {
  std::vector<BufferSize> items;  ///< some ten, and six of each view

  void add(const BufferSize& size) { items.push_back(size); }
  [[nodiscard]] std::span<const BufferSize> span() const { return items; }
};

class GrowingBuffers {
 public:
  /// device: outlives this object
  explicit GrowingBuffers(Device& device) : device_(device) {}
  ~GrowingBuffers();
  GrowingBuffers(const GrowingBuffers&) = delete;
  GrowingBuffers& operator=(const GrowingBuffers&) = delete;

  /// What reserve takes at once. wanted: all of a kind
  [[nodiscard]] std::uint64_t reserve_bytes(const BufferSizes& wanted) const;
  /// Creates those that have to become larger. errors  out_of_memory, device_lost, unsupported: more than the device binds; nothing has
  /// changed
  Result<void> reserve(const BufferSizes& wanted);
  /// Buffers that go: nothing takes their place.
  void forget(const BufferSizes& gone);
  /// Larger buffers take the place of smaller ones. Whether there were any
  bool take(Uploads& uploads, Garbage& garbage);

 private:
  struct Larger {
    BufferSize size;
    Buffer buffer;
  };
  [[nodiscard]] bool grows(const BufferSize& size) const;

  Device& device_;
  std::vector<Larger> larger_;  ///< one for each buffer that grows, some ten
};

}  // namespace coppice::gpu
