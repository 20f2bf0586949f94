#include "failure.h"

namespace forest {

std::string result_text(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of the device's memory";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "the driver could not be started";
    case VK_ERROR_DEVICE_LOST:
      return "the device was lost: its driver gave up, or it was taken away";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "an extension is not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "no driver fits";
    case VK_ERROR_SURFACE_LOST_KHR:
      return "the window's surface was lost";
    default:
      return "VkResult " + std::to_string(result);
  }
}

}  // namespace forest
