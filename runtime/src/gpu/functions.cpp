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
  return functions;
}

}  // namespace coppice::gpu
