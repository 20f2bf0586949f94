#pragma once

// An open plant in the streamer: its file, the state of each chunk, and its data in CPU memory.

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
  HookArray<PageNode> nodes;  ///< two for each split. Children use corners of their parents, so they stay as long as the page does
  HookBuffer clusters;        ///< kPageBytes for the GPU, until they are uploaded
};

/// A wood LoD or a chunk of leaf meshes.
struct MeshData {
  gpu::MeshBlock block;         ///< while decoded
  std::uint64_t gpu_bytes = 0;  ///< size of the block; unknown until it has been decoded
};

/// Bytes of a chunk, by their lifetime.
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
  bool decoded = false;         ///< a job decodes it to RGBA8; else the chunk as stored
  bool leaf_mesh_only = false;  ///< only leaf meshes use it
};

/// The maximum of a size over the last 8 to 16 frames, so that detail survives while a camera moves back and forth.
struct RecentSize {
  float current_window_px = 0.0f, last_window_px = 0.0f;
  std::uint32_t frames_in_window = 0;
  [[nodiscard]] float px() const { return current_window_px > last_window_px ? current_window_px : last_window_px; }
};

/// A view group's demand for a plant.
struct GroupDemand {
  PlantDemand now;
  RecentSize recent;
};

/// The demand of all view groups for a plant in a frame.
struct FrameDemand {
  DemandedDetail unlimited;  ///< at the views' own thresholds, without a limit of memory: values are based on it
  DemandedDetail now;        ///< at the threshold in use: what is requested
  DemandedDetail recent;     ///< at the threshold in use, with the largest size of the last frames: what is kept
};

/// The frame that has begun.
struct CurrentFrame {
  std::uint64_t number = 0;
  std::uint64_t last_number = 0;       ///< number of the frame before it
  std::uint64_t completed_number = 0;  ///< the GPU has finished every frame up to this one
  GroupViews views;                    ///< with their own thresholds
};

/// Memory that a demand needs.
struct PlannedBytes {
  std::uint64_t settled = 0;  ///< once everything is resident
  std::uint64_t passing = 0;  ///< additional peak, while the most demanding chunk is read and decoded
};

struct PlantStream {
  Hooks hooks;  ///< io: that of the source
  GpuSizes gpu;
  DecoderPool* decoders = nullptr;  ///< owned by the streamer
  std::uint32_t index = 0;
  HookArray<char> path;                  ///< or the name for the log
  std::span<const std::uint8_t> memory;  ///< the file's content, if it is in memory
  std::int64_t io_file = -1;             ///< closed by the destructor
  std::uint64_t file_bytes = 0;
  PlantFile file;  ///< without small_textures, which `looks` replaces
  HookArray<std::uint32_t> lod_words;
  ValuedPlant valued;
  PlantBox box;                        ///< bounds of the leaf box and the coarsest wood
  HookArray<BoxTriangle> coarse_wood;  ///< its triangles, once it is decoded

  HookArray<Chunk> chunks;          ///< pages, then wood LoDs, then textures, then leaf meshes
  HookArray<PageData> pages;        ///< [page_count]
  HookArray<PageNode*> page_nodes;  ///< [page_count] pages[k].nodes, for the codec; null while there are none
  HookArray<MeshData> wood;         ///< [wood_lod_count]
  HookArray<HookBuffer> textures;   ///< [texture_count] while decoded
  HookArray<TextureUpload> texture_uploads;
  HookArray<MeshData> leaf_meshes;  ///< [leaf_mesh_count]
  gpu::PlantLooks looks;
  gpu::CrownLight light;         ///< measured once, when page 0 of the front is decoded
  gpu::LeafSource leaves;        ///< points to the two above
  gpu::ReadyCuts ready_cuts;     ///< for page 0, until it is uploaded
  std::uint64_t base_bytes = 0;  ///< reserved while open: tables and the arrays above

  std::uint32_t decoded_page_count = 0;   ///< pages [0, this) are decoded or resident
  std::uint32_t resident_page_count = 0;  ///< pages [0, this) are resident
  std::uint32_t decoding_page_count = 0;  ///< pages whose nodes a running job reads: none of them may be evicted
  std::uint32_t transfer_count = 0;
  std::uint32_t evicting_count = 0;
  std::uint32_t eviction_page_end = 0;  ///< while evictions are planned: pages from here on are chosen already
  bool trim_needed = false;             ///< pages past decoded_page_count hold memory

  std::array<GroupDemand, kMaxViewGroups> demands;
  FrameDemand demanded;
  std::uint32_t loadable_page_count = 0;   ///< pages before the first that failed
  std::uint64_t leaf_mesh_load_bytes = 0;  ///< peak memory of loading all leaf meshes and the textures that only they show
  Reread reread;                           ///< of its unreadable chunks
  std::uint64_t retry_frame = 0;           ///< no requests before this frame: the allocator hook or the device had no memory
  bool closing = false;
  std::uint64_t close_frame = 0;      ///< first begin_frame in which it is closing
  std::uint64_t last_used_frame = 0;  ///< closing: last frame that may refer to the plant

  PlantStream() = default;
  PlantStream(const PlantStream&) = delete;
  PlantStream& operator=(const PlantStream&) = delete;
  ~PlantStream();

  Chunk& chunk(ChunkKind kind, std::uint32_t chunk_index);
  [[nodiscard]] const Chunk& chunk(ChunkKind kind, std::uint32_t chunk_index) const {
    return const_cast<PlantStream*>(this)->chunk(kind, chunk_index);
  }
  /// All chunks but pages.
  [[nodiscard]] std::span<Chunk> other_chunks() { return chunks.span().subspan(file.plant.page_count); }
  [[nodiscard]] std::span<const Chunk> other_chunks() const { return chunks.span().subspan(file.plant.page_count); }
  /// id: wood or leaf meshes
  MeshData& mesh(ChunkId id);
  [[nodiscard]] const MeshData& mesh(ChunkId id) const { return const_cast<PlantStream*>(this)->mesh(id); }
  [[nodiscard]] const coppice_file_chunk& file_chunk(const Chunk& of) const { return file.chunks[of.file_chunk]; }
};

/// A chunk and its value in the frame.
struct ValuedChunk {
  PlantStream* plant = nullptr;
  Chunk* chunk = nullptr;
  float value = 0.0f;
};

/// Opens the source; nothing is read.
/// index   the plant's, for chunk ids
/// errors  io, bad_file: shorter than a header, out_of_memory; path is not in the message
Result<std::unique_ptr<PlantStream>> open_plant_file(const Hooks& hooks, const GpuSizes& gpu, const PlantSource& source,
                                                     std::uint32_t index);

/// Checks the front and fills in the tables; decodes nothing. before: file.header is read
/// front   the file's first header.first_read_bytes. errors  bad_file, unsupported, out_of_memory
Result<void> take_front(PlantStream& plant, std::span<const std::uint8_t> front);

/// Copies the box and the triangles of the coarsest wood, once that is decoded.
void take_coarse_wood(PlantStream& plant);

ChunkBytes chunk_bytes(const PlantStream& plant, const Chunk& chunk);

/// Maximum number of the plant's chunks that may be requested at the same time: one page, and all others.
inline std::size_t max_requests(const PlantStream& plant) {
  return plant.other_chunks().size() + 1;
}

/// True if the chunk is one of leaf meshes, or a texture that only they show. All of those are needed, or none.
bool in_leaf_mesh_set(const PlantStream& plant, const Chunk& chunk);

/// Value of a chunk under plant.demands and plant.demanded.unlimited, over all view groups; infinite for pinned chunks. Computed once a
/// frame.
float chunk_value(const PlantStream& plant, Chunk& chunk, const CurrentFrame& frame);

/// Updates with a new frame's demand.
void update_demand(GroupDemand& of, const PlantDemand& demand);
/// Which size of a plant counts.
enum class DemandSize : std::uint8_t { now, recent };
float max_size_px(const GroupDemand& demand, DemandSize size);
/// Bytes of a texture, or the peak of loading a wood LoD: what is compared with LumpLimits.
std::uint64_t lump_bytes(const PlantStream& plant, const Chunk& chunk);

/// Maximum bytes of a texture; of loading a wood LoD, or all leaf meshes. A resident one may take a third more.
struct LumpLimits {
  std::uint64_t texture_bytes = UINT64_MAX, other_bytes = UINT64_MAX;
};
/// The views at the thresholds of a plant.
struct DemandViews {
  const GroupViews& pages;
  const GroupViews& lumps;
  LumpLimits limits;
  bool every_texture = true;  ///< else those without which the plant is wrong by more than the threshold
};
/// The demand of all view groups for the plant; none for one that is closing.
DemandedDetail demanded_at(const PlantStream& plant, DemandSize size, const DemandViews& views);
/// Counts all chunks that are not pinned.
PlannedBytes planned_bytes(const PlantStream& plant, const DemandedDetail& demanded);
/// Marks a chunk that can never be loaded: nothing that needs it is in demand any more.
void give_up(PlantStream& plant, const Chunk& chunk);
/// Lets failed chunks be requested again, with what give_up() took away. unreadable_only: not those that are damaged
void forget_failures(PlantStream& plant, bool unreadable_only);
/// True if the leaf meshes can be drawn.
bool leaf_meshes_resident(const PlantStream& plant);
bool is_demanded(const PlantStream& plant, const DemandedDetail& demanded, const Chunk& chunk);
/// True if the chunk is pinned, also while its plant is closing, or in plant.demanded.recent.
bool demanded_recently(const PlantStream& plant, const Chunk& chunk);

/// Allocates the nodes of a page that is decoded next, which later pages refer to; its chunk is in the transfer.
/// errors  out_of_memory: nothing stays allocated
Result<void> prepare_page(PlantStream& plant, Transfer& transfer);

/// The work of a decode job: checks the chunk's bytes and decodes them. Any thread; reads the plant's file and earlier nodes only.
Result<void> decode_chunk(Transfer& transfer);

/// True if the stored bytes are what is uploaded, and not only the job's input.
bool keeps_bytes(const Transfer& transfer);

/// Takes over the results of the job.
void accept_decoded(PlantStream& plant, Transfer& transfer);

void free_page(PlantStream& plant, std::uint32_t page);
/// Frees a page's data for the GPU.
void free_clusters(PlantStream& plant, std::uint32_t page);

/// Frees the CPU memory of a decoded chunk that is no page.
void free_decoded(PlantStream& plant, ChunkId id);

}  // namespace coppice
