#pragma once

// Variables under which a process has limits_layer above its driver.

#include <cstdlib>
#include <string>
#include <vector>

#include "places.h"

namespace coppice::test {

/// row  a name in device_rows.h; more  NAME=VALUE, further variables of the layer
/// The validation layer stands above this one, so that it holds the program to the device's limits.
inline std::vector<std::string> environment_of_device(const std::string& row, const std::vector<std::string>& more = {}) {
  const char* folders = std::getenv("XDG_DATA_DIRS");
  std::vector<std::string> variables = more;
  // The loader stacks layers in the order in which it finds them, whatever that of VK_INSTANCE_LAYERS.
  variables.push_back(std::string("XDG_DATA_DIRS=") + (folders != nullptr && *folders != '\0' ? folders : "/usr/local/share:/usr/share") +
                      ":" + kDeviceLayer);
  variables.emplace_back("VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation:VK_LAYER_COPPICE_limits");
  variables.push_back("COPPICE_TEST_DEVICE=" + row);
  // The same order of work in each process, so that equal pictures have equal bytes.
  variables.emplace_back("LP_NUM_THREADS=1");
  return variables;
}

}  // namespace coppice::test
