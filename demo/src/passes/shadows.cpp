#include "shadows.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <glm/gtc/type_ptr.hpp>

#include "failure.h"
#include "vk_struct.h"

namespace forest {
namespace {

constexpr std::array<float, Shadows::kMaps> kRadii_m{22, 100, 480, 160};
/// In pixels of the map: a shadow is soft, and seen from farther away than the map's pixels are fine.
constexpr float kError_px = 3;
constexpr std::uint64_t kFramesBetweenRefinements = 24;
/// Steps in which a square follows the eye: a part of its radius, and whole pixels of the map.
constexpr float kStepsPerRadius = 8;
constexpr float kNeverDrawn = 1e30f;
/// Shadows are soft: what sways in them need not be seen in every frame.
constexpr std::uint64_t kFramesBetweenSways = 3;
/// In which boughs swing to and fro.
constexpr float kSwing_s = 1.0f;

coppice_camera sun_camera(const ShadowFrame& frame, std::size_t cascade, glm::vec3 center, const Shadows& shadows) {
  coppice_sun_desc desc;
  coppice_sun_desc_init(&desc);
  const glm::vec3 from = cascade == Shadows::kSkyMap ? glm::vec3(0, 1, 0) : frame.sun_direction;
  for (int axis = 0; axis < 3; ++axis) {
    desc.sun_direction[axis] = from[axis];
    desc.center[axis] = center[axis];
  }
  desc.radius_m = shadows.cascades[cascade].radius_m;
  desc.size_px = shadows.cascades[cascade].map.extent.width;
  coppice_camera camera;
  coppice_camera_init(&camera);
  if (coppice_sun_camera(frame.context, frame.views[cascade], &desc, &camera) != COPPICE_OK) throw Failure("coppice_sun_camera failed");
  camera.error_px = kError_px;
  return camera;
}

/// The middle of a square before the eye, on the map's grid, so that edges of shadows do not crawl as it moves.
glm::vec3 center_of(const ShadowFrame& frame, std::size_t index, const Shadows& shadows) {
  const Shadows::Cascade& cascade = shadows.cascades[index];
  glm::vec3 ahead = frame.eye + 0.65f * cascade.radius_m * glm::vec3(frame.forward.x, 0, frame.forward.z);
  ahead.y = height_at(*frame.terrain, ahead.x, ahead.z);
  const glm::mat3 sun_from_world(glm::make_mat4(sun_camera(frame, index, ahead, shadows).view_from_world));
  const float step_m = cascade.radius_m / kStepsPerRadius;
  return glm::transpose(sun_from_world) * (glm::round(sun_from_world * ahead / step_m) * step_m);
}

/// The one that is farthest behind, in its radii: a fast eye must not keep the larger ones waiting.
std::optional<std::size_t> due_cascade(const Shadows& shadows, const ShadowFrame& frame) {
  std::optional<std::size_t> due;
  float most = -1;
  for (std::size_t i = 0; i < shadows.cascades.size(); ++i) {
    const Shadows::Cascade& cascade = shadows.cascades[i];
    const bool first = cascade.drawn_frame == 0;
    const bool finer = cascade.drawn_arrivals != frame.arrivals && frame.number >= cascade.drawn_frame + kFramesBetweenRefinements;
    const float behind = first ? kNeverDrawn : glm::distance(center_of(frame, i, shadows), cascade.center) / cascade.radius_m;
    if ((behind == 0 && !finer) || behind <= most) continue;
    most = behind;
    due = i;
  }
  return due;
}

/// How far plants may have moved since a map was drawn, in its texels. Another wind moves them anywhere at once.
float moved_texels(const Shadows::Cascade& cascade, const ShadowFrame& frame) {
  const float swings = std::abs(frame.time_s - cascade.drawn_time_s) / kSwing_s;
  const bool alike = frame.sway_m == cascade.drawn_sway_m && swings < 0.5f;
  const float share = alike ? std::sin(std::numbers::pi_v<float> * swings) : 1.0f;
  return std::max(frame.sway_m, cascade.drawn_sway_m) * share * static_cast<float>(cascade.map.extent.width) / (2 * cascade.radius_m);
}

/// The one that wind has left farthest behind: shadows that stand while their plants sway are seen near by first.
std::optional<std::size_t> due_in_wind(const Shadows& shadows, const ShadowFrame& frame) {
  std::optional<std::size_t> due;
  float most = 1;
  for (std::size_t i = 0; i < Shadows::kCascades; ++i) {
    const float behind = moved_texels(shadows.cascades[i], frame);
    if (behind < most) continue;
    most = behind;
    due = i;
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

Shadows::Shadows(const Device& device, std::uint32_t size_px, bool sky_map) : cascades(sky_map ? kMaps : kCascades) {
  ImageDesc desc;
  desc.format = VK_FORMAT_D32_SFLOAT;
  desc.extent = {size_px, size_px};
  desc.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  for (std::size_t i = 0; i < cascades.size(); ++i) {
    cascades[i].map = create_image(device, desc);
    cascades[i].radius_m = kRadii_m[i];
  }
}

namespace {

/// The map, as it is drawn in this frame.
DueMap begin_wind_map(Shadows& shadows, const ShadowFrame& frame, std::size_t index) {
  Shadows::Cascade& cascade = shadows.cascades[index];
  cascade.center = center_of(frame, index, shadows);
  const coppice_camera camera = sun_camera(frame, index, cascade.center, shadows);
  cascade.clip_from_world = glm::make_mat4(camera.clip_from_view) * glm::mat4(glm::make_mat4(camera.view_from_world));
  cascade.drawn_frame = frame.number;
  cascade.drawn_arrivals = frame.arrivals;
  cascade.drawn_time_s = frame.time_s;
  cascade.drawn_sway_m = frame.sway_m;
  return {index, camera};
}

}  // namespace

std::vector<DueMap> due_maps(Shadows& shadows, const ShadowFrame& frame) {
  std::vector<DueMap> due;
  for (auto index = due_cascade(shadows, frame); index; index = due_cascade(shadows, frame)) {
    const bool first = shadows.cascades[*index].drawn_frame == 0;
    due.push_back(begin_wind_map(shadows, frame, *index));
    if (!first) break;
  }
  if (due.empty() && frame.number % kFramesBetweenSways == 0)
    if (const auto index = due_in_wind(shadows, frame)) due.push_back(begin_wind_map(shadows, frame, *index));
  return due;
}

void record_shadows(const Shadows& shadows, VkCommandBuffer commands, std::span<const DueMap> due,
                    const std::function<void(coppice_view)>& cull, const std::function<void(coppice_view)>& draw) {
  for (const DueMap& map : due) {
    cull(map.camera.view);
    begin_map(commands, shadows.cascades[map.cascade].map);
    draw(map.camera.view);
    end_map(commands, shadows.cascades[map.cascade].map);
  }
}

void outdate(Shadows& shadows) {
  for (Shadows::Cascade& cascade : shadows.cascades) cascade.drawn_frame = 0;
}

std::array<coppice_shadow_map, Shadows::kCascades> shadow_maps(const Shadows& shadows) {
  std::array<coppice_shadow_map, Shadows::kCascades> maps{};
  for (std::size_t i = 0; i < Shadows::kCascades; ++i) {
    maps[i].image = shadows.cascades[i].map.view;
    std::copy_n(glm::value_ptr(shadows.cascades[i].clip_from_world), 16, maps[i].clip_from_world);
  }
  return maps;
}

}  // namespace forest
