#include "vulkan_functions.h"

#include <string>

#include <volk.h>

namespace coppice::bake {

Result<PFN_vkGetInstanceProcAddr> load_vulkan() {
  // volk knows the loader's name on each system. Nothing else of it is used.
  if (volkInitialize() == VK_SUCCESS) return vkGetInstanceProcAddr;
  return Error{Status::unsupported,
               "--areas vulkan needs Vulkan, and no Vulkan loader is installed: install a Vulkan driver (Debian: apt-get install "
               "mesa-vulkan-drivers), or leave out --areas"};
}

Result<void> load_instance_functions(PFN_vkGetInstanceProcAddr get, VkInstance instance, VulkanFunctions& vk) {
#define COPPICE_LOAD(name)                                      \
  vk.name = reinterpret_cast<PFN_##name>(get(instance, #name)); \
  if (vk.name == nullptr) return Error{Status::unsupported, "a Vulkan function is missing", Error::kNoOffset, #name};
  COPPICE_AREA_INSTANCE_FUNCTIONS(COPPICE_LOAD)
#undef COPPICE_LOAD
  return {};
}

Result<void> load_device_functions(VkDevice device, VulkanFunctions& vk) {
#define COPPICE_LOAD(name)                                                       \
  vk.name = reinterpret_cast<PFN_##name>(vk.vkGetDeviceProcAddr(device, #name)); \
  if (vk.name == nullptr) return Error{Status::unsupported, "a Vulkan function is missing", Error::kNoOffset, #name};
  COPPICE_AREA_DEVICE_FUNCTIONS(COPPICE_LOAD)
#undef COPPICE_LOAD
  return {};
}

Result<void> check_vulkan(VkResult result, const char* call) {
  switch (result) {
    case VK_SUCCESS:
      return {};
    case VK_TIMEOUT:
      return Error{Status::device_lost, "the Vulkan device hangs while it measures areas", Error::kNoOffset, call};
    case VK_ERROR_DEVICE_LOST:
      return Error{Status::device_lost, "the Vulkan device was lost while it measured areas", Error::kNoOffset, call};
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return Error{Status::out_of_memory, "the Vulkan device has not enough memory to measure areas", Error::kNoOffset, call};
    default:
      return Error{Status::internal, "Vulkan failed", Error::kNoOffset, std::string(call) + " returned VkResult " + std::to_string(result)};
  }
}

}  // namespace coppice::bake
