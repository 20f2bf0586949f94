#pragma once

// Devices of other people: what limits_layer reports in place of the driver's own figures.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include <vulkan/vulkan_core.h>

namespace coppice::test {

/// A figure of 0 and an empty list say nothing: the driver's own stays. Only what is stricter than the driver is reported.
struct DeviceRow {
  const char* name;
  const char* source;  ///< where limits and features come from
  VkPhysicalDeviceType type = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  std::uint32_t subgroup_size = 0;  ///< reported as it is; shaders run in the driver's own
  VkPhysicalDeviceLimits limits{};
  VkDeviceSize max_allocation_bytes = 0;
  std::vector<VkMemoryHeap> heaps;
  std::vector<VkMemoryType> types;
  std::uint32_t buffer_types = ~0u;        ///< a bit for each memory type that buffers and linear images may have
  std::uint32_t image_types = ~0u;         ///< likewise, of optimal images
  VkDeviceSize image_alignment_bytes = 1;  ///< where their memory begins; a power of two
  std::vector<const char*> missing_features;
  std::vector<const char*> missing_extensions;
};

/// The first is the driver as it is, but a discrete GPU: what pictures of the others are compared with.
const std::vector<DeviceRow>& device_rows();

/// Null: there is none of that name.
const DeviceRow* find_row(std::string_view name);

/// A row's 0 says nothing.
template <class Number>
void lower(Number& value, Number most) {
  if (most != 0) value = std::min(value, most);
}

void tighten(VkPhysicalDeviceLimits& limits, const DeviceRow& row);

/// driver  has one type. Without types of the row it stays.
VkPhysicalDeviceMemoryProperties tighten(const VkPhysicalDeviceMemoryProperties& driver, const DeviceRow& row);

/// Calls visit for each feature that the row lacks, wherever the chain has it. A row with a name that is no feature ends the program.
void for_each_missing(const DeviceRow& row, VkPhysicalDeviceFeatures2& chain,
                      const std::function<void(const char* name, VkBool32& enabled)>& visit);

bool lacks_extension(const DeviceRow& row, std::string_view name);

}  // namespace coppice::test
