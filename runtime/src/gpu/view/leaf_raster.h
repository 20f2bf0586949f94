#pragma once

// The compute rasteriser. It draws small leaves, and the wood between them, into a buffer of its own with atomics, and then that buffer
// into the engine's attachments. leaf_raster.cpp lists what a frame records.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "coppice/vulkan.h"
#include "device.h"
#include "gpu_timer.h"
#include "growing_buffers.h"
#include "instances.h"
#include "passes.h"
#include "raster_shared.h"
#include "result.h"

namespace coppice::gpu {

struct RasterDesc {
  VkDescriptorSetLayout frame_set = VK_NULL_HANDLE;  ///< its layout
  std::uint32_t max_instances = 0;
  bool int64_atomics = false;      ///< shaderInt64 and shaderBufferInt64Atomics are enabled
  std::optional<bool> many_lanes;  ///< spreads work over many invocations; default: unless a processor runs them
};

/// How leaves and splats are spread over invocations.
struct RasterShape {
  bool expand_together = false;     ///< kTogether of leaf_expand.comp
  std::uint32_t leaf_lanes = 0;     ///< lanes of a group that processes clusters of leaves
  std::uint32_t leaf_clusters = 0;  ///< clusters that such a group processes one after the other
  std::uint32_t big_pixels = 0;     ///< a leaf whose rectangle holds more pixels gets a whole group
  std::uint32_t big_lanes = 0;      ///< lanes of that group
  std::uint32_t row_lanes = 0;      ///< lanes of that group that share a row of pixels
  std::uint32_t splat_lanes = 0;    ///< lanes of a group that processes clusters of splats
  std::uint32_t cluster_lanes = 0;  ///< lanes of that group that share a cluster
};

/// Numbers that the rasteriser's lists have space for.
struct WorkSize {
  std::uint32_t slots = 0;
  std::uint32_t clusters = kWorkClusters;
};

/// Bytes of a picture and its tiles.
struct PictureSize {
  std::uint64_t picture_bytes = 0, tile_bytes = 0;
};
PictureSize picture_size(std::uint32_t width_px, std::uint32_t height_px, std::uint32_t eye_count);

InstanceBlock gpu_block(const InstanceBounds& bounds);

/// The rasteriser's state of a view.
struct RasterView {
  Buffer culling_passes;  ///< CullingPass[kCullingPasses]
  Buffer work;    ///< WorkItem[]: work_items of raster.glsl, by instance slot. Pixels of the picture name them. Not for views of only depth
  Buffer motion;  ///< ClusterMotion[], one for each work item; only with velocity
  Buffer picture, tiles;  ///< for all its eyes, one after the other; as large as the view's maximum so far
  DescriptorSet set;
  bool set_stale = false;  ///< one of its buffers has been replaced
  bool depth_alone = false;
  bool has_velocity = false;
  bool reversed_depth = false;
  float depth_step = 0.0f;                             ///< precision of the attachments' depth: the smallest step, or the rounding
  std::uint32_t eye_count = 1;                         ///< in this frame
  RasterPush push{};                                   ///< in this frame
  coppice_debug_view debug_view = COPPICE_DEBUG_NONE;  ///< in this frame
};

/// The state that all views share, and lists that only culling reads: they are shared because views run one after another on the queue.
class LeafRaster {
 public:
  /// device, deletion, pipelines: outlive this object; pipelines are closed before it is destroyed. It requests no pipeline yet.
  /// errors  out_of_memory; unsupported: more than kMaxSlots, or too few storage buffers in a stage
  static Result<std::unique_ptr<LeafRaster>> create(Device& device, DeferredDeletion& deletion, PipelineSet& pipelines,
                                                    const RasterDesc& desc);
  /// The GPU must be done with everything.
  ~LeafRaster();
  LeafRaster(const LeafRaster&) = delete;
  LeafRaster& operator=(const LeafRaster&) = delete;

  /// Adds its buffers for these instance slots and clusters, of no bytes if there is no slot. The caller creates them and reports changes.
  /// depth_views: there are views of only depth
  void add_sizes(const WorkSize& size, bool depth_views, BufferSizes& sizes);
  /// Does the same for a view's buffers.
  static void add_view_sizes(const WorkSize& size, RasterView& view, BufferSizes& sizes);

  /// InstanceBlock[]: the blocks of the instance table.
  [[nodiscard]] const Buffer& block_buffer() const { return buffers_.blocks; }

  /// errors  out_of_memory, device_lost
  Result<void> create_view(const AttachmentDesc& attachments, RasterView& view);
  /// The GPU must be done with it.
  void destroy_view(RasterView& view);
  /// Gives a view's picture back; prepare makes another.
  void release_picture(RasterView& view);
  /// Adds a pipeline that draws pictures to such attachments; it is not requested yet.
  Pipeline* add_resolve(const AttachmentDesc& attachments);

  /// Requests the pipelines of such a frame of a view. True if all are built; else it may not be prepared.
  bool request(coppice_debug_view debug_view, std::uint32_t eye_count, Pipeline& resolve);
  /// Reserves memory for a frame of a view. False if there is none, or if the rasteriser does not draw the view: then record nothing of it.
  bool prepare(RasterView& view, const coppice_camera& camera, std::uint32_t eye_count);
  /// Records the initial values of the view's buffers; the caller's barrier makes them visible to compute shaders. before: prepare
  void record_start(VkCommandBuffer cmd, const RasterView& view) const;
  /// Requests the pipeline for an engine's occluder; true if it is built.
  bool request_occluder() { return pipeline_set_.request(*pipelines_.occluder); }
  [[nodiscard]] bool has_occluder_pass() const { return pipelines_.occluder->handle() != VK_NULL_HANDLE; }
  struct Cull {
    VkDescriptorSet frame_set = VK_NULL_HANDLE;
    std::uint32_t slot_count = 0;
    const coppice_occluder* occluder = nullptr;  ///< its images are in frame_set; may be null. before: has_occluder_pass()
    GpuTimer* timer = nullptr;                   ///< may be null
  };
  /// before: record_start, buffers for slot_count, and all inputs of culling. after: compute shaders have written the picture
  void record(VkCommandBuffer cmd, const RasterView& view, const Cull& cull) const;
  /// The destination of a picture: the pipeline from add_resolve, and the eye.
  struct Resolve {
    const Pipeline& pipeline;
    std::uint32_t eye = 0;
  };
  /// Inside dynamic rendering: copies an eye's picture into its attachments.
  void record_resolve(VkCommandBuffer cmd, const RasterView& view, VkDescriptorSet frame_set, const Resolve& resolve) const;

 private:
  /// kPass of write_pixel.glsl. With 64-bit atomics the first pass writes names too, and the second is not needed.
  enum RasterPass : std::uint32_t { kDepth, kName, kCount, kPassCount };
  struct Pipelines {
    CullPipelines cull;
    EyePipelines blocks, expand, draws;
    Pipeline *finest_tiles = nullptr, *other_tiles = nullptr, *motion = nullptr, *occluder = nullptr;
    std::array<Pipeline*, kPassCount> splats{}, leaves{}, big{};
  };
  struct Buffers {
    Buffer blocks, visible_blocks, items, big;
    Buffer work;  ///< as RasterView::work, shared by all views of only depth: nothing names its items after drawing
  };

  LeafRaster(Device& device, DeferredDeletion& deletion, PipelineSet& pipelines, const RasterDesc& desc);
  Result<void> create_layouts();
  void add_pipelines();
  /// The passes over leaves for a view: those of Pipelines.
  [[nodiscard]] std::span<const RasterPass> passes(coppice_debug_view debug_view) const;
  Result<void> reserve_picture(RasterView& view, const PictureSize& wanted);
  [[nodiscard]] const Buffer& work_of(const RasterView& view) const { return view.depth_alone ? buffers_.work : view.work; }
  Result<void> rebuild_set(RasterView& view);
  void bind(VkCommandBuffer cmd, const Pipeline& pipeline) const;
  /// A culling pass of a view.
  struct ViewPass {
    const RasterView& view;
    std::uint32_t culling_pass = 0;
  };
  void dispatch_stage(VkCommandBuffer cmd, const Pipeline& pipeline, const ViewPass& of, std::uint64_t stage_offset) const;
  void record_leaves(VkCommandBuffer cmd, const ViewPass& of, GpuTimer* timer) const;
  void record_tiles(VkCommandBuffer cmd, const ViewPass& of) const;
  void push(VkCommandBuffer cmd, const RasterPush& constants) const;
  void record_occluder(VkCommandBuffer cmd, const RasterView& view, const RasterPush& constants) const;
  void barrier(VkCommandBuffer cmd) const;

  Device& device_;
  DeferredDeletion& deletion_;
  PipelineSet& pipeline_set_;
  RasterDesc desc_;
  std::uint32_t lanes_ = 8;
  RasterShape shape_{};
  SetLayout set_layout_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  Pipelines pipelines_;
  Buffers buffers_;
};

}  // namespace coppice::gpu
