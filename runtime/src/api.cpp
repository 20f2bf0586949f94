// The C API: checks what the engine passes, translates, forwards. No logic.

#include <cmath>
#include <memory>
#include <new>

#include "context.h"
#include "sun_camera.h"

struct coppice_context {
  std::unique_ptr<coppice::Context> context;
};

namespace {

using coppice::Error;
using Recording = coppice::Context::Recording;
using coppice::Result;
using coppice::Status;

coppice_status fail(const coppice_log& log, const char* function, const Error& error) {
  coppice::log_line(log, COPPICE_LOG_ERROR, "%s: %s", function, error.message().c_str());
  return static_cast<coppice_status>(error.status);
}

coppice_status invalid(const coppice_context* context, const char* function, const char* what) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  return fail(context->context->log(), function, {Status::invalid_argument, what});
}

coppice_status finish(const coppice_context* context, const char* function, const Result<void>& result) {
  return result ? COPPICE_OK : fail(context->context->log(), function, result.error());
}

template <class T>
bool has_size(const T* argument) {
  return argument != nullptr && argument->struct_size == sizeof(T);
}

const char* desc_problem(const coppice_context_desc& desc) {
  if (desc.instance == VK_NULL_HANDLE || desc.physical_device == VK_NULL_HANDLE || desc.device == VK_NULL_HANDLE)
    return "instance, physical_device and device must be set";
  if (desc.get_instance_proc_addr == nullptr) return "get_instance_proc_addr must be set";
  if (desc.color_format == VK_FORMAT_UNDEFINED || desc.depth_format == VK_FORMAT_UNDEFINED)
    return "color_format and depth_format must be set";
  if (desc.samples == 0 || (desc.samples & (desc.samples - 1)) != 0) return "samples must be one VkSampleCountFlagBits";
  if (desc.memory_budget_bytes == 0) return "memory_budget_bytes must be above 0";
  if (!(desc.streaming_ms > 0.0f)) return "streaming_ms must be above 0";
  if (!(desc.prefetch_frames >= 0.0f && std::isfinite(desc.prefetch_frames))) return "prefetch_frames must be finite and not below 0";
  if (desc.max_instances == 0 || desc.max_plants == 0 || desc.max_plants > 65536) return "max_instances or max_plants out of range";
  return nullptr;
}

bool all_finite(const float* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (!std::isfinite(values[i])) return false;
  return true;
}

const char* view_problem(const coppice_view* view) {
  if (!has_size(view)) return "view is null or has a wrong struct_size";
  if (!all_finite(view->view_from_world, 16) || !all_finite(view->clip_from_view, 16)) return "view has a matrix that is not finite";
  if (view->width_px == 0 || view->height_px == 0) return "view has no pixels";
  if (!(view->error_px > 0.0f)) return "view.error_px must be above 0";
  if (view->debug_view < COPPICE_DEBUG_NONE || view->debug_view > COPPICE_DEBUG_RESIDENCY)
    return "view.debug_view is not a coppice_debug_view";
  if (view->lod < COPPICE_LOD_CUT || view->lod > COPPICE_LOD_DISCRETE) return "view.lod is not a coppice_lod_mode";
  if (view->kind != COPPICE_VIEW_CAMERA && view->kind != COPPICE_VIEW_SHADOW) return "view.kind is not a coppice_view_kind";
  if (view->shadow_cascade_count > COPPICE_MAX_SHADOW_CASCADES) return "view.shadow_cascade_count is above COPPICE_MAX_SHADOW_CASCADES";
  for (uint32_t i = 0; i < view->shadow_cascade_count; ++i)
    if (view->shadow_cascades[i].image == VK_NULL_HANDLE || !all_finite(view->shadow_cascades[i].clip_from_world, 16))
      return "view.shadow_cascades has an entry without an image, or a matrix that is not finite";
  return nullptr;
}

/// What lies beyond is a mistake, and would overflow what is computed from it.
constexpr float kMaxScale = 1e6f;

bool is_placement(const coppice_placement& placement) {
  const float* q = placement.rotation;
  const float length_squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return all_finite(placement.position, 3) && all_finite(placement.tint, 3) && placement.scale > 0.0f && placement.scale <= kMaxScale &&
         std::abs(length_squared - 1.0f) < 0.01f;
}

}  // namespace

const char* coppice_status_text(coppice_status status) {
  switch (status) {
    case COPPICE_OK:
      return "success";
    case COPPICE_ERROR_INVALID_ARGUMENT:
      return "invalid argument";
    case COPPICE_ERROR_IO:
      return "a file could not be read";
    case COPPICE_ERROR_BAD_FILE:
      return "not a .coppice file, damaged, or of another version";
    case COPPICE_ERROR_UNSUPPORTED:
      return "the device lacks something required";
    case COPPICE_ERROR_OUT_OF_MEMORY:
      return "out of memory";
    case COPPICE_ERROR_DEVICE_LOST:
      return "the Vulkan device is lost";
    case COPPICE_ERROR_INTERNAL:
      return "internal error";
    case COPPICE_STATUS_MAX_ENUM:
      break;
  }
  return "unknown status";
}

void coppice_context_desc_init(coppice_context_desc* desc) {
  *desc = {};
  desc->struct_size = sizeof *desc;
  desc->depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  desc->samples = VK_SAMPLE_COUNT_1_BIT;
  desc->memory_budget_bytes = 256ull << 20;
  desc->max_instances = 131072;
  desc->max_plants = 64;
  desc->streaming_ms = 1.0f;
  desc->prefetch_frames = 20.0f;
}

coppice_status coppice_context_create(const coppice_context_desc* desc, coppice_context** context) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  *context = nullptr;
  if (!has_size(desc)) return COPPICE_ERROR_INVALID_ARGUMENT;
  if (const char* problem = desc_problem(*desc)) return fail(desc->log, __func__, {Status::invalid_argument, problem});
  auto created = coppice::Context::create(*desc);
  if (!created) return fail(desc->log, __func__, created.error());
  *context = new (std::nothrow) coppice_context{*std::move(created)};
  return *context != nullptr ? COPPICE_OK : COPPICE_ERROR_OUT_OF_MEMORY;
}

void coppice_context_destroy(coppice_context* context) {
  delete context;
}

coppice_status coppice_set_memory_budget(coppice_context* context, uint64_t bytes) {
  if (context == nullptr || bytes == 0) return invalid(context, __func__, "bytes must be above 0");
  context->context->set_memory_budget(bytes);
  return COPPICE_OK;
}

coppice_status coppice_plant_open(coppice_context* context, const char* path, coppice_plant* plant) {
  if (context == nullptr || path == nullptr || plant == nullptr) return invalid(context, __func__, "path or plant is null");
  *plant = 0;
  auto opened = context->context->open_plant(path);
  if (!opened) return static_cast<coppice_status>(opened.error().status);  // the log has it, with the path
  *plant = *opened;
  return COPPICE_OK;
}

coppice_status coppice_plant_close(coppice_context* context, coppice_plant plant) {
  if (context == nullptr || !context->context->is_open(plant)) return invalid(context, __func__, "plant is not open");
  context->context->close_plant(plant);
  return COPPICE_OK;
}

coppice_status coppice_plant_reload(coppice_context* context, coppice_plant plant, const char* path) {
  if (context == nullptr || !context->context->is_open(plant)) return invalid(context, __func__, "plant is not open");
  const auto reloaded = context->context->reload_plant(plant, path);
  return reloaded ? COPPICE_OK : static_cast<coppice_status>(reloaded.error().status);  // the log has it, with the path
}

void coppice_plant_info_init(coppice_plant_info* info) {
  *info = {};
  info->struct_size = sizeof *info;
}

coppice_status coppice_plant_get_info(const coppice_context* context, coppice_plant plant, coppice_plant_info* info) {
  if (context == nullptr || !context->context->is_open(plant)) return invalid(context, __func__, "plant is not open");
  if (!has_size(info)) return invalid(context, __func__, "info is null or has a wrong struct_size");
  context->context->fill_info(plant, *info);
  return COPPICE_OK;
}

coppice_status coppice_instances_add(coppice_context* context, coppice_plant plant, const coppice_placement* placements, uint32_t count,
                                     coppice_instance* instances) {
  if (context == nullptr || !context->context->is_open(plant)) return invalid(context, __func__, "plant is not open");
  if (placements == nullptr && count > 0) return invalid(context, __func__, "placements is null");
  for (uint32_t i = 0; i < count; ++i)
    if (!is_placement(placements[i]))
      return invalid(context, __func__, "a placement is not finite, not scaled above 0 or not a unit quaternion");
  const std::span<coppice_instance> handles(instances, instances != nullptr ? count : 0);
  return finish(context, __func__, context->context->add_instances(plant, {placements, count}, handles));
}

coppice_status coppice_instance_move(coppice_context* context, coppice_instance instance, const coppice_placement* placement) {
  if (context == nullptr || !context->context->instances().is_live(instance)) return invalid(context, __func__, "no such instance");
  if (placement == nullptr || !is_placement(*placement)) return invalid(context, __func__, "placement is null or not valid");
  context->context->instances().move(instance, *placement);
  return COPPICE_OK;
}

coppice_status coppice_instances_remove(coppice_context* context, const coppice_instance* instances, uint32_t count) {
  if (context == nullptr || (instances == nullptr && count > 0)) return invalid(context, __func__, "instances is null");
  // A handle given twice is removed once. What is not live is refused before anything is removed.
  for (uint32_t i = 0; i < count; ++i)
    if (!context->context->instances().is_live(instances[i])) return invalid(context, __func__, "no such instance; none was removed");
  for (uint32_t i = 0; i < count; ++i)
    if (context->context->instances().is_live(instances[i])) context->context->instances().remove(instances[i]);
  return COPPICE_OK;
}

coppice_status coppice_scene_open(coppice_context* context, const char* path, coppice_scene* scene) {
  if (context == nullptr || path == nullptr || scene == nullptr) return invalid(context, __func__, "path or scene is null");
  *scene = 0;
  if (context->context->has_scene()) return invalid(context, __func__, "a scene is open: close it first");
  auto opened = context->context->open_scene(path);
  if (!opened) return static_cast<coppice_status>(opened.error().status);  // the log has it, with the path
  *scene = *opened;
  return COPPICE_OK;
}

coppice_status coppice_scene_close(coppice_context* context, coppice_scene scene) {
  if (context == nullptr || !context->context->is_scene(scene)) return invalid(context, __func__, "scene is not open");
  context->context->close_scene();
  return COPPICE_OK;
}

void coppice_scene_info_init(coppice_scene_info* info) {
  *info = {};
  info->struct_size = sizeof *info;
}

coppice_status coppice_scene_get_info(const coppice_context* context, coppice_scene scene, coppice_scene_info* info) {
  if (context == nullptr || !context->context->is_scene(scene)) return invalid(context, __func__, "scene is not open");
  if (!has_size(info)) return invalid(context, __func__, "info is null or has a wrong struct_size");
  context->context->fill_info(*info);
  return COPPICE_OK;
}

void coppice_scene_plant_info_init(coppice_scene_plant_info* info) {
  *info = {};
  info->struct_size = sizeof *info;
}

coppice_status coppice_scene_get_plant(const coppice_context* context, coppice_scene scene, uint32_t species,
                                       coppice_scene_plant_info* info) {
  if (context == nullptr || !context->context->is_scene(scene)) return invalid(context, __func__, "scene is not open");
  if (!has_size(info)) return invalid(context, __func__, "info is null or has a wrong struct_size");
  if (!context->context->fill_info(species, *info)) return invalid(context, __func__, "species is none of the scene's");
  return COPPICE_OK;
}

void coppice_view_init(coppice_view* view) {
  *view = {};
  view->struct_size = sizeof *view;
  view->error_px = 2.0f;
  view->lod = COPPICE_LOD_CUT;
  for (int i = 0; i < 16; i += 5) view->view_from_world[i] = view->clip_from_view[i] = 1.0f;
  view->sun_direction[1] = 1.0f;
  for (int i = 0; i < 3; ++i) {
    view->sun_color[i] = 3.0f;
    view->sky_color[i] = 0.6f;
    view->ground_color[i] = 0.2f;
  }
}

coppice_status coppice_shadow_view(const coppice_context* context, const coppice_view* camera, const coppice_shadow_desc* desc,
                                   coppice_view* shadow) {
  if (context == nullptr || desc == nullptr || shadow == nullptr) return invalid(context, __func__, "desc or shadow is null");
  if (const char* problem = view_problem(camera)) return invalid(context, __func__, problem);
  if (!all_finite(desc->center, 3) || !(desc->radius_m > 0.0f) || !std::isfinite(desc->radius_m) || desc->size_px == 0)
    return invalid(context, __func__, "desc has no size");
  const coppice::SunSphere sphere{.center = {desc->center[0], desc->center[1], desc->center[2]}, .radius_m = desc->radius_m};
  *shadow = *camera;
  shadow->kind = COPPICE_VIEW_SHADOW;
  shadow->lod = COPPICE_LOD_CUT;
  shadow->debug_view = COPPICE_DEBUG_NONE;
  shadow->leaf_budget = 0;
  shadow->shadow_cascade_count = 0;
  shadow->width_px = shadow->height_px = desc->size_px;
  coppice::set_sun_camera(*shadow, sphere, context->context->reversed_depth());
  return COPPICE_OK;
}

void coppice_frame_init(coppice_frame* frame) {
  *frame = {};
  frame->struct_size = sizeof *frame;
}

coppice_status coppice_frame_begin(coppice_context* context, const coppice_frame* frame) {
  if (context == nullptr || !has_size(frame)) return invalid(context, __func__, "frame is null or has a wrong struct_size");
  if (const char* problem = view_problem(frame->view)) return invalid(context, __func__, problem);
  return finish(context, __func__, context->context->begin_frame(*frame));
}

coppice_status coppice_record_upload(coppice_context* context, VkCommandBuffer cmd) {
  if (context == nullptr || cmd == VK_NULL_HANDLE) return invalid(context, __func__, "cmd is null");
  if (context->context->recording() != Recording::begun) return invalid(context, __func__, "not the first call since coppice_frame_begin");
  return finish(context, __func__, context->context->record_upload(cmd));
}

coppice_status coppice_record_cull(coppice_context* context, VkCommandBuffer cmd, const coppice_view* view) {
  if (context == nullptr || cmd == VK_NULL_HANDLE) return invalid(context, __func__, "cmd is null");
  if (const char* problem = view_problem(view)) return invalid(context, __func__, problem);
  if (view->kind == COPPICE_VIEW_SHADOW && !context->context->has_shadow_views())
    return invalid(context, __func__, "a shadow view without coppice_context_desc.shadow_format");
  if (context->context->recording() < Recording::uploaded)
    return invalid(context, __func__, "coppice_record_upload was not called for this frame");
  return finish(context, __func__, context->context->record_cull(cmd, *view));
}

coppice_status coppice_record_draw(coppice_context* context, VkCommandBuffer cmd, const coppice_view* view) {
  if (context == nullptr || cmd == VK_NULL_HANDLE) return invalid(context, __func__, "cmd is null");
  if (const char* problem = view_problem(view)) return invalid(context, __func__, problem);
  if (view->kind == COPPICE_VIEW_SHADOW && !context->context->has_shadow_views())
    return invalid(context, __func__, "a shadow view without coppice_context_desc.shadow_format");
  if (context->context->recording() < Recording::culled)
    return invalid(context, __func__, "coppice_record_cull was not called for this frame");
  context->context->record_draw(cmd, *view);
  return COPPICE_OK;
}

void coppice_stats_init(coppice_stats* stats) {
  *stats = {};
  stats->struct_size = sizeof *stats;
}

coppice_status coppice_get_stats(const coppice_context* context, coppice_stats* stats) {
  if (context == nullptr || !has_size(stats)) return invalid(context, __func__, "stats is null or has a wrong struct_size");
  context->context->fill_stats(*stats);
  return COPPICE_OK;
}
