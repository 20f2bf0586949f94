#pragma once

// Buffers whose size follows a count. A larger buffer replaces a smaller one in the next upload only, so nothing is replaced between the
// upload and the draws of a frame.

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
  bool kept = false;  ///< a larger buffer keeps this one's content; it can be copied from and to
  VkFormat texels = VK_FORMAT_R32_UINT;

  [[nodiscard]] BufferDesc desc(MemoryKind kind) const { return {name, bytes, usage, kind, texels}; }
};

/// All buffers whose size follows a count.
struct BufferSizes {
  std::vector<BufferSize> items;  ///< about ten, and six for each view

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

  /// Bytes that reserve allocates at once. needed: all buffers of a kind
  [[nodiscard]] std::uint64_t reserve_bytes(const BufferSizes& needed) const;
  /// Creates the buffers that must become larger. errors  out_of_memory, device_lost, unsupported: more than the device binds; nothing has
  /// changed
  Result<void> reserve(const BufferSizes& needed);
  /// Forgets buffers that are destroyed without a successor.
  void forget(const BufferSizes& gone);
  /// Replaces smaller buffers by larger ones. True if there were any
  bool replace(Uploads& uploads, DeferredDeletion& deletion);

 private:
  struct Larger {
    BufferSize size;
    Buffer buffer;
  };
  [[nodiscard]] bool grows(const BufferSize& size) const;

  Device& device_;
  std::vector<Larger> larger_;  ///< one for each buffer that grows, about ten
};

}  // namespace coppice::gpu
