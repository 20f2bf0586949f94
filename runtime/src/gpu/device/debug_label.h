#pragma once

// What a graphics debugger shows: labels round what is recorded, and names of objects. Nothing where the engine has not enabled
// VK_EXT_debug_utils.

#include "device.h"

namespace coppice::gpu {

/// What is recorded while it lives is under the label. name: static storage
class DebugLabel {
 public:
  DebugLabel(const Device& device, VkCommandBuffer cmd, const char* name) : device_(device), cmd_(cmd) {
    if (device_.vk.vkCmdBeginDebugUtilsLabelEXT == nullptr) return;
    const VkDebugUtilsLabelEXT label{.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, .pLabelName = name};
    device_.vk.vkCmdBeginDebugUtilsLabelEXT(cmd_, &label);
  }
  ~DebugLabel() {
    if (device_.vk.vkCmdEndDebugUtilsLabelEXT != nullptr) device_.vk.vkCmdEndDebugUtilsLabelEXT(cmd_);
  }
  DebugLabel(const DebugLabel&) = delete;
  DebugLabel& operator=(const DebugLabel&) = delete;

 private:
  const Device& device_;
  VkCommandBuffer cmd_;
};

/// Any thread, before another has the object. handle: of that type, or null; name: copied
template <class Handle>
void name_object(const Device& device, VkObjectType type, Handle handle, const char* name) {
  if (device.vk.vkSetDebugUtilsObjectNameEXT == nullptr || handle == VK_NULL_HANDLE) return;
  const VkDebugUtilsObjectNameInfoEXT info{.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                           .objectType = type,
                                           .objectHandle = reinterpret_cast<std::uint64_t>(handle),
                                           .pObjectName = name};
  device.vk.vkSetDebugUtilsObjectNameEXT(device.device, &info);
}

}  // namespace coppice::gpu
