#pragma once

// The GPU half of the runtime. It owns everything in device memory, and records upload, culling and drawing into the engine's command
// buffers. It decides nothing about residency: the caller says which chunks to add and to drop.
//
// Calls in a frame: begin_frame; ViewRecorder::show for its views; record_upload_begin, any number of upload_* and drop_*,
// record_upload_end; then culls and draws of the views in any order.
// Thread: externally serialised; const functions may overlap, and so may the recording of different views.

#include <cstdint>
#include <memory>
#include <span>

#include "coppice/vulkan.h"
#include "deferred_deletion.h"
#include "device.h"
#include "growing_buffers.h"
#include "instances.h"
#include "pipelines.h"
#include "plant_store.h"
#include "result.h"
#include "triangles.h"
#include "uploads.h"
#include "views.h"
#include "wind_maps.h"

namespace coppice::gpu {

struct RendererDesc {
  Device device;  ///< memory.ledger outlives the renderer
  coppice_allocator allocator{};
  ViewsDesc views;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
  std::uint64_t memory_budget_bytes = 0;  ///< the ledger's budget; the ledger has none while the renderer is created: see set_memory_budget
  std::uint32_t max_plants = 0;           ///< only an upper limit, as is views.max_instances
  coppice_jobs jobs{};                    ///< jobs that build pipelines
  bool blocking_pipelines = true;         ///< pipelines are built when they are needed, not by jobs
  bool only_measured = false;             ///< only measures its memory: allocates no device memory and builds no pipeline
};

class Renderer {
 public:
  /// errors  out_of_memory, device_lost, unsupported, internal
  static Result<std::unique_ptr<Renderer>> create(const RendererDesc& desc);
  /// Before: the GPU has finished every recorded frame.
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Deletes what the GPU is done with, and reads back counts. before: frame_number grows
  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  /// As WindMaps::begin_frame. If memory is short the log says so, and the frame has no map. before: begin_frame
  void begin_wind_map(FrameWind& wind);

  /// RendererDesc's, or less if larger buffers would exceed what the device binds.
  [[nodiscard]] std::uint32_t max_instances() const { return desc_.views.max_instances; }
  [[nodiscard]] std::uint32_t max_plants() const { return desc_.max_plants; }
  [[nodiscard]] const Capacity& capacity() const { return capacity_; }
  /// Reserves buffers for at least this much, <= max_instances() and max_plants(). Larger buffers take over in the next
  /// record_upload_begin. errors  out_of_memory; nothing has changed
  Result<void> reserve(const Capacity& needed);
  /// Makes buffers smaller that are larger than these slots, or the budget, need. False: call it again in the next frame
  [[nodiscard]] bool shrink(std::uint32_t slots);
  /// Gives the pictures of all views back in the next upload; views that are drawn make others if those fit.
  void release_pictures() { gives_pictures_back_ = true; }
  /// As Backend::lasting_bytes.
  [[nodiscard]] std::uint64_t lasting_bytes(std::uint32_t slots, std::uint64_t budget_bytes);
  /// Bytes that a view's picture takes.
  [[nodiscard]] std::uint64_t picture_bytes(std::uint32_t width_px, std::uint32_t height_px, std::uint32_t eye_count) const;
  /// Bytes that reserve() allocates at once. The replaced buffers are deleted once the GPU is done with them.
  [[nodiscard]] std::uint64_t reserve_bytes(const Capacity& needed);
  /// Temporary bytes for bringing up to slot_count new slots to the GPU in one frame.
  [[nodiscard]] std::uint64_t slot_upload_bytes(std::uint32_t slot_count) const;

  /// Makes the plant drawable once its first page is uploaded. plant: < max_plants and not in use. lod_words: pack_lod_table of the file
  /// errors  out_of_memory
  Result<void> add_plant(std::uint32_t plant, const PlantFile& file, const PlantAppearance& appearance,
                         std::span<const std::uint32_t> lod_words);
  /// Nothing of the plant may be drawn from the next upload on. See PlantStore::remove.
  void remove_plant(std::uint32_t plant) { plants_.remove(plant); }

  /// before / after: as coppice_record_upload. queue: graphics.
  void record_upload_begin(VkCommandBuffer cmd);
  /// errors  as PlantStore's
  Result<void> upload_page(const PageUpload& upload);
  Result<bool> upload_mesh(const MeshUpload& upload, std::uint64_t max_bytes = PlantStore::kWhole);
  Result<bool> upload_texture(std::uint32_t plant, std::uint32_t texture, std::span<const std::uint8_t> bytes,
                              std::uint64_t max_bytes = PlantStore::kWhole) {
    return plants_.upload_texture(plant, texture, bytes, max_bytes);
  }
  [[nodiscard]] TriangleWriter& triangles() { return triangles_; }
  /// For hiding and dropping chunks.
  [[nodiscard]] PlantStore& plants() { return plants_; }
  /// instances: no more slots than capacity(). plants: all that were ever added; leaf_meshes_resident is set only if all of them have
  /// been uploaded. errors  out_of_memory: the frame's uploads do not fit; the frame draws nothing
  Result<void> record_upload_end(InstanceTable& instances, std::span<const LodPlant> plants);

  /// attachments: checked. errors  out_of_memory, device_lost
  Result<std::uint32_t> add_view(const AttachmentDesc& attachments);
  void remove_view(std::uint32_t view);
  /// view: from add_view
  [[nodiscard]] ViewRecorder& view(std::uint32_t view) { return views_.view(view); }
  [[nodiscard]] const ViewRecorder& view(std::uint32_t view) const { return views_.view(view); }
  [[nodiscard]] bool has_raster() const { return views_.has_raster(); }
  /// Times uploads; all zero without ViewsDesc::pass_times.
  [[nodiscard]] const GpuTimer& timer() const { return timer_; }

  /// True if the frame's upload succeeded: only then its views may be culled.
  [[nodiscard]] bool can_cull() const { return upload_state_ == UploadState::uploaded; }
  /// errors  device_lost: a Vulkan call said so, now or earlier; nothing that is recorded from then on draws
  [[nodiscard]] Result<void> device_state() const { return check_alive(device_); }
  [[nodiscard]] const PipelineSet& pipelines() const { return pipelines_; }
  [[nodiscard]] const Device& device() const { return device_; }
  /// Derives the size of device memory blocks, and the share of draw commands, from this budget from now on.
  void set_memory_budget(std::uint64_t bytes);
  /// Rounding of images and buffers in an upload.
  static constexpr std::uint64_t kSlackBytes = 64ull << 10;
  /// Bytes of the ring for chunks.
  [[nodiscard]] std::uint64_t staging_bytes() const;

 private:
  /// Progress of a frame's upload. Only an uploaded frame is culled.
  enum class UploadState : std::uint8_t { none, recording, failed, uploaded };

  explicit Renderer(const RendererDesc& desc);
  Result<void> create();
  void lower_limits();
  Result<void> create_buffers();
  [[nodiscard]] BufferSizes sizes(const Capacity& capacity);
  Result<void> stage_frame(InstanceTable& instances, std::span<const LodPlant> plants);
  Result<void> stage_indices();
  Result<void> stage_instances(InstanceTable& instances);

  Device device_;
  OpenMemory memory_;
  RendererDesc desc_;
  PipelineSet pipelines_;
  DeferredDeletion deletion_;
  Uploads uploads_;
  GrowingBuffers growing_;
  TriangleWriter triangles_;
  TextureSets texture_sets_;
  PlantStore plants_;
  WindMaps wind_maps_;
  SceneBuffers scene_;
  Views views_;
  GpuTimer timer_;
  Capacity capacity_;
  bool has_wind_maps_ = false;  ///< scene_.wind_maps has space for them, or will have with the next upload
  std::uint32_t uploaded_slot_count_ = 0;
  std::uint64_t frame_ = 0, completed_ = 0;
  VkCommandBuffer upload_cmd_ = VK_NULL_HANDLE;
  UploadState upload_state_ = UploadState::none;
  bool has_indices_ = false;
  bool gives_pictures_back_ = false;
  bool lists_may_grow_ = false;  ///< the budget has grown, and the rasteriser's lists have not yet
};

}  // namespace coppice::gpu
