#pragma once

// The process's device with calls that fail when a test says so: every Vulkan call of the runtime that returns a VkResult is counted and
// may return an error instead of being made. Also counts the objects that are alive.

#include <cstdint>
#include <string>
#include <vector>

#include "coppice/vulkan.h"

namespace coppice::test {

/// Faults for all contexts that were created with failing_device's desc. One thread at a time.
struct DeviceFaults {
  static constexpr std::uint64_t kNever = ~std::uint64_t{0};

  std::vector<std::string> calls;  ///< names of those that could have failed, in order
  std::uint64_t fail_at = kNever;  ///< index of the call that returns `result`
  bool for_good = false;           ///< and all calls behind it
  VkResult result = VK_SUCCESS;
  std::string failed_call;        ///< name of the first one; empty: none was reached
  std::int64_t live_objects = 0;  ///< created and not destroyed
  std::string missing;            ///< name of a function that the loader does not have
};

DeviceFaults& device_faults();
/// Starts anew, but for live_objects.
void reset_device_faults();

/// A software driver takes most of a run's time to compile pipelines: those of a context are, but in name, those of the first context that
/// made them from the same shaders and constants. Their descs must be alike. Before the device goes:
void destroy_shared_pipelines();

/// Sends the context's Vulkan calls through the faults.
void fail_with_device_faults(coppice_vulkan_desc& desc);

}  // namespace coppice::test
