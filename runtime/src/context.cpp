#include "context.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <new>
#include <utility>

namespace coppice {
namespace {

/// The compute rasteriser's lists of a page's leaves and of the cuts coarser than it, about; see coppice_context_desc.compute_raster.
constexpr std::uint64_t kRasterListBytesPerPage = 180 * COPPICE_PAGE_SPLITS;

std::uint64_t nanoseconds(float ms) {
  return static_cast<std::uint64_t>(std::min(double{ms} * 1e6, 1e18));
}

std::uint32_t index_of(coppice_plant plant) {
  return static_cast<std::uint32_t>(plant & 0xffffffffu) - 1;
}
std::uint32_t generation_of(coppice_plant plant) {
  return static_cast<std::uint32_t>(plant >> 32);
}

Result<std::unique_ptr<gpu::Renderer>> create_renderer(const coppice_context_desc& desc) {
  COPPICE_TRY(device, gpu::open_device(desc.instance, desc.physical_device, desc.device, desc.get_instance_proc_addr));
  device.block_textures = desc.texture_compression_bc == VK_TRUE && gpu::has_block_textures(device);
  return gpu::Renderer::create({.device = device,
                                .attachments = {.color_format = desc.color_format,
                                                .depth_format = desc.depth_format,
                                                .depth_compare = desc.depth_compare,
                                                .samples = desc.samples},
                                .pipeline_cache = desc.pipeline_cache,
                                .memory_budget_bytes = desc.memory_budget_bytes,
                                .max_instances = desc.max_instances,
                                .max_plants = desc.max_plants,
                                .compute_raster = desc.compute_raster == VK_TRUE,
                                .int64_atomics = desc.shader_int64_atomics == VK_TRUE && gpu::has_int64_atomics(device),
                                .pass_times = desc.pass_times == VK_TRUE});
}

}  // namespace

Result<std::unique_ptr<Context>> Context::create(const coppice_context_desc& desc) {
  std::unique_ptr<Context> context(new (std::nothrow) Context);
  if (!context) return Error{Status::out_of_memory, "context"};
  COPPICE_TRY(hooks, complete_hooks({desc.allocator, desc.jobs, desc.io, desc.log}));
  context->hooks_ = std::move(hooks);
  COPPICE_TRY(renderer, create_renderer(desc));
  context->renderer_ = std::move(renderer);
  COPPICE_TRY(instances, gpu::InstanceTable::create(context->hooks_.hooks.allocator, desc.max_instances, desc.max_plants));
  context->instances_ = std::move(instances);
  const StreamerOptions options{.gpu = {.page_bytes = gpu::kPageBytes,
                                        .wood_vertex_bytes = sizeof(gpu::WoodVertex),
                                        .leaf_mesh_vertex_bytes = sizeof(gpu::LeafMeshVertex),
                                        .page_list_bytes = context->renderer_->has_raster() ? kRasterListBytesPerPage : 0,
                                        .block_textures = context->renderer_->block_textures()},
                                .budget_bytes = desc.memory_budget_bytes,
                                .max_plants = desc.max_plants,
                                .hand_over_budget_ns = nanoseconds(desc.streaming_ms)};
  context->streaming_ns_ = options.hand_over_budget_ns;
  COPPICE_TRY(streamer, Streamer::create(context->hooks_.hooks, options));
  context->streamer_ = std::move(streamer);
  context->plants_.resize(desc.max_plants);
  context->demands_.resize(desc.max_plants);
  context->residency_.resize(desc.max_plants);
  return context;
}

Result<coppice_plant> Context::open_plant(const char* path) {
  COPPICE_TRY(index, streamer_->open_plant(path));
  const PlantFile& file = streamer_->file(index);
  if (auto added = renderer_->add_plant(index, file, streamer_->lod_words(index)); !added) {
    log_line(log(), COPPICE_LOG_ERROR, "%s: %s", path, added.error().message().c_str());
    streamer_->close_plant(index);
    return added.error();
  }
  instances_.set_plant_sphere(index, file.plant.sphere_center, file.plant.sphere_radius);
  PlantEntry& entry = plants_[index];
  entry.open = true;
  entry.on_gpu = true;
  return std::uint64_t{entry.generation} << 32 | (index + 1);
}

bool Context::is_open(coppice_plant plant) const {
  const std::uint32_t index = index_of(plant);
  return index < plants_.size() && plants_[index].open && plants_[index].generation == generation_of(plant);
}

void Context::close_plant(coppice_plant plant) {
  const std::uint32_t index = index_of(plant);
  instances_.remove_plant(index);
  streamer_->close_plant(index);
  plants_[index].open = false;
  ++plants_[index].generation;
}

void Context::fill_info(coppice_plant plant, coppice_plant_info& info) const {
  const std::uint32_t index = index_of(plant);
  const PlantFile& file = streamer_->file(index);
  const PlantState state = streamer_->state(index);
  info.leaf_count = file.plant.leaf_count;
  info.resident_leaf_count = state.resident_leaf_count;
  info.page_count = file.plant.page_count;
  info.resident_page_count = state.resident_page_count;
  info.wood_lod_count = file.plant.wood_lod_count;
  const std::span<const std::uint32_t> words = streamer_->lod_words(index);
  info.wood_triangle_count = file.plant.wood_lod_count == 0 ? 0 : lod::coppice_table_wood_triangles(lod_table(file, words), 0);
  std::copy_n(file.plant.sphere_center, 3, info.sphere_center);
  info.sphere_radius = file.plant.sphere_radius;
  info.file_bytes = file.header.file_bytes;
  static_assert(sizeof info.name == sizeof file.plant.name);
  std::memcpy(info.name, file.plant.name, sizeof info.name);
}

Result<void> Context::add_instances(coppice_plant plant, std::span<const coppice_placement> placements,
                                    std::span<coppice_instance> handles) {
  return instances_.add(index_of(plant), placements, handles);
}

Result<coppice_scene> Context::open_scene(const char* path) {
  std::unique_ptr<Scene> scene(new (std::nothrow) Scene);
  if (!scene) return Error{Status::out_of_memory, "scene"};
  COPPICE_TRY(stream, SceneStream::open(hooks_.hooks, path, {}));
  scene->stream = std::move(stream);
  scene->tile_blocks.resize(scene->stream->file().tiles.size());
  scene->plants.resize(scene->stream->file().species.size());
  scene->handle = ++last_scene_;
  scene_ = std::move(scene);
  return scene_->handle;
}

void Context::close_scene() {
  for (std::uint32_t tile = 0; tile < scene_->tile_blocks.size(); ++tile) remove_tile(tile);
  for (const coppice_plant plant : scene_->plants)
    if (is_open(plant)) close_plant(plant);
  scene_.reset();
}

void Context::fill_info(coppice_scene_info& info) const {
  const SceneFile& file = scene_->stream->file();
  info.species_count = file.header.species_count;
  info.tile_count = file.header.tile_count;
  info.instance_count = file.header.instance_count;
  info.file_bytes = file.header.file_bytes;
  std::copy_n(file.header.square_min, 2, info.square_min);
  info.square_side = file.header.square_side;
  info.height_min = file.tiles[0].entry.box_min[1];
  info.height_max = file.tiles[0].entry.box_max[1];
  for (const SceneTile& tile : file.tiles) {
    info.height_min = std::min(info.height_min, tile.entry.box_min[1]);
    info.height_max = std::max(info.height_max, tile.entry.box_max[1]);
  }
}

namespace {

/// A tile that is larger than this when it comes grows up in so many frames, if no more than so many others do.
constexpr float kGrowFrom_px = 3.0f;
constexpr std::uint32_t kGrowFrames = 16, kMostGrowing = 16;
/// A plant that found no memory is tried again so often, after so many frames each.
constexpr std::uint32_t kSpeciesTries = 8;
constexpr std::uint64_t kSpeciesRetryFrames = 30;
/// Device memory that grows with an instance: draw commands, places in the lists of wood.
constexpr std::uint64_t kInstanceGrowthBytes = 64;

coppice_placement placement_of(const SceneInstance& instance) {
  coppice_placement placement{};
  std::ranges::copy(instance.position_m, placement.position);
  placement.scale = instance.scale;
  placement.rotation[1] = std::sin(0.5f * instance.yaw_rad);
  placement.rotation[3] = std::cos(0.5f * instance.yaw_rad);
  std::ranges::copy(instance.tint, placement.tint);
  return placement;
}

}  // namespace

void Context::stream_scene(const LodView& view) {
  static_assert(kTileBlockInstances == gpu::kDirtyBlockSlots);
  const std::uint64_t affordable = streamer_->stats().budget_bytes / 4 / (kInstanceGrowthBytes * kTileBlockInstances);
  const std::uint32_t block_count = instances_.free_block_count() + scene_->block_count;
  scene_->stream->begin_frame({view.eye_m, view.focal_px, view.near_m},
                              static_cast<std::uint32_t>(std::min<std::uint64_t>(block_count, affordable)));
  for (const std::uint32_t tile : scene_->stream->dropped()) remove_tile(tile);
  grow_tiles();
  // One of each at least; more while there is time. What is over waits for the next frame.
  const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(streaming_ns_);
  while (open_next_species() && std::chrono::steady_clock::now() < end) {
  }
  for (auto ready = scene_->stream->next_ready(); ready; ready = scene_->stream->next_ready()) {
    place_tile(*ready);
    if (std::chrono::steady_clock::now() >= end) break;
  }
}

// It blocks for two reads and decodes what is pinned.
bool Context::open_next_species() {
  const auto wanted = scene_->stream->next_species();
  if (!wanted || frame_number_ < scene_->species_frame) return false;
  const auto plant = open_plant(wanted->path->c_str());
  // Room may be on its way; the tiles that need the plant wait.
  if (!plant && plant.error().status == Status::out_of_memory && ++scene_->species_tries < kSpeciesTries) {
    scene_->species_frame = frame_number_ + kSpeciesRetryFrames;
    return false;
  }
  scene_->species_tries = 0;
  if (plant) scene_->plants[wanted->species] = *plant;
  scene_->stream->species_opened(wanted->species, static_cast<bool>(plant));
  return true;
}

void Context::place_tile(const ReadyTile& ready) {
  scene_->placed.clear();
  for (const SceneInstance& instance : ready.instances)
    if (is_open(scene_->plants[instance.species]))
      scene_->placed.push_back({placement_of(instance), index_of(scene_->plants[instance.species])});
  std::vector<std::uint32_t>& blocks = scene_->tile_blocks[ready.tile];
  if (!instances_.add_tile(scene_->placed, blocks)) return scene_->stream->refused(ready.tile);
  scene_->block_count += static_cast<std::uint32_t>(blocks.size());
  if (ready.size_px > kGrowFrom_px && scene_->growing.size() < kMostGrowing) {
    instances_.scale_tile(blocks, 1.0f / static_cast<float>(kGrowFrames));
    scene_->growing.push_back({ready.tile, 1});
  }
  scene_->stream->placed(ready.tile);
}

// Where the threshold is above some pixels, plants would pop up.
void Context::grow_tiles() {
  for (Scene::Growing& growing : scene_->growing) {
    const auto share = static_cast<float>(growing.share);
    instances_.scale_tile(scene_->tile_blocks[growing.tile], (share + 1.0f) / share);
    ++growing.share;
  }
  std::erase_if(scene_->growing, [](const Scene::Growing& growing) { return growing.share == kGrowFrames; });
}

void Context::remove_tile(std::uint32_t tile) {
  std::vector<std::uint32_t>& blocks = scene_->tile_blocks[tile];
  std::erase_if(scene_->growing, [tile](const Scene::Growing& growing) { return growing.tile == tile; });
  instances_.remove_tile(blocks);
  scene_->block_count -= static_cast<std::uint32_t>(blocks.size());
  blocks.clear();
}

Result<void> Context::begin_frame(const coppice_frame& frame) {
  if (frame.frame_number <= frame_number_ || frame.completed_number >= frame.frame_number)
    return Error{Status::invalid_argument, "coppice_frame.frame_number must grow and lie above completed_number"};
  COPPICE_TRY(view, demand_view(*frame.view));
  frame_number_ = frame.frame_number;
  recording_ = Recording::begun;
  renderer_->begin_frame(frame.frame_number, frame.completed_number);
  const gpu::FrameCounts& counts = renderer_->counts();
  leaf_budget_.observe({counts.frame, counts.leaves, counts.wood_triangles, counts.hardware_triangles});
  threshold_px_ =
      leaf_budget_.threshold_px(frame.frame_number, view.lod.error_px, frame.view->lod == COPPICE_LOD_CUT ? frame.view->leaf_budget : 0);
  view.lod.error_px = threshold_px_;
  // A discrete level has up to four times the leaves of the cut; the error falls about as their root.
  if (view.lod.discrete) view.lod.error_px *= 0.5f;
  if (scene_) stream_scene(view.lod);
  streamer_->set_overhead_bytes(renderer_->overhead_bytes() + instances_.bytes() + (scene_ ? scene_->stream->bytes() : 0));
  instances_.update_bounds();
  measure_demand(instances_.blocks(), view, demands_);
  streamer_->begin_frame({frame.frame_number, frame.completed_number, &view, demands_});

  for (const ChunkId& id : streamer_->take_evicted())
    if (id.kind == ChunkKind::texture) renderer_->hide_texture(id.plant, id.index);
  for (const ChunkId& id : streamer_->take_released()) drop_chunk(id);
  for (const std::uint32_t plant : streamer_->take_closed_plants()) {
    if (plants_[plant].on_gpu) renderer_->remove_plant(plant);
    plants_[plant].on_gpu = false;
  }
  return {};
}

void Context::drop_chunk(ChunkId id) {
  if (!plants_[id.plant].on_gpu) return;
  switch (id.kind) {
    case ChunkKind::page:
      return renderer_->drop_page(id.plant, id.index);
    case ChunkKind::wood:
      return renderer_->drop_wood(id.plant, id.index);
    case ChunkKind::texture:
      return renderer_->drop_texture(id.plant, id.index);
    case ChunkKind::leaf_mesh:
      return renderer_->drop_leaf_mesh(id.plant, id.index);
  }
}

Result<void> Context::upload_chunk(const DecodedChunk& chunk) {
  if (chunk.id.kind == ChunkKind::wood) return renderer_->upload_wood(chunk.id.plant, chunk.id.index, *chunk.wood);
  if (chunk.id.kind == ChunkKind::leaf_mesh) return renderer_->upload_leaf_mesh(chunk.id.plant, chunk.id.index, *chunk.wood);
  if (chunk.id.kind == ChunkKind::texture) return renderer_->upload_texture(chunk.id.plant, chunk.id.index, chunk.texture);
  return renderer_->upload_page({.plant = chunk.id.plant, .page = chunk.id.index, .nodes = chunk.nodes, .patches = chunk.patches});
}

void Context::upload_decoded() {
  const std::uint64_t start = now_ns(), spent = streamer_->hand_over_ns();
  const std::uint64_t left = streaming_ns_ - std::min(streaming_ns_, spent);
  bool first = true;
  for (const DecodedChunk& chunk : streamer_->take_decoded(renderer_->upload_room_bytes())) {
    if (!std::exchange(first, false) && now_ns() - start >= left) break;  // the rest is handed out again
    const ChunkId id = chunk.id;
    if (!streamer_->awaits_upload(id)) continue;  // an earlier page of its plant failed
    if (auto uploaded = upload_chunk(chunk); uploaded)
      streamer_->uploaded(id);
    else
      streamer_->upload_failed(id, uploaded.error());
  }
}

Result<void> Context::record_upload(VkCommandBuffer cmd) {
  recording_ = Recording::uploaded;
  renderer_->record_upload_begin(cmd);
  upload_decoded();
  for (std::uint32_t plant = 0; plant < plants_.size(); ++plant) {
    if (!plants_[plant].open) continue;
    const PlantState state = streamer_->state(plant);
    residency_[plant] = {state.resident_leaf_count, state.resident_wood_mask, state.leaf_meshes_resident};
  }
  return renderer_->record_upload_end(instances_, residency_);
}

Result<void> Context::record_cull(VkCommandBuffer cmd, const coppice_view& view) {
  COPPICE_TRY(demand, demand_view(view));
  recording_ = Recording::culled;
  if (view.leaf_budget > 0 && view.lod == COPPICE_LOD_CUT) demand.lod.error_px = std::max(demand.lod.error_px, threshold_px_);
  renderer_->record_cull(cmd, view, demand.lod);
  return {};
}

void Context::fill_stats(coppice_stats& stats) const {
  const StreamStats streaming = streamer_->stats();
  const gpu::FrameCounts& counts = renderer_->counts();
  stats.instance_count = instances_.count();
  stats.gpu_frame_number = counts.frame;
  stats.visible_instance_count = counts.visible_instances;
  stats.drawn_leaf_count = counts.leaves;
  stats.drawn_wood_triangle_count = counts.wood_triangles;
  stats.leaf_mesh_instance_count = counts.leaf_mesh_instances;
  stats.drawn_leaf_mesh_triangle_count = counts.leaf_mesh_triangles;
  stats.source_leaf_count = 0;
  for (std::uint32_t plant = 0; plant < plants_.size(); ++plant)
    if (plants_[plant].open)
      stats.source_leaf_count += std::uint64_t{instances_.plant_count(plant)} * streamer_->file(plant).plant.leaf_count;
  stats.memory_budget_bytes = streaming.budget_bytes;
  stats.memory_bytes = streaming.memory_bytes;
  stats.memory_peak_bytes = streaming.memory_peak_bytes;
  stats.pages_loaded = streaming.chunks_loaded;
  stats.pages_evicted = streaming.chunks_evicted;
  stats.pages_failed = streaming.chunks_failed;
  stats.pages_in_flight = streaming.chunks_in_flight;
  stats.pages_wanted = streaming.chunks_wanted;
  stats.threshold_px = streaming.threshold_px;
  stats.pages_queued = streaming.chunks_queued;
  stats.pages_cancelled = streaming.reads_cancelled;
  stats.bytes_read = streaming.bytes_read;
  stats.decode_ms = 1e-6 * static_cast<double>(streaming.decode_ns);
  const SceneStats scene = scene_ ? scene_->stream->stats() : SceneStats{};
  stats.scene_instance_count = scene.instance_count;
  stats.scene_tile_count = scene.tile_count;
  stats.scene_tiles_resident = scene.resident_tiles;
  stats.scene_tiles_wanted = scene.wanted_tiles;
  stats.scene_tiles_missing = scene.missing_tiles;
  stats.scene_tiles_failed = static_cast<std::uint32_t>(scene.tiles_failed);
  stats.scene_threshold_px = scene.threshold_px;
  static_assert(COPPICE_PASS_COUNT == static_cast<std::uint32_t>(gpu::Pass::count));
  std::ranges::copy(renderer_->timer().pass_ms(), stats.pass_ms);
}

}  // namespace coppice
