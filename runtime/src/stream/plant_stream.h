#pragma once

// One open plant as the streamer keeps it: its file, the state of each chunk, and what of them lies in CPU memory.

#include <cstdint>
#include <memory>

#include "chunk_value.h"
#include "hooks.h"
#include "mesh_clusters.h"
#include "page_clusters.h"
#include "page_codec.h"
#include "reader.h"
#include "streamer.h"
#include "transfer.h"

namespace coppice {

/// CPU memory of a foliage page.
struct PageData {
  HookArray<PageNode> nodes;  ///< two per split. Children's corners are their parents', so they stay as long as the page does
  HookBuffer clusters;        ///< kPageBytes for the GPU, until they are uploaded
};

/// A wood LoD or a chunk of leaf meshes.
struct MeshData {
  gpu::MeshBlock block;         ///< while decoded
  std::uint64_t gpu_bytes = 0;  ///< of the block, once it has been decoded; before it is not known
};

/// What a chunk takes, bytes, by how long.
struct ChunkBytes {
  std::uint64_t gpu = 0;     ///< while resident or evicting
  std::uint64_t kept = 0;    ///< CPU, while decoded or resident
  std::uint64_t upload = 0;  ///< CPU, while decoded
  std::uint64_t work = 0;    ///< CPU, while reading or decoding: the file's bytes and the codec's output
  [[nodiscard]] std::uint64_t total() const { return gpu + kept + upload + work; }
};

/// What is uploaded of a texture.
struct TextureUpload {
  std::uint64_t bytes = 0;
  bool decoded = false;         ///< to RGBA8, by a job; else the chunk as stored
  bool leaf_mesh_only = false;  ///< nothing but leaf meshes shows it
};

/// The largest size of the last 8 to 16 frames: what a camera that comes and goes is still taken to look at.
struct RecentSize {
  float current_window_px = 0.0f, last_window_px = 0.0f;
  std::uint32_t frames_in_window = 0;
  [[nodiscard]] float px() const { return current_window_px > last_window_px ? current_window_px : last_window_px; }
};

/// What a lens asks of a plant.
struct LensDemand {
  PlantDemand now;
  RecentSize recent;
};

/// What a plant is asked for in a frame, by all lenses.
struct FrameWants {
  PlantWants unlimited;  ///< at the views' own thresholds, were memory no matter: what values are of
  PlantWants now;        ///< at the threshold in use: what is asked for
  PlantWants recent;     ///< at the threshold in use, by the size of the last frames: what is kept
};

/// What wants come to.
struct PlannedBytes {
  std::uint64_t settled = 0;  ///< once everything is resident
  std::uint64_t passing = 0;  ///< besides, while what takes most on its way is read and decoded
};

struct PlantStream {
  Hooks hooks;  ///< io: of the source
  GpuSizes gpu;
  DecoderPool* decoders = nullptr;  ///< the streamer's
  std::uint32_t index = 0;
  HookArray<char> path;                  ///< or the name that the log has
  std::span<const std::uint8_t> memory;  ///< where there is no file
  std::int64_t io_file = -1;             ///< closed by the destructor
  std::uint64_t file_bytes = 0;
  PlantFile file;  ///< without small_textures: `looks` has what they show
  HookArray<std::uint32_t> lod_words;
  ValuedPlant valued;
  PlantBox box;                        ///< of the leaf box and the coarsest wood
  HookArray<BoxTriangle> coarse_wood;  ///< the coarsest, once it is decoded

  HookArray<Chunk> chunks;          ///< pages, then wood LoDs, then textures, then leaf meshes
  HookArray<PageData> pages;        ///< [page_count]
  HookArray<PageNode*> page_nodes;  ///< [page_count] pages[k].nodes, for the codec; null while there are none
  HookArray<MeshData> wood;         ///< [wood_lod_count]
  HookArray<HookBuffer> textures;   ///< [texture_count] while decoded
  HookArray<TextureUpload> texture_uploads;
  HookArray<MeshData> leaf_meshes;  ///< [leaf_mesh_count]
  gpu::PlantLooks looks;
  gpu::CrownLight light;         ///< measured once, when page 0 is decoded out of the front
  gpu::LeafSource leaves;        ///< points to the two above
  gpu::ReadyCuts ready_cuts;     ///< with page 0, until it is uploaded
  std::uint64_t base_bytes = 0;  ///< counted while open: tables and the arrays above

  std::uint32_t decoded_page_count = 0;   ///< pages [0, this) are decoded or resident
  std::uint32_t resident_page_count = 0;  ///< pages [0, this) are resident
  std::uint32_t decoding_page_count = 0;  ///< a job reads earlier pages' nodes: no page may go
  std::uint32_t transfer_count = 0;
  std::uint32_t evicting_count = 0;
  std::uint32_t victim_page_end = 0;  ///< while evictions are planned: pages from here on are chosen already
  bool trim_needed = false;           ///< pages past decoded_page_count hold memory

  std::array<LensDemand, kMostLenses> demands;
  FrameWants wants;
  std::uint32_t loadable_page_count = 0;  ///< pages before the first that failed
  bool leaf_meshes_affordable = true;     ///< false where the budget is for what is worth more
  std::uint64_t retry_frame = 0;          ///< no requests before: the allocator hook or the device had nothing
  bool closing = false;
  std::uint64_t close_frame = 0;      ///< first begin_frame that saw it closing
  std::uint64_t last_used_frame = 0;  ///< closing: last frame that may refer to the plant

  PlantStream() = default;
  PlantStream(const PlantStream&) = delete;
  PlantStream& operator=(const PlantStream&) = delete;
  ~PlantStream();

  Chunk& chunk(ChunkKind kind, std::uint32_t chunk_index);
  [[nodiscard]] const Chunk& chunk(ChunkKind kind, std::uint32_t chunk_index) const {
    return const_cast<PlantStream*>(this)->chunk(kind, chunk_index);
  }
  /// id: of wood or leaf meshes
  MeshData& mesh(ChunkId id);
  [[nodiscard]] const MeshData& mesh(ChunkId id) const { return const_cast<PlantStream*>(this)->mesh(id); }
  [[nodiscard]] const coppice_file_chunk& file_chunk(const Chunk& of) const { return file.chunks[of.file_chunk]; }
};

/// Opens the source; nothing is read.
/// index   the plant's, for chunk ids
/// errors  io, bad_file: shorter than a header, out_of_memory; path is not in the message
Result<std::unique_ptr<PlantStream>> open_plant_file(const Hooks& hooks, const GpuSizes& gpu, const PlantSource& source,
                                                     std::uint32_t index);

/// Checks the front and fills in the tables; nothing is decoded. file.header: read
/// front   the file's first header.first_read_bytes. errors  bad_file, unsupported, out_of_memory
Result<void> take_front(PlantStream& plant, std::span<const std::uint8_t> front);

/// Once the coarsest wood is decoded: its box, and itself.
void take_coarse_wood(PlantStream& plant);

ChunkBytes chunk_bytes(const PlantStream& plant, const Chunk& chunk);

/// Whether the chunk is one of leaf meshes, or a texture that only they show: all of those are needed, or none.
bool in_leaf_mesh_set(const PlantStream& plant, const Chunk& chunk);

/// What is needed for the leaf meshes and is neither there nor on its way, bytes as in ChunkBytes::total().
std::uint64_t missing_leaf_mesh_bytes(const PlantStream& plant);

/// Value of a chunk under plant.demands and plant.wants.unlimited, over all lenses; infinite for what is pinned.
float chunk_value(const PlantStream& plant, const Chunk& chunk, const LensViews& views);

/// A new frame's demand.
void update_demand(LensDemand& of, const PlantDemand& demand);
/// Which size of a plant counts.
enum class DemandSize : std::uint8_t { now, recent };
float max_size_px(const LensDemand& demand, DemandSize size);
/// What all lenses ask of the plant; nothing of one that is closing.
PlantWants wants_at(const PlantStream& plant, DemandSize size, const LensViews& views);
PlantWants no_wants(const PlantStream& plant);
/// Of what is not pinned.
PlannedBytes planned_bytes(const PlantStream& plant, const PlantWants& wants);
/// A chunk that can never come: nothing that needs it is wanted any more.
void give_up(PlantStream& plant, const Chunk& chunk);
/// Whether the leaf meshes can be drawn.
bool leaf_meshes_resident(const PlantStream& plant);
bool is_wanted(const PlantStream& plant, const PlantWants& wants, const Chunk& chunk);
bool wanted_now(const PlantStream& plant, const Chunk& chunk);
bool wanted_recently(const PlantStream& plant, const Chunk& chunk);

/// Allocates what decoding a page writes; the page's chunk is in the transfer.
/// errors  out_of_memory: nothing stays allocated
Result<void> prepare_page(PlantStream& plant, Transfer& transfer);

/// The work of a decode job: checks the chunk's bytes and decodes them. Any thread; reads the plant's file and earlier nodes only.
Result<void> decode_chunk(Transfer& transfer);

/// Takes over what the job made.
void accept_decoded(PlantStream& plant, Transfer& transfer);

void free_page(PlantStream& plant, std::uint32_t page);
/// Gives up what was for the GPU of a page.
void free_clusters(PlantStream& plant, std::uint32_t page);

/// Gives up what a decoded chunk that is no page holds in CPU memory.
void free_decoded(PlantStream& plant, ChunkId id);

}  // namespace coppice
