#pragma once

// The views of a context, and the objects that all of them share: layouts, pipelines, draw lists, the rasteriser.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "draw_lists.h"
#include "leaf_raster.h"
#include "passes.h"
#include "plant_store.h"
#include "view_recorder.h"

namespace coppice::gpu {

struct ViewsDesc {
  std::uint32_t max_instances = 0;
  bool compute_raster = false;     ///< compute shaders draw small leaves, if the device can
  bool int64_atomics = false;      ///< shaderInt64 and shaderBufferInt64Atomics are enabled
  std::optional<bool> many_lanes;  ///< as in RasterDesc
  bool pass_times = false;
};

/// Calls in a frame: begin_frame, ViewRecorder::show for those that are drawn, prepare; then these are culled and drawn in any order.
/// Thread: externally serialised; const functions may overlap, and so may the recording of different views.
class Views {
 public:
  /// All references outlive this object; pipelines are closed before it is destroyed.
  Views(Device& device, DeferredDeletion& deletion, PipelineSet& pipelines, const SceneBuffers& scene, const PlantStore& plants,
        const coppice_allocator& allocator);
  /// errors  out_of_memory, device_lost, internal
  Result<void> create(const ViewsDesc& desc, const TextureSets& textures);
  /// The GPU must be done with everything.
  ~Views();
  Views(const Views&) = delete;
  Views& operator=(const Views&) = delete;

  /// Returns the new view's index, the lowest that is free. attachments: checked. capacity: as in the last add_sizes. errors
  /// out_of_memory, device_lost
  Result<std::uint32_t> add(const AttachmentDesc& attachments, const Capacity& capacity);
  /// Removes a view; its memory is freed once the GPU is done with it. view: from add, here and below
  void remove(std::uint32_t view);
  [[nodiscard]] ViewRecorder& view(std::uint32_t view) { return *views_[view]; }
  [[nodiscard]] const ViewRecorder& view(std::uint32_t view) const { return *views_[view]; }

  /// Adds their buffers by slot and by plant.
  void add_sizes(const Capacity& capacity, BufferSizes& sizes);
  /// Reserves memory for this many plants. errors  out_of_memory; nothing has changed
  Result<void> reserve_plants(std::uint32_t count) { return lists_.reserve(count); }
  /// Maximum bytes that DrawLists::fill adds to all views' buffers.
  [[nodiscard]] std::uint64_t max_command_bytes(std::uint64_t memory_budget_bytes) const;
  /// Bytes of all pictures, which release_pictures gives back; a frame makes those that it needs and that fit. Call it in an upload.
  [[nodiscard]] std::uint64_t picture_bytes() const;
  void release_pictures();
  /// Call this if one of those buffers, or of the scene's, has been replaced.
  void buffers_changed();

  /// Requests the pipelines that a plant's leaves, or one of its meshes, need.
  void request_leaves(std::uint32_t plant);
  void request_mesh(std::uint32_t plant, std::uint32_t mesh);

  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  /// plants: all that were ever added. errors  out_of_memory: nothing may be culled
  Result<void> prepare(const InstanceTable& instances, std::span<const LodPlant> plants, std::uint64_t memory_budget_bytes);
  /// The frame's records, for SceneBuffers::plants.
  [[nodiscard]] std::span<const Plant> plant_records() const { return lists_.records(); }
  /// InstanceBlock[]; none without the rasteriser.
  [[nodiscard]] const Buffer* block_buffer() const { return raster_ ? &raster_->block_buffer() : nullptr; }
  [[nodiscard]] bool has_raster() const { return raster_ != nullptr; }

 private:
  /// A removed view, and the last frame that may have drawn it.
  struct Removed {
    std::uint64_t last_frame = 0;
    std::unique_ptr<ViewRecorder> view;
  };
  Result<void> create_raster();
  std::size_t pipelines_for(const AttachmentDesc& attachments);
  void request(DrawKind kind);
  void request_first(const DrawPipelines& pipelines);

  Device& device_;
  DeferredDeletion& deletion_;
  PipelineSet& pipelines_;
  const SceneBuffers& scene_;
  const PlantStore& plants_;
  ViewsDesc desc_;
  Passes passes_;
  std::vector<DrawPipelines> draws_;       ///< one for each kind of attachments that a view has had
  std::array<bool, kDrawKinds> needed_{};  ///< needed by a plant that is or was resident
  DrawLists lists_;
  std::unique_ptr<LeafRaster> raster_;                ///< null: the hardware draws everything
  std::vector<std::unique_ptr<ViewRecorder>> views_;  ///< by index; null: free
  std::vector<Removed> removed_;
  std::vector<Buffer*> commands_;  ///< scratch
  std::uint64_t frame_ = 0;
};

}  // namespace coppice::gpu
