#pragma once

// Time stamps between the passes of a frame, read back once the GPU has finished it. A stamp waits for all commands before it, so a frame
// with stamps takes longer than one without.

#include <array>
#include <cstdint>

#include "device.h"
#include "result.h"

namespace coppice::gpu {

enum class Pass : std::uint32_t { upload, cull, splats, leaves, tiles, count };

class GpuTimer {
 public:
  /// errors  out_of_memory
  Result<void> create(Device& device);
  void destroy(const Device& device);
  [[nodiscard]] bool exists() const { return pool_ != VK_NULL_HANDLE; }

  /// Uses a free set of stamps for the frame, if there is one. Outside a render pass, before the frame's first mark.
  void begin(const Device& device, VkCommandBuffer cmd, std::uint64_t frame, std::uint64_t completed_frame);
  /// Assigns the time since the last mark, or since begin, to `pass`.
  void mark(const Device& device, VkCommandBuffer cmd, Pass pass);
  /// Reads the stamps of the newest completed frame; on failure the times do not change.
  void collect(Device& device, std::uint64_t completed_frame);

  /// Milliseconds of each pass in that frame; 0 before the first.
  [[nodiscard]] const std::array<float, static_cast<std::size_t>(Pass::count)>& pass_ms() const { return pass_ms_; }

 private:
  static constexpr std::uint32_t kSlots = 4;
  static constexpr std::uint32_t kMarks = 64;
  struct Slot {
    std::uint64_t frame = 0;  ///< 0: free
    std::uint32_t mark_count = 0;
    std::array<Pass, kMarks> passes{};
  };
  void stamp(const Device& device, VkCommandBuffer cmd);

  VkQueryPool pool_ = VK_NULL_HANDLE;
  float tick_ns_ = 1.0f;
  std::array<Slot, kSlots> slots_;
  std::uint32_t current_ = kSlots;  ///< kSlots: the frame has no stamps
  std::array<float, static_cast<std::size_t>(Pass::count)> pass_ms_{};
};

}  // namespace coppice::gpu
