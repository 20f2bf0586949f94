#pragma once

// The compute rasteriser: draws small leaves, and the wood between them, into a buffer of its own with atomics, and then that buffer into
// the engine's attachments. What a frame records is in leaf_raster.cpp.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "coppice/coppice.h"
#include "device.h"
#include "gpu_timer.h"
#include "growing_buffers.h"
#include "instances.h"
#include "passes.h"
#include "raster_shared.h"
#include "result.h"

namespace coppice::gpu {

struct RasterDesc {
  AttachmentDesc attachments;
  VkDescriptorSetLayout frame_set = VK_NULL_HANDLE;  ///< its layout
  std::uint32_t max_instances = 0;
  bool int64_atomics = false;      ///< shaderInt64 and shaderBufferInt64Atomics are enabled
  std::optional<bool> many_lanes;  ///< work is spread over many invocations; without a value: unless a processor runs them
};

/// How leaves and splats are spread over invocations.
struct RasterShape {
  bool expand_together = false;     ///< kTogether of leaf_expand.comp
  std::uint32_t leaf_lanes = 0;     ///< of a group that goes through clusters of leaves
  std::uint32_t leaf_clusters = 0;  ///< that it takes one after the other
  std::uint32_t big_pixels = 0;     ///< a leaf whose rectangle holds more is a whole group's
  std::uint32_t big_lanes = 0;      ///< of that group
  std::uint32_t row_lanes = 0;      ///< of them, so many share a row of pixels
  std::uint32_t splat_lanes = 0;    ///< of a group that goes through clusters of splats
  std::uint32_t cluster_lanes = 0;  ///< of them, so many share a cluster
};

InstanceBlock gpu_block(const InstanceBounds& bounds);

class LeafRaster {
 public:
  /// device, garbage, pipelines: outlive this object; pipelines are closed before it goes. None is wanted yet
  /// errors  out_of_memory; unsupported: more than kMaxSlots, or too few storage buffers in a stage
  static Result<std::unique_ptr<LeafRaster>> create(Device& device, Garbage& garbage, PipelineSet& pipelines, const RasterDesc& desc);
  /// The GPU must be done with everything.
  ~LeafRaster();
  LeafRaster(const LeafRaster&) = delete;
  LeafRaster& operator=(const LeafRaster&) = delete;

  /// Its buffers by instance slot, for so many, and what goes with them; none for no slot. The caller creates them and says so.
  void add_sizes(std::uint32_t slots, BufferSizes& sizes);
  void buffers_changed() { set_stale_ = true; }

  /// InstanceBlock[]: those of the instance table.
  [[nodiscard]] const Buffer& block_buffer() const { return buffers_.blocks; }

  /// Wants the pipelines that such a view needs; whether all are there. Else it may not be begun.
  bool want(const coppice_view& view);
  /// What begin_view allocates for it.
  [[nodiscard]] std::uint64_t wanted_bytes(const coppice_view& view) const;
  /// Makes room for a view and records what its buffers start with; the caller's barrier makes it visible to compute shaders.
  /// False: there is no memory for it, or it is not a view the rasteriser draws: record nothing more.
  bool begin_view(VkCommandBuffer cmd, const coppice_view& view);
  /// before: begin_view, buffers for slot_count, and all that culling reads. after: the picture, written by compute shaders.
  /// timer: may be null
  void record(VkCommandBuffer cmd, VkDescriptorSet frame_set, std::uint32_t slot_count, GpuTimer* timer) const;
  /// Inside dynamic rendering: the picture of the last begin_view into its attachments.
  void record_resolve(VkCommandBuffer cmd, VkDescriptorSet frame_set, coppice_view_kind kind) const;

 private:
  /// Of leaf_raster.comp.
  enum Source : std::uint32_t { kClusters, kBig, kSourceCount };
  /// kPass of write_pixel.glsl. With 64-bit atomics the first writes radiance too, and the second is never needed.
  enum RasterPass : std::uint32_t { kDepth, kRadiance, kCount, kPassCount };
  struct Pipelines {
    CullPipelines cull;
    Pipeline *blocks = nullptr, *draws = nullptr, *expand = nullptr, *finest_tiles = nullptr, *other_tiles = nullptr;
    Pipeline *resolve = nullptr, *resolve_shadow = nullptr;  ///< the latter is null where there are no shadow views
    std::array<std::array<Pipeline*, kSourceCount>, kPassCount> leaves{};
    std::array<Pipeline*, kPassCount> splats{};

    [[nodiscard]] Pipeline* resolve_of(coppice_view_kind kind) const { return kind == COPPICE_VIEW_SHADOW ? resolve_shadow : resolve; }
  };
  struct Buffers {
    Buffer rounds;
    Buffer blocks, visible_blocks, items, work, splats, big;  ///< add_sizes
    Buffer picture, tiles;                                    ///< by the view
  };

  LeafRaster(Device& device, Garbage& garbage, PipelineSet& pipelines, const RasterDesc& desc);
  Result<void> create_layouts();
  void add_pipelines();
  /// Which of the passes over leaves a view takes: those of Pipelines.
  [[nodiscard]] std::span<const RasterPass> passes(coppice_debug_view debug_view) const;
  Result<void> create_rounds();
  struct ViewBytes {
    std::uint64_t picture = 0, tiles = 0;
  };
  /// Of the buffers that a view needs, or of those that are there where they are larger.
  [[nodiscard]] ViewBytes view_bytes(const coppice_view& view) const;
  Result<void> reserve_picture(const coppice_view& view);
  Result<void> rebuild_set();
  void bind(VkCommandBuffer cmd, const Pipeline& pipeline) const;
  void dispatch_stage(VkCommandBuffer cmd, const Pipeline& pipeline, std::uint32_t round, std::uint64_t stage_offset) const;
  void record_leaves(VkCommandBuffer cmd, std::uint32_t round, GpuTimer* timer) const;
  void record_tiles(VkCommandBuffer cmd, std::uint32_t round) const;
  void barrier(VkCommandBuffer cmd) const;

  Device& device_;
  Garbage& garbage_;
  PipelineSet& pipeline_set_;
  RasterDesc desc_;
  std::uint32_t lanes_ = 8;
  RasterShape shape_{};
  SetLayout set_layout_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  Pipelines pipelines_;
  Buffers buffers_;
  DescriptorSet set_;
  bool set_stale_ = false;                              ///< a buffer of it has been replaced
  RasterPush push_{};                                   ///< of the last view
  coppice_debug_view debug_view_ = COPPICE_DEBUG_NONE;  ///< likewise
};

}  // namespace coppice::gpu
