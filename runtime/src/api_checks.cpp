#include "api_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <span>
#include <utility>

namespace coppice {
namespace {

// What lies beyond these is a mistake, and would overflow what is computed from it.
constexpr double kMaxPosition_m = 3.3e7;  // of numbers of cells
constexpr double kMaxCenter_m = 1e9;
constexpr double kMaxEye_m = 1e10;
constexpr float kMinRadius_m = 1e-6f, kMaxRadius_m = 1e8f;
constexpr float kMinScale = 1e-6f, kMaxScale = 1e6f;
constexpr float kMaxTint = 65504.0f;  // the largest half
constexpr float kMaxBias = 4.0f;
constexpr float kMaxRadiance = 1e9f;
constexpr float kMaxFogDensity = 1e6f;
constexpr float kMaxMatrix = 1e10f;
constexpr double kMaxCascade = 1e10;
constexpr float kMinFocal = 1e-6f, kMaxFocal = 1e6f;  // of clip_from_view
constexpr float kMaxError_px = 1e6f;
constexpr std::int32_t kMaxOffset_px = 1 << 20;
constexpr float kMaxPrefetchFrames = 1000.0f;
constexpr std::uint32_t kMaxPlants = 65536;
/// Of squared lengths and products of axes that should be 1 or 0.
constexpr float kUnitTolerance = 0.01f;

/// Numbers of a struct that share a range.
struct Field {
  const char* name;
  std::span<const float> values;
  float least, most;
};

std::string numbered(const Field& field, std::size_t index) {
  return field.values.size() == 1 ? field.name : std::string(field.name) + "[" + std::to_string(index) + "]";
}

std::string range_problem(const Field& field) {
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    const float value = field.values[i];
    if (value >= field.least && value <= field.most) continue;
    if (!std::isfinite(value)) return numbered(field, i) + " is not finite";
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), " is %g: outside %g to %g", static_cast<double>(value), static_cast<double>(field.least),
                  static_cast<double>(field.most));
    return numbered(field, i) + text.data();
  }
  return {};
}

std::string double_problem(const char* name, std::span<const double> values, double most) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::abs(values[i]) <= most) continue;
    const std::string field = std::string(name) + "[" + std::to_string(i) + "]";
    if (!std::isfinite(values[i])) return field + " is not finite";
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), " is %g: outside %g to %g", values[i], -most, most);
    return field + text.data();
  }
  return {};
}

template <std::size_t count>
std::string range_problem(const Field (&fields)[count]) {
  for (const Field& field : fields)
    if (std::string problem = range_problem(field); !problem.empty()) return problem;
  return {};
}

bool is_unit(std::span<const float> values) {
  float sum = 0;
  for (const float value : values) sum += value * value;
  return std::abs(sum - 1.0f) < kUnitTolerance;
}

/// Rotation, perhaps mirrored, and translation alone. m: finite, column-major
bool is_rigid(std::span<const double, 16> m) {
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 3; ++b) {
      double product = 0;
      for (std::size_t row = 0; row < 3; ++row) product += m[4 * a + row] * m[4 * b + row];
      if (!(std::abs(product - (a == b ? 1.0 : 0.0)) < kUnitTolerance)) return false;
    }
  return m[3] == 0.0 && m[7] == 0.0 && m[11] == 0.0 && m[15] == 1.0;
}

/// By the 2 x 2 minors of the first and the last two columns.
template <class T>
double determinant(const T& m) {
  const auto minor = [&](std::size_t column, std::size_t a, std::size_t b) {
    return double{m[4 * column + a]} * double{m[4 * column + 4 + b]} - double{m[4 * column + b]} * double{m[4 * column + 4 + a]};
  };
  return minor(0, 0, 1) * minor(2, 2, 3) - minor(0, 0, 2) * minor(2, 1, 3) + minor(0, 0, 3) * minor(2, 1, 2) +
         minor(0, 1, 2) * minor(2, 0, 3) - minor(0, 1, 3) * minor(2, 0, 2) + minor(0, 2, 3) * minor(2, 0, 1);
}

std::string projection_problem(std::span<const float, 16> m) {
  const bool perspective = m[11] < 0.0f && m[15] == 0.0f, parallel = m[11] == 0.0f && m[15] > 0.0f;
  if (m[3] != 0.0f || m[7] != 0.0f || !(perspective || parallel))
    return "clip_from_view is neither a perspective that looks down -z nor orthographic: its last row must be 0 0 -1 0 or 0 0 0 1";
  for (const std::size_t i : {std::size_t{0}, std::size_t{5}})
    if (!(std::abs(m[i]) >= kMinFocal && std::abs(m[i]) <= kMaxFocal))
      return "clip_from_view[" + std::to_string(i) + "] is a scale outside 1e-6 to 1e6";
  if (determinant(m) == 0.0) return "clip_from_view has no inverse";
  return {};
}

std::string map_problem(const coppice_shadow_map& map) {
  if (map.image == VK_NULL_HANDLE) return "image is null";
  if (std::string problem = double_problem("clip_from_world", map.clip_from_world, kMaxCascade); !problem.empty()) return problem;
  return determinant(map.clip_from_world) == 0.0 ? "clip_from_world has no inverse" : "";
}

std::string size_problem(const char* name, std::uint32_t value, std::uint32_t most) {
  if (value >= 1 && value <= most) return {};
  return std::string(name) + " is " + std::to_string(value) + ": outside 1 to " + std::to_string(most);
}

template <class... Problems>
std::string first_of(Problems... problems) {
  std::string first;
  const auto take = [&](std::string& problem) {
    if (first.empty()) first = std::move(problem);
  };
  (take(problems), ...);
  return first;
}

std::string flag_problem(const char* name, std::uint32_t value) {
  return value <= COPPICE_TRUE ? "" : std::string(name) + " is " + std::to_string(value) + ", neither 0 nor 1";
}

/// origin: what the position counts from
std::string position_problem(std::span<const double, 3> position, const dvec3& origin) {
  const dvec3 place = dvec3(position) + origin;
  const double first[3] = {place.x, place.y, place.z};
  if (std::string problem = double_problem("position", position, 2.0 * kMaxPosition_m); !problem.empty()) return problem;
  const std::string problem = double_problem("position", first, kMaxPosition_m);
  return problem.empty() || origin == dvec3{0, 0, 0} ? problem : problem + ", with the origin";
}

}  // namespace

std::string desc_problem(const coppice_context_desc& desc) {
  if (desc.memory_budget_bytes == 0) return "memory_budget_bytes is 0";
  if (!(desc.streaming_ms > 0.0f)) return "streaming_ms is not above 0";
  return first_of(range_problem({"prefetch_frames", {&desc.prefetch_frames, 1}, 0.0f, kMaxPrefetchFrames}),
                  size_problem("max_instances", desc.max_instances, kMaxHandleIndex),
                  size_problem("max_plants", desc.max_plants, kMaxPlants), flag_problem("allow_outside", desc.allow_outside));
}

std::string vulkan_problem(const coppice_vulkan_desc& vulkan) {
  if (vulkan.instance == VK_NULL_HANDLE) return "instance is null";
  if (vulkan.physical_device == VK_NULL_HANDLE) return "physical_device is null";
  if (vulkan.device == VK_NULL_HANDLE) return "device is null";
  if (vulkan.get_instance_proc_addr == nullptr) return "get_instance_proc_addr is null";
  return first_of(flag_problem("texture_compression_bc", vulkan.texture_compression_bc),
                  flag_problem("compute_raster", vulkan.compute_raster), flag_problem("shader_int64_atomics", vulkan.shader_int64_atomics),
                  flag_problem("pass_times", vulkan.pass_times), flag_problem("blocking_pipelines", vulkan.blocking_pipelines));
}

std::string device_memory_problem(const coppice_device_memory& hook) {
  return (hook.allocate == nullptr) != (hook.free == nullptr) ? "one of allocate, free is null" : "";
}

std::string view_desc_problem(const coppice_view_desc& desc) {
  return desc.output == COPPICE_OUTPUT_LIT || desc.output == COPPICE_OUTPUT_DEPTH ? "" : "output is not a coppice_output";
}

std::string vulkan_view_problem(const coppice_view_desc& view, const coppice_vulkan_view_desc& desc) {
  if (view.output == COPPICE_OUTPUT_LIT && desc.color_format == VK_FORMAT_UNDEFINED) return "color_format is not set";
  if (view.output == COPPICE_OUTPUT_DEPTH && desc.color_format != VK_FORMAT_UNDEFINED)
    return "color_format is set, and desc.output is COPPICE_OUTPUT_DEPTH";
  if (desc.depth_format == VK_FORMAT_UNDEFINED) return "depth_format is not set";
  if (desc.depth_compare != VK_COMPARE_OP_LESS && desc.depth_compare != VK_COMPARE_OP_LESS_OR_EQUAL &&
      desc.depth_compare != VK_COMPARE_OP_GREATER && desc.depth_compare != VK_COMPARE_OP_GREATER_OR_EQUAL)
    return "depth_compare is none of LESS, LESS_OR_EQUAL, GREATER and GREATER_OR_EQUAL";
  if (desc.samples == 0 || (desc.samples & (desc.samples - 1)) != 0) return "samples is not one VkSampleCountFlagBits";
  return {};
}

std::string camera_problem(const coppice_camera& camera, const ViewLimits& limits) {
  const Field fields[] = {{"clip_from_view", camera.clip_from_view, -kMaxMatrix, kMaxMatrix},
                          {"error_px", {&camera.error_px, 1}, std::numeric_limits<float>::min(), kMaxError_px}};
  if (std::string problem = first_of(double_problem("view_from_world", camera.view_from_world, kMaxEye_m), range_problem(fields),
                                     size_problem("width_px", camera.width_px, limits.max_width_px),
                                     size_problem("height_px", camera.height_px, limits.max_height_px));
      !problem.empty())
    return problem;
  for (const auto& [name, offset] : {std::pair{"x_px", camera.x_px}, {"y_px", camera.y_px}})
    if (offset < 0 || offset > kMaxOffset_px)
      return std::string(name) + " is " + std::to_string(offset) + ": outside 0 to " + std::to_string(kMaxOffset_px);
  if (!is_rigid(camera.view_from_world)) return "view_from_world is not a rotation and a translation";
  if (std::string problem = projection_problem(camera.clip_from_view); !problem.empty()) return problem;
  if (camera.lod < COPPICE_LOD_CUT || camera.lod > COPPICE_LOD_DISCRETE) return "lod is not a coppice_lod_mode";
  if (camera.debug_view < COPPICE_DEBUG_NONE || camera.debug_view > COPPICE_DEBUG_RESIDENCY)
    return "debug_view is not a coppice_debug_view";
  return {};
}

std::string light_problem(const coppice_light& light) {
  const Field fields[] = {
      {"sun_direction", light.sun_direction, -2.0f, 2.0f}, {"sun_color", light.sun_color, 0.0f, kMaxRadiance},
      {"sky_color", light.sky_color, 0.0f, kMaxRadiance},  {"ground_color", light.ground_color, 0.0f, kMaxRadiance},
      {"fog_color", light.fog_color, 0.0f, kMaxRadiance},  {"fog_density", {&light.fog_density, 1}, 0.0f, kMaxFogDensity}};
  if (std::string problem = range_problem(fields); !problem.empty()) return problem;
  if (!is_unit(light.sun_direction)) return "sun_direction is not of unit length";
  if (light.shadow_map_count > COPPICE_MAX_SHADOW_MAPS) return "shadow_map_count is above COPPICE_MAX_SHADOW_MAPS";
  for (std::uint32_t i = 0; i < light.shadow_map_count; ++i)
    if (const std::string problem = map_problem(light.shadow_maps[i]); !problem.empty())
      return "shadow_maps[" + std::to_string(i) + "]." + problem;
  return {};
}

std::string sun_problem(const coppice_sun_desc& desc, const ViewLimits& limits) {
  const Field fields[] = {{"sun_direction", desc.sun_direction, -2.0f, 2.0f},
                          {"radius_m", {&desc.radius_m, 1}, kMinRadius_m, kMaxRadius_m}};
  return first_of(range_problem(fields), double_problem("center", desc.center, kMaxCenter_m),
                  size_problem("size_px", desc.size_px, std::min(limits.max_width_px, limits.max_height_px)),
                  is_unit(desc.sun_direction) ? std::string() : std::string("sun_direction is not of unit length"));
}

std::string origin_problem(std::span<const double, 3> origin) {
  return double_problem("origin", origin, kMaxPosition_m);
}

std::string scene_placement_problem(const coppice_scene_placement& placement, const dvec3& origin) {
  return first_of(position_problem(placement.position, origin), range_problem({"rotation", placement.rotation, -2.0f, 2.0f}),
                  is_unit(placement.rotation) ? std::string() : std::string("rotation is not a unit quaternion"));
}

std::string placement_problem(const coppice_placement& placement, const dvec3& origin) {
  if (std::string problem = position_problem(placement.position, origin); !problem.empty()) return problem;
  const Field fields[] = {{"scale", {&placement.scale, 1}, kMinScale, kMaxScale},
                          {"rotation", placement.rotation, -2.0f, 2.0f},
                          {"tint", placement.tint, 0.0f, kMaxTint},
                          {"lod_bias", {&placement.lod_bias, 1}, -kMaxBias, kMaxBias},
                          {"leaf_share", {&placement.leaf_share, 1}, 0.0f, 1.0f}};
  if (std::string problem = range_problem(fields); !problem.empty()) return problem;
  return is_unit(placement.rotation) ? "" : "rotation is not a unit quaternion";
}

std::string handle_problem(std::uint64_t handle, HandleKind kind, std::uint32_t context_tag) {
  if (handle == 0) return "is 0";
  const Handle said = unpack_handle(handle);
  constexpr std::array kNames{"no kind of handle", "a plant's handle", "an instance's handle", "a scene's handle", "a view's handle"};
  if (said.kind != kind)
    return std::string("is ") + kNames[std::min(static_cast<std::size_t>(said.kind), kNames.size() - 1)] + ", not " +
           kNames[static_cast<std::size_t>(kind)];
  return said.context == context_tag ? "" : "is a handle of another context";
}

}  // namespace coppice
