#pragma once

// One view: the buffers that culling fills, and the draws from them.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "coppice/vulkan.h"
#include "draw_lists.h"
#include "frame_counts.h"
#include "frame_wind.h"
#include "gpu_timer.h"
#include "leaf_raster.h"
#include "passes.h"
#include "plant_store.h"
#include "select.h"

namespace coppice::gpu {

/// What all views read.
struct SceneBuffers {
  Buffer instances;       ///< Instance[], by slot
  Buffer moved;           ///< Instance[]: InstanceTable::moved
  Buffer plants, tables;  ///< Plant[] and the words of packed tables, by plant
  Buffer quad_indices;    ///< uint16, of as many leaf quads as a cluster has
  Buffer wind_maps;       ///< vec2[kWindMaps][kMostMapPlaces], or one place before the first map
};

/// How much there is room for.
struct Capacity {
  std::uint32_t slots = 0;  ///< of instances; none before the first is reserved
  std::uint32_t plants = 0;
};

/// What views share; all of it outlives them.
struct ViewShared {
  Device& device;
  Garbage& garbage;
  PipelineSet& pipelines;
  const SceneBuffers& scene;
  const PlantStore& plants;
  const Passes& passes;
  const DrawLists& lists;
  LeafRaster* raster;  ///< null: everything is drawn by the hardware
};

struct ViewOptions {
  std::uint32_t max_instances = 0;
  bool pass_times = false;
};

/// What a view shows in a frame.
struct ShownView {
  coppice_camera camera;
  LodView lod;  ///< selection's view of it
  FrameWind wind{};
};

/// A frame: begin_frame, show, prepare; then record_cull, then record_draw, any number of times.
/// Thread: externally serialised, but what is recorded of different views may overlap.
class ViewRecorder {
 public:
  ViewRecorder(const ViewShared& shared, const DrawPipelines& pipelines) : shared_(shared), pipelines_(pipelines) {}
  /// Its buffers, for so many slots and plants. errors  out_of_memory, device_lost
  Result<void> create(const ViewOptions& options, const Capacity& capacity);
  /// The GPU must be done with it.
  ~ViewRecorder();
  ViewRecorder(const ViewRecorder&) = delete;
  ViewRecorder& operator=(const ViewRecorder&) = delete;

  void add_sizes(const Capacity& capacity, BufferSizes& sizes);
  void buffers_changed();
  /// DrawLists::fill's.
  [[nodiscard]] Buffer& command_buffer() { return buffers_.leaf_commands; }

  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  /// In this frame; a view that shows nothing is neither culled nor drawn.
  void show(const ShownView& shown) { shown_ = shown; }
  [[nodiscard]] bool is_shown() const { return shown_.has_value(); }
  /// The draw lists are filled. Takes all memory that the frame needs. errors  out_of_memory: it may not be culled
  Result<void> prepare(std::uint32_t slot_count);

  /// Before / after: as coppice_record_cull. is_shown(); prepared
  void record_cull(VkCommandBuffer cmd, const coppice_light& light);
  /// In place of that where the frame's upload has failed: there is nothing to draw.
  void leave_out();
  /// Whether one of them has been called in this frame.
  [[nodiscard]] bool is_culled() const { return culled_.recorded; }
  /// is_culled(). eye: < eye_count()
  void record_draw(VkCommandBuffer cmd, std::uint32_t eye) const;
  /// is_shown()
  [[nodiscard]] std::uint32_t eye_count() const { return shown_->lod.eye_count; }

  [[nodiscard]] const AttachmentDesc& attachments() const { return pipelines_.attachments; }
  [[nodiscard]] const FrameCounts& counts() const { return counts_; }
  /// All zero without ViewOptions::pass_times.
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
    bool recorded = false;
    VkDescriptorSet set = VK_NULL_HANDLE;
  };
  /// What of a view is there: what has to be built for it is wanted from here on.
  struct Ready {
    bool cull = false, raster = false;

    bool operator==(const Ready&) const = default;
  };
  /// What is recorded for an eye.
  struct EyeDraws {
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    std::uint32_t eye = 0;
  };
  /// Where a mesh finds its instances, the commands of its parts, and their count.
  struct MeshDraw {
    std::uint32_t mesh = 0, list_first = 0, part_first = 0, part_count = 0;
  };
  /// Commands from `first` on: as many as this one of the plant's draw_counts says.
  struct IndirectDraws {
    std::uint32_t first = 0, count = 0, most = 0;
  };

  Result<void> rebuild_set();
  [[nodiscard]] FrameBindings bindings() const;
  /// The frame's set with images of a light.
  struct LitSet {
    DescriptorSet set;
    std::uint64_t last_frame = 0;
  };
  struct FrameSet {
    VkDescriptorSet set = VK_NULL_HANDLE;
    bool has_images = false;  ///< the light's; else there are none, or there was no memory for them
  };
  FrameSet set_of(const coppice_light& light);
  [[nodiscard]] const coppice_occluder* occluder_of(const coppice_light& light, const FrameSet& set);
  Ready want(coppice_debug_view debug_view);
  void record_start(VkCommandBuffer cmd, const coppice_light& light, bool has_maps);
  void record_readback(VkCommandBuffer cmd);
  void draw_leaves(const EyeDraws& draws, std::uint32_t plant) const;
  void draw_wood(const EyeDraws& draws, std::uint32_t plant, std::uint32_t lod) const;
  void draw_leaf_mesh(const EyeDraws& draws, std::uint32_t plant, std::uint32_t chunk) const;
  void draw_mesh(const EyeDraws& draws, std::uint32_t plant, const MeshDraw& draw) const;
  void draw_indirect(VkCommandBuffer cmd, const Buffer& commands, std::uint32_t plant, const IndirectDraws& draws) const;
  bool bind_draw(VkCommandBuffer cmd, const DrawPush& push, VkPipeline pipeline) const;

  ViewShared shared_;
  DrawPipelines pipelines_;
  std::uint32_t max_instances_ = 0;
  Buffers buffers_;
  RasterView raster_;  ///< empty without ViewShared::raster
  DescriptorSet frame_set_;
  std::vector<LitSet> lit_sets_;  ///< one for each cull with such a light that the GPU may be at, and one
  bool has_occluder_ = false;     ///< a cull was given one: from the next frame on what that needs is wanted
  bool set_stale_ = true;         ///< a buffer of the sets has been replaced
  bool commands_zeroed_ = false;  ///< leaf_commands, since they are these
  std::optional<ShownView> shown_;
  std::optional<LodView> before_;   ///< in the frame before, where it showed something
  CulledBy by_ = CulledBy::nobody;  ///< of the frame
  Culled culled_;
  std::uint32_t slot_count_ = 0;
  std::uint64_t frame_ = 0, completed_ = 0;

  static constexpr std::uint32_t kReadbackSlots = 8;
  Buffer readback_;
  std::array<std::uint64_t, kReadbackSlots> readback_frames_{};  ///< 0: never used
  FrameCounts counts_;
  GpuTimer timer_;
};

}  // namespace coppice::gpu
