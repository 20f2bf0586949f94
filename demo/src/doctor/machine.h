#pragma once

#include <string>
#include <vector>

#include <volk.h>

namespace forest {

/// Something that Coppice asks of a device, and whether it has it.
struct Need {
  std::string name;
  bool needed = false;  ///< else wanted: Coppice goes on without
  bool there = false;
  const char* without;  ///< what then happens
};

/// What the table of runtime/README.md has, and timelineSemaphore, which coppice-forest needs.
std::vector<Need> needs_of(VkPhysicalDevice device);
/// Its name, its kind, its versions: a line.
std::string describe(VkPhysicalDevice device);

}  // namespace forest
