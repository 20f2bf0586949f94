#pragma once

// Functions of a test that a context calls instead of the device's own.

#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "coppice/vulkan.h"
#include "vulkan_device.h"

namespace coppice::test {

/// By name; a null one is missing.
using ReplacedFunctions = std::map<std::string, PFN_vkVoidFunction>;

template <class Function>
std::pair<const std::string, PFN_vkVoidFunction> replacing(const char* name, Function* function) {
  return {name, reinterpret_cast<PFN_vkVoidFunction>(function)};
}

/// Those of the desc that was last given some: contexts ask for them while they are created.
inline ReplacedFunctions& replaced_functions() {
  static ReplacedFunctions replaced;
  return replaced;
}

namespace replaced {

inline VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_device(VkDevice device, const char* name) {
  const auto found = replaced_functions().find(name);
  return found == replaced_functions().end() ? vkGetDeviceProcAddr(device, name) : found->second;
}

inline VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_instance(VkInstance instance, const char* name) {
  const auto found = replaced_functions().find(name);
  if (found != replaced_functions().end()) return found->second;
  return std::string_view(name) == "vkGetDeviceProcAddr" ? reinterpret_cast<PFN_vkVoidFunction>(of_device)
                                                         : vkGetInstanceProcAddr(instance, name);
}

}  // namespace replaced

/// For contexts of this desc, which may have been given others before; those of other descs are forgotten.
inline void replace_functions(coppice_vulkan_desc& desc, const ReplacedFunctions& functions) {
  if (desc.get_instance_proc_addr != replaced::of_instance) replaced_functions().clear();
  desc.get_instance_proc_addr = replaced::of_instance;
  for (const auto& [name, function] : functions) replaced_functions()[name] = function;
}

}  // namespace coppice::test
