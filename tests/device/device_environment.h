#pragma once

// Variables under which a process has limits_layer above its driver.

#include <cstdlib>
#include <string>
#include <vector>

#include "places.h"

namespace coppice::test {

/// NAME=VALUE. row  a name in device_rows.h; fill  of COPPICE_TEST_FILL, null for none
/// The validation layer stands above this one, so that it holds the program to the device's limits.
inline std::vector<std::string> environment_of_device(const std::string& row, const char* fill = nullptr) {
  const char* folders = std::getenv("XDG_DATA_DIRS");
  std::vector<std::string> variables{
      "XDG_DATA_DIRS=" + std::string(kDeviceLayer) + ":" +
          (folders != nullptr && *folders != '\0' ? folders : "/usr/local/share:/usr/share"),
      "VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation:VK_LAYER_COPPICE_limits",
      "COPPICE_TEST_DEVICE=" + row,
      // The same order of work in each process, so that equal pictures have equal bytes.
      "LP_NUM_THREADS=1",
  };
  if (fill != nullptr) variables.push_back(std::string("COPPICE_TEST_FILL=") + fill);
  return variables;
}

}  // namespace coppice::test
