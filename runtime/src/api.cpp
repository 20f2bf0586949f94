// The C API: checks what the engine passes, translates, forwards. No logic.

#include <memory>
#include <new>
#include <optional>
#include <string>

#include "api_checks.h"
#include "context.h"
#include "sun_camera.h"

struct coppice_context {
  std::unique_ptr<coppice::Context> context;
};

namespace {

using coppice::Error;
using coppice::HandleKind;
using Recording = coppice::Context::Recording;
using coppice::Result;
using coppice::Status;

coppice_status fail(const coppice_log& log, const char* function, const Error& error) {
  coppice::log_line(log, COPPICE_LOG_ERROR, "%s: %s", function, error.message().c_str());
  return static_cast<coppice_status>(error.status);
}

coppice_status invalid(const coppice_context& context, const char* function, const std::string& problem) {
  coppice::log_line(context.context->log(), COPPICE_LOG_ERROR, "%s: %s", function, problem.c_str());
  return COPPICE_ERROR_INVALID_ARGUMENT;
}

coppice_status finish(const coppice_context& context, const char* function, const Result<void>& result) {
  return result ? COPPICE_OK : fail(context.context->log(), function, result.error());
}

/// Says to the log what is wrong, but for a desc of another size: of that the log's place is not known.
bool is_valid(const coppice_context_desc* desc, const char* function) {
  if (!coppice::struct_problem(desc, "desc").empty()) return false;
  const std::string problem = coppice::desc_problem(*desc);
  if (!problem.empty()) coppice::log_line(desc->log, COPPICE_LOG_ERROR, "%s: desc.%s", function, problem.c_str());
  return problem.empty();
}

/// Once a device is lost it stays so. The log has heard when.
bool is_lost(const coppice_context& context) {
  return !context.context->device_state();
}

coppice::ViewLimits view_limits(const coppice_context& context) {
  const coppice::gpu::Device& device = context.context->device();
  return {device.max_view_width, device.max_view_height};
}

std::string plant_problem(const coppice_context& context, coppice_plant plant) {
  if (context.context->is_open(plant)) return {};
  const std::string problem = coppice::handle_problem(plant, HandleKind::plant, context.context->tag());
  return "plant " + (problem.empty() ? "has been closed" : problem);
}

/// Of one that a call needs more of than its handle.
std::string failed_plant_problem(const coppice_context& context, coppice_plant plant) {
  if (std::string problem = plant_problem(context, plant); !problem.empty()) return problem;
  return context.context->plant_state(plant) == COPPICE_PLANT_FAILED ? "plant could not be opened: close it" : "";
}

std::string unready_plant_problem(const coppice_context& context, coppice_plant plant) {
  if (std::string problem = failed_plant_problem(context, plant); !problem.empty()) return problem;
  return context.context->plant_state(plant) == COPPICE_PLANT_OPENING ? "plant is being opened" : "";
}

std::string memory_problem(const void* bytes, size_t size, const char* name) {
  return bytes == nullptr ? "bytes is null" : size == 0 ? "size is 0" : name == nullptr ? "name is null" : "";
}

coppice::PlantSource memory_source(const void* bytes, size_t size, const char* name) {
  return {name, {static_cast<const std::uint8_t*>(bytes), size}};
}

/// What opens a plant and logs its error, with the path.
coppice_status finish_open(const Result<coppice_plant>& opened, coppice_plant* plant) {
  if (!opened) return static_cast<coppice_status>(opened.error().status);
  *plant = *opened;
  return COPPICE_OK;
}

/// source  none: what it was opened from
coppice_status reload(coppice_context& context, coppice_plant plant, const std::optional<coppice::PlantSource>& source) {
  if (is_lost(context)) return COPPICE_ERROR_DEVICE_LOST;
  const auto reloaded = context.context->reload_plant(plant, source);
  return reloaded ? COPPICE_OK : static_cast<coppice_status>(reloaded.error().status);  // the log has it, with the path
}

/// name  of the argument
std::string instance_problem(const coppice_context& context, coppice_instance instance, const std::string& name) {
  if (context.context->instances().is_live(instance)) return {};
  const std::string problem = coppice::handle_problem(instance, HandleKind::instance, context.context->tag());
  return name + " " + (problem.empty() ? "has been removed" : problem);
}

std::string scene_problem(const coppice_context& context, coppice_scene scene) {
  if (context.context->is_scene(scene)) return {};
  const std::string problem = coppice::handle_problem(scene, HandleKind::scene, context.context->tag());
  return "scene " + (problem.empty() ? "has been closed" : problem);
}

std::string view_problem(const coppice_context& context, coppice_view view, const std::string& name = "view") {
  if (context.context->is_view(view)) return {};
  const std::string problem = coppice::handle_problem(view, HandleKind::view, context.context->tag());
  return name + " " + (problem.empty() ? "has been destroyed" : problem);
}

/// What recording culls and draws have in common.
std::string record_problem(const coppice_context& context, VkCommandBuffer cmd, coppice_view view) {
  if (cmd == VK_NULL_HANDLE) return "cmd is null";
  if (std::string problem = view_problem(context, view); !problem.empty()) return problem;
  if (context.context->recording() != Recording::uploaded) return "coppice_record_upload was not called for this frame";
  return context.context->recorder(view).is_shown() ? "" : "view has no camera in this frame";
}

std::string cameras_problem(const coppice_context& context, const coppice_frame& frame) {
  if (frame.camera_count == 0) return {};
  if (frame.cameras == nullptr) return "frame.cameras is null";
  if (frame.camera_bytes != sizeof(coppice_camera))
    return "frame.camera_bytes is not the size of a coppice_camera: call coppice_frame_init";
  const std::span<const coppice_camera> cameras(frame.cameras, frame.camera_count);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string name = "frame.cameras[" + std::to_string(i) + "]";
    if (std::string problem = coppice::struct_problem(&cameras[i], name.c_str()); !problem.empty()) return problem;
    if (std::string problem = view_problem(context, cameras[i].view, name + ".view"); !problem.empty()) return problem;
    for (std::size_t other = 0; other < i; ++other)
      if (cameras[other].view == cameras[i].view) return name + ".view is that of frame.cameras[" + std::to_string(other) + "] too";
    if (const std::string problem = coppice::camera_problem(cameras[i], view_limits(context)); !problem.empty())
      return name + "." + problem;
  }
  return {};
}

}  // namespace

/// Returns the status of a call whose argument has a problem.
#define COPPICE_REFUSE_IF(expression) \
  if (const std::string coppice_problem = (expression); !coppice_problem.empty()) return invalid(*context, __func__, coppice_problem)

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
  if (desc == nullptr) return;
  *desc = {};
  desc->struct_size = sizeof *desc;
  desc->memory_budget_bytes = 256ull << 20;
  desc->max_instances = 16777216;
  desc->max_plants = 65536;
  desc->compute_raster = VK_TRUE;
  desc->streaming_ms = 1.0f;
  desc->prefetch_frames = 20.0f;
}

coppice_status coppice_context_create(const coppice_context_desc* desc, coppice_context** context) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  *context = nullptr;
  if (!is_valid(desc, __func__)) return COPPICE_ERROR_INVALID_ARGUMENT;
  auto created = coppice::Context::create(*desc);
  if (!created) return fail(desc->log, __func__, created.error());
  *context = new (std::nothrow) coppice_context{*std::move(created)};
  return *context != nullptr ? COPPICE_OK : fail(desc->log, __func__, {Status::out_of_memory, "context"});
}

coppice_status coppice_context_cost(const coppice_context_desc* desc, uint64_t* bytes) {
  if (bytes == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  *bytes = 0;
  if (!is_valid(desc, __func__)) return COPPICE_ERROR_INVALID_ARGUMENT;
  const auto cost = coppice::Context::cost(*desc);
  if (!cost) return fail(desc->log, __func__, cost.error());
  *bytes = *cost;
  return COPPICE_OK;
}

void coppice_context_destroy(coppice_context* context) {
  delete context;
}

coppice_status coppice_pipelines_ready(const coppice_context* context, VkBool32* ready) {
  if (ready != nullptr) *ready = VK_FALSE;
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(ready == nullptr ? "ready is null" : "");
  const auto all = context->context->pipelines().ready();
  if (!all) return static_cast<coppice_status>(all.error().status);  // the log has it
  *ready = *all ? VK_TRUE : VK_FALSE;
  return COPPICE_OK;
}

coppice_status coppice_set_memory_budget(coppice_context* context, uint64_t bytes) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  return finish(*context, __func__, context->context->set_memory_budget(bytes));
}

coppice_status coppice_plant_open(coppice_context* context, const char* path, coppice_plant* plant) {
  if (plant != nullptr) *plant = 0;
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(path == nullptr ? "path is null" : plant == nullptr ? "plant is null" : "");
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  return finish_open(context->context->open_plant(path), plant);
}

coppice_status coppice_plant_open_async(coppice_context* context, const char* path, coppice_plant* plant) {
  if (plant != nullptr) *plant = 0;
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(path == nullptr ? "path is null" : plant == nullptr ? "plant is null" : "");
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  const auto started = context->context->start_open(path);
  if (!started) coppice::log_line(context->context->log(), COPPICE_LOG_ERROR, "%s: %s", path, started.error().message().c_str());
  return finish_open(started, plant);
}

coppice_status coppice_plant_open_memory(coppice_context* context, const void* bytes, size_t size, const char* name, coppice_plant* plant) {
  if (plant != nullptr) *plant = 0;
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(memory_problem(bytes, size, name));
  COPPICE_REFUSE_IF(plant == nullptr ? "plant is null" : "");
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  return finish_open(context->context->open_plant(memory_source(bytes, size, name)), plant);
}

coppice_status coppice_plant_close(coppice_context* context, coppice_plant plant) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(plant_problem(*context, plant));
  context->context->close_plant(plant);
  return COPPICE_OK;
}

coppice_status coppice_plant_reload(coppice_context* context, coppice_plant plant, const char* path) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(unready_plant_problem(*context, plant));
  return reload(*context, plant, path != nullptr ? std::optional<coppice::PlantSource>(path) : std::nullopt);
}

coppice_status coppice_plant_reload_memory(coppice_context* context, coppice_plant plant, const void* bytes, size_t size,
                                           const char* name) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(unready_plant_problem(*context, plant));
  COPPICE_REFUSE_IF(memory_problem(bytes, size, name));
  return reload(*context, plant, memory_source(bytes, size, name));
}

void coppice_plant_info_init(coppice_plant_info* info) {
  if (info == nullptr) return;
  *info = {};
  info->struct_size = sizeof *info;
}

coppice_status coppice_plant_get_info(const coppice_context* context, coppice_plant plant, coppice_plant_info* info) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(plant_problem(*context, plant));
  COPPICE_REFUSE_IF(coppice::struct_problem(info, "info"));
  context->context->fill_info(plant, *info);
  return COPPICE_OK;
}

coppice_status coppice_instances_add(coppice_context* context, coppice_plant plant, const coppice_placement* placements, uint32_t count,
                                     coppice_instance* instances) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(failed_plant_problem(*context, plant));
  COPPICE_REFUSE_IF(placements == nullptr && count > 0 ? "placements is null" : "");
  for (uint32_t i = 0; i < count; ++i)
    if (const std::string problem = coppice::placement_problem(placements[i]); !problem.empty())
      return invalid(*context, __func__, "placements[" + std::to_string(i) + "]." + problem + "; none was added");
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  const std::span<coppice_instance> handles(instances, instances != nullptr ? count : 0);
  return finish(*context, __func__, context->context->add_instances(plant, {placements, count}, handles));
}

coppice_status coppice_instance_move(coppice_context* context, coppice_instance instance, const coppice_placement* placement) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(instance_problem(*context, instance, "instance"));
  COPPICE_REFUSE_IF(placement == nullptr ? "placement is null" : "");
  if (const std::string problem = coppice::placement_problem(*placement); !problem.empty())
    return invalid(*context, __func__, "placement." + problem);
  context->context->instances().move(instance, *placement);
  return COPPICE_OK;
}

coppice_status coppice_instances_remove(coppice_context* context, const coppice_instance* instances, uint32_t count) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(instances == nullptr && count > 0 ? "instances is null" : "");
  // A handle given twice is removed once. What is not live is refused before anything is removed.
  for (uint32_t i = 0; i < count; ++i)
    if (!context->context->instances().is_live(instances[i]))
      return invalid(*context, __func__,
                     instance_problem(*context, instances[i], "instances[" + std::to_string(i) + "]") + "; none was removed");
  for (uint32_t i = 0; i < count; ++i)
    if (context->context->instances().is_live(instances[i])) context->context->instances().remove(instances[i]);
  return COPPICE_OK;
}

coppice_status coppice_scene_open(coppice_context* context, const char* path, coppice_scene* scene) {
  if (scene != nullptr) *scene = 0;
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(path == nullptr ? "path is null" : scene == nullptr ? "scene is null" : "");
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  COPPICE_REFUSE_IF(context->context->scene() != nullptr ? "a scene is open: close it first" : "");
  auto opened = context->context->open_scene(path);
  if (!opened) return static_cast<coppice_status>(opened.error().status);  // the log has it, with the path
  *scene = *opened;
  return COPPICE_OK;
}

coppice_status coppice_scene_close(coppice_context* context, coppice_scene scene) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(scene_problem(*context, scene));
  context->context->close_scene();
  return COPPICE_OK;
}

void coppice_scene_info_init(coppice_scene_info* info) {
  if (info == nullptr) return;
  *info = {};
  info->struct_size = sizeof *info;
}

coppice_status coppice_scene_get_info(const coppice_context* context, coppice_scene scene, coppice_scene_info* info) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(scene_problem(*context, scene));
  COPPICE_REFUSE_IF(coppice::struct_problem(info, "info"));
  context->context->scene()->fill_info(*info);
  return COPPICE_OK;
}

void coppice_scene_plant_info_init(coppice_scene_plant_info* info) {
  if (info == nullptr) return;
  *info = {};
  info->struct_size = sizeof *info;
}

coppice_status coppice_scene_get_plant(const coppice_context* context, coppice_scene scene, uint32_t species,
                                       coppice_scene_plant_info* info) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(scene_problem(*context, scene));
  COPPICE_REFUSE_IF(coppice::struct_problem(info, "info"));
  COPPICE_REFUSE_IF(
      context->context->scene()->fill_info(species, *info) ? "" : "species " + std::to_string(species) + " is none of the scene's");
  return COPPICE_OK;
}

void coppice_view_desc_init(coppice_view_desc* desc) {
  if (desc == nullptr) return;
  *desc = {};
  desc->struct_size = sizeof *desc;
  desc->depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  desc->samples = VK_SAMPLE_COUNT_1_BIT;
}

coppice_status coppice_view_create(coppice_context* context, const coppice_view_desc* desc, coppice_view* view) {
  if (view != nullptr) *view = 0;
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(view == nullptr ? "view is null" : "");
  COPPICE_REFUSE_IF(coppice::struct_problem(desc, "desc"));
  COPPICE_REFUSE_IF(coppice::view_desc_problem(*desc));
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  const auto created = context->context->create_view(*desc);
  if (!created) return fail(context->context->log(), __func__, created.error());
  *view = *created;
  return COPPICE_OK;
}

coppice_status coppice_view_destroy(coppice_context* context, coppice_view view) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(view_problem(*context, view));
  context->context->destroy_view(view);
  return COPPICE_OK;
}

coppice_status coppice_is_settled(const coppice_context* context, coppice_view view, uint32_t* settled) {
  if (settled != nullptr) *settled = 0;
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(settled == nullptr ? "settled is null" : "");
  COPPICE_REFUSE_IF(view_problem(*context, view));
  *settled = context->context->is_settled(view) ? 1 : 0;
  return COPPICE_OK;
}

void coppice_camera_init(coppice_camera* camera) {
  if (camera == nullptr) return;
  *camera = {};
  camera->struct_size = sizeof *camera;
  camera->error_px = 2.0f;
  camera->lod = COPPICE_LOD_CUT;
  for (int i = 0; i < 16; i += 5) camera->view_from_world[i] = camera->clip_from_view[i] = 1.0f;
}

void coppice_light_init(coppice_light* light) {
  if (light == nullptr) return;
  *light = {};
  light->struct_size = sizeof *light;
  light->sun_direction[1] = 1.0f;
  for (int i = 0; i < 3; ++i) {
    light->sun_color[i] = 3.0f;
    light->sky_color[i] = 0.6f;
    light->ground_color[i] = 0.2f;
  }
}

void coppice_sun_desc_init(coppice_sun_desc* desc) {
  if (desc == nullptr) return;
  *desc = {};
  desc->struct_size = sizeof *desc;
  desc->sun_direction[1] = 1.0f;
}

coppice_status coppice_sun_camera(const coppice_context* context, coppice_view view, const coppice_sun_desc* desc, coppice_camera* camera) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(view_problem(*context, view));
  COPPICE_REFUSE_IF(coppice::struct_problem(desc, "desc"));
  COPPICE_REFUSE_IF(camera == nullptr ? "camera is null" : "");
  COPPICE_REFUSE_IF(coppice::sun_problem(*desc, view_limits(*context)));
  coppice_camera_init(camera);
  camera->view = view;
  camera->width_px = camera->height_px = desc->size_px;
  coppice::set_sun_camera(*camera, *desc, coppice::gpu::is_reversed(context->context->attachments(view).depth_compare));
  return COPPICE_OK;
}

void coppice_frame_init(coppice_frame* frame) {
  if (frame == nullptr) return;
  *frame = {};
  frame->struct_size = sizeof *frame;
  frame->camera_bytes = sizeof(coppice_camera);
}

coppice_status coppice_frame_begin(coppice_context* context, const coppice_frame* frame) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(coppice::struct_problem(frame, "frame"));
  COPPICE_REFUSE_IF(cameras_problem(*context, *frame));
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  return finish(*context, __func__, context->context->begin_frame(*frame, {frame->cameras, frame->camera_count}));
}

coppice_status coppice_record_upload(coppice_context* context, VkCommandBuffer cmd) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(cmd == VK_NULL_HANDLE ? "cmd is null" : "");
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  COPPICE_REFUSE_IF(context->context->recording() != Recording::begun ? "not the first call since coppice_frame_begin" : "");
  return finish(*context, __func__, context->context->record_upload(cmd));
}

coppice_status coppice_record_cull(coppice_context* context, VkCommandBuffer cmd, coppice_view view, const coppice_light* light) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(light != nullptr ? coppice::struct_problem(light, "light") : "");
  COPPICE_REFUSE_IF(light != nullptr ? coppice::light_problem(*light) : "");
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  COPPICE_REFUSE_IF(record_problem(*context, cmd, view));
  coppice_light default_light;
  coppice_light_init(&default_light);
  return finish(*context, __func__, context->context->record_cull(cmd, view, light != nullptr ? *light : default_light));
}

coppice_status coppice_record_draw(coppice_context* context, VkCommandBuffer cmd, coppice_view view) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  if (is_lost(*context)) return COPPICE_ERROR_DEVICE_LOST;
  COPPICE_REFUSE_IF(record_problem(*context, cmd, view));
  COPPICE_REFUSE_IF(context->context->recorder(view).is_culled() ? "" : "coppice_record_cull was not called for the view in this frame");
  context->context->record_draw(cmd, view);
  return COPPICE_OK;
}

void coppice_stats_init(coppice_stats* stats) {
  if (stats == nullptr) return;
  *stats = {};
  stats->struct_size = sizeof *stats;
}

coppice_status coppice_get_stats(const coppice_context* context, coppice_stats* stats) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(coppice::struct_problem(stats, "stats"));
  context->context->fill_stats(*stats);
  return COPPICE_OK;
}

void coppice_view_stats_init(coppice_view_stats* stats) {
  if (stats == nullptr) return;
  *stats = {};
  stats->struct_size = sizeof *stats;
}

coppice_status coppice_get_view_stats(const coppice_context* context, coppice_view view, coppice_view_stats* stats) {
  if (context == nullptr) return COPPICE_ERROR_INVALID_ARGUMENT;
  COPPICE_REFUSE_IF(view_problem(*context, view));
  COPPICE_REFUSE_IF(coppice::struct_problem(stats, "stats"));
  context->context->fill_stats(view, *stats);
  return COPPICE_OK;
}
