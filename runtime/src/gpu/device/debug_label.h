#pragma once

// Labels of commands and names of objects for graphics debuggers. Does nothing if the engine has not enabled VK_EXT_debug_utils.

#include "device.h"

namespace coppice::gpu {

/// Labels the commands that are recorded during its lifetime. name: static storage
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

/// Any thread, before another thread gets the object. handle: of that type, or null; name: copied
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
