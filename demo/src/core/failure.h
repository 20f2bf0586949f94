#pragma once

#include <stdexcept>
#include <string>

#include <vulkan/vulkan_core.h>

namespace forest {

/// Anything that ends the program with one line and exit code 1. The demo is an application: it may throw, the library may not.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The result's name, of those that a driver gives for something that the user can change; else its number.
std::string result_text(VkResult result);

/// Throws a Failure that names the call unless it succeeded. VK_SUBOPTIMAL_KHR and other positive results pass.
inline void check(VkResult result, const char* call) {
  if (result < 0) throw Failure(std::string(call) + " failed: " + result_text(result));
}

}  // namespace forest
