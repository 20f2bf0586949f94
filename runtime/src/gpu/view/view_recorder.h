#pragma once

// A view: the buffers that culling fills, and the draws that read them.

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

/// Inputs that all views read.
struct SceneBuffers {
  Buffer instances;       ///< Instance[], by slot
  Buffer moved;           ///< Instance[]: InstanceTable::moved
  Buffer plants, tables;  ///< Plant[] and the words of packed tables, by plant
  Buffer quad_indices;    ///< uint16, for as many leaf quads as a cluster has
  Buffer wind_maps;       ///< vec2[kWindMaps][kMaxMapPlaces], or one place before the first map
};

/// Numbers of objects that buffers have space for.
struct Capacity {
  std::uint32_t slots = 0;  ///< instance slots; 0 before the first is reserved
  std::uint32_t plants = 0;
  std::uint32_t clusters = kWorkClusters;  ///< WorkSize::clusters

  [[nodiscard]] WorkSize work() const { return {slots, clusters}; }
  bool operator==(const Capacity&) const = default;
};

/// Objects that views share; all of them outlive the views.
struct ViewShared {
  Device& device;
  DeferredDeletion& deletion;
  PipelineSet& pipelines;
  const SceneBuffers& scene;
  const PlantStore& plants;
  const Passes& passes;
  const DrawLists& lists;
  LeafRaster* raster;  ///< null: the hardware draws everything
};

struct ViewOptions {
  std::uint32_t max_instances = 0;
  bool pass_times = false;
};

/// What a view shows in a frame.
struct ShownView {
  coppice_camera camera;
  LodView lod;  ///< the view for selection
  FrameWind wind{};
};

/// Calls in a frame: begin_frame, show, prepare; then record_cull, then record_draw, any number of times.
/// Thread: externally serialised, but the recording of different views may overlap.
class ViewRecorder {
 public:
  ViewRecorder(const ViewShared& shared, const DrawPipelines& pipelines) : shared_(shared), pipelines_(pipelines) {}
  /// Creates its buffers for this many slots and plants. errors  out_of_memory, device_lost
  Result<void> create(const ViewOptions& options, const Capacity& capacity);
  /// The GPU must be done with it.
  ~ViewRecorder();
  ViewRecorder(const ViewRecorder&) = delete;
  ViewRecorder& operator=(const ViewRecorder&) = delete;

  void add_sizes(const Capacity& capacity, BufferSizes& sizes);
  void buffers_changed();
  /// Bytes of its picture. Giving it back: the next frame that shows the view makes another, if that fits.
  [[nodiscard]] std::uint64_t picture_bytes() const { return raster_.picture.size_bytes + raster_.tiles.size_bytes; }
  void release_picture();
  /// The one that DrawLists::fill fills.
  [[nodiscard]] Buffer& command_buffer() { return buffers_.leaf_commands; }

  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);
  /// Sets what it shows in this frame. A view without it is neither culled nor drawn.
  void show(const ShownView& shown) { shown_ = shown; }
  [[nodiscard]] bool is_shown() const { return shown_.has_value(); }
  /// Reserves all memory that the frame needs. instance_frame: InstanceTable::frame. before: the draw lists are filled. errors
  /// out_of_memory: it may not be culled
  Result<void> prepare(std::uint32_t slot_count, std::uint32_t instance_frame);

  /// Before and after: as coppice_record_cull; is_shown(); prepared
  void record_cull(VkCommandBuffer cmd, const coppice_light& light);
  /// Call this instead if the frame's upload has failed: there is nothing to draw.
  void leave_out();
  /// True if record_cull or leave_out has been called in this frame.
  [[nodiscard]] bool is_culled() const { return culled_.recorded; }
  /// before: is_culled(). eye: < eye_count()
  void record_draw(VkCommandBuffer cmd, std::uint32_t eye) const;
  /// before: is_shown()
  [[nodiscard]] std::uint32_t eye_count() const { return shown_->lod.eye_count; }

  [[nodiscard]] const AttachmentDesc& attachments() const { return pipelines_.attachments; }
  [[nodiscard]] const FrameCounts& counts() const { return counts_; }
  /// Its times are all zero without ViewOptions::pass_times.
  [[nodiscard]] const GpuTimer& timer() const { return timer_; }
  /// float[instance slots]: the cut of each, after record_cull. Has TRANSFER_SRC, for tests.
  [[nodiscard]] VkBuffer cut_buffer() const { return buffers_.cuts.buffer; }

 private:
  struct Buffers {
    Buffer view, counters;
    Buffer cuts, debug_colors, wood_list, leaf_commands;  ///< by slot; leaf_commands also grows with what is drawn
    Buffer draw_counts, wood_commands;                    ///< by plant
  };
  /// Who draws what was culled: the hardware alone, or the hardware for what the rasteriser leaves.
  enum class CulledBy : std::uint8_t { nobody, hardware, raster };
  struct Culled {
    bool recorded = false;
    VkDescriptorSet set = VK_NULL_HANDLE;
  };
  /// The parts of a view that are built; asking for them starts building.
  struct Ready {
    bool cull = false, raster = false;

    bool operator==(const Ready&) const = default;
  };
  /// Draws for one eye.
  struct EyeDraws {
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    std::uint32_t eye = 0;
  };
  /// Places of a mesh's instances, of the commands of its parts, and of their count.
  struct MeshDraw {
    std::uint32_t mesh = 0, list_first = 0, part_first = 0, part_count = 0;
  };
  /// Commands from `first` on; this element of the plant's draw_counts gives their number.
  struct IndirectDraws {
    std::uint32_t first = 0, count = 0, maximum = 0;
  };

  Result<void> rebuild_set();
  [[nodiscard]] FrameBindings bindings() const;
  /// The frame's set with the images of a light.
  struct LitSet {
    DescriptorSet set;
    std::uint64_t last_frame = 0;
  };
  struct FrameSet {
    VkDescriptorSet set = VK_NULL_HANDLE;
    bool has_images = false;  ///< has the light's images; else the light has none, or memory was short
  };
  FrameSet set_of(const coppice_light& light);
  [[nodiscard]] const coppice_occluder* occluder_of(const coppice_light& light, const FrameSet& set);
  Ready request(coppice_debug_view debug_view);
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
  std::vector<LitSet> lit_sets_;  ///< one for each cull with such a light that the GPU may still be running, and one more
  bool has_occluder_ = false;     ///< a cull has had an occluder: its pipeline is requested from the next frame on
  bool set_stale_ = true;         ///< a buffer of the sets has been replaced
  bool commands_zeroed_ = false;  ///< leaf_commands have been cleared since they were replaced
  std::optional<ShownView> shown_;
  std::optional<LodView> before_;   ///< the view in the frame before, if it was shown
  CulledBy by_ = CulledBy::nobody;  ///< for this frame
  Culled culled_;
  std::uint32_t slot_count_ = 0, instance_frame_ = 0;
  std::uint64_t frame_ = 0, completed_ = 0;

  static constexpr std::uint32_t kReadbackSlots = 8;
  Buffer readback_;
  std::array<std::uint64_t, kReadbackSlots> readback_frames_{};  ///< 0: never used
  FrameCounts counts_;
  GpuTimer timer_;
};

}  // namespace coppice::gpu
