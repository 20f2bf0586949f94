#pragma once

// Buffers whose size follows a count. A buffer is replaced by a larger or a smaller one in the next upload only, so nothing is replaced
// between the upload and the draws of a frame.

#include <cstdint>
#include <span>
#include <vector>

#include "uploads.h"

namespace coppice::gpu {

struct BufferSize {
  Buffer* buffer = nullptr;
  const char* name = "";    ///< static storage
  std::uint64_t bytes = 0;  ///< 0: not needed
  VkBufferUsageFlags usage = 0;
  bool kept = false;  ///< its successor keeps this one's content; it can be copied from and to
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
  /// Bytes that are free some frames after shrink().
  [[nodiscard]] std::uint64_t excess_bytes(const BufferSizes& needed) const;
  /// Creates smaller buffers for those that are larger than needed; they may exceed the budget until the larger ones are gone, if that is
  /// exceeded already. False if memory is short: try again in the next frame
  [[nodiscard]] bool shrink(const BufferSizes& needed);
  /// Forgets buffers that are destroyed without a successor.
  void forget(const BufferSizes& gone);
  /// Replaces buffers by their successors. True if there were any
  bool replace(Uploads& uploads, DeferredDeletion& deletion);

 private:
  struct Successor {
    BufferSize size;
    Buffer buffer;  ///< none: it is given back
  };
  /// A buffer, or its successor.
  [[nodiscard]] const Buffer& latest(const BufferSize& size) const;
  /// needed: only those that change
  Result<void> make(const BufferSizes& needed);

  Device& device_;
  std::vector<Successor> successors_;  ///< one for each buffer that changes, about ten
};

}  // namespace coppice::gpu
