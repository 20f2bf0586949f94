#include "abi.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace coppice {
namespace {

/// theirs: not null
std::uint32_t size_of(const void* theirs) {
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, theirs, sizeof bytes);
  return bytes;
}

}  // namespace

template <>
coppice_context_desc struct_defaults() {
  auto desc = zeroed_struct<coppice_context_desc>();
  desc.max_instances = 16777216;
  desc.max_plants = 65536;
  desc.memory_budget_bytes = 256ull << 20;
  desc.streaming_ms = 1.0f;
  desc.prefetch_frames = 20.0f;
  return desc;
}

template <>
coppice_scene_placement struct_defaults() {
  auto placement = zeroed_struct<coppice_scene_placement>();
  placement.rotation[3] = 1.0f;
  return placement;
}

namespace {

template <class T>
void set_identity(T& eye) {
  for (int i = 0; i < 16; i += 5) {
    eye.view_from_world[i] = 1.0;
    eye.clip_from_view[i] = 1.0f;
  }
}

}  // namespace

template <>
coppice_eye struct_defaults() {
  auto eye = zeroed_struct<coppice_eye>();
  set_identity(eye);
  return eye;
}

template <>
coppice_camera struct_defaults() {
  auto camera = zeroed_struct<coppice_camera>();
  camera.error_px = 2.0f;
  camera.lod = COPPICE_LOD_CUT;
  set_identity(camera);
  camera.layer_mask = COPPICE_ALL_LAYERS;
  return camera;
}

template <>
coppice_sun_desc struct_defaults() {
  auto desc = zeroed_struct<coppice_sun_desc>();
  desc.sun_direction[1] = 1.0f;
  return desc;
}

template <>
coppice_frame struct_defaults() {
  auto frame = zeroed_struct<coppice_frame>();
  frame.camera_bytes = sizeof(coppice_camera);
  return frame;
}

template <>
coppice_wind struct_defaults() {
  auto wind = zeroed_struct<coppice_wind>();
  wind.direction[0] = 1.0f;
  wind.gustiness = 0.5f;
  wind.gusts_m = -1.0;
  return wind;
}

template <>
coppice_ray struct_defaults() {
  auto ray = zeroed_struct<coppice_ray>();
  ray.layer_mask = COPPICE_ALL_LAYERS;
  ray.direction[2] = -1.0f;
  ray.max_distance_m = std::numeric_limits<float>::infinity();
  return ray;
}

template <>
coppice_leaf_layout struct_defaults() {
  auto layout = zeroed_struct<coppice_leaf_layout>();
  layout.position = layout.normal = layout.uv = layout.color = layout.material = layout.along = layout.sided = COPPICE_NONE;
  layout.index_bytes = sizeof(std::uint32_t);
  return layout;
}

std::string struct_size_problem(const void* theirs, const char* name) {
  if (theirs == nullptr) return std::string(name) + " is null";
  const std::uint32_t bytes = size_of(theirs);
  if (bytes >= sizeof bytes && bytes <= kMaxStructBytes && bytes % alignof(std::uint32_t) == 0) return {};
  return std::string(name) + ".struct_size is " + std::to_string(bytes) + ": call its _init function";
}

std::string unknown_record_bytes_problem(const void* record, std::size_t known_bytes, std::size_t bytes, const std::string& name) {
  for (std::size_t i = known_bytes; i < bytes; ++i)
    if (static_cast<const unsigned char*>(record)[i] != 0)
      return name + ": byte " + std::to_string(i) + " is not 0, and this version of the library knows the first " +
             std::to_string(known_bytes) + " alone";
  return {};
}

std::string unknown_bytes_problem(const void* theirs, std::size_t known_bytes, const char* name) {
  return unknown_record_bytes_problem(theirs, known_bytes, size_of(theirs), name);
}

std::string records_problem(const void* records, std::size_t count, std::uint32_t bytes, const char* name) {
  if (count == 0) return {};
  if (records == nullptr) return std::string(name) + " is null";
  if (bytes >= sizeof(std::uint32_t) && bytes <= kMaxStructBytes && bytes % alignof(std::uint32_t) == 0) return {};
  return std::string(name) + " are " + std::to_string(bytes) + " bytes apart: give the size of one";
}

void init_kind(std::span<const StructInit> by_kind, std::size_t kind, void* theirs, std::size_t bytes) {
  if (theirs == nullptr || bytes < sizeof(std::uint32_t) || bytes > kMaxStructBytes) return;
  const auto size = static_cast<std::uint32_t>(bytes);
  if (kind < by_kind.size()) return by_kind[kind](theirs, size);
  std::memset(theirs, 0, bytes);
  std::memcpy(theirs, &size, sizeof size);
}

void write_bytes(const void* ours, std::size_t our_bytes, void* theirs) {
  const std::uint32_t size = size_of(theirs);
  const std::size_t known = std::min<std::size_t>(our_bytes, size);
  std::memcpy(theirs, ours, known);
  std::memset(static_cast<unsigned char*>(theirs) + known, 0, size - known);
  std::memcpy(theirs, &size, sizeof size);
}

}  // namespace coppice

void coppice_struct_init(coppice_struct kind, void* data, size_t bytes) {
  using coppice::init_struct;
  static constexpr coppice::StructInit kInits[] = {init_struct<coppice_context_desc>,
                                                   init_struct<coppice_allocator>,
                                                   init_struct<coppice_jobs>,
                                                   init_struct<coppice_io>,
                                                   init_struct<coppice_log>,
                                                   init_struct<coppice_trace>,
                                                   init_struct<coppice_plant_info>,
                                                   init_struct<coppice_scene_info>,
                                                   init_struct<coppice_scene_plant_info>,
                                                   init_struct<coppice_stats>,
                                                   init_struct<coppice_view_desc>,
                                                   init_struct<coppice_camera>,
                                                   init_struct<coppice_sun_desc>,
                                                   init_struct<coppice_frame>,
                                                   init_struct<coppice_view_stats>,
                                                   init_struct<coppice_scene_placement>,
                                                   init_struct<coppice_change>,
                                                   init_struct<coppice_file_info>,
                                                   init_struct<coppice_material>,
                                                   init_struct<coppice_card>,
                                                   init_struct<coppice_leaf_layout>,
                                                   init_struct<coppice_leaf_output>,
                                                   init_struct<coppice_eye>,
                                                   init_struct<coppice_tree_info>,
                                                   init_struct<coppice_ray>,
                                                   init_struct<coppice_hit>,
                                                   init_struct<coppice_wind>,
                                                   init_struct<coppice_gusts>};
  static_assert(std::size(kInits) == COPPICE_STRUCT_GUSTS + 1);
  coppice::init_kind(kInits, static_cast<std::size_t>(kind), data, bytes);
}
