#include "functions.h"

namespace coppice::gpu {

Result<Functions> load_functions(PFN_vkGetInstanceProcAddr get_instance_proc_addr, VkInstance instance, VkDevice device) {
  Functions functions;
#define COPPICE_LOAD(name)                                                                \
  functions.name = reinterpret_cast<PFN_##name>(get_instance_proc_addr(instance, #name)); \
  if (!functions.name) return Error{Status::unsupported, "Vulkan function is missing", Error::kNoOffset, #name};
  COPPICE_INSTANCE_FUNCTIONS(COPPICE_LOAD)
#undef COPPICE_LOAD
#define COPPICE_LOAD(name)                                                                     \
  functions.name = reinterpret_cast<PFN_##name>(functions.vkGetDeviceProcAddr(device, #name)); \
  if (!functions.name) return Error{Status::unsupported, "Vulkan function is missing", Error::kNoOffset, #name};
  COPPICE_DEVICE_FUNCTIONS(COPPICE_LOAD)
#undef COPPICE_LOAD
// The instance is asked, because it knows whether its extension is enabled: a loader may answer for the device in any case.
#define COPPICE_LOAD(name) functions.name = reinterpret_cast<PFN_##name>(get_instance_proc_addr(instance, #name));
  COPPICE_DEBUG_FUNCTIONS(COPPICE_LOAD)
#undef COPPICE_LOAD
  return functions;
}

Functions without_memory(Functions functions) {
  functions.vkSetDebugUtilsObjectNameEXT = nullptr;  // without memory there are no objects to name
  functions.vkAllocateMemory = [](VkDevice, const VkMemoryAllocateInfo*, const VkAllocationCallbacks*, VkDeviceMemory* memory) {
    *memory = reinterpret_cast<VkDeviceMemory>(memory);  // any value but null
    return VK_SUCCESS;
  };
  functions.vkFreeMemory = [](VkDevice, VkDeviceMemory, const VkAllocationCallbacks*) {};
  functions.vkMapMemory = [](VkDevice, VkDeviceMemory, VkDeviceSize, VkDeviceSize, VkMemoryMapFlags, void** data) {
    static std::uint8_t nothing = 0;
    *data = &nothing;
    return VK_SUCCESS;
  };
  functions.vkBindBufferMemory = [](VkDevice, VkBuffer, VkDeviceMemory, VkDeviceSize) { return VK_SUCCESS; };
  functions.vkBindImageMemory = [](VkDevice, VkImage, VkDeviceMemory, VkDeviceSize) { return VK_SUCCESS; };
  functions.vkCreateBufferView = [](VkDevice, const VkBufferViewCreateInfo*, const VkAllocationCallbacks*, VkBufferView* view) {
    *view = VK_NULL_HANDLE;
    return VK_SUCCESS;
  };
  functions.vkCreateImageView = [](VkDevice, const VkImageViewCreateInfo*, const VkAllocationCallbacks*, VkImageView* view) {
    *view = VK_NULL_HANDLE;
    return VK_SUCCESS;
  };
  functions.vkCreateComputePipelines = [](VkDevice, VkPipelineCache, std::uint32_t, const VkComputePipelineCreateInfo*,
                                          const VkAllocationCallbacks*, VkPipeline* pipeline) {
    *pipeline = VK_NULL_HANDLE;
    return VK_SUCCESS;
  };
  functions.vkCreateGraphicsPipelines = [](VkDevice, VkPipelineCache, std::uint32_t, const VkGraphicsPipelineCreateInfo*,
                                           const VkAllocationCallbacks*, VkPipeline* pipeline) {
    *pipeline = VK_NULL_HANDLE;
    return VK_SUCCESS;
  };
  functions.vkGetBufferDeviceAddress = [](VkDevice, const VkBufferDeviceAddressInfo*) { return VkDeviceAddress{0}; };
  functions.vkUpdateDescriptorSets = [](VkDevice, std::uint32_t, const VkWriteDescriptorSet*, std::uint32_t, const VkCopyDescriptorSet*) {};
  return functions;
}

}  // namespace coppice::gpu
