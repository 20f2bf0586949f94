#pragma once

#include <vulkan/vulkan_core.h>

#include "result.h"

namespace coppice::gpu {

#define COPPICE_INSTANCE_FUNCTIONS(X)    \
  X(vkGetDeviceProcAddr)                 \
  X(vkGetPhysicalDeviceFeatures2)        \
  X(vkGetPhysicalDeviceFormatProperties) \
  X(vkGetPhysicalDeviceProperties)       \
  X(vkGetPhysicalDeviceProperties2)      \
  X(vkGetPhysicalDeviceMemoryProperties)

#define COPPICE_DEVICE_FUNCTIONS(X) \
  X(vkAllocateDescriptorSets)       \
  X(vkAllocateMemory)               \
  X(vkBindBufferMemory)             \
  X(vkBindImageMemory)              \
  X(vkCmdBindDescriptorSets)        \
  X(vkCmdBindIndexBuffer)           \
  X(vkCmdBindPipeline)              \
  X(vkCmdCopyBuffer)                \
  X(vkCmdCopyBufferToImage)         \
  X(vkCmdDispatch)                  \
  X(vkCmdDispatchIndirect)          \
  X(vkCmdDraw)                      \
  X(vkCmdDrawIndexedIndirect)       \
  X(vkCmdDrawIndexedIndirectCount)  \
  X(vkCmdFillBuffer)                \
  X(vkCmdPipelineBarrier2)          \
  X(vkCmdPushConstants)             \
  X(vkCmdResetQueryPool)            \
  X(vkCmdSetScissor)                \
  X(vkCmdSetViewport)               \
  X(vkCmdUpdateBuffer)              \
  X(vkCmdWriteTimestamp2)           \
  X(vkCreateBuffer)                 \
  X(vkCreateBufferView)             \
  X(vkCreateComputePipelines)       \
  X(vkCreateDescriptorPool)         \
  X(vkCreateDescriptorSetLayout)    \
  X(vkCreateGraphicsPipelines)      \
  X(vkCreateImage)                  \
  X(vkCreateImageView)              \
  X(vkCreatePipelineLayout)         \
  X(vkCreateQueryPool)              \
  X(vkCreateSampler)                \
  X(vkCreateShaderModule)           \
  X(vkDestroyBuffer)                \
  X(vkDestroyBufferView)            \
  X(vkDestroyDescriptorPool)        \
  X(vkDestroyDescriptorSetLayout)   \
  X(vkDestroyImage)                 \
  X(vkDestroyImageView)             \
  X(vkDestroyPipeline)              \
  X(vkDestroyPipelineLayout)        \
  X(vkDestroyQueryPool)             \
  X(vkDestroySampler)               \
  X(vkDestroyShaderModule)          \
  X(vkFreeMemory)                   \
  X(vkGetBufferDeviceAddress)       \
  X(vkGetBufferMemoryRequirements)  \
  X(vkGetImageMemoryRequirements)   \
  X(vkGetQueryPoolResults)          \
  X(vkMapMemory)                    \
  X(vkUpdateDescriptorSets)

// Functions of VK_EXT_debug_utils; null if the engine has not enabled it.
#define COPPICE_DEBUG_FUNCTIONS(X) \
  X(vkCmdBeginDebugUtilsLabelEXT)  \
  X(vkCmdEndDebugUtilsLabelEXT)    \
  X(vkSetDebugUtilsObjectNameEXT)

/// The Vulkan functions of one device. We do not use volk, because its names are globals of the program: an engine with its own copy of
/// volk would clash with one in this library.
struct Functions {
#define COPPICE_DECLARE(name) PFN_##name name = nullptr;
  COPPICE_INSTANCE_FUNCTIONS(COPPICE_DECLARE)
  COPPICE_DEVICE_FUNCTIONS(COPPICE_DECLARE)
  COPPICE_DEBUG_FUNCTIONS(COPPICE_DECLARE)
#undef COPPICE_DECLARE
};

/// errors  unsupported: a function is missing, with its name
Result<Functions> load_functions(PFN_vkGetInstanceProcAddr get_instance_proc_addr, VkInstance instance, VkDevice device);

/// Returns functions that neither allocate nor map memory, to measure the memory that buffers and images need. Those may be created and
/// destroyed, and nothing else.
Functions without_memory(Functions functions);

}  // namespace coppice::gpu
