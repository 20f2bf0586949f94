#pragma once

#include <array>
#include <cstdint>

#include "device.h"
#include "handle.h"

namespace forest {

struct FrameSlot {
  Handle<VkCommandPool> pool;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  Handle<VkSemaphore> acquired;  ///< binary: the swapchain image is free
};

/// Frames in flight. A timeline semaphore counts finished frames, so its value is what coppice_frame::completed_number wants.
struct FrameRing {
  static constexpr std::size_t kSlots = 2;
  std::array<FrameSlot, kSlots> slots;
  Handle<VkSemaphore> timeline;
  std::uint64_t number = 0;     ///< number of the frame being recorded, from 1 on
  std::uint64_t submitted = 0;  ///< the latest frame that was submitted

  [[nodiscard]] std::size_t slot_index() const { return number % kSlots; }
};

FrameRing create_frame_ring(const Device& device);
// Waits go on for as long as wait_patiently has it.

/// Waits until the slot's previous frame has finished, then starts recording the next frame.
FrameSlot& begin_frame(const Device& device, FrameRing& ring);
/// present_from, present_to: the slot's `acquired` and the image's `rendered` semaphores; null without a swapchain.
void submit_frame(const Device& device, FrameRing& ring, VkSemaphore present_from, VkSemaphore present_to);
std::uint64_t completed_frame(const Device& device, const FrameRing& ring);
/// Blocks until every submitted frame has finished.
void wait_for_frames(const Device& device, const FrameRing& ring);
/// The same, of a device that may be lost; afterwards it may be destroyed.
void finish_frames(const Device& device, const FrameRing& ring) noexcept;

}  // namespace forest
