#include <algorithm>
#include <cmath>
#include <cstring>

#include "check.h"
#include "convert.h"
#include "renderer.h"

namespace coppice::gpu {
namespace {

/// Whether x and y of the picture and the way to the viewer are left-handed: +x right and +y up, where Vulkan's is down.
bool is_mirrored(const mat4& clip_from_world) {
  const mat4 rows = transpose(clip_from_world);
  return dot(rows.column[0].xyz(), cross(rows.column[1].xyz(), rows.column[3].xyz())) < 0.0f;
}

static_assert(kDebugLod == COPPICE_DEBUG_LOD && kDebugPath == COPPICE_DEBUG_PATH && kDebugOverdraw == COPPICE_DEBUG_OVERDRAW);
static_assert(kDebugOcclusion == COPPICE_DEBUG_OCCLUSION && kDebugError == COPPICE_DEBUG_ERROR);
static_assert(kDebugResidency == COPPICE_DEBUG_RESIDENCY);

/// reversed: depth is larger where it is nearer
View gpu_view(const coppice_view& view, const LodView& lod, std::uint32_t instance_slot_count, bool reversed) {
  View converted{};
  converted.clip_from_world = lod.clip_from_world;
  std::ranges::copy(lod.planes, converted.planes);
  converted.camera_position = lod.eye_m;
  converted.error_px = lod.error_px;
  converted.focal_px = lod.focal_px;
  converted.near_m = lod.near_m;
  converted.lod_full = lod.full ? 1 : 0;
  converted.lod_discrete = lod.discrete ? 1 : 0;
  converted.instance_slot_count = instance_slot_count;
  converted.fog_density = view.fog_density;
  converted.sun_direction = vec3(view.sun_direction);
  converted.sun_color = vec3(view.sun_color);
  converted.sky_color = vec3(view.sky_color);
  converted.ground_color = vec3(view.ground_color);
  converted.fog_color = vec3(view.fog_color);
  converted.debug_view = static_cast<std::uint32_t>(view.debug_view);
  converted.is_shadow = view.kind == COPPICE_VIEW_SHADOW ? 1 : 0;
  converted.cascade_count = view.shadow_cascade_count;
  converted.depth_sign = reversed ? 1.0f : -1.0f;
  converted.is_mirrored = is_mirrored(converted.clip_from_world) ? 1 : 0;
  for (std::uint32_t i = 0; i < view.shadow_cascade_count; ++i) converted.cascades[i] = mat4(view.shadow_cascades[i].clip_from_world);
  return converted;
}

constexpr VkPipelineStageFlags2 kShaders =
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;

}  // namespace

void Renderer::want_mesh(const MeshPipelines& pipelines, const MeshBuffer& mesh) {
  for (const SurfaceTextures& textures : mesh.textures) {
    const std::size_t textured = textures.color != kNoTexture ? 1 : 0;
    pipelines_.want(*pipelines.plain[textured]);
    if (textures.normal_map != kNoTexture) pipelines_.want(*pipelines.relief[textured]);
  }
}

void Renderer::want_leaves(const PlantSlot& plant) {
  for (const std::uint32_t texture : plant.leaf_textures) pipelines_.want(*passes_.camera.leaf[texture != kNoTexture ? 1 : 0]);
}

bool Renderer::can_draw_leaf_meshes(const PlantSlot& plant) const {
  const auto drawable = [&](const SurfaceTextures& textures) {
    return passes_.camera.leaf_mesh.plain[textures.color != kNoTexture ? 1 : 0]->handle() != VK_NULL_HANDLE;
  };
  return std::ranges::all_of(std::span(plant.meshes).subspan(kMaxWoodLods, plant.leaf_mesh_count),
                             [&](const MeshBuffer& mesh) { return std::ranges::all_of(mesh.textures, drawable); });
}

Renderer::Ready Renderer::want(const coppice_view& view) {
  if (view.kind == COPPICE_VIEW_SHADOW)
    for (const std::size_t textured : {0u, 1u}) {
      if (passes_.camera.leaf[textured]->wanted) pipelines_.want(*passes_.shadow.leaf[textured]);
      if (passes_.camera.wood.plain[textured]->wanted) pipelines_.want(*passes_.shadow.wood.plain[textured]);
    }
  return {pipelines_.want(*passes_.cull[view.debug_view != COPPICE_DEBUG_NONE ? 1 : 0]), raster_ && raster_->want(view)};
}

void Renderer::record_cull(VkCommandBuffer cmd, const coppice_view& engine_view, const LodView& lod) {
  if (!drawable_) return;
  const Functions& vk = device_.vk;
  // Until what shows its colours is built a debug view is shown as any other.
  coppice_view view = engine_view;
  view.debug_view = COPPICE_DEBUG_NONE;
  Ready ready = want(view);
  if (engine_view.debug_view != COPPICE_DEBUG_NONE && want(engine_view) == ready) view.debug_view = engine_view.debug_view;
  View constants = gpu_view(view, lod, instance_slot_count_, is_reversed(desc_.attachments.depth_compare));
  view_set_ = set_of(view);
  constants.debug_colors = gpu_address(growing_.debug_colors.address);
  memory_barrier(device_, cmd, kShaders | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_TRANSFER_WRITE_BIT);
  update_buffer(cmd, fixed_.view, &constants, sizeof constants);
  update_buffer(cmd, growing_.wood_commands, mesh_templates_.data(), mesh_templates_.size() * sizeof(DrawCommand));
  vk.vkCmdFillBuffer(cmd, growing_.draw_counts.buffer, 0, std::max<std::size_t>(plants_.size(), 1) * kDrawCounts * sizeof(std::uint32_t),
                     0);
  vk.vkCmdFillBuffer(cmd, fixed_.counters.buffer, 0, VK_WHOLE_SIZE, 0);
  rastered_ = ready.raster && instance_slot_count_ > 0 && fits(raster_->wanted_bytes(view)) && raster_->begin_view(cmd, view, frame_);
  memory_barrier(device_, cmd, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, kShaders,
                 VK_ACCESS_2_UNIFORM_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
                     VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
  if (rastered_) {
    raster_->record(cmd, view_set_, instance_slot_count_, timer_.exists() ? &timer_ : nullptr);
  } else if (instance_slot_count_ > 0 && ready.cull) {
    vk.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, passes_.cull[view.debug_view != COPPICE_DEBUG_NONE ? 1 : 0]->handle());
    vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, passes_.layout, 0, 1, &view_set_, 0, nullptr);
    vk.vkCmdDispatch(cmd, (instance_slot_count_ + kCullGroupSize - 1) / kCullGroupSize, 1, 1);
  }
  memory_barrier(device_, cmd, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT,
                 VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT |
                     VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT |
                     VK_ACCESS_2_TRANSFER_READ_BIT);
  if (view.kind == COPPICE_VIEW_CAMERA) record_readback(cmd);
  if (timer_.exists()) timer_.mark(device_, cmd, Pass::cull);
}

void Renderer::record_readback(VkCommandBuffer cmd) {
  for (std::uint32_t slot = 0; slot < kReadbackSlots; ++slot) {
    if (readback_frames_[slot] > completed_) continue;
    readback_frames_[slot] = frame_;
    const VkBufferCopy region{0, slot * sizeof(Counters), sizeof(Counters)};
    device_.vk.vkCmdCopyBuffer(cmd, fixed_.counters.buffer, fixed_.readback.buffer, 1, &region);
    memory_barrier(device_, cmd, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_HOST_BIT,
                   VK_ACCESS_2_HOST_READ_BIT);
    return;
  }
}

void Renderer::record_draw(VkCommandBuffer cmd, const coppice_view& view) const {
  if (!drawable_) return;
  const Functions& vk = device_.vk;
  const VkViewport viewport{0.0f, 0.0f, static_cast<float>(view.width_px), static_cast<float>(view.height_px), 0.0f, 1.0f};
  const VkRect2D scissor{{0, 0}, {view.width_px, view.height_px}};
  vk.vkCmdSetViewport(cmd, 0, 1, &viewport);
  vk.vkCmdSetScissor(cmd, 0, 1, &scissor);
  if (rastered_) raster_->record_resolve(cmd, view_set_, view.kind);
  vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.layout, 0, 1, &view_set_, 0, nullptr);
  const DrawPipelines& pipelines = view.kind == COPPICE_VIEW_SHADOW ? passes_.shadow : passes_.camera;
  // Trunks first: they hide leaves behind them, and the depth test is cheaper than a leaf.
  for (std::uint32_t plant = 0; plant < plants_.size(); ++plant)
    for (std::uint32_t lod = 0; plant_counts_[plant] > 0 && lod < kMaxWoodLods; ++lod)
      if (records_[plant].wood_resident_mask >> lod & 1u) draw_wood(cmd, pipelines, plant, lod);
  for (std::uint32_t plant = 0; view.kind == COPPICE_VIEW_CAMERA && plant < plants_.size(); ++plant)
    for (std::uint32_t i = 0; plant_counts_[plant] > 0 && i < records_[plant].leaf_mesh_count; ++i) draw_leaf_mesh(cmd, plant, i);
  vk.vkCmdBindIndexBuffer(cmd, fixed_.indices.buffer, 0, VK_INDEX_TYPE_UINT16);
  for (std::uint32_t plant = 0; plant < plants_.size(); ++plant)
    if (plant_counts_[plant] > 0) draw_leaves(cmd, pipelines, plant);
}

bool Renderer::bind_draw(VkCommandBuffer cmd, const PlantSlot& plant, const DrawPush& push,
                         const std::array<Pipeline*, 2>& pipelines) const {
  const bool textured = push.texture != kNoTexture;
  const bool resident = textured && plant.textures[push.texture].visible;
  const VkDescriptorSet set = resident ? plant.textures[push.texture].set.set : default_set_.set;
  const VkPipeline pipeline = pipelines[textured ? 1 : 0]->handle();
  if (pipeline == VK_NULL_HANDLE) return false;
  device_.vk.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  device_.vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.layout, 1, 1, &set, 0, nullptr);
  device_.vk.vkCmdPushConstants(cmd, passes_.layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof push, &push);
  return true;
}

void Renderer::draw_leaves(VkCommandBuffer cmd, const DrawPipelines& pipelines, std::uint32_t index) const {
  const PlantSlot& plant = plants_[index];
  const Plant& record = records_[index];
  for (std::uint32_t texture : plant.leaf_textures) {
    if (!bind_draw(cmd, plant, {.plant = index, .texture = texture}, pipelines.leaf)) continue;
    const auto draw = [&](std::uint32_t first, std::uint32_t kind, std::uint32_t most) {
      if (most == 0) return;
      device_.vk.vkCmdDrawIndexedIndirectCount(cmd, leaf_commands_.buffer, std::uint64_t{first} * sizeof(DrawCommand),
                                               growing_.draw_counts.buffer, (kDrawCounts * index + kind) * sizeof(std::uint32_t), most,
                                               sizeof(DrawCommand));
    };
    // Instances of one cluster each, which the rasteriser leaves to nobody; then clusters.
    if (!rastered_) draw(record.leaf_command_base, 0, std::min(record.instance_count, device_.max_draw_count));
    draw(record.leaf_command_base + record.instance_count, 1, record.leaf_command_capacity);
  }
}

void Renderer::draw_wood(VkCommandBuffer cmd, const DrawPipelines& pipelines, std::uint32_t index, std::uint32_t lod) const {
  const Plant& record = records_[index];
  draw_mesh(cmd, index, plants_[index].meshes[lod],
            {.list_first = record.wood_list_base + lod * record.instance_count,
             .command = index * kMeshCommands + lod,
             .part_first = record.part_base + lod * kPartCommands,
             .part_count = kWoodPartCounts + lod,
             .pipelines = &pipelines.wood});
}

void Renderer::draw_leaf_mesh(VkCommandBuffer cmd, std::uint32_t index, std::uint32_t chunk) const {
  const Plant& record = records_[index];
  draw_mesh(cmd, index, plants_[index].meshes[kMaxWoodLods + chunk],
            {.list_first = record.leaf_mesh_list_base,
             .command = index * kMeshCommands + kMaxWoodLods + chunk,
             .part_first = record.part_base + (record.wood_lod_count + chunk) * kPartCommands,
             .part_count = kMeshPartCount,
             .pipelines = &passes_.camera.leaf_mesh});
}

void Renderer::draw_mesh(VkCommandBuffer cmd, std::uint32_t index, const MeshBuffer& mesh, const MeshDraw& draw) const {
  device_.vk.vkCmdBindIndexBuffer(cmd, mesh.buffer.buffer, 0, VK_INDEX_TYPE_UINT32);
  const PlantSlot& plant = plants_[index];
  for (const SurfaceTextures& textures : mesh.textures) {
    // What has its normal map or its pipeline on the way is drawn without for as long; shadow views have none.
    const Pipeline* in_relief = draw.pipelines->relief[textures.color != kNoTexture ? 1 : 0];
    const bool relief = in_relief != nullptr && in_relief->handle() != VK_NULL_HANDLE && textures.normal_map != kNoTexture &&
                        plant.textures[textures.normal_map].visible;
    if (relief)
      device_.vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.layout, 2, 1,
                                         &plant.textures[textures.normal_map].set.set, 0, nullptr);
    if (!bind_draw(cmd, plant,
                   {.plant = index,
                    .texture = textures.color,
                    .vertices = mesh.vertices,
                    .wood_list_first = draw.list_first,
                    .normal_map = textures.normal_map},
                   relief ? draw.pipelines->relief : draw.pipelines->plain))
      continue;
    // One draw or none, as there are instances. Not vkCmdDrawIndexedIndirect: after draws with a count, lavapipe of Mesa 22.3 reads their
    // count for it too, and in a view without quads everything would vanish.
    const VkDeviceSize command = draw.command * sizeof(DrawCommand);
    device_.vk.vkCmdDrawIndexedIndirectCount(cmd, growing_.wood_commands.buffer, command, growing_.wood_commands.buffer,
                                             command + offsetof(DrawCommand, instance_count), 1, sizeof(DrawCommand));
    if (records_[index].part_capacity == 0) continue;
    device_.vk.vkCmdDrawIndexedIndirectCount(cmd, leaf_commands_.buffer, draw.part_first * sizeof(DrawCommand), growing_.draw_counts.buffer,
                                             (kDrawCounts * index + draw.part_count) * sizeof(std::uint32_t), records_[index].part_capacity,
                                             sizeof(DrawCommand));
  }
}

}  // namespace coppice::gpu
