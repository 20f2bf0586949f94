#pragma once

// What a view needs and records: the buffers that culling fills, and the draws from them.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "coppice/coppice.h"
#include "draw_lists.h"
#include "gpu_timer.h"
#include "leaf_raster.h"
#include "passes.h"
#include "plant_store.h"
#include "select.h"

namespace coppice::gpu {

struct ViewDesc {
  AttachmentDesc attachments;
  std::uint32_t max_instances = 0;
  bool compute_raster = false;     ///< small leaves by compute shaders, where the device does
  bool int64_atomics = false;      ///< shaderInt64 and shaderBufferInt64Atomics are enabled
  std::optional<bool> many_lanes;  ///< RasterDesc's
  bool pass_times = false;
};

/// What all views read.
struct SceneBuffers {
  Buffer instances;       ///< Instance[], by slot
  Buffer plants, tables;  ///< Plant[] and the words of packed tables, by plant
  Buffer quad_indices;    ///< uint16, of as many leaf quads as a cluster has
};

/// How much there is room for.
struct Capacity {
  std::uint32_t slots = 0;  ///< of instances; none before the first is reserved
  std::uint32_t plants = 0;
};

/// Sums over the latest completed frame.
struct FrameCounts {
  std::uint64_t frame = 0;
  std::uint32_t visible_instances = 0;
  std::uint32_t occluded_instances = 0;  ///< in view, but hidden
  std::uint64_t leaves = 0;
  std::uint64_t wood_triangles = 0;
  std::uint32_t leaf_mesh_instances = 0;
  std::uint64_t leaf_mesh_triangles = 0;
  std::uint64_t hardware_triangles = 0;  ///< of leaves, leaf meshes and wood
};

/// A frame: begin_frame, prepare, then record_cull and record_draw of one view after the other.
/// Thread: externally serialised; const functions may overlap.
class ViewRecorder {
 public:
  /// Everything that is passed by reference outlives this object; pipelines are closed before it goes.
  ViewRecorder(Device& device, Garbage& garbage, PipelineSet& pipelines, const SceneBuffers& scene, const PlantStore& plants,
               const coppice_allocator& allocator);
  /// errors  out_of_memory, device_lost, internal
  Result<void> create(const ViewDesc& desc, const TextureSets& textures);
  /// The GPU must be done with everything.
  ~ViewRecorder();
  ViewRecorder(const ViewRecorder&) = delete;
  ViewRecorder& operator=(const ViewRecorder&) = delete;

  /// Its buffers by slot and by plant.
  void add_sizes(const Capacity& capacity, BufferSizes& sizes);
  /// Room for so many. errors  out_of_memory; nothing has changed
  Result<void> reserve_plants(std::uint32_t count) { return lists_.reserve(count); }
  /// One of those, or of the scene's, has been replaced.
  void buffers_changed();

  /// Has the pipelines built that a view needs in any case, or a plant's leaves, or a mesh of it.
  void want_first();
  void want_leaves(std::uint32_t plant);
  void want_mesh(std::uint32_t plant, std::uint32_t mesh);

  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  /// residency: [plants]. errors  out_of_memory: nothing may be culled
  Result<void> prepare(const InstanceTable& instances, std::span<const PlantResidency> residency, std::uint64_t memory_budget_bytes);
  /// Of the frame, for SceneBuffers::plants.
  [[nodiscard]] std::span<const Plant> plant_records() const { return lists_.records(); }
  /// InstanceBlock[]; none without the rasteriser.
  [[nodiscard]] const Buffer* block_buffer() const { return raster_ ? &raster_->block_buffer() : nullptr; }

  /// lod: selection's view of `view`. Before / after: as coppice_record_cull.
  void record_cull(VkCommandBuffer cmd, const coppice_view& view, const LodView& lod);
  /// Nothing, no state either, where nothing has been culled.
  void record_draw(VkCommandBuffer cmd, const coppice_view& view) const;

  [[nodiscard]] const FrameCounts& counts() const { return counts_; }
  [[nodiscard]] bool has_raster() const { return raster_ != nullptr; }
  /// All zero without ViewDesc::pass_times.
  [[nodiscard]] GpuTimer& timer() { return timer_; }
  [[nodiscard]] const GpuTimer& timer() const { return timer_; }
  /// float[instance slots]: the cut of each, after record_cull. TRANSFER_SRC; for tests.
  [[nodiscard]] VkBuffer cut_buffer() const { return buffers_.cuts.buffer; }

 private:
  struct Buffers {
    Buffer view, counters;
    Buffer cuts, debug_colors, wood_list, leaf_commands;  ///< by slot; leaf_commands also grow with what is drawn
    Buffer draw_counts, wood_commands;                    ///< by plant
  };
  /// What is to be drawn by: all by the hardware, or what the rasteriser has left.
  enum class CulledBy : std::uint8_t { nobody, hardware, raster };
  struct Culled {
    CulledBy by = CulledBy::nobody;
    VkDescriptorSet set = VK_NULL_HANDLE;
  };
  /// What of a view is there: what has to be built for it is wanted from here on.
  struct Ready {
    bool cull = false, raster = false;

    bool operator==(const Ready&) const = default;
  };
  /// Where a mesh finds its instances, the commands of its parts, and their count.
  struct MeshDraw {
    std::uint32_t mesh = 0, list_first = 0, part_first = 0, part_count = 0;
    const MeshPipelines& pipelines;
  };

  Result<void> create_raster();
  Result<void> rebuild_set();
  [[nodiscard]] FrameBindings bindings() const;
  VkDescriptorSet set_of(const coppice_view& view);
  Ready want(const coppice_view& view);
  void record_start(VkCommandBuffer cmd, const coppice_view& view, const LodView& lod);
  CulledBy begin_culling(VkCommandBuffer cmd, const coppice_view& view, const Ready& ready);
  void record_readback(VkCommandBuffer cmd);
  void draw_leaves(VkCommandBuffer cmd, const LeafPipelines& pipelines, std::uint32_t plant) const;
  void draw_wood(VkCommandBuffer cmd, const MeshPipelines& pipelines, std::uint32_t plant, std::uint32_t lod) const;
  void draw_leaf_mesh(VkCommandBuffer cmd, std::uint32_t plant, std::uint32_t chunk) const;
  void draw_mesh(VkCommandBuffer cmd, std::uint32_t plant, const MeshDraw& draw) const;
  void draw_commands(VkCommandBuffer cmd, std::uint32_t plant, std::uint32_t first, std::uint32_t count, std::uint32_t most) const;
  bool bind_draw(VkCommandBuffer cmd, const DrawPush& push, const Pipeline& with) const;

  Device& device_;
  Garbage& garbage_;
  PipelineSet& pipelines_;
  const SceneBuffers& scene_;
  const PlantStore& plants_;
  ViewDesc desc_;
  Passes passes_;
  DrawLists lists_;
  Buffers buffers_;
  std::unique_ptr<LeafRaster> raster_;  ///< null: everything is drawn by the hardware
  DescriptorSet frame_set_;
  DescriptorSet shadowed_set_;  ///< the same with the maps of the last view that had any
  std::array<VkImageView, kMaxCascades> maps_{};
  bool set_stale_ = true;  ///< a buffer of the sets has been replaced
  Culled culled_;          ///< the last record_cull of the frame
  std::uint32_t slot_count_ = 0;
  std::uint64_t frame_ = 0, completed_ = 0;

  static constexpr std::uint32_t kReadbackSlots = 8;
  Buffer readback_;
  std::array<std::uint64_t, kReadbackSlots> readback_frames_{};  ///< 0: never used
  FrameCounts counts_;
  GpuTimer timer_;
};

}  // namespace coppice::gpu
