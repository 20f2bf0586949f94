#pragma once

// What an engine may pass to vulkan.h, as api_checks.h.

#include <string>

#include "coppice/vulkan.h"

namespace coppice {

std::string vulkan_problem(const coppice_vulkan_desc& vulkan);
std::string device_memory_problem(const coppice_device_memory& hook);
/// What color_formats[i] gets; COPPICE_CONTENT_DEFAULT where that has to be said.
coppice_content content_of(coppice_output output, const coppice_vulkan_view_desc& desc, std::uint32_t i);
std::string vulkan_view_problem(const coppice_view_desc& view, const coppice_vulkan_view_desc& desc);

/// light.shadow_maps: not null where there are any, of our size
std::string light_problem(const coppice_light& light);

}  // namespace coppice
