#pragma once

// The GPU half of the runtime: owns what lives in device memory and records upload, culling and drawing into the engine's command buffers.
// It decides nothing about residency: the caller says which chunks to take and to drop.
//
// A frame: begin_frame; record_upload_begin, any number of upload_* and drop_*, record_upload_end; record_cull; record_draw.
// Thread: externally serialised; const functions may overlap.

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "coppice/coppice.h"
#include "coppice_shared.h"
#include "crown_light.h"
#include "device.h"
#include "gpu_timer.h"
#include "instances.h"
#include "leaf_raster.h"
#include "mesh_clusters.h"
#include "page_clusters.h"
#include "passes.h"
#include "plant_tables.h"
#include "reader.h"
#include "resources.h"
#include "result.h"
#include "select.h"
#include "tree.h"

namespace coppice::gpu {

struct RendererDesc {
  Device device;  ///< memory.ledger outlives the renderer
  AttachmentDesc attachments;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
  std::uint64_t memory_budget_bytes = 0;  ///< the ledger's, which has none while the renderer is created: see set_memory_budget
  std::uint32_t max_instances = 0;        ///< upper limits alone: see Renderer::max_instances
  std::uint32_t max_plants = 0;
  bool compute_raster = false;     ///< small leaves by compute shaders, where the device does
  bool int64_atomics = false;      ///< shaderInt64 and shaderBufferInt64Atomics are enabled
  std::optional<bool> many_lanes;  ///< RasterDesc's
  bool pass_times = false;
  coppice_jobs jobs{};             ///< where pipelines are built
  bool blocking_pipelines = true;  ///< they are built where they are wanted, and not by jobs
  bool only_measured = false;      ///< what it takes of the ledger is asked for and nothing else: no device memory, no pipeline
};

// What is uploaded is moved to its addresses where it lies.

/// A page's leaves; see page_clusters.h.
struct PageUpload {
  std::uint32_t plant = 0;
  std::uint32_t page = 0;
  std::span<std::uint8_t> clusters;  ///< of build_page
  ReadyCuts* ready_cuts = nullptr;   ///< of page 0
};

/// A wood LoD or a chunk of leaf meshes; see mesh_clusters.h.
struct MeshUpload {
  std::uint32_t plant = 0;
  std::uint32_t mesh = 0;  ///< wood LoD, or kMaxWoodLods + chunk of leaf meshes
  MeshBlock* block = nullptr;
};

/// What may be drawn of a plant this frame.
struct PlantResidency {
  std::uint32_t leaf_count = 1;
  std::uint32_t wood_mask = 0;
  bool leaf_meshes = false;
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

/// How much there is room for.
struct Capacity {
  std::uint32_t slots = 0;  ///< of instances; none before the first is reserved
  std::uint32_t plants = 0;
};

class Renderer {
 public:
  /// errors  out_of_memory, unsupported, internal
  static Result<std::unique_ptr<Renderer>> create(const RendererDesc& desc);
  /// The GPU must have finished every frame recorded.
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Frees what the GPU is done with and fetches counts. frame_number grows
  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number);

  /// RendererDesc's, or less where buffers for so many would be more than the device binds.
  [[nodiscard]] std::uint32_t max_instances() const { return desc_.max_instances; }
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
  /// Nothing of the plant may be drawn from the next upload on; its chunks must have been dropped.
  void remove_plant(std::uint32_t plant);

  /// before / after: as coppice_record_upload. queue: graphics.
  void record_upload_begin(VkCommandBuffer cmd);
  /// errors  out_of_memory: the chunk is not there
  Result<void> upload_page(const PageUpload& upload);
  Result<void> upload_mesh(const MeshUpload& upload);
  /// bytes: a TEXTURE chunk. errors  bad_file: the field and its offset; unsupported: blocks, and the device does not take them;
  /// out_of_memory
  Result<void> upload_texture(std::uint32_t plant, std::uint32_t texture, std::span<const std::uint8_t> bytes);
  /// The GPU must have finished the last frame that drew the chunk.
  void drop_page(std::uint32_t plant, std::uint32_t page);
  /// mesh: MeshUpload's
  void drop_mesh(std::uint32_t plant, std::uint32_t mesh);
  void drop_texture(std::uint32_t plant, std::uint32_t texture);
  /// Stops drawing with the texture; drop_texture follows when the GPU is done.
  void hide_texture(std::uint32_t plant, std::uint32_t texture);
  /// instances: no more slots than capacity(). residency: [plants], of all that were ever added; leaf_meshes only where all of them have
  /// been uploaded. errors  out_of_memory: what goes up with this frame does not fit; the frame draws nothing
  Result<void> record_upload_end(InstanceTable& instances, std::span<const PlantResidency> residency);

  /// lod: selection's view of `view`. Before / after: as coppice_record_cull.
  void record_cull(VkCommandBuffer cmd, const coppice_view& view, const LodView& lod);
  void record_draw(VkCommandBuffer cmd, const coppice_view& view) const;

  [[nodiscard]] const FrameCounts& counts() const { return counts_; }
  [[nodiscard]] const AttachmentDesc& attachments() const { return desc_.attachments; }
  /// The least memory budget that holds what takes taken_bytes of the ledger now, before any plant.
  [[nodiscard]] std::uint64_t least_budget_bytes(std::uint64_t taken_bytes) const;
  /// errors  device_lost: a Vulkan call said so, now or earlier; nothing that is recorded from then on draws
  [[nodiscard]] Result<void> device_state() const { return check_alive(device_); }
  [[nodiscard]] const PipelineSet& pipelines() const { return pipelines_; }
  [[nodiscard]] const Device& device() const { return device_; }
  /// Whether upload_texture takes BC1 and BC3.
  [[nodiscard]] bool block_textures() const { return device_.block_textures; }
  /// From now on blocks of device memory, and the share of draw commands, are as large as this budget has them.
  void set_memory_budget(std::uint64_t bytes);
  /// What images and buffers of an upload are rounded up to.
  static constexpr std::uint64_t kSlackBytes = 64ull << 10;
  /// A chunk of more than this for the GPU is staged in a buffer of its own.
  static constexpr std::uint64_t kStagingSliceBytes = Staging::kSliceBytes;
  /// Of the ring, for chunks.
  [[nodiscard]] std::uint64_t staging_bytes() const;
  /// Whether small leaves are drawn by compute shaders.
  [[nodiscard]] bool has_raster() const { return raster_ != nullptr; }
  /// All zero without RendererDesc::pass_times.
  [[nodiscard]] const GpuTimer& timer() const { return timer_; }
  /// float[instance slots]: the cut of each, after record_cull. TRANSFER_SRC; for tests.
  [[nodiscard]] VkBuffer cut_buffer() const { return growing_.cuts.buffer; }

 private:
  /// Of a material; kNoTexture where it has none.
  struct SurfaceTextures {
    std::uint32_t color = kNoTexture, normal_map = kNoTexture;

    bool operator==(const SurfaceTextures&) const = default;
  };
  struct MeshBuffer {
    Buffer buffer;  ///< a MeshBlock's bytes
    uvec2 vertices{};
    std::uint32_t index_count = 0, cluster_count = 0;
    std::vector<SurfaceTextures> textures;  ///< used by its vertices; distinct
  };
  struct PlantTexture {
    Texture texture;
    DescriptorSet set;
    bool visible = false;
  };
  struct PlantSlot {
    bool used = false;
    Plant record{};
    Buffer tables;
    PlantTables layout;                        ///< of `tables`
    bool has_cuts = false;                     ///< its leaves can be drawn
    std::vector<Buffer> pages;                 ///< [page] null where it is not there
    std::vector<std::uint32_t> leaf_textures;  ///< used by its cards, kNoTexture included; distinct
    std::vector<SurfaceTextures> material_textures;
    std::array<MeshBuffer, kMeshCommands> meshes;  ///< wood LoDs, then leaf meshes
    std::uint32_t leaf_mesh_count = 0;
    std::vector<PlantTexture> textures;
    std::vector<std::uint8_t> pending_tables;  ///< contents of `tables`, until the next upload
    std::vector<std::uint32_t> pending_words;  ///< the packed table, until the next upload
  };
  /// Where a mesh finds its instances, its command, and the commands of its parts and their count.
  struct MeshDraw {
    std::uint32_t list_first = 0, command = 0;
    std::uint64_t part_first = 0;
    std::uint32_t part_count = 0;
    const MeshPipelines* pipelines = nullptr;
  };
  struct FixedBuffers {
    Buffer view, counters, indices, readback;
  };
  struct GrowingBuffers {
    Buffer instances, cuts, debug_colors;               ///< by slot
    Buffer plants, tables, draw_counts, wood_commands;  ///< by plant
  };
  /// Takes the place of a buffer with the next frame.
  struct LargerBuffer {
    Buffer* smaller = nullptr;
    Buffer buffer;
    bool kept = false;
  };
  struct Copy {
    VkBuffer from, to;
    VkBufferCopy region;
  };
  struct TextureCopy {
    VkBuffer from;
    std::uint64_t offset;
    VkImage image;
    std::uint32_t width, height, mip_count, format;
  };

  explicit Renderer(const RendererDesc& desc);
  void lower_limits();
  Result<void> create_buffers();
  /// Of the buffers that follow them.
  [[nodiscard]] std::vector<BufferSize> sizes(const Capacity& capacity);
  /// Those of them that have to become larger.
  [[nodiscard]] std::vector<BufferSize> growing(const Capacity& wanted);
  void take_larger();
  Result<void> create_default_texture();
  Result<void> create_raster();
  Result<void> rebuild_frame_set();
  [[nodiscard]] FrameBindings frame_bindings() const;
  VkDescriptorSet set_of(const coppice_view& view);
  Result<void> reserve_draws();
  /// Whether so many bytes can be taken for a buffer; see Ledger::fits.
  [[nodiscard]] bool fits(std::uint64_t bytes);
  Result<StagingSlice> stage(std::uint64_t bytes);
  Result<void> stage_copy(const void* data, std::uint64_t bytes, VkBuffer to, std::uint64_t offset);
  Result<void> stage_once();
  Result<void> stage_plant_tables();
  Result<void> stage_instances(InstanceTable& instances);
  Result<void> stage_texels(const Texture& texture, std::span<const std::uint8_t> texels);
  void drop_page(Buffer& page);
  Result<void> stage_patch(PlantSlot& plant, std::uint64_t offset, std::span<const std::uint8_t> bytes);
  Result<void> stage_cuts(PlantSlot& plant, ReadyCuts& cuts);
  Result<void> add_single_leaf(PlantSlot& plant, const PlantFile& file, const PlantAppearance& appearance);
  Result<void> stage_frame(InstanceTable& instances, std::span<const PlantResidency> residency);
  void place_draws(std::uint64_t most_clusters, bool parts);
  [[nodiscard]] std::uint64_t wanted_parts(std::uint32_t plant) const;
  [[nodiscard]] std::uint64_t wanted_commands(std::uint32_t plant) const;
  void fill_records(const InstanceTable& instances, std::span<const PlantResidency> residency);
  void fill_meshes(std::uint32_t plant, const PlantResidency& residency);
  void record_buffer_copies(std::vector<Copy>& copies);
  void record_texture_copies();
  void update_buffer(VkCommandBuffer cmd, const Buffer& buffer, const void* data, std::uint64_t bytes) const;
  void record_readback(VkCommandBuffer cmd);
  void draw_leaves(VkCommandBuffer cmd, const DrawPipelines& pipelines, std::uint32_t plant) const;
  void draw_wood(VkCommandBuffer cmd, const DrawPipelines& pipelines, std::uint32_t plant, std::uint32_t lod) const;
  void draw_leaf_mesh(VkCommandBuffer cmd, std::uint32_t plant, std::uint32_t index) const;
  void draw_mesh(VkCommandBuffer cmd, std::uint32_t plant, const MeshBuffer& mesh, const MeshDraw& draw) const;
  /// False: the pipeline is not there.
  bool bind_draw(VkCommandBuffer cmd, const PlantSlot& plant, const DrawPush& push, const std::array<Pipeline*, 2>& pipelines) const;
  void destroy_plant(PlantSlot& plant);

  /// What of a view is there: what has to be built for it is wanted from here on.
  struct Ready {
    bool cull = false, raster = false;

    bool operator==(const Ready&) const = default;
  };
  Ready want(const coppice_view& view);
  void want_mesh(const MeshPipelines& pipelines, const MeshBuffer& mesh);
  void want_leaves(const PlantSlot& plant);
  [[nodiscard]] bool can_draw_leaf_meshes(const PlantSlot& plant) const;

  Device device_;
  RendererDesc desc_;
  PipelineSet pipelines_;
  Passes passes_;
  Garbage garbage_;
  Staging staging_;
  FixedBuffers fixed_;
  GrowingBuffers growing_;
  Capacity capacity_;
  std::vector<LargerBuffer> larger_;
  Buffer leaf_commands_, wood_list_;  ///< grow with instances and residency
  DescriptorSet frame_set_;
  DescriptorSet shadowed_set_;  ///< the same with the maps of the last view that had any
  std::array<VkImageView, kMaxCascades> maps_{};
  Texture default_texture_;  ///< 1 x 1 white, for textures not there yet
  DescriptorSet default_set_;
  std::unique_ptr<LeafRaster> raster_;  ///< null: everything is drawn by the hardware
  GpuTimer timer_;
  bool rastered_ = false;                      ///< the last record_cull left a picture to resolve
  VkDescriptorSet view_set_ = VK_NULL_HANDLE;  ///< of the last record_cull
  std::deque<PlantSlot> plants_;               ///< up to the last that was ever added; so are the others
  std::vector<Plant> records_;                 ///< as uploaded this frame
  std::vector<std::uint32_t> plant_counts_;    ///< instances per plant, this frame
  std::vector<DrawCommand> mesh_templates_;

  VkCommandBuffer upload_cmd_ = VK_NULL_HANDLE;
  /// moves_: from buffers to larger ones. copies_ overwrite parts of what these wrote, patches_ of what the copies wrote; behind barriers
  std::vector<Copy> moves_, copies_, patches_;
  std::vector<TextureCopy> texture_copies_;
  std::uint32_t most_mesh_lists_ = 1;  ///< of a plant: its wood LoDs, and one where it has leaf meshes
  std::uint64_t frame_ = 0, completed_ = 0;
  std::uint32_t instance_slot_count_ = 0;
  bool once_staged_ = false;      ///< index buffer and default texture
  bool drawable_ = false;         ///< this frame's record_upload_end succeeded
  bool frame_set_stale_ = false;  ///< a buffer of the frame set has been replaced

  static constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  static constexpr std::uint32_t kReadbackSlots = 8;
  std::array<std::uint64_t, kReadbackSlots> readback_frames_{};  ///< 0: never used
  FrameCounts counts_;
};

}  // namespace coppice::gpu
