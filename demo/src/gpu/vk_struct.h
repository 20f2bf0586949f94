#pragma once

#include <vulkan/vulkan_core.h>

namespace forest {

/// A Vulkan struct with its type set and everything else zero.
template <class T>
T vk_struct(VkStructureType type) {
  T value{};
  value.sType = type;
  return value;
}

}  // namespace forest
