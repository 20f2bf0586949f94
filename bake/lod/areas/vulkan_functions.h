#pragma once

// The Vulkan functions that measure areas. They are loaded on demand, so that the tool starts without Vulkan.

#include <vulkan/vulkan_core.h>

#include "result.h"

namespace coppice::bake {

#define COPPICE_AREA_INSTANCE_FUNCTIONS(X) \
  X(vkCreateDevice)                        \
  X(vkDestroyInstance)                     \
  X(vkEnumeratePhysicalDevices)            \
  X(vkGetDeviceProcAddr)                   \
  X(vkGetPhysicalDeviceFeatures2)          \
  X(vkGetPhysicalDeviceFormatProperties)   \
  X(vkGetPhysicalDeviceMemoryProperties)   \
  X(vkGetPhysicalDeviceProperties2)        \
  X(vkGetPhysicalDeviceQueueFamilyProperties)

#define COPPICE_AREA_DEVICE_FUNCTIONS(X) \
  X(vkAllocateCommandBuffers)            \
  X(vkAllocateMemory)                    \
  X(vkBeginCommandBuffer)                \
  X(vkBindBufferMemory)                  \
  X(vkBindImageMemory)                   \
  X(vkCmdBeginQuery)                     \
  X(vkCmdBeginRendering)                 \
  X(vkCmdBindPipeline)                   \
  X(vkCmdDraw)                           \
  X(vkCmdEndQuery)                       \
  X(vkCmdEndRendering)                   \
  X(vkCmdPipelineBarrier2)               \
  X(vkCmdPushConstants)                  \
  X(vkCmdResetQueryPool)                 \
  X(vkCmdSetScissor)                     \
  X(vkCmdSetViewport)                    \
  X(vkCreateBuffer)                      \
  X(vkCreateCommandPool)                 \
  X(vkCreateFence)                       \
  X(vkCreateGraphicsPipelines)           \
  X(vkCreateImage)                       \
  X(vkCreateImageView)                   \
  X(vkCreatePipelineLayout)              \
  X(vkCreateQueryPool)                   \
  X(vkCreateShaderModule)                \
  X(vkDestroyBuffer)                     \
  X(vkDestroyCommandPool)                \
  X(vkDestroyDevice)                     \
  X(vkDestroyFence)                      \
  X(vkDestroyImage)                      \
  X(vkDestroyImageView)                  \
  X(vkDestroyPipeline)                   \
  X(vkDestroyPipelineLayout)             \
  X(vkDestroyQueryPool)                  \
  X(vkDestroyShaderModule)               \
  X(vkEndCommandBuffer)                  \
  X(vkFreeMemory)                        \
  X(vkGetBufferDeviceAddress)            \
  X(vkGetBufferMemoryRequirements)       \
  X(vkGetDeviceQueue)                    \
  X(vkGetImageMemoryRequirements)        \
  X(vkGetQueryPoolResults)               \
  X(vkMapMemory)                         \
  X(vkQueueSubmit2)                      \
  X(vkResetCommandPool)                  \
  X(vkResetFences)                       \
  X(vkWaitForFences)

/// The functions of one instance and one device. They are no globals like volk's, which serve one device per program: tests have two.
struct VulkanFunctions {
#define COPPICE_DECLARE(name) PFN_##name name = nullptr;
  COPPICE_AREA_INSTANCE_FUNCTIONS(COPPICE_DECLARE)
  COPPICE_AREA_DEVICE_FUNCTIONS(COPPICE_DECLARE)
#undef COPPICE_DECLARE
};

/// Finds the loader of this system: libvulkan.so.1, vulkan-1.dll.
/// errors  unsupported: there is none
Result<PFN_vkGetInstanceProcAddr> load_vulkan();

/// errors  unsupported: a function is missing; the error names it
Result<void> load_instance_functions(PFN_vkGetInstanceProcAddr get, VkInstance instance, VulkanFunctions& vk);
Result<void> load_device_functions(VkDevice device, VulkanFunctions& vk);

/// call    the function's name
/// errors  device_lost, out_of_memory, internal
Result<void> check_vulkan(VkResult result, const char* call);

}  // namespace coppice::bake
