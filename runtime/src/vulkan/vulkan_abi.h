#pragma once

// The defaults of the structs of vulkan.h; see abi.h.

#include "abi.h"
#include "coppice/vulkan.h"

namespace coppice {

template <>
coppice_vulkan_desc struct_defaults();
template <>
coppice_vulkan_view_desc struct_defaults();
template <>
coppice_light struct_defaults();

}  // namespace coppice
