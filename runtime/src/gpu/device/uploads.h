#pragma once

// Copies to the GPU: the staging ring, and the copies that a frame's upload records.

#include <cstdint>
#include <deque>
#include <span>

#include "bounded_list.h"
#include "deferred_deletion.h"
#include "hooks.h"

namespace coppice::gpu {

/// A ring of mapped, coherent memory. A copy that does not fit gets a buffer of its own, which is deleted after the frame. That happens for
/// a first upload of many instances, not in the steady state.
///
/// Copies run in the order: moves, copies, patches; each kind may overwrite the results of the one before.
class Uploads {
 public:
  /// The ring has a contiguous run of this size while little of it is in use.
  static constexpr std::uint64_t kSliceBytes = 3ull << 20;

  /// device, deletion: outlive this object
  Uploads(Device& device, DeferredDeletion& deletion, const coppice_allocator& allocator)
      : device_(device), deletion_(deletion), allocator_(allocator) {}
  /// errors  out_of_memory, device_lost
  Result<void> create();
  /// The GPU must be done with everything.
  ~Uploads() { destroy_buffer(device_, ring_); }
  Uploads(const Uploads&) = delete;
  Uploads& operator=(const Uploads&) = delete;

  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  /// The ring has space for slices of this size in total.
  [[nodiscard]] std::uint64_t room_bytes() const;

  // errors of the next four: out_of_memory, device_lost. offset: in the buffer
  /// Returns the address to write the bytes to; they are copied from there.
  Result<std::uint8_t*> copy(std::uint64_t bytes, const Buffer& to, std::uint64_t offset);
  Result<void> copy(std::span<const std::uint8_t> bytes, const Buffer& to, std::uint64_t offset);
  Result<void> patch(std::span<const std::uint8_t> bytes, const Buffer& to, std::uint64_t offset);
  /// Copies texels to a texture that nothing has been copied to, or those that follow the last ones. texels: all mip levels, largest first.
  /// at: bytes that have been copied. Returns how many have then: whole rows of at most max_bytes, but at least one row
  Result<std::uint64_t> fill(const Texture& texture, std::span<const std::uint8_t> texels, std::uint64_t at, std::uint64_t max_bytes);
  /// Copies the content of a buffer to its successor, as far as that goes.
  void move(const Buffer& from, const Buffer& to);

  /// The progress of a frame's copies.
  struct Mark {
    std::size_t copies = 0, patches = 0, fills = 0;
  };
  [[nodiscard]] Mark mark() const { return {copies_.count, patches_.count, fills_.count}; }
  /// Cancels all copies since the mark.
  void undo(const Mark& mark);

  /// Records all copies. The caller records barriers before and after.
  void record(VkCommandBuffer cmd);

 private:
  struct Slice {
    VkBuffer buffer = VK_NULL_HANDLE;
    std::uint64_t offset = 0;
    std::uint8_t* data = nullptr;  ///< aligned to 16
  };
  struct Copy {
    VkBuffer from, to;
    VkBufferCopy region;
  };
  struct Fill {
    VkBuffer from;
    std::uint64_t offset;  ///< in `from`
    Texture texture;
    std::uint64_t first_texel, end_texel;  ///< bytes of the texture, all levels in a row
    bool last;                             ///< it is whole then
  };
  struct RingMark {
    std::uint64_t frame, head;
  };
  static constexpr std::size_t kMaxMoves = 16;  ///< maximum of buffers that grow in a frame

  Result<Slice> stage(std::uint64_t bytes);
  void record_copies(VkCommandBuffer cmd, std::span<Copy> copies);
  void record_fill(VkCommandBuffer cmd, const Fill& fill);

  Device& device_;
  DeferredDeletion& deletion_;
  coppice_allocator allocator_;
  Buffer ring_;
  std::uint64_t head_ = 0, tail_ = 0;  ///< grow for ever; the place in the ring is the remainder
  std::deque<RingMark> marks_;         ///< one for each frame that the GPU has not finished
  std::uint64_t frame_ = 0;
  BoundedList<Copy> moves_, copies_, patches_;
  BoundedList<Fill> fills_;
};

template <class T>
std::span<const std::uint8_t> bytes_of(std::span<const T> values) {
  return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()};
}

/// Records a copy of host memory as it is now, for data that changes in every frame. bytes: a multiple of 4
void update_buffer(const Device& device, VkCommandBuffer cmd, const Buffer& buffer, std::span<const std::uint8_t> bytes);

}  // namespace coppice::gpu
