#include "views.h"

#include <algorithm>
#include <array>
#include <new>

namespace coppice::gpu {

Views::Views(Device& device, DeferredDeletion& deletion, PipelineSet& pipelines, const SceneBuffers& scene, const PlantStore& plants,
             const coppice_allocator& allocator)
    : device_(device), deletion_(deletion), pipelines_(pipelines), scene_(scene), plants_(plants), lists_(allocator) {}

Result<void> Views::create(const ViewsDesc& desc, const TextureSets& textures) {
  desc_ = desc;
  COPPICE_CHECK(create_passes(device_, textures, pipelines_, passes_));
  return create_raster();
}

Result<void> Views::create_raster() {
  if (!desc_.compute_raster) return {};
  auto raster = LeafRaster::create(device_, deletion_, pipelines_,
                                   {.frame_set = passes_.frame_set.layout,
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

Views::~Views() {
  removed_.clear();
  views_.clear();
  raster_.reset();
  destroy_passes(device_, passes_);
}

Result<std::uint32_t> Views::add(const AttachmentDesc& attachments, const Capacity& capacity) {
  const std::size_t draws = pipelines_for(attachments);
  std::unique_ptr<ViewRecorder> view(
      new (std::nothrow) ViewRecorder({device_, deletion_, pipelines_, scene_, plants_, passes_, lists_, raster_.get()}, draws_[draws]));
  if (!view) return Error{Status::out_of_memory, "view"};
  COPPICE_CHECK(view->create({.max_instances = desc_.max_instances, .pass_times = desc_.pass_times}, capacity));
  const auto free = std::ranges::find_if(views_, [](const auto& known) { return known == nullptr; });
  const auto index = static_cast<std::uint32_t>(free - views_.begin());
  if (free == views_.end()) views_.emplace_back();
  views_[index] = std::move(view);
  return index;
}

void Views::remove(std::uint32_t view) {
  removed_.push_back({frame_, std::move(views_[view])});
}

std::size_t Views::pipelines_for(const AttachmentDesc& attachments) {
  const auto known = std::ranges::find(draws_, attachments, &DrawPipelines::attachments);
  if (known != draws_.end()) return static_cast<std::size_t>(known - draws_.begin());
  DrawPipelines& added = draws_.emplace_back(add_draw_pipelines(passes_, attachments, pipelines_));
  if (raster_) added.resolve = raster_->add_resolve(attachments);
  request_first(added);
  return draws_.size() - 1;
}

// Requests the pipelines that nearly every plant needs, and those of resident plants; others when they are first needed.
void Views::request_first(const DrawPipelines& pipelines) {
  pipelines_.request(*passes_.cull.plain.of(1));
  pipelines_.request(*pipelines.of(DrawKind::leaf_textured));
  pipelines_.request(*pipelines.of(DrawKind::wood_textured));
  if (raster_) raster_->request(COPPICE_DEBUG_NONE, 1, *pipelines.resolve);
  for (std::size_t kind = 0; kind < kDrawKinds; ++kind)
    if (needed_[kind] && pipelines.kinds[kind] != nullptr) pipelines_.request(*pipelines.kinds[kind]);
}

void Views::request(DrawKind kind) {
  needed_[static_cast<std::size_t>(kind)] = true;
  for (const DrawPipelines& pipelines : draws_)
    if (Pipeline* pipeline = pipelines.of(kind); pipeline != nullptr) pipelines_.request(*pipeline);
}

void Views::request_mesh(std::uint32_t plant, std::uint32_t mesh) {
  for (const SurfaceTextures& textures : plants_.plant(plant)->meshes[mesh].textures.span()) {
    request(mesh_kind(mesh, textures.color != kNoTexture, false));
    if (textures.normal_map != kNoTexture) request(mesh_kind(mesh, textures.color != kNoTexture, true));
  }
}

void Views::request_leaves(std::uint32_t plant) {
  const StoredPlant& stored = *plants_.plant(plant);
  for (const std::uint32_t texture : stored.leaf_textures.span()) request(leaf_kind(texture, stored.has_transparency));
}

void Views::add_sizes(const Capacity& capacity, BufferSizes& sizes) {
  for (const auto& view : views_)
    if (view) view->add_sizes(capacity, sizes);
  // The rasteriser's lists are large, and nothing needs them before the first instance.
  const bool depth_views = std::ranges::any_of(views_, [](const auto& view) { return view && is_depth_alone(view->attachments()); });
  if (raster_) raster_->add_sizes(capacity.work(), depth_views, sizes);
}

std::uint64_t Views::max_command_bytes(std::uint64_t memory_budget_bytes) const {
  return static_cast<std::uint64_t>(views_.size()) * memory_budget_bytes / kCommandShare;
}

std::uint64_t Views::picture_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& view : views_)
    if (view) bytes += view->picture_bytes();
  return bytes;
}

void Views::release_pictures() {
  for (const auto& view : views_)
    if (view) view->release_picture();
}

void Views::buffers_changed() {
  for (const auto& view : views_)
    if (view) view->buffers_changed();
}

void Views::begin_frame(std::uint64_t frame_number, std::uint64_t completed_number) {
  frame_ = frame_number;
  std::erase_if(removed_, [&](const Removed& removed) { return removed.last_frame <= completed_number; });
  for (const auto& view : views_)
    if (view) view->begin_frame(frame_number, completed_number);
}

Result<void> Views::prepare(const InstanceTable& instances, std::span<const LodPlant> plants, std::uint64_t memory_budget_bytes) {
  commands_.clear();
  for (const auto& view : views_)
    if (view) commands_.push_back(&view->command_buffer());
  const DrawListInput input{plants_, instances, plants, draws_, has_raster(), memory_budget_bytes};
  if (lists_.fill(device_, deletion_, input, commands_)) buffers_changed();
  for (const auto& view : views_)
    if (view) COPPICE_CHECK(view->prepare(static_cast<std::uint32_t>(instances.slots().size()), instances.frame()));
  return {};
}

}  // namespace coppice::gpu
