#include "vulkan_checks.h"

#include <algorithm>
#include <array>

#include "api_fields.h"

namespace coppice {
namespace {

constexpr float kMaxRadiance = 1e9f;
constexpr float kMaxFogDensity = 1e6f;
constexpr float kMaxParameter = 1e9f;
constexpr std::int32_t kMaxOccluderOffset_px = 65536;

std::string map_problem(const coppice_shadow_map& map) {
  if (map.image == VK_NULL_HANDLE) return "image is null";
  if (std::string problem = double_problem("clip_from_world", map.clip_from_world, double{kMaxMatrix}); !problem.empty()) return problem;
  return determinant(map.clip_from_world) == 0.0 ? "clip_from_world has no inverse" : "";
}

std::string occluder_problem(const coppice_occluder& occluder) {
  if (occluder.image == VK_NULL_HANDLE) return "image is null";
  const auto is_far = [](std::int32_t px) { return px < -kMaxOccluderOffset_px || px > kMaxOccluderOffset_px; };
  if (is_far(occluder.x_px)) return "x_px is beyond 65536";
  if (is_far(occluder.y_px)) return "y_px is beyond 65536";
  return reserved_problem(occluder.reserved);
}

std::string color_problem(coppice_output output, const coppice_vulkan_view_desc& desc, std::uint32_t i) {
  const auto is_set = [&](std::uint32_t color) { return desc.color_formats[color] != VK_FORMAT_UNDEFINED; };
  const std::string at = "[" + std::to_string(i) + "]";
  if (desc.contents[i] < COPPICE_CONTENT_DEFAULT || desc.contents[i] > COPPICE_CONTENT_NONE)
    return "contents" + at + " is not a coppice_content";
  if (!is_set(i)) return {};
  if (output == COPPICE_OUTPUT_DEPTH) return "color_formats" + at + " is set, and desc.output is COPPICE_OUTPUT_DEPTH";
  if (i > 0 && !is_set(i - 1)) return "color_formats" + at + " is set, and the one before is not";
  return content_of(output, desc, i) == COPPICE_CONTENT_DEFAULT ? "contents" + at + " is not set, and has no default" : "";
}

}  // namespace

coppice_content content_of(coppice_output output, const coppice_vulkan_view_desc& desc, std::uint32_t i) {
  if (desc.contents[i] != COPPICE_CONTENT_DEFAULT) return desc.contents[i];
  if (output == COPPICE_OUTPUT_LIT) return i == 0 ? COPPICE_CONTENT_LIT : COPPICE_CONTENT_DEFAULT;
  constexpr std::array kSurface{COPPICE_CONTENT_ALBEDO, COPPICE_CONTENT_NORMAL, COPPICE_CONTENT_LIGHT, COPPICE_CONTENT_USER,
                                COPPICE_CONTENT_VELOCITY};
  return i < kSurface.size() ? kSurface[i] : COPPICE_CONTENT_DEFAULT;
}

namespace {

std::string queues_problem(const coppice_vulkan_desc& vulkan) {
  const std::uint32_t count = vulkan.queue_family_count;
  if (count == 1 || count > COPPICE_MAX_QUEUE_FAMILIES) return "queue_family_count is none of 0, 2 and 3";
  for (std::uint32_t i = 0; i < count; ++i)
    if (std::find(vulkan.queue_families, vulkan.queue_families + i, vulkan.queue_families[i]) != vulkan.queue_families + i)
      return "queue_families[" + std::to_string(i) + "] is there twice";
  return {};
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
                  flag_problem("draw_indirect_count", vulkan.draw_indirect_count), queues_problem(vulkan));
}

std::string device_memory_problem(const coppice_device_memory& hook) {
  return (hook.allocate == nullptr) != (hook.free == nullptr) ? "one of allocate, free is null" : "";
}

std::string vulkan_view_problem(const coppice_view_desc& view, const coppice_vulkan_view_desc& desc) {
  const bool colors = view.output != COPPICE_OUTPUT_DEPTH;
  if (colors && desc.color_formats[0] == VK_FORMAT_UNDEFINED) return "color_formats[0] is not set";
  for (std::uint32_t i = 0; i < COPPICE_MAX_COLORS; ++i)
    if (std::string problem = color_problem(view.output, desc, i); !problem.empty()) return problem;
  if (desc.depth_format == VK_FORMAT_UNDEFINED) return "depth_format is not set";
  if (desc.depth_compare != VK_COMPARE_OP_LESS && desc.depth_compare != VK_COMPARE_OP_LESS_OR_EQUAL &&
      desc.depth_compare != VK_COMPARE_OP_GREATER && desc.depth_compare != VK_COMPARE_OP_GREATER_OR_EQUAL)
    return "depth_compare is none of LESS, LESS_OR_EQUAL, GREATER and GREATER_OR_EQUAL";
  if (std::string problem = flag_problem("has_stencil", desc.has_stencil); !problem.empty()) return problem;
  if (desc.subpass != 0 && desc.render_pass == VK_NULL_HANDLE) return "subpass is set, and render_pass is null";
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
  if (light.occluder == nullptr) return {};
  const std::string problem = occluder_problem(*light.occluder);
  return problem.empty() ? problem : "occluder." + problem;
}

std::string triangles_problem(const coppice_triangles& triangles) {
  if (!(triangles.leaf_count >= 0.0f)) return "leaf_count is below 0";
  if (triangles.positions % 4 != 0) return "positions is not a multiple of 4";
  return triangles.positions == 0 && triangles.triangle_capacity > 0 ? "positions is 0" : "";
}

std::string override_problem(const coppice_material_override& material_override) {
  const auto share_problem = [](const char* name, const float& share) {
    return share == -1.0f ? std::string() : range_problem({name, {&share, 1}, 0.0f, 1.0f});
  };
  const Field fields[] = {{"leaf_tint", material_override.leaf_tint, 0.0f, kMaxTint},
                          {"wood_tint", material_override.wood_tint, 0.0f, kMaxTint},
                          {"parameters", material_override.parameters, -kMaxParameter, kMaxParameter}};
  return first_of(range_problem(fields), share_problem("leaf_roughness", material_override.leaf_roughness),
                  share_problem("wood_roughness", material_override.wood_roughness),
                  share_problem("translucency", material_override.translucency));
}

}  // namespace coppice
