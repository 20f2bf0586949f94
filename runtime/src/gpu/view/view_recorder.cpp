#include "view_recorder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <utility>

#include "check.h"
#include "convert.h"
#include "debug_label.h"

namespace coppice::gpu {
namespace {

/// True if x and y of the picture and the direction to the viewer are left-handed: +x right and +y up, while Vulkan's y points down.
bool is_mirrored(const LodView& lod) {
  const mat4 rows = transpose(lod.eyes[0].clip_from_world);
  return dot(rows.column[0].xyz(), cross(rows.column[1].xyz(), lod.toward_viewer)) > 0.0f;
}

/// A shadow map's matrix for places relative to the eye. eye: in the engine's coordinates
mat4 clip_from_eye(const double (&clip_from_world)[16], const dvec3& eye) {
  mat4 clip;
  const auto row = [&](std::size_t i) {
    const double moved = clip_from_world[i] * eye.x + clip_from_world[4 + i] * eye.y + clip_from_world[8 + i] * eye.z;
    return static_cast<float>(moved + clip_from_world[12 + i]);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = [&](std::size_t k) { return static_cast<float>(clip_from_world[4 * i + k]); };
    clip.column[i] = {at(0), at(1), at(2), at(3)};
  }
  clip.column[3] = {row(0), row(1), row(2), row(3)};
  return clip;
}

static_assert(kDebugLod == COPPICE_DEBUG_LOD && kDebugPath == COPPICE_DEBUG_PATH && kDebugOverdraw == COPPICE_DEBUG_OVERDRAW);
static_assert(kDebugOcclusion == COPPICE_DEBUG_OCCLUSION && kDebugError == COPPICE_DEBUG_ERROR);
static_assert(kDebugResidency == COPPICE_DEBUG_RESIDENCY);

/// Properties of the view's attachments and of the scene.
struct ViewKind {
  std::uint32_t instance_slot_count = 0, instance_frame = 0;
  bool reversed = false;  ///< depth is larger for nearer places
  bool depth_alone = false;
};

static_assert(kMaxEyes == coppice::kMaxEyes);

/// Maps (x, y, depth key, 1), x and y of clip space times w, to the world. Gauss-Jordan elimination with pivoting of rows.
mat4 world_from_key(const LodEye& eye) {
  const mat4 rows = transpose(eye.clip_from_world);
  const std::array<vec4, 4> from{rows.column[0], rows.column[1], eye.key_row, rows.column[3]};
  double m[4][8]{};
  for (std::size_t i = 0; i < 4; ++i) {
    const double row[4] = {from[i].x, from[i].y, from[i].z, from[i].w};
    std::ranges::copy(row, m[i]);
    m[i][4 + i] = 1.0;
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const auto by_size = [k](const double(&a)[8], const double(&b)[8]) { return std::abs(a[k]) < std::abs(b[k]); };
    std::swap_ranges(m[k], m[k] + 8, *std::max_element(m + k, m + 4, by_size));
    const double pivot = m[k][k];
    for (double& number : m[k]) number /= pivot;
    for (std::size_t i = 0; i < 4; ++i) {
      const double factor = i == k ? 0.0 : m[i][k];
      for (std::size_t j = 0; j < 8; ++j) m[i][j] -= factor * m[k][j];
    }
  }
  mat4 inverse;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto at = [&](std::size_t i) { return static_cast<float>(m[i][4 + k]); };
    inverse.column[k] = {at(0), at(1), at(2), at(3)};
  }
  return inverse;
}

/// Moves the matrix to places relative to another eye, by_m further on.
mat4 moved(const mat4& clip, const vec3& by_m) {
  mat4 from = clip;
  from.column[3] = clip * vec4(by_m, 1.0f);
  return from;
}

Eye gpu_eye(const LodEye& eye, const mat4& clip_before) {
  Eye converted{.clip_from_world = eye.clip_from_world,
                .clip_from_world_before = clip_before,
                .world_from_key = world_from_key(eye),
                .key_row = eye.key_row,
                .place = eye.place_m,
                .first_px = {static_cast<std::uint32_t>(eye.x_px), static_cast<std::uint32_t>(eye.y_px)}};
  std::ranges::copy(eye.planes, converted.planes);
  return converted;
}

View gpu_view(const ShownView& shown, const LodView& before, const coppice_light& light, const ViewKind& kind) {
  const coppice_camera& view = shown.camera;
  const LodView& lod = shown.lod;
  View converted{};
  for (std::size_t i = 0; i < lod.eye_count; ++i)
    converted.eyes[i] = gpu_eye(lod.eyes[i], moved(before.eyes[i].clip_from_world, (lod.eye_m - before.eye_m).rounded()));
  const CellPlace eye = cell_place(lod.eye_m);
  converted.eye_cell = eye.cell;
  converted.eye_in_cell = eye.place;
  converted.layer_mask = lod.layer_mask;
  converted.error_px = lod.error_px;
  converted.focal_px = lod.focal_px;
  converted.near_m = lod.near_m;
  converted.lod_full = lod.full ? 1 : 0;
  converted.lod_discrete = lod.discrete ? 1 : 0;
  converted.instance_slot_count = kind.instance_slot_count;
  converted.frame = kind.instance_frame;
  converted.fog_density = light.fog_density;
  converted.sun_direction = vec3(light.sun_direction);
  converted.sun_color = vec3(light.sun_color);
  converted.sky_color = vec3(light.sky_color);
  converted.ground_color = vec3(light.ground_color);
  converted.fog_color = vec3(light.fog_color);
  converted.debug_view = static_cast<std::uint32_t>(view.debug_view);
  converted.is_shadow = kind.depth_alone ? 1 : 0;
  converted.shadow_map_count = light.shadow_map_count;
  converted.depth_sign = kind.reversed ? 1.0f : -1.0f;
  converted.is_mirrored = is_mirrored(lod) ? 1 : 0;
  converted.is_perspective = lod.parallel ? 0.0f : 1.0f;
  converted.toward_viewer = lod.parallel ? lod.toward_viewer : vec3(0.0f);
  converted.temporal_frame = view.temporal_frame;
  converted.wind = wind_now(shown.wind.now, lod.eye_m);
  converted.wind_before = wind_now(shown.wind.before, lod.eye_m);
  converted.half_size_px = {0.5f * static_cast<float>(view.width_px), 0.5f * static_cast<float>(view.height_px)};
  for (std::uint32_t i = 0; i < light.shadow_map_count; ++i)
    converted.map_clips[i] = clip_from_eye(light.shadow_maps[i].clip_from_world, lod.eye_m - lod.origin_m);
  return converted;
}

constexpr VkPipelineStageFlags2 kShaders =
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;

}  // namespace

Result<void> ViewRecorder::create(const ViewOptions& options, const Capacity& capacity) {
  max_instances_ = options.max_instances;
  Device& device = shared_.device;
  constexpr VkBufferUsageFlags kTo = VK_BUFFER_USAGE_TRANSFER_DST_BIT, kFrom = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  COPPICE_CHECK(move_into(buffers_.view, create_buffer(device, {"coppice view", sizeof(View), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | kTo})));
  COPPICE_CHECK(move_into(buffers_.counters, create_buffer(device, {"coppice counters", sizeof(Counters), kStorage | kFrom})));
  COPPICE_CHECK(
      move_into(readback_, create_buffer(device, {"coppice read-back", kReadbackSlots * sizeof(Counters), kTo, MemoryKind::host})));
  if (shared_.raster != nullptr) COPPICE_CHECK(shared_.raster->create_view(attachments(), raster_));
  BufferSizes sizes;
  add_sizes(capacity, sizes);
  for (const BufferSize& size : sizes.span())
    if (size.bytes > 0) COPPICE_CHECK(move_into(*size.buffer, create_buffer(device, size.desc(MemoryKind::lasting))));
  if (options.pass_times) COPPICE_CHECK(timer_.create(device));
  return {};
}

ViewRecorder::~ViewRecorder() {
  Device& device = shared_.device;
  if (shared_.raster != nullptr) shared_.raster->destroy_view(raster_);
  timer_.destroy(device);
  for (Buffer* buffer : {&buffers_.view, &buffers_.counters, &buffers_.cuts, &buffers_.debug_colors, &buffers_.wood_list,
                         &buffers_.leaf_commands, &buffers_.draw_counts, &buffers_.wood_commands, &readback_})
    destroy_buffer(device, *buffer);
  destroy_set(device, frame_set_);
  for (LitSet& lit : lit_sets_) destroy_set(device, lit.set);
}

void ViewRecorder::add_sizes(const Capacity& capacity, BufferSizes& sizes) {
  constexpr VkBufferUsageFlags kFrom = VK_BUFFER_USAGE_TRANSFER_SRC_BIT, kIndirect = VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
  const std::uint64_t slots = std::max(capacity.slots, std::min(kFirstSlots, max_instances_)), plants = capacity.plants;
  sizes.add({&buffers_.cuts, "coppice cuts", slots * sizeof(float), kStorage | kFrom});
  sizes.add({&buffers_.debug_colors, "coppice debug colours", slots * sizeof(std::uint32_t),
             kStorage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT});
  // An instance may be in the list of any wood LoD, and in that of leaf meshes.
  sizes.add({&buffers_.wood_list, "coppice wood list", slots * (kMaxWoodLods + 1) * sizeof(std::uint32_t), kStorage});
  sizes.add({&buffers_.leaf_commands, kLeafCommandsName, slots * sizeof(DrawCommand), kStorage | kIndirect});
  sizes.add({&buffers_.draw_counts, "coppice draw counts", kDrawCounts * plants * sizeof(std::uint32_t), kStorage | kIndirect});
  sizes.add({&buffers_.wood_commands, "coppice mesh commands", plants * kMeshCommands * sizeof(DrawCommand), kStorage | kIndirect});
  if (shared_.raster != nullptr) LeafRaster::add_view_sizes(capacity.work(), raster_, sizes);
}

void ViewRecorder::release_picture() {
  if (shared_.raster != nullptr) shared_.raster->release_picture(raster_);
}

void ViewRecorder::buffers_changed() {
  set_stale_ = true;
  raster_.set_stale = true;
}

FrameBindings ViewRecorder::bindings() const {
  const SceneBuffers& scene = shared_.scene;
  FrameBindings bindings{.buffers = {&buffers_.view, &scene.instances, &scene.plants, &scene.tables, &buffers_.cuts, &buffers_.wood_list,
                                     &buffers_.leaf_commands, &buffers_.draw_counts, &buffers_.wood_commands, &buffers_.counters}};
  bindings.wind_maps = &scene.wind_maps;
  bindings.moved = &scene.moved;
  bindings.maps.fill(shared_.plants.placeholder().texture.view);
  bindings.occluders.fill(shared_.plants.placeholder().texture.view);
  return bindings;
}

Result<void> ViewRecorder::rebuild_set() {
  COPPICE_TRY(set, create_frame_set(shared_.device, shared_.passes, bindings()));
  shared_.deletion.defer(frame_set_);
  frame_set_ = set;
  set_stale_ = commands_zeroed_ = false;
  return {};
}

// Returns set 0 with the light's images, or without them if memory is short. It is written anew each time, because a handle may name
// another image since the GPU finished with the last one.
ViewRecorder::FrameSet ViewRecorder::set_of(const coppice_light& light) {
  if (light.shadow_map_count == 0 && light.occluder == nullptr) return {frame_set_.set, false};
  FrameBindings with = bindings();
  for (std::uint32_t i = 0; i < light.shadow_map_count; ++i) with.maps[i] = light.shadow_maps[i].image;
  if (light.occluder != nullptr) {
    with.occluders.fill(light.occluder->image);
    if (light.occluder->second_image != VK_NULL_HANDLE) with.occluders[1] = light.occluder->second_image;
  }
  const auto free = std::ranges::find_if(lit_sets_, [this](const LitSet& lit) { return lit.last_frame <= completed_; });
  if (free != lit_sets_.end()) {
    write_frame_set(shared_.device, shared_.passes, free->set, with);
    free->last_frame = frame_;
    return {free->set.set, true};
  }
  const auto set = create_frame_set(shared_.device, shared_.passes, with);
  if (!set) {
    go_on_without(shared_.device, set.error(), "drawn without shadows and occluder");
    return {frame_set_.set, false};
  }
  lit_sets_.push_back({*set, frame_});
  return {set->set, true};
}

const coppice_occluder* ViewRecorder::occluder_of(const coppice_light& light, const FrameSet& set) {
  if (light.occluder == nullptr) return nullptr;
  has_occluder_ = true;
  return set.has_images && shared_.raster->has_occluder_pass() ? light.occluder : nullptr;
}

void ViewRecorder::begin_frame(std::uint64_t frame_number, std::uint64_t completed_number) {
  frame_ = frame_number;
  completed_ = completed_number;
  before_ = shown_ ? std::optional(shown_->lod) : std::nullopt;
  shown_.reset();
  culled_ = {};
  by_ = CulledBy::nobody;
  if (timer_.exists()) timer_.collect(shared_.device, completed_);
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

Result<void> ViewRecorder::prepare(std::uint32_t slot_count, std::uint32_t instance_frame) {
  slot_count_ = slot_count;
  instance_frame_ = instance_frame;
  if (!shown_) return {};
  // It also completes a growth that failed half way in an earlier frame.
  if (set_stale_) COPPICE_CHECK(rebuild_set());
  // Until the pipeline that shows its colours is built, a debug view is drawn as a normal one.
  coppice_camera& camera = shown_->camera;
  const coppice_debug_view debug_view = std::exchange(camera.debug_view, COPPICE_DEBUG_NONE);
  const Ready ready = request(COPPICE_DEBUG_NONE);
  if (has_occluder_ && shared_.raster != nullptr) shared_.raster->request_occluder();
  if (debug_view != COPPICE_DEBUG_NONE && request(debug_view) == ready) camera.debug_view = debug_view;
  by_ = ready.cull ? CulledBy::hardware : CulledBy::nobody;
  if (slot_count_ == 0)
    by_ = CulledBy::nobody;
  else if (ready.raster && shared_.raster->prepare(raster_, camera, eye_count()))
    by_ = CulledBy::raster;
  return {};
}

ViewRecorder::Ready ViewRecorder::request(coppice_debug_view debug_view) {
  return {shared_.pipelines.request(*shared_.passes.cull.of(debug_view, eye_count())),
          shared_.raster != nullptr && shared_.raster->request(debug_view, eye_count(), *pipelines_.resolve)};
}

void ViewRecorder::record_cull(VkCommandBuffer cmd, const coppice_light& light) {
  const Functions& vk = shared_.device.vk;
  const coppice_camera& camera = shown_->camera;
  const DebugLabel label(shared_.device, cmd, "coppice_record_cull");
  const FrameSet set = set_of(light);
  culled_ = {true, set.set};
  if (timer_.exists()) timer_.begin(shared_.device, cmd, frame_, completed_);
  GpuTimer* timer = timer_.exists() ? &timer_ : nullptr;
  memory_barrier(shared_.device, cmd, kShaders | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_TRANSFER_WRITE_BIT);
  record_start(cmd, light, set.has_images);
  memory_barrier(shared_.device, cmd, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                 kShaders | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
                 VK_ACCESS_2_UNIFORM_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
                     VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
  if (by_ == CulledBy::raster) {
    shared_.raster->record(cmd, raster_, {culled_.set, slot_count_, occluder_of(light, set), timer});
  } else if (by_ == CulledBy::hardware) {
    vk.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, shared_.passes.cull.of(camera.debug_view, eye_count())->handle());
    vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, shared_.passes.layout, 0, 1, &culled_.set, 0, nullptr);
    vk.vkCmdDispatch(cmd, (slot_count_ + kCullGroupSize - 1) / kCullGroupSize, 1, 1);
  }
  memory_barrier(shared_.device, cmd, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT,
                 VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT |
                     VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                 VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT |
                     VK_ACCESS_2_TRANSFER_READ_BIT);
  record_readback(cmd);
  if (timer != nullptr) timer->mark(shared_.device, cmd, Pass::cull);
}

void ViewRecorder::leave_out() {
  culled_.recorded = true;
  by_ = CulledBy::nobody;
}

/// Records what precedes the passes over instances.
void ViewRecorder::record_start(VkCommandBuffer cmd, const coppice_light& light, bool has_maps) {
  const Functions& vk = shared_.device.vk;
  View constants = gpu_view(*shown_, before_ && before_->eye_count == shown_->lod.eye_count ? *before_ : shown_->lod, light,
                            {slot_count_, instance_frame_, is_reversed(attachments().depth_compare), is_depth_alone(attachments())});
  if (!has_maps) constants.shadow_map_count = 0;
  constants.has_overrides = shared_.lists.has_overrides() ? 1 : 0;
  constants.debug_colors = gpu_address(buffers_.debug_colors.address);
  const SceneBuffers& scene = shared_.scene;
  constants.instances = gpu_address(scene.instances.address);
  constants.moved = gpu_address(scene.moved.address);
  constants.tables = gpu_address(scene.tables.address);
  constants.wind_maps = gpu_address(scene.wind_maps.address);
  update_buffer(shared_.device, cmd, buffers_.view, bytes_of(std::span<const View>(&constants, 1)));
  update_buffer(shared_.device, cmd, buffers_.wood_commands, bytes_of(shared_.lists.mesh_commands()));
  const std::uint64_t count_bytes = std::max(shared_.lists.count(), 1u) * kDrawCounts * sizeof(std::uint32_t);
  vk.vkCmdFillBuffer(cmd, buffers_.draw_counts.buffer, 0, count_bytes, 0);
  vk.vkCmdFillBuffer(cmd, buffers_.counters.buffer, 0, VK_WHOLE_SIZE, 0);
  // Commands beyond a wrong count must draw nothing; without counts those are all behind the last command.
  if (!std::exchange(commands_zeroed_, true) || !shared_.device.draw_counts)
    vk.vkCmdFillBuffer(cmd, buffers_.leaf_commands.buffer, 0, VK_WHOLE_SIZE, 0);
  if (by_ == CulledBy::raster) shared_.raster->record_start(cmd, raster_);
}

void ViewRecorder::record_readback(VkCommandBuffer cmd) {
  for (std::uint32_t slot = 0; slot < kReadbackSlots; ++slot) {
    if (readback_frames_[slot] > completed_) continue;
    readback_frames_[slot] = frame_;
    const VkBufferCopy region{0, slot * sizeof(Counters), sizeof(Counters)};
    shared_.device.vk.vkCmdCopyBuffer(cmd, buffers_.counters.buffer, readback_.buffer, 1, &region);
    memory_barrier(shared_.device, cmd, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_HOST_BIT,
                   VK_ACCESS_2_HOST_READ_BIT);
    return;
  }
}

void ViewRecorder::record_draw(VkCommandBuffer cmd, std::uint32_t eye) const {
  if (by_ == CulledBy::nobody) return;
  const DebugLabel label(shared_.device, cmd, "coppice_record_draw");
  const Functions& vk = shared_.device.vk;
  const coppice_camera& camera = shown_->camera;
  const LodEye& from = shown_->lod.eyes[eye];
  const VkViewport viewport{static_cast<float>(from.x_px),
                            static_cast<float>(from.y_px),
                            static_cast<float>(camera.width_px),
                            static_cast<float>(camera.height_px),
                            0.0f,
                            1.0f};
  const VkRect2D scissor{{from.x_px, from.y_px}, {camera.width_px, camera.height_px}};
  vk.vkCmdSetViewport(cmd, 0, 1, &viewport);
  vk.vkCmdSetScissor(cmd, 0, 1, &scissor);
  if (by_ == CulledBy::raster) shared_.raster->record_resolve(cmd, raster_, culled_.set, {*pipelines_.resolve, eye});
  vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, shared_.passes.layout, 0, 1, &culled_.set, 0, nullptr);
  const EyeDraws draws{cmd, eye};
  const std::span<const Plant> records = shared_.lists.records();
  // Trunks come first: they hide leaves behind them, and a depth test is cheaper than a leaf.
  for (std::uint32_t plant = 0; plant < records.size(); ++plant)
    for (std::uint32_t lod = 0; records[plant].instance_count > 0 && lod < kMaxWoodLods; ++lod)
      if (records[plant].wood_resident_mask >> lod & 1u) draw_wood(draws, plant, lod);
  for (std::uint32_t plant = 0; !is_depth_alone(attachments()) && plant < records.size(); ++plant)
    for (std::uint32_t i = 0; records[plant].instance_count > 0 && i < records[plant].leaf_mesh_count; ++i) draw_leaf_mesh(draws, plant, i);
  vk.vkCmdBindIndexBuffer(cmd, shared_.scene.quad_indices.buffer, 0, VK_INDEX_TYPE_UINT16);
  for (std::uint32_t plant = 0; plant < records.size(); ++plant)
    if (records[plant].instance_count > 0) draw_leaves(draws, plant);
}

/// False if the pipeline is not built.
bool ViewRecorder::bind_draw(VkCommandBuffer cmd, const DrawPush& push, VkPipeline pipeline) const {
  if (pipeline == VK_NULL_HANDLE) return false;
  const StoredTexture& texture = shared_.plants.shown_texture(push.plant, push.texture);
  shared_.device.vk.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  shared_.device.vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, shared_.passes.layout, 1, 1, &texture.set.set, 0,
                                            nullptr);
  shared_.device.vk.vkCmdPushConstants(cmd, shared_.passes.layout, kDrawStages, 0, sizeof push, &push);
  return true;
}

/// Draws the commands from `first` on; element `count` of the plant's draw_counts gives their number, at most `most`.
void ViewRecorder::draw_indirect(VkCommandBuffer cmd, const Buffer& commands, std::uint32_t plant, const IndirectDraws& draws) const {
  if (draws.maximum == 0) return;
  const Functions& vk = shared_.device.vk;
  const VkDeviceSize first = VkDeviceSize{draws.first} * sizeof(DrawCommand);
  // Single commands use counts too, because after draws with a count lavapipe of Mesa 22.3 uses that count for draws without.
  if (shared_.device.draw_counts)
    vk.vkCmdDrawIndexedIndirectCount(cmd, commands.buffer, first, buffers_.draw_counts.buffer,
                                     (kDrawCounts * plant + draws.count) * sizeof(std::uint32_t), draws.maximum, sizeof(DrawCommand));
  else
    vk.vkCmdDrawIndexedIndirect(cmd, commands.buffer, first, draws.maximum, sizeof(DrawCommand));
}

void ViewRecorder::draw_leaves(const EyeDraws& draws, std::uint32_t plant) const {
  const Plant& record = shared_.lists.records()[plant];
  const StoredPlant& stored = *shared_.plants.plant(plant);
  for (const std::uint32_t texture : stored.leaf_textures.span()) {
    const DrawPush push{.plant = plant, .texture = texture, .eye = draws.eye};
    if (!bind_draw(draws.cmd, push, pipelines_.drawing(leaf_kind(texture, stored.has_transparency), DrawKind::leaf_textured))) continue;
    // First instances of one cluster each, which the rasteriser never leaves to the hardware; then clusters.
    if (by_ == CulledBy::hardware)
      draw_indirect(draws.cmd, buffers_.leaf_commands, plant, {record.leaf_command_base, kSingleCount, record.instance_count});
    draw_indirect(draws.cmd, buffers_.leaf_commands, plant,
                  {record.leaf_command_base + record.instance_count, kClusterCount, record.leaf_command_capacity});
  }
}

void ViewRecorder::draw_wood(const EyeDraws& draws, std::uint32_t plant, std::uint32_t lod) const {
  const Plant& record = shared_.lists.records()[plant];
  draw_mesh(draws, plant,
            {.mesh = lod,
             .list_first = record.wood_list_base + lod * record.instance_count,
             .part_first = record.part_base + lod * kPartCommands,
             .part_count = kWoodPartCounts + lod});
}

void ViewRecorder::draw_leaf_mesh(const EyeDraws& draws, std::uint32_t plant, std::uint32_t chunk) const {
  const Plant& record = shared_.lists.records()[plant];
  draw_mesh(draws, plant,
            {.mesh = kMaxWoodLods + chunk,
             .list_first = record.leaf_mesh_list_base,
             .part_first = record.part_base + (record.wood_lod_count + chunk) * kPartCommands,
             .part_count = kMeshPartCount});
}

void ViewRecorder::draw_mesh(const EyeDraws& draws, std::uint32_t index, const MeshDraw& draw) const {
  const StoredPlant& plant = *shared_.plants.plant(index);
  const StoredMesh& mesh = plant.meshes[draw.mesh];
  shared_.device.vk.vkCmdBindIndexBuffer(draws.cmd, mesh.buffer.buffer, 0, VK_INDEX_TYPE_UINT32);
  for (const SurfaceTextures& textures : mesh.textures.span()) {
    const bool has_texture = textures.color != kNoTexture;
    // While its normal map or pipeline is missing it is drawn without; shadow views have none.
    const Pipeline* in_relief = pipelines_.of(mesh_kind(draw.mesh, has_texture, true));
    const bool relief = in_relief != nullptr && in_relief->handle() != VK_NULL_HANDLE && textures.normal_map != kNoTexture &&
                        plant.textures[textures.normal_map].visible;
    if (relief)
      shared_.device.vk.vkCmdBindDescriptorSets(draws.cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, shared_.passes.layout, 2, 1,
                                                &plant.textures[textures.normal_map].set.set, 0, nullptr);
    const DrawPush push{.plant = index,
                        .texture = textures.color,
                        .vertices = mesh.vertices,
                        .wood_list_first = draw.list_first,
                        .normal_map = textures.normal_map,
                        .eye = draws.eye};
    if (!bind_draw(draws.cmd, push, pipelines_.drawing(mesh_kind(draw.mesh, has_texture, relief), mesh_kind(draw.mesh, true, relief))))
      continue;
    draw_indirect(draws.cmd, buffers_.wood_commands, index, {index * kMeshCommands + draw.mesh, kMeshDrawn + draw.mesh, 1});
    draw_indirect(draws.cmd, buffers_.leaf_commands, index,
                  {draw.part_first, draw.part_count, shared_.lists.records()[index].part_capacity});
  }
}

}  // namespace coppice::gpu
