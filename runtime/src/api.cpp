// The C API: checks the engine's arguments, translates, forwards. No logic.

#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "abi.h"
#include "api_call.h"
#include "api_checks.h"
#include "api_fields.h"
#include "frame_wind.h"

namespace {

using coppice::Call;
using coppice::failed_plant_problem, coppice::finish_open, coppice::placements_problem, coppice::plant_problem;
using coppice::HandleKind;
using coppice::gpu::InstanceTable;
using coppice::gpu::PlacementRecords;

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

/// source  none for the one that the plant was opened from
coppice_status reload(const Call& call, coppice::Context& context, coppice_plant plant, const std::optional<coppice::PlantSource>& source) {
  if (!context.device_state()) return call.lost();
  const auto reloaded = context.reload_plant(plant, source);
  return reloaded ? COPPICE_OK : call.logged(reloaded.error(), source ? source->name : context.plant_path(plant));
}

/// name  of the argument
std::string instance_problem(const coppice_context& context, coppice_instance instance, const std::string& name) {
  if (context.context->instances().is_live(instance)) return {};
  const std::string problem = coppice::handle_problem(instance, HandleKind::instance, context.context->tag());
  return name + " " + (problem.empty() ? "has been removed" : problem);
}

/// The first of the handles that is not live. rest: what has not been done then
std::string instances_problem(const coppice_context& context, std::span<const coppice_instance> instances, const char* rest) {
  for (std::size_t i = 0; i < instances.size(); ++i)
    if (!context.context->instances().is_live(instances[i]))
      return instance_problem(context, instances[i], "instances[" + std::to_string(i) + "]") + rest;
  return {};
}

/// Returns the number of handles that were dead.
uint32_t remove_live(std::span<const coppice_instance> handles, InstanceTable& instances) {
  uint32_t dead = 0;
  for (const coppice_instance handle : handles) {
    if (instances.is_live(handle))
      instances.remove(handle);
    else
      ++dead;
  }
  return dead;
}

std::string null_problem(const coppice_instance* instances, uint32_t count) {
  return instances == nullptr && count > 0 ? "instances is null" : "";
}

coppice::ViewLimits view_limits(const coppice_context& context) {
  const coppice::BackendLimits& limits = context.context->limits();
  return {limits.max_view_width_px, limits.max_view_height_px};
}

/// Reads the frame's cameras and checks them.
std::string read_cameras(coppice_context& context, const coppice_frame& frame) {
  std::vector<coppice_camera>& ours = context.cameras;
  if (std::string problem = coppice::records_problem(frame.cameras, frame.camera_count, frame.camera_bytes, "frame.cameras");
      !problem.empty())
    return problem;
  ours.resize(frame.camera_count);
  context.second_eyes.resize(frame.camera_count);
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const std::string name = "frame.cameras[" + std::to_string(i) + "]";
    const auto* theirs = reinterpret_cast<const unsigned char*>(frame.cameras) + i * frame.camera_bytes;
    if (std::string problem = coppice::read_struct(reinterpret_cast<const coppice_camera*>(theirs), name.c_str(), ours[i]);
        !problem.empty())
      return problem;
    if (std::string problem = coppice::view_problem(context, ours[i].view, name + ".view"); !problem.empty()) return problem;
    for (std::size_t other = 0; other < i; ++other)
      if (ours[other].view == ours[i].view) return name + ".view is that of frame.cameras[" + std::to_string(other) + "] too";
    if (ours[i].second_eye != nullptr) {
      coppice_eye& eye = context.second_eyes[i];
      if (std::string problem = coppice::read_struct(ours[i].second_eye, (name + ".second_eye").c_str(), eye); !problem.empty())
        return problem;
      ours[i].second_eye = &eye;
    }
    if (const std::string problem = coppice::camera_problem(ours[i], view_limits(context)); !problem.empty()) return name + "." + problem;
  }
  return {};
}

}  // namespace

std::string coppice::plant_problem(const coppice_context& context, coppice_plant plant) {
  if (context.context->is_open(plant)) return {};
  const std::string problem = handle_problem(plant, HandleKind::plant, context.context->tag());
  return "plant " + (problem.empty() ? "has been closed" : problem);
}

std::string coppice::failed_plant_problem(const coppice_context& context, coppice_plant plant) {
  if (std::string problem = plant_problem(context, plant); !problem.empty()) return problem;
  return context.context->plant_state(plant) == COPPICE_PLANT_FAILED ? "plant could not be opened: close it" : "";
}

std::string coppice::view_problem(const coppice_context& context, coppice_view view, const std::string& name) {
  if (context.context->is_view(view)) return {};
  const std::string problem = handle_problem(view, HandleKind::view, context.context->tag());
  return name + " " + (problem.empty() ? "has been destroyed" : problem);
}

std::string coppice::placements_problem(const coppice_context& context, const gpu::PlacementRecords& records, const char* rest,
                                        const coppice_instance* movers) {
  if (records.count == 0) return {};
  if (records.first == nullptr) return "placements is null";
  if (records.stride < sizeof(coppice_placement::position)) return "stride is " + std::to_string(records.stride) + ": less than a position";
  for (std::size_t i = 0; i < records.count; ++i) {
    if (movers != nullptr && !context.context->instances().is_live(movers[i])) continue;
    if (const std::string problem = placement_problem(records[i], context.context->origin()); !problem.empty())
      return "placements[" + std::to_string(i) + "]." + problem + rest;
  }
  return {};
}

uint32_t coppice_version() {
  return COPPICE_HEADER_VERSION;
}

const char* coppice_status_text(coppice_status status) {
  static constexpr const char* kTexts[] = {"success",
                                           "invalid argument",
                                           "a file could not be read",
                                           "not a file of the kind, damaged, or of another version",
                                           "the device lacks something required",
                                           "out of memory",
                                           "the Vulkan device is lost",
                                           "internal error"};
  static_assert(std::size(kTexts) == COPPICE_ERROR_INTERNAL + 1);
  const auto index = static_cast<std::size_t>(status);
  return index < std::size(kTexts) ? kTexts[index] : "unknown status";
}

void coppice_context_destroy(coppice_context* context) {
  if (context == nullptr) return;
  {
    const Call call(context, __func__, coppice::CallGuard::Access::exclusive);
    if (call.begun() != COPPICE_OK) return;
  }
  delete context;
}

coppice_status coppice_set_memory_budget(coppice_context* context, uint64_t bytes) {
  COPPICE_BEGIN_CALL(exclusive);
  return call.finish(context->context->set_memory_budget(bytes));
}

coppice_status coppice_trim(coppice_context* context, uint64_t target_bytes) {
  COPPICE_BEGIN_CALL(exclusive);
  return call.finish(context->context->trim(target_bytes));
}

coppice_status coppice_retry_failed(coppice_context* context) {
  COPPICE_BEGIN_CALL(exclusive);
  context->context->retry_failed();
  return COPPICE_OK;
}

coppice_status coppice_plant_open(coppice_context* context, const char* path, coppice_plant* plant) {
  if (plant != nullptr) *plant = 0;
  COPPICE_BEGIN_CALL(exclusive);
  if (path == nullptr || plant == nullptr) return call.refuse(path == nullptr ? "path is null" : "plant is null");
  if (!context->context->device_state()) return call.lost();
  return finish_open(call, path, context->context->open_plant(path), plant);
}

coppice_status coppice_plant_open_async(coppice_context* context, const char* path, coppice_plant* plant) {
  if (plant != nullptr) *plant = 0;
  COPPICE_BEGIN_CALL(exclusive);
  if (path == nullptr || plant == nullptr) return call.refuse(path == nullptr ? "path is null" : "plant is null");
  if (!context->context->device_state()) return call.lost();
  const auto started = context->context->start_open(path);
  if (!started) coppice::log_line(context->context->log(), COPPICE_LOG_ERROR, "%s: %s", path, started.error().message().c_str());
  return finish_open(call, path, started, plant);
}

coppice_status coppice_plant_open_memory(coppice_context* context, const void* bytes, size_t size, const char* name, coppice_plant* plant) {
  if (plant != nullptr) *plant = 0;
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(memory_problem(bytes, size, name));
  if (plant == nullptr) return call.refuse("plant is null");
  if (!context->context->device_state()) return call.lost();
  return finish_open(call, name, context->context->open_plant(memory_source(bytes, size, name)), plant);
}

coppice_status coppice_plant_close(coppice_context* context, coppice_plant plant) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(plant_problem(*context, plant));
  context->context->close_plant(plant);
  return COPPICE_OK;
}

coppice_status coppice_plant_reload(coppice_context* context, coppice_plant plant, const char* path) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(unready_plant_problem(*context, plant));
  return reload(call, *context->context, plant, path != nullptr ? std::optional<coppice::PlantSource>(path) : std::nullopt);
}

coppice_status coppice_plant_reload_memory(coppice_context* context, coppice_plant plant, const void* bytes, size_t size,
                                           const char* name) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(unready_plant_problem(*context, plant));
  COPPICE_REFUSE_IF(memory_problem(bytes, size, name));
  return reload(call, *context->context, plant, memory_source(bytes, size, name));
}

coppice_status coppice_plant_get_info(const coppice_context* context, coppice_plant plant, coppice_plant_info* info) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(plant_problem(*context, plant));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(info, "info"));
  auto ours = coppice::struct_defaults<coppice_plant_info>();
  context->context->fill_info(plant, ours);
  coppice::write_struct(ours, info);
  return COPPICE_OK;
}

coppice_status coppice_set_origin(coppice_context* context, const double* origin) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(origin == nullptr ? "origin is null" : coppice::origin_problem(std::span<const double, 3>(origin, 3)));
  context->context->set_origin({origin[0], origin[1], origin[2]});
  return COPPICE_OK;
}

coppice_status coppice_instances_add(coppice_context* context, coppice_plant plant, const coppice_placement* placements, size_t stride,
                                     uint32_t count, coppice_instance* instances) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(failed_plant_problem(*context, plant));
  const PlacementRecords records{placements, stride, count};
  COPPICE_REFUSE_IF(placements_problem(*context, records, "; none was added"));
  if (!context->context->device_state()) return call.lost();
  const std::span<coppice_instance> handles(instances, instances != nullptr ? count : 0);
  return call.finish(context->context->add_instances(plant, records, handles));
}

coppice_status coppice_instances_move(coppice_context* context, const coppice_instance* instances, const coppice_placement* placements,
                                      size_t stride, uint32_t count) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(null_problem(instances, count));
  COPPICE_REFUSE_IF(instances_problem(*context, {instances, count}, "; none was moved"));
  const PlacementRecords records{placements, stride, count};
  COPPICE_REFUSE_IF(placements_problem(*context, records, "; none was moved"));
  for (uint32_t i = 0; i < count; ++i) context->context->instances().move(instances[i], records[i]);
  return COPPICE_OK;
}

coppice_status coppice_instances_remove(coppice_context* context, const coppice_instance* instances, uint32_t count) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(null_problem(instances, count));
  // A handle given twice is removed once. Dead handles are refused before anything is removed.
  COPPICE_REFUSE_IF(instances_problem(*context, {instances, count}, "; none was removed"));
  remove_live({instances, count}, context->context->instances());
  return COPPICE_OK;
}

coppice_status coppice_instance_is_live(const coppice_context* context, coppice_instance instance, uint32_t* live) {
  if (live != nullptr) *live = COPPICE_FALSE;
  COPPICE_BEGIN_CALL(shared);
  if (live == nullptr) return call.refuse("live is null");
  *live = context->context->instances().is_live(instance) ? COPPICE_TRUE : COPPICE_FALSE;
  return COPPICE_OK;
}

coppice_status coppice_instances_move_live(coppice_context* context, const coppice_instance* instances, const coppice_placement* placements,
                                           size_t stride, uint32_t count, uint32_t* skipped) {
  if (skipped != nullptr) *skipped = 0;
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(null_problem(instances, count));
  const PlacementRecords records{placements, stride, count};
  COPPICE_REFUSE_IF(placements_problem(*context, records, "; none was moved", instances));
  uint32_t dead = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (context->context->instances().is_live(instances[i]))
      context->context->instances().move(instances[i], records[i]);
    else
      ++dead;
  }
  if (skipped != nullptr) *skipped = dead;
  return COPPICE_OK;
}

coppice_status coppice_instances_remove_live(coppice_context* context, const coppice_instance* instances, uint32_t count,
                                             uint32_t* skipped) {
  if (skipped != nullptr) *skipped = 0;
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(null_problem(instances, count));
  const uint32_t dead = remove_live({instances, count}, context->context->instances());
  if (skipped != nullptr) *skipped = dead;
  return COPPICE_OK;
}

coppice_status coppice_instances_fade_in(coppice_context* context, const coppice_instance* instances, uint32_t count, uint32_t frames) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(null_problem(instances, count));
  COPPICE_REFUSE_IF(coppice::size_problem("frames", frames, InstanceTable::kMaxGrowthFrames));
  COPPICE_REFUSE_IF(instances_problem(*context, {instances, count}, "; none fades in"));
  for (uint32_t i = 0; i < count; ++i) context->context->instances().grow(instances[i], frames);
  return COPPICE_OK;
}

coppice_status coppice_get_stats(const coppice_context* context, coppice_stats* stats) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(coppice::struct_size_problem(stats, "stats"));
  auto ours = coppice::struct_defaults<coppice_stats>();
  context->context->fill_stats(ours);
  coppice::write_struct(ours, stats);
  return COPPICE_OK;
}

coppice_status coppice_view_destroy(coppice_context* context, coppice_view view) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(coppice::view_problem(*context, view));
  context->context->destroy_view(view);
  return COPPICE_OK;
}

coppice_status coppice_is_settled(const coppice_context* context, coppice_view view, uint32_t* settled) {
  if (settled != nullptr) *settled = COPPICE_FALSE;
  COPPICE_BEGIN_CALL(shared);
  if (settled == nullptr) return call.refuse("settled is null");
  COPPICE_REFUSE_IF(coppice::view_problem(*context, view));
  *settled = context->context->is_settled(view) ? COPPICE_TRUE : COPPICE_FALSE;
  return COPPICE_OK;
}

coppice_status coppice_sun_camera(const coppice_context* context, coppice_view view, const coppice_sun_desc* desc, coppice_camera* camera) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(coppice::view_problem(*context, view));
  coppice_sun_desc ours;
  COPPICE_REFUSE_IF(coppice::read_struct(desc, "desc", ours));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(camera, "camera"));
  if (const std::string problem = coppice::sun_problem(ours, view_limits(*context)); !problem.empty())
    return call.refuse("desc." + problem);
  coppice::write_struct(context->context->sun_camera(view, ours), camera);
  return COPPICE_OK;
}

coppice_status coppice_wind_gusts(const coppice_context* context, const coppice_wind* wind, const double place[3], coppice_gusts* gusts) {
  COPPICE_BEGIN_CALL(shared);
  coppice_wind ours;
  COPPICE_REFUSE_IF(coppice::read_struct(wind, "wind", ours));
  COPPICE_REFUSE_IF(coppice::in_struct("wind", coppice::wind_problem(ours)));
  if (place == nullptr) return call.refuse("place is null");
  COPPICE_REFUSE_IF(coppice::place_problem(std::span<const double, 3>(place, 3)));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(gusts, "gusts"));
  auto filled = coppice::struct_defaults<coppice_gusts>();
  coppice::set_gusts({.wind = ours}, coppice::dvec3{place[0], place[1], place[2]} + context->context->origin(), filled);
  coppice::write_struct(filled, gusts);
  return COPPICE_OK;
}

coppice_status coppice_frame_begin(coppice_context* context, const coppice_frame* frame) {
  COPPICE_BEGIN_CALL(exclusive);
  coppice_frame ours;
  COPPICE_REFUSE_IF(coppice::read_struct(frame, "frame", ours));
  auto wind = coppice::struct_defaults<coppice_wind>();
  if (ours.wind != nullptr) COPPICE_REFUSE_IF(coppice::read_struct(ours.wind, "frame.wind", wind));
  COPPICE_REFUSE_IF(coppice::in_struct("frame.wind", coppice::wind_problem(wind)));
  ours.wind = &wind;
  COPPICE_REFUSE_IF(read_cameras(*context, ours));
  if (!context->context->device_state()) return call.lost();
  return call.finish(context->context->begin_frame(ours, context->cameras));
}

coppice_status coppice_get_view_stats(const coppice_context* context, coppice_view view, coppice_view_stats* stats) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(coppice::view_problem(*context, view));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(stats, "stats"));
  auto ours = coppice::struct_defaults<coppice_view_stats>();
  context->context->fill_stats(view, ours);
  coppice::write_struct(ours, stats);
  return COPPICE_OK;
}
