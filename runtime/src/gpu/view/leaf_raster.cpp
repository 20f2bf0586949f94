// A frame has several culling passes, large instances first. Depth that the engine has drawn before hides as much as a pass does. Each pass
// runs:
//
//     blocks of instances -> instances: cut, path -> clusters of their lists -> leaves to pixels -> leaves of many pixels
//
// and then computes the smallest depth of every 8, 32 and 128 px tile, with which the next pass drops hidden instances and clusters. All
// counts stay on the device: every dispatch but the first is indirect.

#include "leaf_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <new>

#include "attachments.h"
#include "big_leaves_comp.h"
#include "big_leaves_int64_comp.h"
#include "cluster_motion_comp.h"
#include "convert.h"
#include "cull_raster_comp.h"
#include "hardware_draws_comp.h"
#include "leaf_blocks_comp.h"
#include "leaf_expand_comp.h"
#include "leaf_raster_comp.h"
#include "leaf_raster_int64_comp.h"
#include "leaf_splats_comp.h"
#include "leaf_splats_int64_comp.h"
#include "leaf_tiles_comp.h"
#include "occluder_comp.h"
#include "raster_resolve_depth_frag.h"
#include "raster_resolve_frag.h"
#include "raster_resolve_vert.h"

namespace coppice::gpu {
namespace {

/// The bindings of raster.glsl: storage buffers, then texels of the picture, of work and of motion. The fragment shader reads picture and
/// work, as texels or not.
constexpr std::uint32_t kStorageCount = 8, kTexelCount = 3;
constexpr std::uint32_t kPictureBinding = 0, kWorkBinding = 5;
constexpr std::array<Binding, kStorageCount + kTexelCount> kRasterSet = [] {
  std::array<Binding, kStorageCount + kTexelCount> bindings{};
  for (Binding& binding : bindings) binding.stages = VK_SHADER_STAGE_COMPUTE_BIT;
  bindings[kPictureBinding].stages |= VK_SHADER_STAGE_FRAGMENT_BIT;
  bindings[kWorkBinding].stages |= VK_SHADER_STAGE_FRAGMENT_BIT;
  for (std::uint32_t i = 0; i < kTexelCount; ++i)
    bindings[kStorageCount + i] = {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_FRAGMENT_BIT};
  return bindings;
}();
/// The hardware draws instances whose leaves are larger on average, px, because their texture is visible and a leaf costs no more there.
constexpr float kSplit_px = 12.0f;

/// Leaves up to this length are drawn as splats.
constexpr float kSplat_px = 4.0f;

/// Minimum number of slots in the size of cluster lists: a share of the clusters.
constexpr std::uint32_t kMinWorkSlotShare = 4;

/// Constants 0 to 7 of the rasteriser's shaders.
struct Constants {
  std::uint32_t kind = 0;
  std::uint32_t lanes = 8;
  std::uint32_t pass = 0;
  std::uint32_t cluster_lanes = 1;
  std::uint32_t big_pixels = 400;
  std::uint32_t row_lanes = 1;
  std::uint32_t eyes = 1;
  std::uint32_t contents = 0;
};

/// A software driver pays for each group, and for each load of an invocation: it gets few groups, and shared data is loaded once. On a GPU
/// hundreds of invocations hide each other's loads, so work is spread as far as it goes. DECISIONS.md, "Drawing", has the figures.
constexpr RasterShape kFewLanes{.expand_together = false,
                                .leaf_lanes = 8,
                                .leaf_clusters = 4,
                                .big_pixels = 400,
                                .big_lanes = 8,
                                .row_lanes = 1,
                                .splat_lanes = 8,
                                .cluster_lanes = 1};
constexpr RasterShape kManyLanes{.expand_together = true,
                                 .leaf_lanes = 64,
                                 .leaf_clusters = 1,
                                 .big_pixels = 128,
                                 .big_lanes = 64,
                                 .row_lanes = 8,
                                 .splat_lanes = 64,
                                 .cluster_lanes = 32};

std::uint64_t tile_count_of(std::uint32_t level, std::uint32_t width_px, std::uint32_t height_px) {
  const std::uint64_t side = std::uint64_t{kTileSide_px} << (2 * level);
  return ((width_px + side - 1) / side) * ((height_px + side - 1) / side);
}

std::uint64_t tile_count(std::uint32_t width_px, std::uint32_t height_px) {
  std::uint64_t count = 0;
  for (std::uint32_t level = 0; level < kTileLevels; ++level) count += tile_count_of(level, width_px, height_px);
  return count;
}

/// Maximum rounding of depth attachments, in both directions of depth. Normalised formats round to their next number; 1 - key is rounded
/// near 1, plus some for the interpolation of triangles.
float depth_step(const AttachmentDesc& attachments) {
  float step = is_reversed(attachments.depth_compare) ? 0.0f : 0x1p-20f;
  const VkFormat format = attachments.depth_format;
  if (format == VK_FORMAT_D16_UNORM || format == VK_FORMAT_D16_UNORM_S8_UINT) step += 0x1p-15f;
  if (format == VK_FORMAT_X8_D24_UNORM_PACK32 || format == VK_FORMAT_D24_UNORM_S8_UINT) step += 0x1p-23f;
  return step;
}

/// Most of it does not depend on the slots. It grows in few steps, because each step takes all of it twice for some frames.
std::uint64_t work_capacity(const WorkSize& size) {
  return size.slots == 0 ? 0 : std::uint64_t{size.clusters} + std::bit_ceil(std::max(size.slots, size.clusters / kMinWorkSlotShare));
}

BufferSize work_size(Buffer& work, const WorkSize& size) {
  return {&work, "coppice work items",       work_capacity(size) * sizeof(WorkItem), kStorage | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT,
          false, VK_FORMAT_R32G32B32A32_UINT};
}

/// As many elements of motion, for a view with velocity.
BufferSize motion_size(Buffer& motion, const WorkSize& size) {
  return {&motion,
          "coppice cluster motion",
          work_capacity(size) * sizeof(ClusterMotion),
          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT,
          false,
          VK_FORMAT_R32G32B32A32_UINT};
}

/// Leaves and wood of each instance, drawn by the rasteriser or the hardware.
constexpr std::uint32_t kItemsPerSlot = 2;

/// True if the rasteriser draws such a view.
bool is_drawn(const coppice_camera& view) {
  return view.lod == COPPICE_LOD_CUT;
}

}  // namespace

LeafRaster::LeafRaster(Device& device, DeferredDeletion& deletion, PipelineSet& pipelines, const RasterDesc& desc)
    : device_(device), deletion_(deletion), pipeline_set_(pipelines), desc_(desc) {}

Result<std::unique_ptr<LeafRaster>> LeafRaster::create(Device& device, DeferredDeletion& deletion, PipelineSet& pipelines,
                                                       const RasterDesc& desc) {
  VkPhysicalDeviceSubgroupProperties subgroup{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &subgroup};
  device.vk.vkGetPhysicalDeviceProperties2(device.physical_device, &properties);
  if (desc.max_instances > kMaxSlots)
    return Error{Status::unsupported, "max_instances beyond what the compute rasteriser names", Error::kNoOffset,
                 std::to_string(desc.max_instances)};
  if (device.max_stage_buffers < kFrameStorageBuffers + kStorageCount)
    return Error{Status::unsupported, "too few storage buffers in a stage for the compute rasteriser"};
  constexpr VkSubgroupFeatureFlags kNeeded = VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT;
  if ((subgroup.supportedOperations & kNeeded) != kNeeded || !(subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT))
    return Error{Status::unsupported, "no subgroup ballots for the compute rasteriser"};
  std::unique_ptr<LeafRaster> raster(new (std::nothrow) LeafRaster(device, deletion, pipelines, desc));
  if (!raster) return Error{Status::out_of_memory, "compute rasteriser"};
  raster->lanes_ = std::clamp(subgroup.subgroupSize, 8u, 64u);
  raster->shape_ = desc.many_lanes.value_or(properties.properties.deviceType != VK_PHYSICAL_DEVICE_TYPE_CPU) ? kManyLanes : kFewLanes;
  COPPICE_CHECK(raster->create_layouts());
  raster->add_pipelines();
  return raster;
}

LeafRaster::~LeafRaster() {
  const Functions& vk = device_.vk;
  vk.vkDestroyPipelineLayout(device_.device, layout_, nullptr);
  destroy_set_layout(device_, set_layout_);
  for (Buffer* buffer : {&buffers_.blocks, &buffers_.visible_blocks, &buffers_.items, &buffers_.big, &buffers_.work})
    destroy_buffer(device_, *buffer);
}

Result<void> LeafRaster::create_layouts() {
  COPPICE_CHECK(move_into(set_layout_, create_set_layout(device_, "coppice raster", kRasterSet)));
  const std::array sets{desc_.frame_set, set_layout_.layout};
  const VkPushConstantRange push{.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, .size = sizeof(RasterPush)};
  return move_into(layout_, create_pipeline_layout(device_, sets, push));
}

void LeafRaster::add_pipelines() {
  using Words = std::span<const std::uint32_t>;
  const auto add = [this](const char* name, Words words, const Constants& constants) {
    return &pipeline_set_.add(
        {.name = name, .layout = layout_, .first = words, .constants = std::bit_cast<std::array<std::uint32_t, 8>>(constants)});
  };
  const auto add_select = [&](const char* name, Words words, Constants constants) {
    return for_each_eye_count([&](std::uint32_t eyes) {
      constants.eyes = eyes;
      return add(name, words, constants);
    });
  };
  pipelines_.blocks = add_select("leaf_blocks.comp", leaf_blocks_comp_spirv, {});
  pipelines_.draws = add_select("hardware_draws.comp", hardware_draws_comp_spirv, {.lanes = lanes_});
  pipelines_.expand = add_select("leaf_expand.comp", leaf_expand_comp_spirv, {.kind = shape_.expand_together ? 1u : 0u, .lanes = lanes_});
  const auto add_cull = [&](std::uint32_t debugged) { return add_select("cull_raster.comp", cull_raster_comp_spirv, {.kind = debugged}); };
  pipelines_.cull = {add_cull(0), add_cull(1)};
  const auto add_tiles = [&](std::uint32_t others) {
    return add("leaf_tiles.comp", leaf_tiles_comp_spirv, {.kind = others, .lanes = lanes_});
  };
  pipelines_.finest_tiles = add_tiles(0);
  pipelines_.other_tiles = add_tiles(1);
  pipelines_.motion = add("cluster_motion.comp", cluster_motion_comp_spirv, {.lanes = lanes_});
  pipelines_.occluder = add("occluder.comp", occluder_comp_spirv, {.lanes = lanes_});
  const Words leaves = desc_.int64_atomics ? Words(leaf_raster_int64_comp_spirv) : Words(leaf_raster_comp_spirv);
  const Words big = desc_.int64_atomics ? Words(big_leaves_int64_comp_spirv) : Words(big_leaves_comp_spirv);
  const Words splats = desc_.int64_atomics ? Words(leaf_splats_int64_comp_spirv) : Words(leaf_splats_comp_spirv);
  for (std::uint32_t pass = 0; pass < kPassCount; ++pass) {
    pipelines_.splats[pass] =
        add("leaf_splats.comp", splats, {.lanes = shape_.splat_lanes, .pass = pass, .cluster_lanes = shape_.cluster_lanes});
    pipelines_.leaves[pass] = add("leaf_raster.comp", leaves, {.lanes = shape_.leaf_lanes, .pass = pass, .big_pixels = shape_.big_pixels});
    pipelines_.big[pass] = add("big_leaves.comp", big, {.lanes = shape_.big_lanes, .pass = pass, .row_lanes = shape_.row_lanes});
  }
}

Pipeline* LeafRaster::add_resolve(const AttachmentDesc& attachments) {
  using Words = std::span<const std::uint32_t>;
  return &pipeline_set_.add({.name = "raster_resolve.vert",
                             .layout = layout_,
                             .first = raster_resolve_vert_spirv,
                             .fragment = is_depth_alone(attachments) ? Words(raster_resolve_depth_frag_spirv) : raster_resolve_frag_spirv,
                             .constants = {0, 0, 0, 0, 0, 0, 0, packed_contents(attachments)},
                             .attachments = attachments});
}

std::span<const LeafRaster::RasterPass> LeafRaster::passes(coppice_debug_view debug_view) const {
  static constexpr std::array kDrawn{kDepth, kName};
  static constexpr std::array kCounted{kCount};
  if (debug_view == COPPICE_DEBUG_OVERDRAW) return kCounted;
  return std::span(kDrawn).first(desc_.int64_atomics ? 1 : 2);
}

bool LeafRaster::request(coppice_debug_view debug_view, std::uint32_t eye_count, Pipeline& resolve) {
  bool ready = true;
  const auto request = [&](Pipeline* pipeline) { ready = pipeline_set_.request(*pipeline) && ready; };
  request(pipelines_.blocks.of(eye_count));
  request(pipelines_.cull.of(debug_view, eye_count));
  request(pipelines_.expand.of(eye_count));
  for (const RasterPass pass : passes(debug_view)) {
    request(pipelines_.splats[pass]);
    request(pipelines_.leaves[pass]);
    request(pipelines_.big[pass]);
  }
  request(pipelines_.finest_tiles);
  request(pipelines_.other_tiles);
  request(pipelines_.draws.of(eye_count));
  if (has_content(resolve.recipe.attachments, COPPICE_CONTENT_VELOCITY)) request(pipelines_.motion);
  request(&resolve);
  return ready;
}

Result<void> LeafRaster::create_view(const AttachmentDesc& attachments, RasterView& view) {
  view.depth_alone = is_depth_alone(attachments);
  view.has_velocity = has_content(attachments, COPPICE_CONTENT_VELOCITY);
  view.reversed_depth = is_reversed(attachments.depth_compare);
  view.depth_step = depth_step(attachments);
  return move_into(view.culling_passes, create_buffer(device_, {"coppice culling passes", kCullingPasses * sizeof(CullingPass),
                                                                kStorage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT}));
}

void LeafRaster::destroy_view(RasterView& view) {
  for (Buffer* buffer : {&view.culling_passes, &view.work, &view.motion, &view.picture, &view.tiles}) destroy_buffer(device_, *buffer);
  destroy_set(device_, view.set);
}

void LeafRaster::release_picture(RasterView& view) {
  for (Buffer* buffer : {&view.picture, &view.tiles}) deletion_.defer(*buffer);
}

void LeafRaster::add_sizes(const WorkSize& size, bool depth_views, BufferSizes& sizes) {
  const std::uint64_t slots = size.slots, block_count = (slots + kBlockSlots - 1) / kBlockSlots;
  sizes.add({&buffers_.blocks, "coppice blocks", block_count * sizeof(InstanceBlock), kStorage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true});
  sizes.add({&buffers_.visible_blocks, "coppice visible blocks", block_count * sizeof(std::uint32_t), kStorage});
  sizes.add({&buffers_.items, "coppice items", slots * kItemsPerSlot * sizeof(std::uint32_t), kStorage});
  sizes.add({&buffers_.big, "coppice big leaves", slots > 0 ? kBigCapacity * sizeof(uvec2) : 0, kStorage});
  if (depth_views) sizes.add(work_size(buffers_.work, size));
}

void LeafRaster::add_view_sizes(const WorkSize& size, RasterView& view, BufferSizes& sizes) {
  if (view.depth_alone) return;
  sizes.add(work_size(view.work, size));
  if (view.has_velocity) sizes.add(motion_size(view.motion, size));
}

PictureSize picture_size(std::uint32_t width_px, std::uint32_t height_px, std::uint32_t eye_count) {
  return {std::uint64_t{eye_count} * width_px * height_px * 2 * sizeof(std::uint32_t),
          eye_count * tile_count(width_px, height_px) * sizeof(std::uint32_t)};
}

InstanceBlock gpu_block(const InstanceBounds& bounds) {
  static_assert(kBlockSlots == kInstanceBlockSlots);
  const CellPlace center = cell_place(bounds.center_m);
  return {.center = center.place,
          .radius_m = bounds.radius_m,
          .max_instance_radius_m = bounds.max_instance_radius_m,
          .instance_count = bounds.instance_count,
          .cell_xy = pack_cell_xy(center.cell),
          .cell_z = static_cast<std::uint32_t>(center.cell.z)};
}

Result<void> LeafRaster::rebuild_set(RasterView& view) {
  const Buffer& work = work_of(view);
  const std::array<Bound, kStorageCount + kTexelCount> bound{{{&view.picture},
                                                              {&buffers_.blocks},
                                                              {&view.culling_passes},
                                                              {&buffers_.visible_blocks},
                                                              {&buffers_.items},
                                                              {&work},
                                                              {&buffers_.big},
                                                              {&view.tiles},
                                                              {&view.picture},
                                                              {&work},
                                                              {view.has_velocity ? &view.motion : &work}}};
  COPPICE_TRY(made, create_set(device_, set_layout_, bound));
  deletion_.defer(view.set);
  view.set = made;
  view.set_stale = false;
  return {};
}

Result<void> LeafRaster::reserve_picture(RasterView& view, const PictureSize& needed) {
  COPPICE_TRY(picture, create_buffer(device_, {"coppice picture", needed.picture_bytes, kStorage | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT,
                                               MemoryKind::alone}));
  auto tiles = create_buffer(device_, {"coppice tiles", needed.tile_bytes, kStorage, MemoryKind::alone});
  if (!tiles) {
    destroy_buffer(device_, picture);
    return tiles.error();
  }
  release_picture(view);
  view.picture = picture;
  view.tiles = *tiles;
  view.set_stale = true;
  return {};
}

bool LeafRaster::prepare(RasterView& view, const coppice_camera& camera, std::uint32_t eye_count) {
  if (!is_drawn(camera)) return false;
  // A picture that is larger already stays.
  PictureSize needed = picture_size(camera.width_px, camera.height_px, eye_count);
  needed.picture_bytes = std::max(needed.picture_bytes, view.picture.size_bytes);
  needed.tile_bytes = std::max(needed.tile_bytes, view.tiles.size_bytes);
  Result<void> reserved;
  if (needed.picture_bytes > view.picture.size_bytes || needed.tile_bytes > view.tiles.size_bytes) {
    if (!fits_buffer(device_, needed.picture_bytes + needed.tile_bytes)) return false;
    reserved = reserve_picture(view, needed);
  }
  // It also retries after an earlier frame in which the picture's set could not be made.
  if (reserved && view.set_stale) reserved = rebuild_set(view);
  if (!reserved) {
    go_on_without(device_, reserved.error(), "what the compute shaders would draw is drawn by the hardware");
    return false;
  }
  const bool reversed = view.reversed_depth;
  const auto capacity = static_cast<std::uint32_t>(work_of(view).size_bytes / sizeof(WorkItem));
  const auto slots = static_cast<std::uint32_t>(buffers_.items.size_bytes / (kItemsPerSlot * sizeof(std::uint32_t)));
  view.debug_view = camera.debug_view;
  view.eye_count = eye_count;
  view.push = {
      .culling_pass = 0,
      .width_px = camera.width_px,
      .height_px = camera.height_px,
      .splat_px = kSplat_px,
      .split_px = kSplit_px,
      .reversed = reversed ? 1u : 0u,
      .lanes = lanes_,
      .work_capacity = capacity,
      // As many whatever the budget: which of two leaves at the same depth wins depends on it.
      .place_bits = static_cast<std::uint32_t>(std::bit_width(std::max(capacity, kWorkClusters + kWorkClusters / kMinWorkSlotShare))),
      .expand_items = shape_.expand_together ? 1 : lanes_,
      .leaf_clusters = shape_.leaf_clusters,
      .splat_clusters = shape_.splat_lanes / shape_.cluster_lanes,
      .hides_from = 1,
      .occluder_step = view.depth_step,
      .motion = gpu_address(view.motion.address),
      .work_clusters = std::min(kWorkClusters, capacity - std::min(capacity, slots))};
  return true;
}

void LeafRaster::record_start(VkCommandBuffer cmd, const RasterView& view) const {
  std::array<CullingPass, kCullingPasses> culling_passes{};
  for (CullingPass& culling_pass : culling_passes) {
    for (RasterStage* stage : {&culling_pass.blocks, &culling_pass.items, &culling_pass.big, &culling_pass.draws})
      stage->groups[1] = stage->groups[2] = 1;
    for (RasterStage* stage : {&culling_pass.work, &culling_pass.splats, &culling_pass.finest_tiles, &culling_pass.other_tiles}) {
      stage->groups[1] = view.eye_count;
      stage->groups[2] = 1;
    }
  }
  device_.vk.vkCmdUpdateBuffer(cmd, view.culling_passes.buffer, 0, sizeof culling_passes, culling_passes.data());
  device_.vk.vkCmdFillBuffer(cmd, view.picture.buffer, 0,
                             std::uint64_t{view.eye_count} * view.push.width_px * view.push.height_px * 2 * sizeof(std::uint32_t), 0);
  device_.vk.vkCmdFillBuffer(cmd, view.tiles.buffer, 0, VK_WHOLE_SIZE, 0);
}

void LeafRaster::bind(VkCommandBuffer cmd, const Pipeline& pipeline) const {
  device_.vk.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle());
}

void LeafRaster::barrier(VkCommandBuffer cmd) const {
  memory_barrier(device_, cmd, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
                 VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
                 VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT |
                     VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
}

void LeafRaster::dispatch_stage(VkCommandBuffer cmd, const Pipeline& pipeline, const ViewPass& of, std::uint64_t stage_offset) const {
  bind(cmd, pipeline);
  device_.vk.vkCmdDispatchIndirect(cmd, of.view.culling_passes.buffer, of.culling_pass * sizeof(CullingPass) + stage_offset);
}

void LeafRaster::record_leaves(VkCommandBuffer cmd, const ViewPass& of, GpuTimer* timer) const {
  const std::span<const RasterPass> drawn = passes(of.view.debug_view);
  for (const RasterPass pass : drawn) {
    if (pass != drawn.front()) barrier(cmd);
    dispatch_stage(cmd, *pipelines_.splats[pass], of, offsetof(CullingPass, splats));
    if (timer != nullptr) timer->mark(device_, cmd, Pass::splats);
    dispatch_stage(cmd, *pipelines_.leaves[pass], of, offsetof(CullingPass, work));
    barrier(cmd);
    dispatch_stage(cmd, *pipelines_.big[pass], of, offsetof(CullingPass, big));
    if (timer != nullptr && pass != drawn.back()) timer->mark(device_, cmd, Pass::leaves);
  }
}

void LeafRaster::record_tiles(VkCommandBuffer cmd, const ViewPass& of) const {
  dispatch_stage(cmd, *pipelines_.finest_tiles, of, offsetof(CullingPass, finest_tiles));
  barrier(cmd);
  dispatch_stage(cmd, *pipelines_.other_tiles, of, offsetof(CullingPass, other_tiles));
  barrier(cmd);
}

void LeafRaster::push(VkCommandBuffer cmd, const RasterPush& constants) const {
  device_.vk.vkCmdPushConstants(cmd, layout_, VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof constants, &constants);
}

void LeafRaster::record_occluder(VkCommandBuffer cmd, const RasterView& view, const RasterPush& constants) const {
  const std::uint64_t finest = tile_count_of(0, constants.width_px, constants.height_px);
  const std::uint64_t others = tile_count(constants.width_px, constants.height_px) - finest;
  const auto dispatch = [&](const Pipeline& pipeline, std::uint64_t tiles) {
    bind(cmd, pipeline);
    device_.vk.vkCmdDispatch(cmd, static_cast<std::uint32_t>((tiles + lanes_ - 1) / lanes_), view.eye_count, 1);
    barrier(cmd);
  };
  push(cmd, constants);
  dispatch(*pipelines_.occluder, finest);
  dispatch(*pipelines_.other_tiles, others);
}

void LeafRaster::record(VkCommandBuffer cmd, const RasterView& view, const Cull& cull) const {
  const Functions& vk = device_.vk;
  const auto mark = [&](Pass pass) {
    if (cull.timer != nullptr) cull.timer->mark(device_, cmd, pass);
  };
  const std::array sets{cull.frame_set, view.set.set};
  vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, static_cast<std::uint32_t>(sets.size()), sets.data(), 0,
                             nullptr);
  const std::uint32_t block_count = (cull.slot_count + kBlockSlots - 1) / kBlockSlots;
  if (block_count == 0) return;
  RasterPush constants = view.push;
  if (cull.occluder != nullptr) {
    constants.hides_from = 0;
    constants.occluder_x_px = cull.occluder->x_px;
    constants.occluder_y_px = cull.occluder->y_px;
    record_occluder(cmd, view, constants);
    mark(Pass::tiles);
  }
  for (std::uint32_t culling_pass = 0; culling_pass < kCullingPasses; ++culling_pass) {
    const ViewPass of{view, culling_pass};
    constants.culling_pass = culling_pass;
    push(cmd, constants);
    bind(cmd, *pipelines_.blocks.of(view.eye_count));
    vk.vkCmdDispatch(cmd, (block_count + kCullGroupSize - 1) / kCullGroupSize, 1, 1);
    barrier(cmd);
    dispatch_stage(cmd, *pipelines_.cull.of(view.debug_view, view.eye_count), of, offsetof(CullingPass, blocks));
    barrier(cmd);
    dispatch_stage(cmd, *pipelines_.expand.of(view.eye_count), of, offsetof(CullingPass, items));
    barrier(cmd);
    mark(Pass::cull);
    record_leaves(cmd, of, cull.timer);
    barrier(cmd);
    mark(Pass::leaves);
    if (culling_pass + 1 == kCullingPasses) break;
    record_tiles(cmd, of);
    mark(Pass::tiles);
  }
  if (view.has_velocity) {
    bind(cmd, *pipelines_.motion);
    vk.vkCmdDispatch(cmd, kMotionGroups, 1, 1);
  }
  dispatch_stage(cmd, *pipelines_.draws.of(view.eye_count), {view, 0}, offsetof(CullingPass, draws));
}

void LeafRaster::record_resolve(VkCommandBuffer cmd, const RasterView& view, VkDescriptorSet frame_set, const Resolve& resolve) const {
  const Functions& vk = device_.vk;
  const std::array sets{frame_set, view.set.set};
  vk.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, resolve.pipeline.handle());
  vk.vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, static_cast<std::uint32_t>(sets.size()), sets.data(), 0,
                             nullptr);
  RasterPush constants = view.push;
  constants.eye = resolve.eye;
  push(cmd, constants);
  vk.vkCmdDraw(cmd, 3, 1, 0, 0);
}

}  // namespace coppice::gpu
