#include "api_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "api_fields.h"
#include "demand.h"

namespace coppice {
namespace {

// Larger values are a mistake, and would overflow later computations.
constexpr double kMaxPosition_m = 3.3e7;  // overflows the numbers of cells
constexpr double kMaxCenter_m = 1e9;
constexpr float kMaxWind_mps = 100.0f;
constexpr std::uint32_t kMinMapSide = 2, kMaxMapSide = 256;
constexpr double kMinMapExtent_m = 1e-3;
constexpr double kMaxTime_s = 1e9;
constexpr double kMaxEye_m = 1e10;
constexpr float kMinRadius_m = 1e-6f, kMaxRadius_m = 1e8f;
constexpr float kMinScale = 1e-6f, kMaxScale = 1e6f;
constexpr float kMaxBias = 4.0f;
constexpr float kMinFocal = 1e-6f, kMaxFocal = 1e6f;  // elements of clip_from_view
constexpr float kMinError_px = std::numeric_limits<float>::min(), kMaxError_px = 1e6f;
constexpr std::int32_t kMaxOffset_px = 1 << 20;
constexpr float kMaxPrefetchFrames = 1000.0f;
constexpr std::uint32_t kMaxPlants = 65536;

/// True if it is a rotation, perhaps mirrored, and a translation. m: finite, column-major
bool is_rigid(std::span<const double, 16> m) {
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 3; ++b) {
      double product = 0;
      for (std::size_t row = 0; row < 3; ++row) product += m[4 * a + row] * m[4 * b + row];
      if (!(std::abs(product - (a == b ? 1.0 : 0.0)) < kUnitTolerance)) return false;
    }
  return m[3] == 0.0 && m[7] == 0.0 && m[11] == 0.0 && m[15] == 1.0;
}

std::string projection_problem(std::span<const float, 16> m) {
  const bool perspective = m[11] < 0.0f && m[15] == 0.0f;
  if (m[3] != 0.0f || m[7] != 0.0f || !(perspective || is_parallel(m)))
    return "clip_from_view is neither a perspective that looks down -z nor orthographic: its last row must be 0 0 -1 0 or 0 0 0 1";
  for (const std::size_t i : {std::size_t{0}, std::size_t{5}})
    if (!(std::abs(m[i]) >= kMinFocal && std::abs(m[i]) <= kMaxFocal))
      return "clip_from_view[" + std::to_string(i) + "] is a scale outside 1e-6 to 1e6";
  if (determinant(m) == 0.0) return "clip_from_view has no inverse";
  return {};
}

/// Eye: coppice_camera, whose own fields describe the first eye, or coppice_eye
template <class Eye>
std::string eye_problem(const Eye& eye) {
  if (std::string problem = first_of(double_problem("view_from_world", eye.view_from_world, kMaxEye_m),
                                     range_problem({"clip_from_view", eye.clip_from_view, -kMaxMatrix, kMaxMatrix}));
      !problem.empty())
    return problem;
  for (const auto& [name, offset] : {std::pair{"x_px", eye.x_px}, {"y_px", eye.y_px}})
    if (offset < 0 || offset > kMaxOffset_px)
      return std::string(name) + " is " + std::to_string(offset) + ": outside 0 to " + std::to_string(kMaxOffset_px);
  if (!is_rigid(eye.view_from_world)) return "view_from_world is not a rotation and a translation";
  return projection_problem(eye.clip_from_view);
}

/// True if a perspective mirrors its picture.
template <class Eye>
bool is_mirror(const Eye& eye) {
  const double* m = eye.view_from_world;
  const dvec3 x{m[0], m[1], m[2]}, y{m[4], m[5], m[6]}, z{m[8], m[9], m[10]};
  return dot(x, cross(y, z)) * static_cast<double>(eye.clip_from_view[0] * eye.clip_from_view[5]) > 0.0;
}

/// origin: what the position counts from
std::string position_problem(std::span<const double, 3> position, const dvec3& origin) {
  const dvec3 place = dvec3(position) + origin;
  const double first[3] = {place.x, place.y, place.z};
  if (std::string problem = double_problem("position", position, 2.0 * kMaxPosition_m); !problem.empty()) return problem;
  const std::string problem = double_problem("position", first, kMaxPosition_m);
  return problem.empty() || origin == dvec3{0, 0, 0} ? problem : problem + ", with the origin";
}

std::string map_problem(const coppice_wind& wind) {
  for (const auto& [name, places] : {std::pair{"map_width", wind.map_width}, std::pair{"map_height", wind.map_height}})
    if (places < kMinMapSide || places > kMaxMapSide)
      return std::string(name) + " is " + std::to_string(places) + ", not within " + std::to_string(kMinMapSide) + " to " +
             std::to_string(kMaxMapSide);
  for (const auto& [name, corner] : {std::pair{"map_min", &wind.map_min}, std::pair{"map_max", &wind.map_max}})
    if (std::string problem = double_problem(name, *corner, kMaxPosition_m); !problem.empty()) return problem;
  for (int axis = 0; axis < 2; ++axis)
    if (!(wind.map_max[axis] - wind.map_min[axis] >= kMinMapExtent_m)) return "map_max is not above map_min by a millimetre or more";
  const std::span<const float> map(wind.map, std::size_t{2} * wind.map_width * wind.map_height);
  return range_problem({"map", map, -kMaxWind_mps, kMaxWind_mps});
}

}  // namespace

std::string desc_problem(const coppice_context_desc& desc) {
  if (desc.memory_budget_bytes == 0) return "memory_budget_bytes is 0";
  if (!(desc.streaming_ms > 0.0f)) return "streaming_ms is not above 0";
  return first_of(range_problem({"prefetch_frames", {&desc.prefetch_frames, 1}, 0.0f, kMaxPrefetchFrames}),
                  size_problem("max_instances", desc.max_instances, kMaxHandleIndex),
                  size_problem("max_plants", desc.max_plants, kMaxPlants), flag_problem("allow_outside", desc.allow_outside),
                  flag_problem("block_textures", desc.block_textures), reserved_problem(desc.reserved));
}

std::string view_desc_problem(const coppice_view_desc& desc) {
  return desc.output >= COPPICE_OUTPUT_LIT && desc.output <= COPPICE_OUTPUT_SURFACE ? "" : "output is not a coppice_output";
}

std::string camera_problem(const coppice_camera& camera, const ViewLimits& limits) {
  if (std::string problem = first_of(eye_problem(camera), range_problem({"error_px", {&camera.error_px, 1}, kMinError_px, kMaxError_px}),
                                     size_problem("width_px", camera.width_px, limits.max_width_px),
                                     size_problem("height_px", camera.height_px, limits.max_height_px));
      !problem.empty())
    return problem;
  if (camera.lod < COPPICE_LOD_CUT || camera.lod > COPPICE_LOD_DISCRETE) return "lod is not a coppice_lod_mode";
  if (camera.debug_view < COPPICE_DEBUG_NONE || camera.debug_view > COPPICE_DEBUG_RESIDENCY)
    return "debug_view is not a coppice_debug_view";
  if (camera.second_eye == nullptr) return {};
  const coppice_eye& second = *camera.second_eye;
  if (const std::string problem = eye_problem(second); !problem.empty()) return "second_eye." + problem;
  if (is_parallel(camera.clip_from_view) || is_parallel(second.clip_from_view))
    return "second_eye is given, and a clip_from_view is not a perspective";
  return is_mirror(camera) == is_mirror(second) ? "" : "second_eye is mirrored where the first is not, or the other way round";
}

std::string sun_problem(const coppice_sun_desc& desc, const ViewLimits& limits) {
  return first_of(range_problem({"radius_m", {&desc.radius_m, 1}, kMinRadius_m, kMaxRadius_m}),
                  double_problem("center", desc.center, kMaxCenter_m),
                  size_problem("size_px", desc.size_px, std::min(limits.max_width_px, limits.max_height_px)),
                  unit_problem("sun_direction", desc.sun_direction));
}

std::string wind_problem(const coppice_wind& wind) {
  const Field fields[] = {{"speed", {&wind.speed, 1}, 0.0f, kMaxWind_mps}, {"gustiness", {&wind.gustiness, 1}, 0.0f, 1.0f}};
  const auto is_time = [](double time_s) { return time_s >= 0.0 && time_s <= kMaxTime_s; };  // false for a NaN
  if (std::string problem = range_problem(fields); !problem.empty()) return problem;
  if (!is_time(wind.time_s)) return "time_s is not within 0 to 1e9";
  if (!is_time(wind.time_before_s)) return "time_before_s is not within 0 to 1e9";
  if (!(wind.gusts_m <= kMaxWind_mps * kMaxTime_s)) return "gusts_m is not up to 1e11";
  if (std::string problem = unit_problem("direction", wind.direction); !problem.empty() || wind.map == nullptr) return problem;
  return map_problem(wind);
}

std::string place_problem(std::span<const double, 3> place) {
  return double_problem("place", place, kMaxPosition_m);
}

std::string origin_problem(std::span<const double, 3> origin) {
  return double_problem("origin", origin, kMaxPosition_m);
}

std::string box_problem(const double* low, const double* high) {
  for (const auto& [name, corner] : {std::pair{"box_min", low}, {"box_max", high}}) {
    if (corner == nullptr) return std::string(name) + " is null";
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (std::isnan(corner[axis])) return std::string(name) + "[" + std::to_string(axis) + "] is not a number";
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (low[axis] > high[axis]) return "box_min[" + std::to_string(axis) + "] is above box_max[" + std::to_string(axis) + "]";
  return {};
}

std::string ray_problem(const coppice_ray& ray) {
  if (!(ray.max_distance_m > 0.0f)) return "max_distance_m is not above 0";
  return first_of(double_problem("origin", ray.origin, kMaxEye_m), unit_problem("direction", ray.direction),
                  flag_problem("boxes", ray.boxes), reserved_problem(ray.reserved));
}

std::string scene_placement_problem(const coppice_scene_placement& placement, const dvec3& origin) {
  return first_of(position_problem(placement.position, origin), unit_problem("rotation", placement.rotation, "not a unit quaternion"));
}

std::string placement_problem(const coppice_placement& placement, const dvec3& origin) {
  if (std::string problem = position_problem(placement.position, origin); !problem.empty()) return problem;
  // A scale below 0 mirrors.
  const float size = std::abs(placement.scale);
  const Field fields[] = {{"scale", {&size, 1}, kMinScale, kMaxScale},
                          {"tint", placement.tint, 0.0f, kMaxTint},
                          {"lod_bias", {&placement.lod_bias, 1}, -kMaxBias, kMaxBias},
                          {"leaf_share", {&placement.leaf_share, 1}, 0.0f, 1.0f}};
  if (std::string problem = range_problem(fields); !problem.empty()) return problem;
  return unit_problem("rotation", placement.rotation, "not a unit quaternion");
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
