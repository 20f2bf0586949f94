#include "vulkan_checks.h"

#include "api_fields.h"

namespace coppice {
namespace {

constexpr float kMaxRadiance = 1e9f;
constexpr float kMaxFogDensity = 1e6f;

std::string map_problem(const coppice_shadow_map& map) {
  if (map.image == VK_NULL_HANDLE) return "image is null";
  if (std::string problem = double_problem("clip_from_world", map.clip_from_world, double{kMaxMatrix}); !problem.empty()) return problem;
  return determinant(map.clip_from_world) == 0.0 ? "clip_from_world has no inverse" : "";
}

}  // namespace

std::string vulkan_problem(const coppice_vulkan_desc& vulkan) {
  if (vulkan.instance == VK_NULL_HANDLE) return "instance is null";
  if (vulkan.physical_device == VK_NULL_HANDLE) return "physical_device is null";
  if (vulkan.device == VK_NULL_HANDLE) return "device is null";
  if (vulkan.get_instance_proc_addr == nullptr) return "get_instance_proc_addr is null";
  return first_of(flag_problem("texture_compression_bc", vulkan.texture_compression_bc),
                  flag_problem("compute_raster", vulkan.compute_raster), flag_problem("shader_int64_atomics", vulkan.shader_int64_atomics),
                  flag_problem("pass_times", vulkan.pass_times), flag_problem("blocking_pipelines", vulkan.blocking_pipelines),
                  reserved_problem(vulkan.reserved));
}

std::string device_memory_problem(const coppice_device_memory& hook) {
  return (hook.allocate == nullptr) != (hook.free == nullptr) ? "one of allocate, free is null" : "";
}

std::string vulkan_view_problem(const coppice_view_desc& view, const coppice_vulkan_view_desc& desc) {
  const std::size_t color_count = view.output == COPPICE_OUTPUT_LIT ? 1 : 0;
  for (std::size_t i = 0; i < std::size(desc.color_formats); ++i) {
    const std::string name = "color_formats[" + std::to_string(i) + "]";
    if (i < color_count && desc.color_formats[i] == VK_FORMAT_UNDEFINED) return name + " is not set";
    if (i >= color_count && desc.color_formats[i] != VK_FORMAT_UNDEFINED)
      return name + " is set, and desc.output is " + (color_count == 0 ? "COPPICE_OUTPUT_DEPTH" : "COPPICE_OUTPUT_LIT: there is one");
  }
  if (desc.depth_format == VK_FORMAT_UNDEFINED) return "depth_format is not set";
  if (desc.depth_compare != VK_COMPARE_OP_LESS && desc.depth_compare != VK_COMPARE_OP_LESS_OR_EQUAL &&
      desc.depth_compare != VK_COMPARE_OP_GREATER && desc.depth_compare != VK_COMPARE_OP_GREATER_OR_EQUAL)
    return "depth_compare is none of LESS, LESS_OR_EQUAL, GREATER and GREATER_OR_EQUAL";
  if (std::string problem = flag_problem("has_stencil", desc.has_stencil); !problem.empty()) return problem;
  if (desc.samples == 0 || (desc.samples & (desc.samples - 1)) != 0) return "samples is not one VkSampleCountFlagBits";
  return {};
}

std::string light_problem(const coppice_light& light) {
  const Field fields[] = {{"sun_color", light.sun_color, 0.0f, kMaxRadiance},
                          {"sky_color", light.sky_color, 0.0f, kMaxRadiance},
                          {"ground_color", light.ground_color, 0.0f, kMaxRadiance},
                          {"fog_color", light.fog_color, 0.0f, kMaxRadiance},
                          {"fog_density", {&light.fog_density, 1}, 0.0f, kMaxFogDensity}};
  if (std::string problem = range_problem(fields); !problem.empty()) return problem;
  if (std::string problem = unit_problem("sun_direction", light.sun_direction); !problem.empty()) return problem;
  if (light.shadow_map_count > COPPICE_MAX_SHADOW_MAPS) return "shadow_map_count is above COPPICE_MAX_SHADOW_MAPS";
  for (std::uint32_t i = 0; i < light.shadow_map_count; ++i)
    if (const std::string problem = map_problem(light.shadow_maps[i]); !problem.empty())
      return "shadow_maps[" + std::to_string(i) + "]." + problem;
  return {};
}

}  // namespace coppice
