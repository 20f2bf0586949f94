#include "vulkan_backend.h"

#include <algorithm>
#include <new>
#include <utility>

#include "attachments.h"

namespace coppice {

Result<std::unique_ptr<Backend>> VulkanBackend::create(const VulkanOptions& with, const BackendOptions& options) {
  const coppice_vulkan_desc& vulkan = with.desc;
  COPPICE_TRY(device, gpu::open_device(vulkan.instance, vulkan.physical_device, vulkan.device, vulkan.get_instance_proc_addr));
  const gpu::OptionalFeatures has = gpu::optional_features(device);
  device.block_textures = vulkan.texture_compression_bc == VK_TRUE && has.block_textures;
  device.draw_counts = vulkan.draw_indirect_count == VK_TRUE && has.draw_counts;
  device.log = options.log;
  device.queue_families = std::vector(vulkan.queue_families, vulkan.queue_families + vulkan.queue_family_count);
  device.memory.hook = with.device_memory;
  device.memory.ledger = &options.ledger;
  COPPICE_TRY(renderer, gpu::Renderer::create({.device = device,
                                               .allocator = options.hooks.allocator,
                                               .views = {.max_instances = options.max_instances,
                                                         .compute_raster = vulkan.compute_raster == VK_TRUE,
                                                         .int64_atomics = vulkan.shader_int64_atomics == VK_TRUE && has.int64_atomics,
                                                         .many_lanes = {},
                                                         .pass_times = vulkan.pass_times == VK_TRUE},
                                               .pipeline_cache = vulkan.pipeline_cache,
                                               .memory_budget_bytes = options.memory_budget_bytes,
                                               .max_plants = options.max_plants,
                                               .jobs = options.hooks.jobs,
                                               .blocking_pipelines = vulkan.blocking_pipelines == VK_TRUE,
                                               .only_measured = options.hooks.jobs.submit == nullptr}));
  std::unique_ptr<Backend> backend(new (std::nothrow) VulkanBackend(std::move(renderer)));
  if (!backend) return Error{Status::out_of_memory, "renderer"};
  return backend;
}

VulkanBackend::VulkanBackend(std::unique_ptr<gpu::Renderer> renderer)
    : renderer_(std::move(renderer)),
      limits_{.max_instances = renderer_->max_instances(),
              .max_plants = renderer_->max_plants(),
              .max_view_width_px = renderer_->device().max_view_width,
              .max_view_height_px = renderer_->device().max_view_height,
              .sizes = {.slack_bytes = gpu::Renderer::kSlackBytes,
                        .form = &cluster_form(renderer_->has_raster()),
                        .block_textures = renderer_->device().block_textures}} {}

void VulkanBackend::fill_stats(coppice_stats& stats) const {
  stats.device_allocations = renderer_->device().memory.block_count;
  stats.pipelines_wanted = renderer_->pipelines().requested_count();
  stats.pipelines_built = renderer_->pipelines().built_count();
  const gpu::PipelineTimes times = renderer_->pipelines().times();
  stats.pipelines_ms = times.sum_ms;
  stats.longest_pipeline_ms = static_cast<float>(times.longest_ms);
  stats.longest_pipeline = times.longest;
  stats.missing_pipeline = renderer_->pipelines().missing();
}

void VulkanBackend::begin_frame(std::uint64_t frame_number, std::uint64_t completed_number, const FrameWind& wind) {
  wind_ = wind;
  renderer_->begin_frame(frame_number, completed_number);
  renderer_->begin_wind_map(wind_);
}

Result<bool> VulkanBackend::upload_chunk(const DecodedChunk& chunk, std::uint64_t max_bytes) {
  const auto [plant, kind, index] = chunk.id;
  switch (kind) {
    case ChunkKind::page:
      COPPICE_CHECK(renderer_->upload_page({plant, index, chunk.clusters, chunk.ready_cuts}));
      return true;
    case ChunkKind::wood:
      return renderer_->upload_mesh({plant, index, chunk.mesh}, max_bytes);
    case ChunkKind::texture:
      return renderer_->upload_texture(plant, index, chunk.texture, max_bytes);
    case ChunkKind::leaf_mesh:
      return renderer_->upload_mesh({plant, gpu::kMaxWoodLods + index, chunk.mesh}, max_bytes);
  }
  return true;
}

void VulkanBackend::hide_chunk(ChunkId id) {
  if (id.kind == ChunkKind::texture) renderer_->plants().hide_texture(id.plant, id.index);
}

void VulkanBackend::drop_chunk(ChunkId id) {
  switch (id.kind) {
    case ChunkKind::page:
      return renderer_->plants().drop_page(id.plant, id.index);
    case ChunkKind::wood:
      return renderer_->plants().drop_mesh(id.plant, id.index);
    case ChunkKind::texture:
      return renderer_->plants().drop_texture(id.plant, id.index);
    case ChunkKind::leaf_mesh:
      return renderer_->plants().drop_mesh(id.plant, gpu::kMaxWoodLods + id.index);
  }
}

void VulkanBackend::show_view(std::uint32_t index, const coppice_camera& camera, const LodView& lod) {
  renderer_->view(index).show({camera, lod, wind_});
}

bool VulkanBackend::has_reversed_depth(std::uint32_t index) const {
  return gpu::is_reversed(view(index).attachments().depth_compare);
}

std::optional<ViewCounts> VulkanBackend::view_counts(std::uint32_t index) const {
  ViewCounts of{view(index).counts(), {}};
  static_assert(COPPICE_PASS_COUNT == static_cast<std::uint32_t>(gpu::Pass::count));
  std::ranges::copy(view(index).timer().pass_ms(), of.pass_ms.begin());
  of.pass_ms[COPPICE_PASS_UPLOAD] = renderer_->timer().pass_ms()[COPPICE_PASS_UPLOAD];
  return of;
}

}  // namespace coppice
