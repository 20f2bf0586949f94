#pragma once

// The figures of a device's row beside a driver's own.

#include <algorithm>
#include <functional>
#include <string_view>

#include <vulkan/vulkan_core.h>

#include "device_rows.h"

namespace coppice::test {

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
