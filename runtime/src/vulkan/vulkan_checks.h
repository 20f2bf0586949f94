#pragma once

// Checks arguments of vulkan.h, as api_checks.h does for coppice.h.

#include <string>

#include "coppice/vulkan.h"

namespace coppice {

std::string vulkan_problem(const coppice_vulkan_desc& vulkan);
std::string device_memory_problem(const coppice_device_memory& hook);
/// The content of color_formats[i]; COPPICE_CONTENT_DEFAULT if it must be set.
coppice_content content_of(coppice_output output, const coppice_vulkan_view_desc& desc, std::uint32_t i);
std::string vulkan_view_problem(const coppice_view_desc& view, const coppice_vulkan_view_desc& desc);

/// Checks light.shadow_maps: not null if there are any, and of our size
std::string light_problem(const coppice_light& light);
std::string triangles_problem(const coppice_triangles& triangles);
std::string override_problem(const coppice_material_override& material_override);

}  // namespace coppice
