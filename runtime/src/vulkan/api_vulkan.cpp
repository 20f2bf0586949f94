// The functions of coppice/vulkan.h: checks the engine's arguments, translates, forwards. No logic.

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <string>
#include <vector>

#include "abi.h"
#include "api_call.h"
#include "api_checks.h"
#include "attachments.h"
#include "debug_label.h"
#include "vulkan_abi.h"
#include "vulkan_backend.h"
#include "vulkan_checks.h"

namespace {

using coppice::ContextOptions;
using coppice::in_struct;
using coppice::VulkanOptions;
using Recording = coppice::Context::Recording;

/// Returns what is wrong with them, or an empty string. options.hooks.log is set as soon as it can be read.
std::string read_options(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan, ContextOptions& options,
                         VulkanOptions& vulkan_options) {
  std::string problem = coppice::read_options(desc, options);
  const auto check = [&problem](std::string next) {
    if (problem.empty()) problem = std::move(next);
  };
  check(coppice::read_struct(vulkan, "vulkan", vulkan_options.desc));
  check(coppice::read_hook(vulkan_options.desc.device_memory, "vulkan.device_memory", vulkan_options.device_memory));
  check(in_struct("vulkan", coppice::vulkan_problem(vulkan_options.desc)));
  check(in_struct("vulkan.device_memory", coppice::device_memory_problem(vulkan_options.device_memory)));
  return problem;
}

coppice::MakeBackend make_renderer(const VulkanOptions& vulkan) {
  return [&vulkan](const coppice::BackendOptions& options) { return coppice::VulkanBackend::create(vulkan, options); };
}

/// Refuses a context that coppice_context_create has made.
std::string renderer_problem(const coppice_context& context) {
  return context.context->renderer() == nullptr ? "the context has no renderer: coppice_vulkan_context_create makes one that has" : "";
}

coppice::gpu::ViewRecorder& recorder(const coppice::Context& context, coppice_view view) {
  return context.renderer()->view(context.backend_view(view));
}

coppice::gpu::AttachmentDesc attachments_of(coppice_output output, const coppice_vulkan_view_desc& desc) {
  coppice::gpu::AttachmentDesc attachments{.depth_format = desc.depth_format,
                                           .depth_compare = desc.depth_compare,
                                           .samples = desc.samples,
                                           .has_stencil = desc.has_stencil == VK_TRUE && desc.render_pass == VK_NULL_HANDLE,
                                           .render_pass = desc.render_pass,
                                           .subpass = desc.subpass};
  std::uint32_t& count = attachments.color_count;
  for (; count < COPPICE_MAX_COLORS && desc.color_formats[count] != VK_FORMAT_UNDEFINED; ++count) {
    attachments.color_formats[count] = desc.color_formats[count];
    attachments.contents[count] = coppice::content_of(output, desc, count);
  }
  return attachments;
}

coppice::gpu::MaterialOverride gpu_override(const coppice_material_override& ours) {
  const float* const p = ours.parameters;
  return {.leaf_tint = coppice::vec3(ours.leaf_tint),
          .leaf_roughness = ours.leaf_roughness,
          .wood_tint = coppice::vec3(ours.wood_tint),
          .wood_roughness = ours.wood_roughness,
          .translucency = ours.translucency,
          .parameters = {p[0], p[1], p[2], p[3]}};
}

/// The plant's triangles as far as they are resident.
coppice::gpu::CutTriangles cut_of(const coppice::LodPlant& plant, const coppice_triangles& asked) {
  coppice::gpu::CutTriangles cut{.leaf_meshes = asked.leaf_count == 0.0f && plant.leaf_meshes_resident};
  if (asked.leaf_count > 0.0f)
    cut.leaf_count = std::min(coppice::lod::coppice_whole_leaf_count(asked.leaf_count), plant.resident_leaf_count);
  if (asked.wood_lod == COPPICE_NONE) return cut;
  const std::uint32_t resident = asked.wood_lod < 32 ? plant.resident_wood_mask >> asked.wood_lod : 0;
  if (resident != 0) cut.wood_lod = asked.wood_lod + static_cast<std::uint32_t>(std::countr_zero(resident));
  return cut;
}

struct PlannedView {
  coppice_planned_view planned{};
  coppice::gpu::AttachmentDesc attachments;
};

/// Reads and checks planned views; returns what is wrong with them, or an empty string.
std::string read_planned(const coppice_planned_view* views, std::uint32_t count, std::uint32_t bytes, std::vector<PlannedView>& planned) {
  if (std::string problem = coppice::records_problem(views, count, bytes, "views"); !problem.empty()) return problem;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string name = "views[" + std::to_string(i) + "]";
    PlannedView view;
    if (std::string problem = coppice::read_record(views, i, bytes, "views", view.planned); !problem.empty()) return problem;
    coppice_vulkan_view_desc desc;
    if (std::string problem = coppice::read_struct(view.planned.vulkan, (name + ".vulkan").c_str(), desc); !problem.empty()) return problem;
    auto of_view = coppice::struct_defaults<coppice_view_desc>();
    of_view.output = view.planned.output;
    std::string problem = coppice::view_desc_problem(of_view);
    if (problem.empty()) problem = coppice::vulkan_view_problem(of_view, desc);
    if (problem.empty() && (view.planned.eye_count < 1 || view.planned.eye_count > coppice::kMaxEyes))
      problem = "eye_count is neither 1 nor 2";
    if (problem.empty() && (view.planned.width_px == 0 || view.planned.height_px == 0)) problem = "width_px or height_px is 0";
    if (!problem.empty()) return in_struct(name.c_str(), problem);
    view.attachments = attachments_of(of_view.output, desc);
    planned.push_back(view);
  }
  return {};
}

using ShadowMaps = std::array<coppice_shadow_map, COPPICE_MAX_SHADOW_MAPS>;

/// A light and the data that it points to.
struct OwnedLight {
  coppice_light light;
  ShadowMaps maps;
  coppice_occluder occluder;
};

/// Reads a light that may be null, and checks it.
std::string read_light(const coppice_light* theirs, OwnedLight& owned) {
  auto& [ours, maps, occluder] = owned;
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
  if (ours.occluder != nullptr) {
    if (std::string problem = coppice::read_struct(ours.occluder, "light.occluder", occluder); !problem.empty()) return problem;
    ours.occluder = &occluder;
  }
  return in_struct("light", coppice::light_problem(ours));
}

/// The checks that recording culls and draws share.
std::string upload_problem(const coppice::Context& context) {
  return context.recording() == Recording::uploaded ? "" : "coppice_record_upload was not called for this frame";
}

std::string recording_problem(const coppice::Context& context, coppice_view view) {
  if (std::string problem = upload_problem(context); !problem.empty()) return problem;
  return recorder(context, view).is_shown() ? "" : "view has no camera in this frame";
}

/// errors  as coppice_vulkan_view_create
coppice::Result<coppice_view> create_view(coppice::Context& context, const coppice_view_desc& desc,
                                          const coppice::gpu::AttachmentDesc& attachments) {
  coppice::gpu::Renderer& renderer = *context.renderer();
  COPPICE_CHECK(coppice::gpu::check_attachments(renderer.device(), attachments));
  COPPICE_TRY(added, renderer.add_view(attachments));
  auto view = context.create_view(desc, added);
  if (!view) renderer.remove_view(added);
  if (!view) return view.error();
  if (const auto alive = context.device_state(); !alive) {  // a job may have found that the device is lost
    context.destroy_view(*view);
    return alive.error();
  }
  return *view;
}

}  // namespace

coppice_status coppice_vulkan_context_create(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan,
                                             coppice_context** context) {
  if (context != nullptr) *context = nullptr;
  ContextOptions options;
  VulkanOptions of_vulkan;
  if (const std::string problem = read_options(desc, vulkan, options, of_vulkan); !problem.empty())
    return coppice::refuse(options, __func__, problem);
  if (context == nullptr) return coppice::refuse(options, __func__, "context is null");
  return coppice::create_context(options, make_renderer(of_vulkan), __func__, context);
}

coppice_status coppice_vulkan_context_cost(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan, uint64_t* bytes) {
  if (bytes != nullptr) *bytes = 0;
  ContextOptions options;
  VulkanOptions of_vulkan;
  if (const std::string problem = read_options(desc, vulkan, options, of_vulkan); !problem.empty())
    return coppice::refuse(options, __func__, problem);
  if (bytes == nullptr) return coppice::refuse(options, __func__, "bytes is null");
  const auto cost = coppice::Context::cost(options, make_renderer(of_vulkan));
  if (!cost) return coppice::fail(options, __func__, cost.error());
  *bytes = *cost;
  return COPPICE_OK;
}

coppice_status coppice_pipelines_ready(const coppice_context* context, VkBool32* ready) {
  if (ready != nullptr) *ready = VK_FALSE;
  COPPICE_BEGIN_CALL(shared);
  if (ready == nullptr) return call.refuse("ready is null");
  COPPICE_REFUSE_IF(renderer_problem(*context));
  const auto all = context->context->renderer()->pipelines().ready();
  if (!all) return call.logged(all.error());
  *ready = *all ? VK_TRUE : VK_FALSE;
  return COPPICE_OK;
}

coppice_status coppice_vulkan_view_create(coppice_context* context, const coppice_view_desc* desc, const coppice_vulkan_view_desc* vulkan,
                                          coppice_view* view) {
  if (view != nullptr) *view = 0;
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(renderer_problem(*context));
  coppice_view_desc of_view;
  COPPICE_REFUSE_IF(coppice::read_struct(desc, "desc", of_view));
  coppice_vulkan_view_desc attachments;
  COPPICE_REFUSE_IF(coppice::read_struct(vulkan, "vulkan", attachments));
  if (view == nullptr) return call.refuse("view is null");
  COPPICE_REFUSE_IF(in_struct("desc", coppice::view_desc_problem(of_view)));
  COPPICE_REFUSE_IF(in_struct("vulkan", coppice::vulkan_view_problem(of_view, attachments)));
  if (!context->context->device_state()) return call.lost();
  const auto created = create_view(*context->context, of_view, attachments_of(of_view.output, attachments));
  if (!created) return call.finish(created.error());
  *view = *created;
  return COPPICE_OK;
}

coppice_status coppice_set_material_override(coppice_context* context, coppice_plant plant,
                                             const coppice_material_override* material_override) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(renderer_problem(*context));
  COPPICE_REFUSE_IF(coppice::plant_problem(*context, plant));
  if (material_override == nullptr) {
    context->context->set_override(plant, std::nullopt);
    return COPPICE_OK;
  }
  coppice_material_override ours;
  COPPICE_REFUSE_IF(coppice::read_struct(material_override, "material_override", ours));
  COPPICE_REFUSE_IF(in_struct("material_override", coppice::override_problem(ours)));
  context->context->set_override(plant, gpu_override(ours));
  return COPPICE_OK;
}

coppice_status coppice_vulkan_view_cost(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan,
                                        const coppice_planned_view* views, uint32_t view_count, uint32_t view_bytes,
                                        uint32_t instance_count, uint64_t* bytes) {
  if (bytes != nullptr) *bytes = 0;
  ContextOptions options;
  VulkanOptions of_vulkan;
  std::vector<PlannedView> planned;
  std::string problem = read_options(desc, vulkan, options, of_vulkan);
  if (problem.empty()) problem = read_planned(views, view_count, view_bytes, planned);
  if (problem.empty() && instance_count > options.desc.max_instances) problem = "instance_count is above desc.max_instances";
  if (problem.empty() && bytes == nullptr) problem = "bytes is null";
  if (!problem.empty()) return coppice::refuse(options, __func__, problem);
  const auto add_views = [&planned](coppice::Backend& backend) -> coppice::Result<std::uint64_t> {
    coppice::gpu::Renderer& renderer = *backend.renderer();
    std::uint64_t picture_bytes = 0;
    for (const PlannedView& view : planned) {
      COPPICE_CHECK(coppice::gpu::check_attachments(renderer.device(), view.attachments));
      COPPICE_CHECK(renderer.add_view(view.attachments));
      picture_bytes += renderer.picture_bytes(view.planned.width_px, view.planned.height_px, view.planned.eye_count);
    }
    return picture_bytes;
  };
  const auto cost = coppice::Context::cost(options, make_renderer(of_vulkan), add_views, instance_count);
  if (!cost) return coppice::fail(options, __func__, cost.error());
  *bytes = *cost;
  return COPPICE_OK;
}

coppice_status coppice_record_upload(coppice_context* context, VkCommandBuffer cmd) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(cmd == VK_NULL_HANDLE ? "cmd is null" : "");
  COPPICE_REFUSE_IF(renderer_problem(*context));
  if (!context->context->device_state()) return call.lost();
  COPPICE_REFUSE_IF(context->context->recording() != Recording::begun ? "not the first call since coppice_frame_begin" : "");
  const coppice::TraceScope trace(context->context->hooks().trace, COPPICE_TRACE_RECORD_UPLOAD);
  std::optional<coppice::gpu::DebugLabel> label;  // not for a queue that may only transfer
  const coppice::gpu::Device& device = context->context->renderer()->device();
  if (device.queue_families.empty()) label.emplace(device, cmd, __func__);
  context->context->renderer()->record_upload_begin(cmd);
  return call.finish(context->context->upload());
}

coppice_status coppice_record_cull(coppice_context* context, VkCommandBuffer cmd, coppice_view view, const coppice_light* light) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(cmd == VK_NULL_HANDLE ? "cmd is null" : "");
  COPPICE_REFUSE_IF(renderer_problem(*context));
  COPPICE_REFUSE_IF(coppice::view_problem(*context, view));
  OwnedLight ours;
  COPPICE_REFUSE_IF(read_light(light, ours));
  if (!context->context->device_state()) return call.lost();
  COPPICE_REFUSE_IF(recording_problem(*context->context, view));
  const coppice::TraceScope trace(context->context->hooks().trace, COPPICE_TRACE_RECORD_CULL);
  if (context->context->renderer()->can_cull())
    recorder(*context->context, view).record_cull(cmd, ours.light);
  else
    recorder(*context->context, view).leave_out();
  return call.finish(context->context->device_state());
}

coppice_status coppice_record_draw(coppice_context* context, VkCommandBuffer cmd, coppice_view view, std::uint32_t eye) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(cmd == VK_NULL_HANDLE ? "cmd is null" : "");
  COPPICE_REFUSE_IF(renderer_problem(*context));
  COPPICE_REFUSE_IF(coppice::view_problem(*context, view));
  if (!context->context->device_state()) return call.lost();
  COPPICE_REFUSE_IF(recording_problem(*context->context, view));
  coppice::gpu::ViewRecorder& drawn = recorder(*context->context, view);
  COPPICE_REFUSE_IF(drawn.is_culled() ? "" : "coppice_record_cull was not called for the view in this frame");
  if (eye >= drawn.eye_count())
    return call.refuse("eye is " + std::to_string(eye) + ": the camera has " + std::to_string(drawn.eye_count()));
  const coppice::TraceScope trace(context->context->hooks().trace, COPPICE_TRACE_RECORD_DRAW);
  drawn.record_draw(cmd, eye);
  return COPPICE_OK;
}

coppice_status coppice_record_triangles(coppice_context* context, VkCommandBuffer cmd, coppice_plant plant, coppice_triangles* triangles) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(cmd == VK_NULL_HANDLE ? "cmd is null" : "");
  COPPICE_REFUSE_IF(renderer_problem(*context));
  COPPICE_REFUSE_IF(coppice::plant_problem(*context, plant));
  coppice_triangles ours;
  COPPICE_REFUSE_IF(coppice::read_struct(triangles, "triangles", ours));
  COPPICE_REFUSE_IF(in_struct("triangles", coppice::triangles_problem(ours)));
  if (!context->context->device_state()) return call.lost();
  COPPICE_REFUSE_IF(upload_problem(*context->context));
  coppice::gpu::Renderer& renderer = *context->context->renderer();
  std::uint32_t slot = 0;
  const coppice::LodPlant* drawn = context->context->drawn_plant(plant, slot);
  const coppice::gpu::StoredPlant* stored = drawn != nullptr ? renderer.plants().plant(slot) : nullptr;
  ours.triangle_count = 0;
  if (renderer.triangles().is_ready() && renderer.can_cull() && stored != nullptr && stored->has_cuts) {
    const coppice::gpu::CutTriangles cut = cut_of(*drawn, ours);
    ours.triangle_count = coppice::gpu::triangle_count(*stored, cut);
    if (ours.triangle_count <= ours.triangle_capacity) renderer.triangles().record(cmd, *stored, cut, ours.positions);
  }
  coppice::write_struct(ours, triangles);
  return COPPICE_OK;
}
