#pragma once

// The GPU half of the runtime: owns what lives in device memory and records upload, culling and drawing into the engine's command buffers.
// It decides nothing about residency: the caller says which chunks to take and to drop.
//
// A frame: begin_frame; ViewRecorder::show of its views; record_upload_begin, any number of upload_* and drop_*, record_upload_end; then
// culls and draws of the views in any order.
// Thread: externally serialised; const functions may overlap, and what is recorded of different views.

#include <cstdint>
#include <memory>
#include <span>

#include "coppice/vulkan.h"
#include "device.h"
#include "garbage.h"
#include "growing_buffers.h"
#include "instances.h"
#include "pipelines.h"
#include "plant_store.h"
#include "result.h"
#include "uploads.h"
#include "views.h"
#include "wind_maps.h"

namespace coppice::gpu {

struct RendererDesc {
  Device device;  ///< memory.ledger outlives the renderer
  coppice_allocator allocator{};
  ViewsDesc views;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
  std::uint64_t memory_budget_bytes = 0;  ///< the ledger's, which has none while the renderer is created: see set_memory_budget
  std::uint32_t max_plants = 0;           ///< an upper limit alone, as views.max_instances
  coppice_jobs jobs{};                    ///< where pipelines are built
  bool blocking_pipelines = true;         ///< they are built where they are wanted, and not by jobs
  bool only_measured = false;             ///< what it takes of the ledger is asked for and nothing else: no device memory, no pipeline
};

class Renderer {
 public:
  /// errors  out_of_memory, device_lost, unsupported, internal
  static Result<std::unique_ptr<Renderer>> create(const RendererDesc& desc);
  /// The GPU must have finished every frame recorded.
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Frees what the GPU is done with and fetches counts. frame_number grows
  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  /// As WindMaps::begin_frame. Where memory is short the log says so, and the frame has no map. After begin_frame
  void take_map(FrameWind& wind);

  /// RendererDesc's, or less where buffers for so many would be more than the device binds.
  [[nodiscard]] std::uint32_t max_instances() const { return desc_.views.max_instances; }
  [[nodiscard]] std::uint32_t max_plants() const { return desc_.max_plants; }
  [[nodiscard]] const Capacity& capacity() const { return capacity_; }
  /// Room for at least so many, <= max_instances() and max_plants(): larger buffers, which take over with the next record_upload_begin.
  /// errors  out_of_memory; nothing has changed
  Result<void> reserve(const Capacity& wanted);
  /// What that takes at once; what the larger buffers take the place of goes once the GPU is done with it.
  [[nodiscard]] std::uint64_t reserve_bytes(const Capacity& wanted);
  /// What bringing new slots, up to so many, to the GPU in one frame takes on the way.
  [[nodiscard]] std::uint64_t slot_upload_bytes(std::uint32_t slot_count) const;

  /// Makes the plant drawable once its first page is uploaded. plant: < max_plants and not in use. lod_words: pack_lod_table of the file
  /// errors  out_of_memory
  Result<void> add_plant(std::uint32_t plant, const PlantFile& file, const PlantAppearance& appearance,
                         std::span<const std::uint32_t> lod_words);
  /// Nothing of the plant may be drawn from the next upload on. As PlantStore::remove
  void remove_plant(std::uint32_t plant) { plants_.remove(plant); }

  /// before / after: as coppice_record_upload. queue: graphics.
  void record_upload_begin(VkCommandBuffer cmd);
  /// errors  as PlantStore's
  Result<void> upload_page(const PageUpload& upload);
  Result<void> upload_mesh(const MeshUpload& upload);
  Result<void> upload_texture(std::uint32_t plant, std::uint32_t texture, std::span<const std::uint8_t> bytes) {
    return plants_.upload_texture(plant, texture, bytes);
  }
  /// For what is hidden and dropped.
  [[nodiscard]] PlantStore& plants() { return plants_; }
  /// instances: no more slots than capacity(). residency: [plants], of all that were ever added; leaf_meshes only where all of them have
  /// been uploaded. errors  out_of_memory: what goes up with this frame does not fit; the frame draws nothing
  Result<void> record_upload_end(InstanceTable& instances, std::span<const PlantResidency> residency);

  /// attachments: checked. errors  out_of_memory, device_lost
  Result<std::uint32_t> add_view(const AttachmentDesc& attachments);
  void remove_view(std::uint32_t view);
  /// view: of add_view
  [[nodiscard]] ViewRecorder& view(std::uint32_t view) { return views_.view(view); }
  [[nodiscard]] const ViewRecorder& view(std::uint32_t view) const { return views_.view(view); }
  [[nodiscard]] bool has_raster() const { return views_.has_raster(); }
  /// Of uploads, all zero without ViewsDesc::pass_times.
  [[nodiscard]] const GpuTimer& timer() const { return timer_; }

  /// Whether the frame's upload is there: only then its views may be culled.
  [[nodiscard]] bool can_cull() const { return upload_state_ == UploadState::uploaded; }
  /// The least memory budget that holds what takes taken_bytes of the ledger now, before any plant.
  [[nodiscard]] std::uint64_t least_budget_bytes(std::uint64_t taken_bytes) const;
  /// errors  device_lost: a Vulkan call said so, now or earlier; nothing that is recorded from then on draws
  [[nodiscard]] Result<void> device_state() const { return check_alive(device_); }
  [[nodiscard]] const PipelineSet& pipelines() const { return pipelines_; }
  [[nodiscard]] const Device& device() const { return device_; }
  /// From now on blocks of device memory, and the share of draw commands, are as large as this budget has them.
  void set_memory_budget(std::uint64_t bytes);
  /// What images and buffers of an upload are rounded up to.
  static constexpr std::uint64_t kSlackBytes = 64ull << 10;
  /// A chunk of more than this for the GPU is staged in a buffer of its own.
  static constexpr std::uint64_t kStagingSliceBytes = Uploads::kSliceBytes;
  /// Of the ring, for chunks.
  [[nodiscard]] std::uint64_t staging_bytes() const;

 private:
  /// Where a frame's upload is. Only what has been uploaded is culled.
  enum class UploadState : std::uint8_t { none, recording, failed, uploaded };

  explicit Renderer(const RendererDesc& desc);
  Result<void> create();
  void lower_limits();
  Result<void> create_buffers();
  [[nodiscard]] BufferSizes sizes(const Capacity& wanted);
  Result<void> stage_frame(InstanceTable& instances, std::span<const PlantResidency> residency);
  Result<void> stage_indices();
  Result<void> stage_instances(InstanceTable& instances);

  Device device_;
  OpenMemory memory_;
  RendererDesc desc_;
  PipelineSet pipelines_;
  Garbage garbage_;
  Uploads uploads_;
  GrowingBuffers growing_;
  TextureSets texture_sets_;
  PlantStore plants_;
  WindMaps wind_maps_;
  SceneBuffers scene_;
  Views views_;
  GpuTimer timer_;
  Capacity capacity_;
  bool has_wind_maps_ = false;  ///< scene_.wind_maps has room for them, or will have with the next upload
  std::uint32_t uploaded_slot_count_ = 0;
  std::uint64_t frame_ = 0, completed_ = 0;
  VkCommandBuffer upload_cmd_ = VK_NULL_HANDLE;
  UploadState upload_state_ = UploadState::none;
  bool has_indices_ = false;
};

}  // namespace coppice::gpu
