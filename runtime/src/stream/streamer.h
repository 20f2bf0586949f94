#pragma once

// Keeps, under the ledger's budget, those chunks of the open plants that show most on screen. It calls no Vulkan function and owns no
// thread: reads go through the I/O hook, decoding through the jobs hook, and the GPU side copies what take_decoded() hands out.
//
// A frame, on the caller's thread:
//   release            the GPU has finished every frame that referred to these: the GPU side gives their memory back now
//   take_closed_plants everything of these plants has been released; their index may come back from open_plant
//   begin_frame        collects finished reads and decodes, re-orders requests, cancels stale ones, evicts, starts reads. Never blocks
//   take_evicted       the GPU side stops referring to these from this frame on
//   take_decoded       the GPU side copies these: begin_upload() for each, then uploaded() or upload_failed()
//   state              the resident prefix to clamp cuts to, after uploaded()
//
// Foliage pages become and stay resident in order: whatever is resident is a prefix of the refinement, so a complete plant.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "demand.h"
#include "hooks.h"
#include "ledger.h"
#include "mesh_clusters.h"
#include "page_clusters.h"
#include "reader.h"
#include "residency.h"
#include "tree.h"

namespace coppice {

/// What the GPU side will take for a chunk; the streamer reserves it before it starts a read.
struct GpuSizes {
  std::uint64_t plant_bytes = 0;                 ///< per open plant: tables, descriptors
  std::uint64_t slack_bytes = 0;                 ///< stays free beside all chunks: what images and buffers are rounded up to
  std::uint64_t most_staged_bytes = UINT64_MAX;  ///< a chunk of more has a copy of itself on its way
  bool mesh_leaves = false;                      ///< gpu::MeshSource::leaves
  /// A host draws: meshes and pages are as coppice.h has them, what it takes is counted here, and it confirms what it has taken and freed.
  bool host = false;
  bool block_textures = false;  ///< the GPU reads BC1 and BC3; where it does not, textures come out of take_decoded() as RGBA8
};

/// What a plant is read from.
struct PlantSource {
  const char* name = "";                     ///< a path; of memory what the log calls it. Copied when the plant is opened
  std::span<const std::uint8_t> bytes = {};  ///< memory that stays until the plant is closed; empty: a file

  PlantSource() = default;
  PlantSource(const char* path_or_name, std::span<const std::uint8_t> memory = {}) : name(path_or_name), bytes(memory) {}
};

struct StreamerOptions {
  GpuSizes gpu;
  std::uint32_t max_plants = 64;     ///< what there are of them by plant grows as they are opened
  std::uint32_t max_in_flight = 16;  ///< reads and decodes together
  /// For taking over what was read and decoded, a frame; at least one is. What is over waits for the next frame.
  std::uint64_t hand_over_budget_ns = UINT64_MAX;
  std::uint64_t (*clock_ns)() = now_ns;  ///< also for the pauses of ReadRetry
};

/// A chunk to upload. Spans and pointers stay valid until uploaded(), upload_failed() or the next begin_frame().
struct DecodedChunk {
  ChunkId id;
  std::uint64_t bytes = 0;  ///< GPU memory
  bool pinned = false;      ///< the plant cannot be drawn without it

  // page: nodes first_node .. first_node + nodes.size() - 1
  std::uint32_t first_node = 0;  ///< 2 * COPPICE_PAGE_SPLITS * index + 1
  std::span<const PageNode> nodes;
  std::span<std::uint8_t> clusters;      ///< gpu::kPageBytes, as gpu::build_page writes them
  gpu::ReadyCuts* ready_cuts = nullptr;  ///< page 0

  gpu::MeshBlock* mesh = nullptr;  ///< wood, leaf mesh

  // texture: a coppice_file_texture and its mip levels, checked; the chunk as stored, or decoded to RGBA8 without GpuSizes::block_textures
  std::span<const std::uint8_t> texture;
};

/// Object space, m.
struct PlantBox {
  std::array<float, 3> low{}, high{};
};
/// Corners are in kBoxSteps-ths of the box.
using BoxTriangle = std::array<QuantisedPoint, 3>;
inline constexpr float kBoxSteps = 65535.0f;

/// What can be drawn of a plant now.
struct PlantState {
  std::uint32_t resident_page_count = 0;
  std::uint32_t resident_leaf_count = 1;  ///< finest cut
  std::uint32_t resident_wood_mask = 0;   ///< bit i: wood LoD i
  std::uint64_t resident_texture_count = 0;
  bool leaf_meshes_resident = false;  ///< every one of them, and the textures that only they show
};

/// Views that streaming takes as one: what they want of each plant at one threshold.
struct StreamLens {
  LodView view;                          ///< threshold and mode
  std::span<const PlantDemand> demands;  ///< by plant index; missing ones count as no demand
};

struct StreamFrame {
  std::uint64_t frame_number = 1;  ///< of the frame about to be recorded; grows
  /// The same views have the same place from frame to frame. What is wanted is what any of them wants; with none nothing is wanted beyond
  /// what is there.
  std::array<std::optional<StreamLens>, kMostLenses> lenses;
};

struct ChunkCounts {
  std::uint64_t loaded = 0;  ///< became resident
  std::uint64_t evicted = 0;
  std::uint64_t failed = 0;
  std::uint64_t cancelled = 0;  ///< reads
  std::uint32_t in_flight = 0;  ///< reading or decoding
  std::uint32_t wanted = 0;     ///< by any view at the threshold in use, not resident
  std::uint32_t queued = 0;     ///< of those wanted, not asked for yet

  ChunkCounts& operator+=(const ChunkCounts& other);
};

struct StreamStats {
  std::array<ChunkCounts, kChunkKindCount> chunks;  ///< by ChunkKind
  std::uint64_t bytes_read = 0;                     ///< by reads that returned, failed ones too
  std::uint64_t decode_ns = 0;                      ///< of jobs that ended, added up
  std::uint64_t hand_over_ns = 0;                   ///< time that the last begin_frame took over what was read and decoded

  /// Of all kinds.
  [[nodiscard]] ChunkCounts all() const;
};

/// Thread: externally serialised; const functions may overlap with each other. The hooks and the ledger must outlive it.
class Streamer {
 public:
  /// errors  out_of_memory
  static Result<std::unique_ptr<Streamer>> create(const Hooks& hooks, Ledger& ledger, const StreamerOptions& options);

  /// Waits for running reads and jobs, closes every file.
  ~Streamer();
  Streamer(const Streamer&) = delete;
  Streamer& operator=(const Streamer&) = delete;

  /// Opens a file, reads its front through the I/O hook (blocks for that, and for further tries where a read fails), checks it and decodes
  /// page 0 and the coarsest wood inline; they come out of the next take_decoded(). Returns the plant's index, < max_plants. errors  io,
  /// bad_file (one log line names file, field and byte); out_of_memory: the hook, the budget, or max_plants are open
  Result<std::uint32_t> open_plant(const PlantSource& source);

  /// The same without waiting, the index at once: finish_open, from time to time, says what has become of it. Up to kMostOpening are read
  /// and decoded at a time. Where there is no memory it is tried kOpenTries times, kOpenRetryFrames apart. errors  out_of_memory:
  /// max_plants are open; not logged
  Result<std::uint32_t> start_open(const PlantSource& source);
  /// Nothing: it is on its way. Otherwise the plant is open, or it failed and its index is free again.
  /// plant  of start_open, neither finished nor cancelled (asserted), here and below. errors  as open_plant, logged
  [[nodiscard]] std::optional<Result<void>> finish_open(std::uint32_t plant);
  /// Does not wait: its index is free once what is under way has come back.
  void cancel_open(std::uint32_t plant);
  static constexpr std::size_t kMostOpening = 8;
  static constexpr std::uint32_t kOpenTries = 8;
  static constexpr std::uint64_t kOpenRetryFrames = 30;

  /// From now on the plant wants nothing. Its chunks come out of take_evicted and release, then its index out of take_closed_plants.
  /// plant  an open index (asserted)
  void close_plant(std::uint32_t plant);

  /// Without small_textures. plant  an open index (asserted); the reference stays valid until the plant comes out of take_closed_plants
  [[nodiscard]] const PlantFile& file(std::uint32_t plant) const;
  [[nodiscard]] const PlantBox& box(std::uint32_t plant) const;
  /// The coarsest wood, of the box.
  [[nodiscard]] std::span<const BoxTriangle> coarse_wood(std::uint32_t plant) const;
  /// The packed table of select.h, for the GPU to copy and for the CPU to select with.
  [[nodiscard]] std::span<const std::uint32_t> lod_words(std::uint32_t plant) const;
  [[nodiscard]] gpu::PlantAppearance appearance(std::uint32_t plant) const;
  [[nodiscard]] PlantState state(std::uint32_t plant) const;
  /// Of a page that is resident. Valid until the next begin_frame
  [[nodiscard]] std::span<const PageNode> page_nodes(std::uint32_t plant, std::uint32_t page) const;
  /// Whether everything that was wanted of the plant in the last begin_frame, and can be had, is resident.
  [[nodiscard]] bool is_settled(std::uint32_t plant) const;
  /// The same of all that the lens wanted, of every plant. lens: < kMostLenses
  [[nodiscard]] bool is_lens_settled(std::size_t lens) const;
  /// In use: the lens's own, or higher where what all want does not fit the budget; 0: every leaf, or it had no view in the last frame.
  [[nodiscard]] float threshold_px(std::size_t lens) const;
  /// Of the plant's file, or its name.
  [[nodiscard]] const char* path(std::uint32_t plant) const;
  /// Its name as long as the plant is open.
  [[nodiscard]] PlantSource source(std::uint32_t plant) const;
  [[nodiscard]] bool is_open(std::uint32_t plant) const;

  /// Of what the ledger has refused.
  [[nodiscard]] Error refusal(std::uint64_t bytes) const;

  /// Until the next release. completed_number  the GPU has finished every frame up to this one
  [[nodiscard]] std::span<const ChunkId> release(std::uint64_t completed_number);
  /// Of the last release; empty after that.
  [[nodiscard]] std::span<const std::uint32_t> take_closed_plants();

  /// Keeps the ledger's budget, and what is wanted of it free, as far as chunks that are not pinned can go.
  void begin_frame(const StreamFrame& frame);

  /// Of the last begin_frame; empty after that.
  [[nodiscard]] std::span<const ChunkId> take_evicted();

  /// Chunks to upload, those that are worth most first and pages of a plant in order, at most about max_bytes of GPU memory but at least
  /// one chunk if there is one. What is not confirmed with uploaded() is handed out again.
  [[nodiscard]] std::span<const DecodedChunk> take_decoded(std::uint64_t max_bytes);
  /// Gives back what was taken for the chunk's place on the GPU, and for a copy on its way there: the GPU side takes it now. False: a chunk
  /// of the last take_decoded does not wait any more, as the failure of a page takes the later ones of its plant along.
  bool begin_upload(ChunkId id);
  /// The copy is recorded in this frame's commands. id: begin_upload was true; pages of a plant in order (asserted).
  void uploaded(ChunkId id);
  /// The GPU side could not take it. out_of_memory: it is asked for again in a while; anything else: it counts as failed. Logged here.
  /// id: begin_upload was true (asserted)
  void upload_failed(ChunkId id, const Error& error);

  // GpuSizes::host, in place of take_decoded to upload_failed.

  /// The chunk that is worth most of those that wait, if there is one: what it points at stays until it is confirmed. One page of a plant
  /// at a time.
  [[nodiscard]] std::optional<DecodedChunk> hold_next();
  /// What the host has to confirm of a chunk.
  enum class Held : std::uint8_t { no, added, dropped };
  /// Any plant and chunk.
  [[nodiscard]] Held held(ChunkId id) const;
  /// The host has a chunk that it was given: it is resident, unless its plant has been closed. held(): added, here and below
  void confirm_taken(ChunkId id);
  /// It had no room: it is asked for again in a while.
  void confirm_refused(ChunkId id);
  /// It has freed one that came out of take_evicted. held(): dropped
  void confirm_freed(ChunkId id);

  [[nodiscard]] StreamStats stats() const;
  /// StreamStats::hand_over_ns
  [[nodiscard]] std::uint64_t hand_over_ns() const;

 private:
  struct State;
  explicit Streamer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace coppice
