#include "view_recorder.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "check.h"
#include "convert.h"

namespace coppice::gpu {
namespace {

constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;

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
  converted.temporal_frame = view.temporal_frame;
  converted.half_size_px = {0.5f * static_cast<float>(view.width_px), 0.5f * static_cast<float>(view.height_px)};
  for (std::uint32_t i = 0; i < view.shadow_cascade_count; ++i) converted.cascades[i] = mat4(view.shadow_cascades[i].clip_from_world);
  return converted;
}

constexpr VkPipelineStageFlags2 kShaders =
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;

}  // namespace

ViewRecorder::ViewRecorder(Device& device, Garbage& garbage, PipelineSet& pipelines, const SceneBuffers& scene, const PlantStore& plants,
                           const coppice_allocator& allocator)
    : device_(device), garbage_(garbage), pipelines_(pipelines), scene_(scene), plants_(plants), lists_(allocator) {}

Result<void> ViewRecorder::create(const ViewDesc& desc, const TextureSets& textures) {
  desc_ = desc;
  COPPICE_CHECK(create_passes(device_, desc.attachments, textures, pipelines_, passes_));
  constexpr VkBufferUsageFlags kTo = VK_BUFFER_USAGE_TRANSFER_DST_BIT, kFrom = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  COPPICE_CHECK(
      move_into(buffers_.view, create_buffer(device_, sizeof(View), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | kTo, MemoryKind::device)));
  COPPICE_CHECK(move_into(buffers_.counters, create_buffer(device_, sizeof(Counters), kStorage | kFrom, MemoryKind::device)));
  COPPICE_CHECK(move_into(readback_, create_buffer(device_, kReadbackSlots * sizeof(Counters), kTo, MemoryKind::host)));
  if (desc.pass_times) COPPICE_CHECK(timer_.create(device_));
  return create_raster();
}

Result<void> ViewRecorder::create_raster() {
  if (!desc_.compute_raster) return {};
  auto raster = LeafRaster::create(device_, garbage_, pipelines_,
                                   {.attachments = desc_.attachments,
                                    .frame_set = passes_.frame_set.layout,
                                    .max_instances = desc_.max_instances,
                                    .int64_atomics = desc_.int64_atomics,
                                    .many_lanes = desc_.many_lanes});
  if (raster)
    raster_ = *std::move(raster);
  else if (raster.error().status == Status::unsupported)
    go_on_without(device_, raster.error(), "all plants are drawn by the hardware");
  else
    return raster.error();
  return {};
}

ViewRecorder::~ViewRecorder() {
  raster_.reset();
  timer_.destroy(device_);
  for (Buffer* buffer : {&buffers_.view, &buffers_.counters, &buffers_.cuts, &buffers_.debug_colors, &buffers_.wood_list,
                         &buffers_.leaf_commands, &buffers_.draw_counts, &buffers_.wood_commands, &readback_})
    destroy_buffer(device_, *buffer);
  destroy_set(device_, frame_set_);
  destroy_set(device_, shadowed_set_);
  destroy_passes(device_, passes_);
}

void ViewRecorder::add_sizes(const Capacity& capacity, BufferSizes& sizes) {
  constexpr VkBufferUsageFlags kFrom = VK_BUFFER_USAGE_TRANSFER_SRC_BIT, kIndirect = VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
  const std::uint64_t slots = std::max(capacity.slots, std::min(kFirstSlots, desc_.max_instances)), plants = capacity.plants;
  sizes.add({&buffers_.cuts, slots * sizeof(float), kStorage | kFrom});
  sizes.add({&buffers_.debug_colors, slots * sizeof(std::uint32_t), kStorage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT});
  // An instance may be in the list of any wood LoD, and in that of leaf meshes.
  sizes.add({&buffers_.wood_list, slots * (kMaxWoodLods + 1) * sizeof(std::uint32_t), kStorage});
  sizes.add({&buffers_.leaf_commands, slots * sizeof(DrawCommand), kStorage | kIndirect});
  sizes.add({&buffers_.draw_counts, kDrawCounts * plants * sizeof(std::uint32_t), kStorage | kIndirect});
  sizes.add({&buffers_.wood_commands, plants * kMeshCommands * sizeof(DrawCommand), kStorage | kIndirect});
  // The rasteriser's lists are large: before the first instance nothing needs them.
  if (raster_) raster_->add_sizes(capacity.slots, sizes);
}

void ViewRecorder::buffers_changed() {
  set_stale_ = true;
  if (raster_) raster_->buffers_changed();
}

FrameBindings ViewRecorder::bindings() const {
  FrameBindings bindings{.buffers = {&buffers_.view, &scene_.instances, &scene_.plants, &scene_.tables, &buffers_.cuts, &buffers_.wood_list,
                                     &buffers_.leaf_commands, &buffers_.draw_counts, &buffers_.wood_commands, &buffers_.counters}};
  bindings.maps.fill(plants_.placeholder().texture.view);
  return bindings;
}

Result<void> ViewRecorder::rebuild_set() {
  COPPICE_TRY(set, create_frame_set(device_, passes_, bindings()));
  garbage_.retire(frame_set_);
  garbage_.retire(shadowed_set_);
  frame_set_ = set;
  set_stale_ = false;
  return {};
}

// Set 0 with the view's shadow maps; without them where memory is short.
VkDescriptorSet ViewRecorder::set_of(const coppice_view& view) {
  if (view.shadow_cascade_count == 0) return frame_set_.set;
  FrameBindings shadowed = bindings();
  for (std::uint32_t i = 0; i < view.shadow_cascade_count; ++i) shadowed.maps[i] = view.shadow_cascades[i].image;
  if (shadowed_set_.pool != VK_NULL_HANDLE && shadowed.maps == maps_) return shadowed_set_.set;
  auto set = create_frame_set(device_, passes_, shadowed);
  if (!set) {
    go_on_without(device_, set.error(), "drawn without shadows");
    return frame_set_.set;
  }
  garbage_.retire(shadowed_set_);
  shadowed_set_ = *set;
  maps_ = shadowed.maps;
  return shadowed_set_.set;
}

void ViewRecorder::begin_frame(std::uint64_t frame_number, std::uint64_t completed_number) {
  frame_ = frame_number;
  completed_ = completed_number;
  culled_ = {};
  if (timer_.exists()) timer_.collect(device_, completed_);
  for (std::uint32_t slot = 0; slot < kReadbackSlots; ++slot) {
    const std::uint64_t frame = readback_frames_[slot];
    if (frame == 0 || frame > completed_ || frame < counts_.frame) continue;
    Counters sums;
    std::memcpy(&sums, readback_.mapped + slot * sizeof sums, sizeof sums);
    const auto sum = [](const std::uint32_t(&words)[2]) { return words[0] | std::uint64_t{words[1]} << 32; };
    counts_ = {.frame = frame,
               .visible_instances = sums.visible_instances,
               .occluded_instances = sums.occluded_instances,
               .leaves = sum(sums.leaves),
               .wood_triangles = sum(sums.wood_triangles),
               .leaf_mesh_instances = sums.leaf_mesh_instances,
               .leaf_mesh_triangles = sum(sums.leaf_mesh_triangles),
               .hardware_triangles = sum(sums.hardware_triangles)};
  }
}

Result<void> ViewRecorder::prepare(const InstanceTable& instances, std::span<const PlantResidency> residency,
                                   std::uint64_t memory_budget_bytes) {
  slot_count_ = static_cast<std::uint32_t>(instances.slots().size());
  const DrawListInput input{plants_, instances, residency, passes_.camera.leaf_mesh, has_raster(), memory_budget_bytes};
  if (lists_.fill(device_, garbage_, input, buffers_.leaf_commands)) set_stale_ = true;
  // Also what a growth left behind that failed half way in an earlier frame.
  return set_stale_ ? rebuild_set() : Result<void>();
}

// What nearly every plant needs; the rest when it is first met.
void ViewRecorder::want_first() {
  for (Pipeline* pipeline : {passes_.cull.plain, passes_.camera.leaf.surface.textured, passes_.camera.wood.flat.textured})
    pipelines_.want(*pipeline);
  (void)want(coppice_view{});
}

void ViewRecorder::want_mesh(std::uint32_t plant, std::uint32_t mesh) {
  const MeshPipelines& pipelines = mesh < kMaxWoodLods ? passes_.camera.wood : passes_.camera.leaf_mesh;
  for (const SurfaceTextures& textures : plants_.plant(plant)->meshes[mesh].textures.span()) {
    pipelines_.want(*pipelines.flat.of(textures.color));
    if (textures.normal_map != kNoTexture) pipelines_.want(*pipelines.relief.of(textures.color));
  }
}

void ViewRecorder::want_leaves(std::uint32_t plant) {
  const StoredPlant& stored = *plants_.plant(plant);
  for (const std::uint32_t texture : stored.leaf_textures.span()) pipelines_.want(*passes_.camera.leaf.of(texture, stored.has_gaps));
}

ViewRecorder::Ready ViewRecorder::want(const coppice_view& view) {
  const auto want_shadow = [&](const Pipeline* camera, Pipeline* shadow) {
    if (camera->wanted) pipelines_.want(*shadow);
  };
  if (view.kind == COPPICE_VIEW_SHADOW) {
    const DrawPipelines &camera = passes_.camera, &shadow = passes_.shadow;
    want_shadow(camera.leaf.surface.plain, shadow.leaf.surface.plain);
    want_shadow(camera.leaf.surface.textured, shadow.leaf.surface.textured);
    want_shadow(camera.leaf.plain_with_gaps, shadow.leaf.plain_with_gaps);
    want_shadow(camera.wood.flat.plain, shadow.wood.flat.plain);
    want_shadow(camera.wood.flat.textured, shadow.wood.flat.textured);
  }
  return {pipelines_.want(*passes_.cull.of(view.debug_view)), raster_ && raster_->want(view)};
}

void ViewRecorder::record_cull(VkCommandBuffer cmd, const coppice_view& engine_view, const LodView& lod) {
  // Until what shows its colours is built a debug view is shown as any other.
  coppice_view view = engine_view;
  view.debug_view = COPPICE_DEBUG_NONE;
  const Ready ready = want(view);
  if (engine_view.debug_view != COPPICE_DEBUG_NONE && want(engine_view) == ready) view.debug_view = engine_view.debug_view;
  culled_ = {.set = set_of(view)};
  memory_barrier(device_, cmd, kShaders | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_TRANSFER_WRITE_BIT);
  record_start(cmd, view, lod);
  if (slot_count_ > 0) culled_.by = begin_culling(cmd, view, ready);
  memory_barrier(device_, cmd, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, kShaders,
                 VK_ACCESS_2_UNIFORM_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
                     VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
  if (culled_.by == CulledBy::raster) {
    raster_->record(cmd, culled_.set, slot_count_, timer_.exists() ? &timer_ : nullptr);
  } else if (culled_.by == CulledBy::hardware) {
    device_.vk.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, passes_.cull.of(view.debug_view)->handle());
    device_.vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, passes_.layout, 0, 1, &culled_.set, 0, nullptr);
    device_.vk.vkCmdDispatch(cmd, (slot_count_ + kCullGroupSize - 1) / kCullGroupSize, 1, 1);
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

/// What the passes over instances start with.
void ViewRecorder::record_start(VkCommandBuffer cmd, const coppice_view& view, const LodView& lod) {
  View constants = gpu_view(view, lod, slot_count_, is_reversed(desc_.attachments.depth_compare));
  if (culled_.set == frame_set_.set) constants.cascade_count = 0;  // there was no memory for a set with the maps
  constants.debug_colors = gpu_address(buffers_.debug_colors.address);
  update_buffer(device_, cmd, buffers_.view, bytes_of(std::span<const View>(&constants, 1)));
  update_buffer(device_, cmd, buffers_.wood_commands, bytes_of(lists_.mesh_commands()));
  device_.vk.vkCmdFillBuffer(cmd, buffers_.draw_counts.buffer, 0, std::max(lists_.count(), 1u) * kDrawCounts * sizeof(std::uint32_t), 0);
  device_.vk.vkCmdFillBuffer(cmd, buffers_.counters.buffer, 0, VK_WHOLE_SIZE, 0);
}

ViewRecorder::CulledBy ViewRecorder::begin_culling(VkCommandBuffer cmd, const coppice_view& view, const Ready& ready) {
  if (ready.raster && fits_buffer(device_, raster_->wanted_bytes(view)) && raster_->begin_view(cmd, view)) return CulledBy::raster;
  return ready.cull ? CulledBy::hardware : CulledBy::nobody;
}

void ViewRecorder::record_readback(VkCommandBuffer cmd) {
  for (std::uint32_t slot = 0; slot < kReadbackSlots; ++slot) {
    if (readback_frames_[slot] > completed_) continue;
    readback_frames_[slot] = frame_;
    const VkBufferCopy region{0, slot * sizeof(Counters), sizeof(Counters)};
    device_.vk.vkCmdCopyBuffer(cmd, buffers_.counters.buffer, readback_.buffer, 1, &region);
    memory_barrier(device_, cmd, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_HOST_BIT,
                   VK_ACCESS_2_HOST_READ_BIT);
    return;
  }
}

void ViewRecorder::record_draw(VkCommandBuffer cmd, const coppice_view& view) const {
  if (culled_.by == CulledBy::nobody) return;
  const Functions& vk = device_.vk;
  const VkViewport viewport{0.0f, 0.0f, static_cast<float>(view.width_px), static_cast<float>(view.height_px), 0.0f, 1.0f};
  const VkRect2D scissor{{0, 0}, {view.width_px, view.height_px}};
  vk.vkCmdSetViewport(cmd, 0, 1, &viewport);
  vk.vkCmdSetScissor(cmd, 0, 1, &scissor);
  if (culled_.by == CulledBy::raster) raster_->record_resolve(cmd, culled_.set, view.kind);
  vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.layout, 0, 1, &culled_.set, 0, nullptr);
  const DrawPipelines& pipelines = view.kind == COPPICE_VIEW_SHADOW ? passes_.shadow : passes_.camera;
  const std::span<const Plant> records = lists_.records();
  // Trunks first: they hide leaves behind them, and the depth test is cheaper than a leaf.
  for (std::uint32_t plant = 0; plant < records.size(); ++plant)
    for (std::uint32_t lod = 0; records[plant].instance_count > 0 && lod < kMaxWoodLods; ++lod)
      if (records[plant].wood_resident_mask >> lod & 1u) draw_wood(cmd, pipelines.wood, plant, lod);
  for (std::uint32_t plant = 0; view.kind == COPPICE_VIEW_CAMERA && plant < records.size(); ++plant)
    for (std::uint32_t i = 0; records[plant].instance_count > 0 && i < records[plant].leaf_mesh_count; ++i) draw_leaf_mesh(cmd, plant, i);
  vk.vkCmdBindIndexBuffer(cmd, scene_.quad_indices.buffer, 0, VK_INDEX_TYPE_UINT16);
  for (std::uint32_t plant = 0; plant < records.size(); ++plant)
    if (records[plant].instance_count > 0) draw_leaves(cmd, pipelines.leaf, plant);
}

/// False: the pipeline is not there.
bool ViewRecorder::bind_draw(VkCommandBuffer cmd, const DrawPush& push, const Pipeline& with) const {
  const VkPipeline pipeline = with.handle();
  if (pipeline == VK_NULL_HANDLE) return false;
  const StoredTexture& texture = plants_.shown_texture(push.plant, push.texture);
  device_.vk.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  device_.vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.layout, 1, 1, &texture.set.set, 0, nullptr);
  device_.vk.vkCmdPushConstants(cmd, passes_.layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof push, &push);
  return true;
}

/// count: which of the plant's draw_counts says how many of the commands from `first` on are drawn
void ViewRecorder::draw_commands(VkCommandBuffer cmd, std::uint32_t plant, std::uint32_t first, std::uint32_t count,
                                 std::uint32_t most) const {
  if (most == 0) return;
  device_.vk.vkCmdDrawIndexedIndirectCount(cmd, buffers_.leaf_commands.buffer, std::uint64_t{first} * sizeof(DrawCommand),
                                           buffers_.draw_counts.buffer, (kDrawCounts * plant + count) * sizeof(std::uint32_t), most,
                                           sizeof(DrawCommand));
}

void ViewRecorder::draw_leaves(VkCommandBuffer cmd, const LeafPipelines& pipelines, std::uint32_t plant) const {
  const Plant& record = lists_.records()[plant];
  const StoredPlant& stored = *plants_.plant(plant);
  for (const std::uint32_t texture : stored.leaf_textures.span()) {
    if (!bind_draw(cmd, {.plant = plant, .texture = texture}, *pipelines.of(texture, stored.has_gaps))) continue;
    // Instances of one cluster each, which the rasteriser leaves to nobody; then clusters.
    if (culled_.by == CulledBy::hardware)
      draw_commands(cmd, plant, record.leaf_command_base, kSingleCount, std::min(record.instance_count, device_.max_draw_count));
    draw_commands(cmd, plant, record.leaf_command_base + record.instance_count, kClusterCount, record.leaf_command_capacity);
  }
}

void ViewRecorder::draw_wood(VkCommandBuffer cmd, const MeshPipelines& pipelines, std::uint32_t plant, std::uint32_t lod) const {
  const Plant& record = lists_.records()[plant];
  draw_mesh(cmd, plant,
            {.mesh = lod,
             .list_first = record.wood_list_base + lod * record.instance_count,
             .part_first = record.part_base + lod * kPartCommands,
             .part_count = kWoodPartCounts + lod,
             .pipelines = pipelines});
}

void ViewRecorder::draw_leaf_mesh(VkCommandBuffer cmd, std::uint32_t plant, std::uint32_t chunk) const {
  const Plant& record = lists_.records()[plant];
  draw_mesh(cmd, plant,
            {.mesh = kMaxWoodLods + chunk,
             .list_first = record.leaf_mesh_list_base,
             .part_first = record.part_base + (record.wood_lod_count + chunk) * kPartCommands,
             .part_count = kMeshPartCount,
             .pipelines = passes_.camera.leaf_mesh});
}

void ViewRecorder::draw_mesh(VkCommandBuffer cmd, std::uint32_t index, const MeshDraw& draw) const {
  const StoredPlant& plant = *plants_.plant(index);
  const StoredMesh& mesh = plant.meshes[draw.mesh];
  device_.vk.vkCmdBindIndexBuffer(cmd, mesh.buffer.buffer, 0, VK_INDEX_TYPE_UINT32);
  for (const SurfaceTextures& textures : mesh.textures.span()) {
    // What has its normal map or its pipeline on the way is drawn without for as long; shadow views have none.
    const Pipeline* in_relief = draw.pipelines.relief.of(textures.color);
    const bool relief = in_relief != nullptr && in_relief->handle() != VK_NULL_HANDLE && textures.normal_map != kNoTexture &&
                        plant.textures[textures.normal_map].visible;
    if (relief)
      device_.vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, passes_.layout, 2, 1,
                                         &plant.textures[textures.normal_map].set.set, 0, nullptr);
    const DrawPush push{.plant = index,
                        .texture = textures.color,
                        .vertices = mesh.vertices,
                        .wood_list_first = draw.list_first,
                        .normal_map = textures.normal_map};
    if (!bind_draw(cmd, push, *(relief ? draw.pipelines.relief : draw.pipelines.flat).of(push.texture))) continue;
    // One draw or none, as there are instances. Not vkCmdDrawIndexedIndirect: after draws with a count, lavapipe of Mesa 22.3 reads their
    // count for it too, and in a view without quads everything would vanish.
    const VkDeviceSize command = (index * kMeshCommands + draw.mesh) * sizeof(DrawCommand);
    device_.vk.vkCmdDrawIndexedIndirectCount(cmd, buffers_.wood_commands.buffer, command, buffers_.wood_commands.buffer,
                                             command + offsetof(DrawCommand, instance_count), 1, sizeof(DrawCommand));
    draw_commands(cmd, index, draw.part_first, draw.part_count, lists_.records()[index].part_capacity);
  }
}

}  // namespace coppice::gpu
