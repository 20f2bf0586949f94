// The functions of coppice/vulkan.h: checks what the engine passes, translates, forwards. No logic.

#include <array>
#include <memory>
#include <new>
#include <string>

#include "abi.h"
#include "api_call.h"
#include "api_checks.h"

namespace {

using coppice::ContextOptions;
using Recording = coppice::Context::Recording;

/// A hook that may be left out: `ours` is without functions then. Returns what is wrong, or an empty string.
template <class Hook>
std::string read_hook(const Hook* theirs, const char* name, Hook& ours) {
  ours = coppice::struct_defaults<Hook>();
  return theirs == nullptr ? "" : coppice::read_struct(theirs, name, ours);
}

std::string in_struct(const char* name, const std::string& problem) {
  return problem.empty() ? "" : std::string(name) + "." + problem;
}

/// Returns what is wrong with them, or an empty string. options.hooks.log is set as soon as it can be read.
std::string read_options(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan, ContextOptions& options) {
  std::string problem = coppice::read_struct(desc, "desc", options.desc);
  const std::string log_problem = read_hook(options.desc.log, "desc.log", options.hooks.log);
  const auto check = [&problem](std::string next) {
    if (problem.empty()) problem = std::move(next);
  };
  check(log_problem);
  check(read_hook(options.desc.allocator, "desc.allocator", options.hooks.allocator));
  check(read_hook(options.desc.jobs, "desc.jobs", options.hooks.jobs));
  check(read_hook(options.desc.io, "desc.io", options.hooks.io));
  check(read_hook(options.desc.trace, "desc.trace", options.hooks.trace));
  check(coppice::read_struct(vulkan, "vulkan", options.vulkan));
  check(read_hook(options.vulkan.device_memory, "vulkan.device_memory", options.device_memory));
  check(in_struct("desc", coppice::desc_problem(options.desc)));
  check(in_struct("vulkan", coppice::vulkan_problem(options.vulkan)));
  check(in_struct("vulkan.device_memory", coppice::device_memory_problem(options.device_memory)));
  return problem;
}

coppice_status fail(const ContextOptions& options, const char* function, const coppice::Error& error) {
  return coppice::fail_without_context(options.hooks.log, function, static_cast<coppice_status>(error.status), error.message());
}

coppice_status refuse(const ContextOptions& options, const char* function, const std::string& problem) {
  return coppice::fail_without_context(options.hooks.log, function, COPPICE_ERROR_INVALID_ARGUMENT, problem);
}

using ShadowMaps = std::array<coppice_shadow_map, COPPICE_MAX_SHADOW_MAPS>;

/// Reads a light that may be null, and checks it. maps: that ours.shadow_maps becomes
std::string read_light(const coppice_light* theirs, coppice_light& ours, ShadowMaps& maps) {
  ours = coppice::struct_defaults<coppice_light>();
  if (theirs == nullptr) return {};
  if (std::string problem = coppice::read_struct(theirs, "light", ours); !problem.empty()) return problem;
  if (ours.shadow_map_count <= maps.size()) {
    if (std::string problem = coppice::records_problem(ours.shadow_maps, ours.shadow_map_count, ours.shadow_map_bytes, "light.shadow_maps");
        !problem.empty())
      return problem;
    for (std::size_t i = 0; i < ours.shadow_map_count; ++i)
      if (std::string problem = coppice::read_record(ours.shadow_maps, i, ours.shadow_map_bytes, "light.shadow_maps", maps[i]);
          !problem.empty())
        return problem;
  }
  ours.shadow_maps = maps.data();
  return in_struct("light", coppice::light_problem(ours));
}

/// What recording culls and draws have in common.
std::string recording_problem(coppice::Context& context, coppice_view view) {
  if (context.recording() != Recording::uploaded) return "coppice_record_upload was not called for this frame";
  return context.recorder(view).is_shown() ? "" : "view has no camera in this frame";
}

}  // namespace

coppice_status coppice_vulkan_context_create(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan,
                                             coppice_context** context) {
  if (context != nullptr) *context = nullptr;
  ContextOptions options;
  if (const std::string problem = read_options(desc, vulkan, options); !problem.empty()) return refuse(options, __func__, problem);
  if (context == nullptr) return refuse(options, __func__, "context is null");
  auto created = coppice::Context::create(options);
  if (!created) return fail(options, __func__, created.error());
  *context = new (std::nothrow) coppice_context{.context = *std::move(created)};
  return *context != nullptr ? COPPICE_OK : fail(options, __func__, {coppice::Status::out_of_memory, "context"});
}

coppice_status coppice_vulkan_context_cost(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan, uint64_t* bytes) {
  if (bytes != nullptr) *bytes = 0;
  ContextOptions options;
  if (const std::string problem = read_options(desc, vulkan, options); !problem.empty()) return refuse(options, __func__, problem);
  if (bytes == nullptr) return refuse(options, __func__, "bytes is null");
  const auto cost = coppice::Context::cost(options);
  if (!cost) return fail(options, __func__, cost.error());
  *bytes = *cost;
  return COPPICE_OK;
}

coppice_status coppice_pipelines_ready(const coppice_context* context, VkBool32* ready) {
  if (ready != nullptr) *ready = VK_FALSE;
  COPPICE_BEGIN_CALL(shared);
  if (ready == nullptr) return call.refuse("ready is null");
  const auto all = context->context->pipelines().ready();
  if (!all) return call.logged(all.error());
  *ready = *all ? VK_TRUE : VK_FALSE;
  return COPPICE_OK;
}

coppice_status coppice_vulkan_view_create(coppice_context* context, const coppice_view_desc* desc, const coppice_vulkan_view_desc* vulkan,
                                          coppice_view* view) {
  if (view != nullptr) *view = 0;
  COPPICE_BEGIN_CALL(exclusive);
  coppice_view_desc of_view;
  COPPICE_REFUSE_IF(coppice::read_struct(desc, "desc", of_view));
  coppice_vulkan_view_desc attachments;
  COPPICE_REFUSE_IF(coppice::read_struct(vulkan, "vulkan", attachments));
  if (view == nullptr) return call.refuse("view is null");
  COPPICE_REFUSE_IF(in_struct("desc", coppice::view_desc_problem(of_view)));
  COPPICE_REFUSE_IF(in_struct("vulkan", coppice::vulkan_view_problem(of_view, attachments)));
  if (!context->context->device_state()) return call.lost();
  const auto created = context->context->create_view(of_view, attachments);
  if (!created) return call.finish(created.error());
  *view = *created;
  return COPPICE_OK;
}

coppice_status coppice_record_upload(coppice_context* context, VkCommandBuffer cmd) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(cmd == VK_NULL_HANDLE ? "cmd is null" : "");
  if (!context->context->device_state()) return call.lost();
  COPPICE_REFUSE_IF(context->context->recording() != Recording::begun ? "not the first call since coppice_frame_begin" : "");
  return call.finish(context->context->record_upload(cmd));
}

coppice_status coppice_record_cull(coppice_context* context, VkCommandBuffer cmd, coppice_view view, const coppice_light* light) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(cmd == VK_NULL_HANDLE ? "cmd is null" : "");
  COPPICE_REFUSE_IF(coppice::view_problem(*context, view));
  coppice_light ours;
  ShadowMaps maps;
  COPPICE_REFUSE_IF(read_light(light, ours, maps));
  if (!context->context->device_state()) return call.lost();
  COPPICE_REFUSE_IF(recording_problem(*context->context, view));
  return call.finish(context->context->record_cull(cmd, view, ours));
}

coppice_status coppice_record_draw(coppice_context* context, VkCommandBuffer cmd, coppice_view view) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(cmd == VK_NULL_HANDLE ? "cmd is null" : "");
  COPPICE_REFUSE_IF(coppice::view_problem(*context, view));
  if (!context->context->device_state()) return call.lost();
  COPPICE_REFUSE_IF(recording_problem(*context->context, view));
  COPPICE_REFUSE_IF(context->context->recorder(view).is_culled() ? "" : "coppice_record_cull was not called for the view in this frame");
  context->context->record_draw(cmd, view);
  return COPPICE_OK;
}
