#include "shadows.h"

#include <cstring>

#include <glm/gtc/type_ptr.hpp>

#include "failure.h"
#include "vk_struct.h"

namespace forest {
namespace {

constexpr std::array<float, Shadows::kCascades> kRadii_m{22, 100, 480};
/// In pixels of the map: a shadow is soft, and seen from farther away than the map's pixels are fine.
constexpr float kError_px = 3;
constexpr std::uint64_t kFramesBetweenRefinements = 24;
/// Steps in which a square follows the eye: a part of its radius, and whole pixels of the map.
constexpr float kStepsPerRadius = 8;
constexpr float kNeverDrawn = 1e30f;

struct Due {
  std::size_t cascade;
  coppice_view view;
  glm::vec3 center;
};

coppice_view sun_view(const ShadowFrame& frame, glm::vec3 center, const Shadows::Cascade& cascade) {
  const coppice_shadow_desc desc{{center.x, center.y, center.z}, cascade.radius_m, cascade.map.extent.width};
  coppice_view view;
  coppice_view_init(&view);
  if (coppice_shadow_view(frame.context, frame.camera, &desc, &view) != COPPICE_OK) throw Failure("coppice_shadow_view failed");
  view.error_px = kError_px;
  return view;
}

/// The middle of a square before the eye, on the map's grid, so that edges of shadows do not crawl as it moves.
glm::vec3 center_of(const ShadowFrame& frame, const Shadows::Cascade& cascade) {
  glm::vec3 ahead = frame.eye + 0.65f * cascade.radius_m * glm::vec3(frame.forward.x, 0, frame.forward.z);
  ahead.y = height_at(*frame.terrain, ahead.x, ahead.z);
  const glm::mat3 sun_from_world(glm::make_mat4(sun_view(frame, ahead, cascade).view_from_world));
  const float step_m = cascade.radius_m / kStepsPerRadius;
  return glm::transpose(sun_from_world) * (glm::round(sun_from_world * ahead / step_m) * step_m);
}

/// The one that is farthest behind, in its radii: a fast eye must not keep the larger ones waiting.
std::optional<Due> due_cascade(const Shadows& shadows, const ShadowFrame& frame) {
  std::optional<Due> due;
  float most = -1;
  for (std::size_t i = 0; i < Shadows::kCascades; ++i) {
    const Shadows::Cascade& cascade = shadows.cascades[i];
    const glm::vec3 center = center_of(frame, cascade);
    const bool first = cascade.drawn_frame == 0;
    const bool finer = cascade.drawn_arrivals != frame.arrivals && frame.number >= cascade.drawn_frame + kFramesBetweenRefinements;
    const float behind = first ? kNeverDrawn : glm::distance(center, cascade.center) / cascade.radius_m;
    if ((behind == 0 && !finer) || behind <= most) continue;
    most = behind;
    due = Due{i, sun_view(frame, center, cascade), center};
  }
  return due;
}

constexpr VkPipelineStageFlags2 kReaders =
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;

void begin_map(VkCommandBuffer commands, const Image& map) {
  record_barrier(commands, to_depth_attachment(map, kReaders));
  VkRenderingAttachmentInfo depth = vk_struct<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
  depth.imageView = map.view;
  depth.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
  depth.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;  // to 0: reversed depth's farthest
  depth.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  VkRenderingInfo info = vk_struct<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  info.renderArea = {{0, 0}, map.extent};
  info.layerCount = 1;
  info.pDepthAttachment = &depth;
  vkCmdBeginRendering(commands, &info);
}

void end_map(VkCommandBuffer commands, const Image& map) {
  vkCmdEndRendering(commands);
  record_barrier(commands, from_depth_attachment(map, kReaders));
}

}  // namespace

Shadows::Shadows(const Device& device, std::uint32_t size_px) {
  ImageDesc desc;
  desc.format = VK_FORMAT_D32_SFLOAT;
  desc.extent = {size_px, size_px};
  desc.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  for (std::size_t i = 0; i < kCascades; ++i) {
    cascades[i].map = create_image(device, desc);
    cascades[i].radius_m = kRadii_m[i];
  }
}

bool record_shadows(Shadows& shadows, VkCommandBuffer commands, const ShadowFrame& frame,
                    const std::function<void(const coppice_view&)>& cull, const std::function<void(const coppice_view&)>& draw) {
  bool any = false;
  for (std::optional<Due> due = due_cascade(shadows, frame); due; due = due_cascade(shadows, frame)) {
    any = true;
    Shadows::Cascade& cascade = shadows.cascades[due->cascade];
    const bool first = cascade.drawn_frame == 0;
    cull(due->view);
    begin_map(commands, cascade.map);
    draw(due->view);
    end_map(commands, cascade.map);
    cascade.center = due->center;
    cascade.clip_from_world = glm::make_mat4(due->view.clip_from_view) * glm::make_mat4(due->view.view_from_world);
    cascade.drawn_frame = frame.number;
    cascade.drawn_arrivals = frame.arrivals;
    if (!first) break;
  }
  return any;
}

void outdate(Shadows& shadows) {
  for (Shadows::Cascade& cascade : shadows.cascades) cascade.drawn_frame = 0;
}

void set_shadows(const Shadows& shadows, coppice_view& camera) {
  camera.shadow_cascade_count = Shadows::kCascades;
  for (std::size_t i = 0; i < Shadows::kCascades; ++i) {
    camera.shadow_cascades[i].image = shadows.cascades[i].map.view;
    std::memcpy(camera.shadow_cascades[i].clip_from_world, glm::value_ptr(shadows.cascades[i].clip_from_world), sizeof(glm::mat4));
  }
}

}  // namespace forest
