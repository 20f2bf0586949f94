#pragma once

// What goes to the GPU: the staging ring, and the copies that a frame's upload records.

#include <cstdint>
#include <deque>
#include <span>

#include "bounded_list.h"
#include "garbage.h"
#include "hooks.h"

namespace coppice::gpu {

/// A ring of mapped, coherent memory. What does not fit gets a buffer of its own, retired with the frame: a first upload of many instances
/// or a large texture, not the steady state.
///
/// Copies run in the order: moves, copies, patches; each kind may overwrite what the one before wrote.
class Uploads {
 public:
  /// There is a run of this in the ring while little of it is in use.
  static constexpr std::uint64_t kSliceBytes = 3ull << 20;

  /// device, garbage: outlive this object
  Uploads(Device& device, Garbage& garbage, const coppice_allocator& allocator)
      : device_(device), garbage_(garbage), allocator_(allocator) {}
  /// errors  out_of_memory, device_lost
  Result<void> create();
  /// The GPU must be done with everything.
  ~Uploads() { destroy_buffer(device_, ring_); }
  Uploads(const Uploads&) = delete;
  Uploads& operator=(const Uploads&) = delete;

  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  /// Slices of together so many bytes come out of the ring.
  [[nodiscard]] std::uint64_t room_bytes() const;

  // errors  out_of_memory, device_lost, of these four. offset: in the buffer
  /// Where to write so many bytes, which are copied.
  Result<std::uint8_t*> copy(std::uint64_t bytes, const Buffer& to, std::uint64_t offset);
  Result<void> copy(std::span<const std::uint8_t> bytes, const Buffer& to, std::uint64_t offset);
  Result<void> patch(std::span<const std::uint8_t> bytes, const Buffer& to, std::uint64_t offset);
  /// texels: of all mip levels, largest first
  Result<void> fill(const Texture& texture, std::span<const std::uint8_t> texels);
  /// The larger one begins with what the smaller holds.
  void move(const Buffer& smaller, const Buffer& larger);

  /// How far a frame's copies have come.
  struct Mark {
    std::size_t copies = 0, patches = 0, fills = 0;
  };
  [[nodiscard]] Mark mark() const { return {copies_.count, patches_.count, fills_.count}; }
  /// What was asked for since is not done.
  void undo(const Mark& mark);

  /// Records everything. The caller's barriers are before and after.
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
    std::uint64_t offset;
    Texture texture;
  };
  struct RingMark {
    std::uint64_t frame, head;
  };
  static constexpr std::size_t kMostMoves = 16;  ///< buffers that grow

  Result<Slice> stage(std::uint64_t bytes);
  void record_copies(VkCommandBuffer cmd, std::span<Copy> copies);
  void record_fill(VkCommandBuffer cmd, const Fill& fill);

  Device& device_;
  Garbage& garbage_;
  coppice_allocator allocator_;
  Buffer ring_;
  std::uint64_t head_ = 0, tail_ = 0;  ///< grow for ever; the place in the ring is the remainder
  std::deque<RingMark> marks_;         ///< one a frame that the GPU has not finished
  std::uint64_t frame_ = 0;
  BoundedList<Copy> moves_, copies_, patches_;
  BoundedList<Fill> fills_;
};

template <class T>
std::span<const std::uint8_t> bytes_of(std::span<const T> values) {
  return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()};
}

/// Records a copy from the host's memory as it is now, for what changes in every frame. bytes: a multiple of 4
void update_buffer(const Device& device, VkCommandBuffer cmd, const Buffer& buffer, std::span<const std::uint8_t> bytes);

}  // namespace coppice::gpu
