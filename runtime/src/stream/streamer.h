#pragma once

// Keeps those chunks of the open plants in memory that show most on screen, under the ledger's budget. It calls no Vulkan function and owns
// no thread: reads go through the I/O hook, decoding through the jobs hook, and the GPU side uploads the chunks of take_decoded().
//
// Calls in a frame, on the caller's thread:
//   release            the GPU has finished every frame that referred to these: the GPU side frees their memory now
//   take_closed_plants everything of these plants has been released; open_plant may use their index again
//   begin_frame        collects finished reads and decodes, orders requests, cancels stale ones, evicts, starts reads. Never blocks
//   take_evicted       the GPU side stops referring to these from this frame on
//   take_decoded       the GPU side copies these: begin_upload() for each, then uploaded() or upload_failed()
//   state              after uploaded(): the resident prefix that limits cuts
//
// Foliage pages become and stay resident in order: the resident ones are always a prefix of the refinement, so a complete plant.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "chunk_form.h"
#include "demand.h"
#include "hooks.h"
#include "ledger.h"
#include "mesh_clusters.h"
#include "page_clusters.h"
#include "reader.h"
#include "residency.h"
#include "tree.h"

namespace coppice {

/// What chunks become on the GPU side, and the memory that they need there; the streamer reserves it before it starts a read.
struct GpuSizes {
  std::uint64_t plant_bytes = 0;                 ///< per open plant: tables, descriptors
  std::uint64_t slack_bytes = 0;                 ///< stays free beside all chunks, for the rounding of images and buffers
  const ChunkForm* form = &cluster_form(false);  ///< outlives the streamer
  bool block_textures = false;                   ///< BC1 and BC3 are read; otherwise textures come out of take_decoded() as RGBA8
};

/// The source that a plant is read from.
struct PlantSource {
  const char* name = "";                     ///< a path, or for memory the log's name for it. Copied when the plant is opened
  std::span<const std::uint8_t> bytes = {};  ///< memory that stays until the plant is closed; empty: a file

  PlantSource() = default;
  PlantSource(const char* path_or_name, std::span<const std::uint8_t> memory = {}) : name(path_or_name), bytes(memory) {}
};

struct StreamerOptions {
  GpuSizes gpu;
  std::uint32_t max_plants = 64;     ///< arrays by plant grow as plants are opened
  std::uint32_t max_in_flight = 16;  ///< sum of reads and decodes
  /// Time per frame for taking over finished reads and decodes and for starting reads; at least one of each is. The rest waits for the
  /// next frame.
  std::uint64_t hand_over_budget_ns = UINT64_MAX;
  std::uint64_t (*clock_ns)() = now_ns;  ///< also for the pauses of ReadRetry
};

/// A chunk to upload. Spans and pointers stay valid until uploaded(), upload_failed() or the next begin_frame().
struct DecodedChunk {
  ChunkId id;
  std::uint64_t bytes = 0;  ///< its memory on the GPU
  bool pinned = false;      ///< the plant cannot be drawn without it

  // page: nodes first_node .. first_node + nodes.size() - 1
  std::uint32_t first_node = 0;  ///< 2 * COPPICE_PAGE_SPLITS * index + 1
  std::span<const PageNode> nodes;
  std::span<std::uint8_t> clusters;      ///< gpu::kPageBytes, written by gpu::build_page
  gpu::ReadyCuts* ready_cuts = nullptr;  ///< for page 0

  gpu::MeshBlock* mesh = nullptr;  ///< for wood and leaf meshes

  // texture: a coppice_file_texture and its mip levels, checked; as stored, or decoded to RGBA8 without GpuSizes::block_textures
  std::span<const std::uint8_t> texture;
};

/// Bounds in object space, m.
struct PlantBox {
  std::array<float, 3> low{}, high{};
};
/// Its corners are in 1 / kBoxSteps of the box.
using BoxTriangle = std::array<QuantisedPoint, 3>;
inline constexpr float kBoxSteps = 65535.0f;

/// The parts of a plant that can be drawn now.
struct PlantState {
  std::uint32_t resident_page_count = 0;
  std::uint32_t resident_leaf_count = 1;  ///< leaves of the finest cut
  std::uint32_t resident_wood_mask = 0;   ///< bit i: wood LoD i
  std::uint64_t resident_texture_count = 0;
  bool leaf_meshes_resident = false;  ///< all of them, and the textures that only they show
};

/// A view group: its demand for each plant at one threshold.
struct ViewGroup {
  LodView view;                          ///< threshold and mode
  std::span<const PlantDemand> demands;  ///< by plant index; plants beyond its end have no demand
};

struct StreamFrame {
  std::uint64_t frame_number = 1;  ///< number of the frame that begins; grows
  std::uint64_t spent_ns = 0;      ///< time of hand_over_budget_ns that is spent already
  /// A view group keeps its index from frame to frame. The demand is the maximum over all groups; without a group nothing more is in demand
  /// than what is resident.
  std::array<std::optional<ViewGroup>, kMaxViewGroups> view_groups;
};

struct ChunkCounts {
  std::uint64_t loaded = 0;  ///< became resident
  std::uint64_t evicted = 0;
  std::uint64_t failed = 0;
  std::uint64_t cancelled = 0;  ///< reads that were cancelled
  std::uint32_t in_flight = 0;  ///< being read or decoded
  std::uint32_t wanted = 0;     ///< in demand by a view at the threshold in use, not resident
  std::uint32_t queued = 0;     ///< the wanted ones that are not requested yet
};

struct StreamStats {
  std::array<ChunkCounts, kChunkKindCount> chunks;  ///< by ChunkKind
  std::uint64_t bytes_read = 0;                     ///< returned by reads, failed ones too
  std::uint64_t decode_ns = 0;                      ///< sum over finished jobs
  std::uint64_t hand_over_ns = 0;                   ///< time of the last begin_frame that counts for hand_over_budget_ns

  /// Sum over all kinds.
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

  /// Opens a file, reads its front through the I/O hook (which blocks, also for retries of a failed read), checks it and decodes page 0 and
  /// the coarsest wood inline; they come out of the next take_decoded(). Returns the plant's index, < max_plants. errors  io, bad_file (one
  /// log line names file, field and byte); out_of_memory: the hook, the budget, or max_plants are open
  Result<std::uint32_t> open_plant(const PlantSource& source);

  /// Opens without waiting and returns the index at once; finish_open, called from time to time, tells the result. Up to kMaxOpening
  /// plants are read and decoded at a time. If memory is short there are kOpenAttempts attempts, kOpenRetryFrames apart. errors
  /// out_of_memory: max_plants are open; not logged
  Result<std::uint32_t> start_open(const PlantSource& source);
  /// Returns nothing while the plant is being opened. Afterwards the plant is open, or it failed and its index is free again.
  /// plant  from start_open, neither finished nor cancelled (asserted), here and below. errors  as open_plant, logged
  [[nodiscard]] std::optional<Result<void>> finish_open(std::uint32_t plant);
  /// Does not wait: the index is free once running work has come back.
  void cancel_open(std::uint32_t plant);
  static constexpr std::size_t kMaxOpening = 8;
  static constexpr std::uint32_t kOpenAttempts = 8;
  static constexpr std::uint64_t kOpenRetryFrames = 30;

  /// Ends all demand for the plant. Its chunks come out of take_evicted and release, then its index out of take_closed_plants.
  /// plant  an open index (asserted)
  void close_plant(std::uint32_t plant);

  /// The file has no small_textures. plant  an open index (asserted); the reference stays valid until the plant comes out of
  /// take_closed_plants
  [[nodiscard]] const PlantFile& file(std::uint32_t plant) const;
  [[nodiscard]] const PlantBox& box(std::uint32_t plant) const;
  /// Triangles of the coarsest wood, in the box.
  [[nodiscard]] std::span<const BoxTriangle> coarse_wood(std::uint32_t plant) const;
  /// The packed table of select.h, for the GPU to copy and for the CPU to select with.
  [[nodiscard]] std::span<const std::uint32_t> lod_words(std::uint32_t plant) const;
  [[nodiscard]] gpu::PlantAppearance appearance(std::uint32_t plant) const;
  [[nodiscard]] PlantState state(std::uint32_t plant) const;
  /// The nodes of a resident page. Valid until the next begin_frame
  [[nodiscard]] std::span<const PageNode> page_nodes(std::uint32_t plant, std::uint32_t page) const;
  /// True if everything of the plant that was in demand in the last begin_frame, and can be had, is resident.
  [[nodiscard]] bool is_settled(std::uint32_t plant) const;
  /// The same for the demand of a view group for every plant. group: < kMaxViewGroups
  [[nodiscard]] bool is_group_settled(std::size_t group) const;
  /// The threshold in use: the group's own, or higher if the demand of all groups does not fit the budget; 0: every leaf, or the group had
  /// no view in the last frame.
  [[nodiscard]] float threshold_px(std::size_t group) const;
  /// The plant's file, or its name.
  [[nodiscard]] const char* path(std::uint32_t plant) const;
  /// The name is valid as long as the plant is open.
  [[nodiscard]] PlantSource source(std::uint32_t plant) const;
  [[nodiscard]] bool is_open(std::uint32_t plant) const;

  /// The error for bytes that the ledger has refused.
  [[nodiscard]] Error refusal(std::uint64_t bytes) const;
  /// Bytes of the ledger that are reserved for chunks that may be evicted, and for plants that are closing.
  [[nodiscard]] std::uint64_t evictable_bytes() const;

  /// Valid until the next release. completed_number  the GPU has finished every frame up to this one
  [[nodiscard]] std::span<const ChunkId> release(std::uint64_t completed_number);
  /// Those since the last call. Valid until the next release
  [[nodiscard]] std::span<const std::uint32_t> take_closed_plants();

  /// Enforces the ledger's budget, and frees as much as was refused lately, as far as chunks that are not pinned can be evicted.
  void begin_frame(const StreamFrame& frame);

  /// Those since the last call. Valid until the next begin_frame
  [[nodiscard]] std::span<const ChunkId> take_evicted();

  /// Chunks to upload, by value, and pages of a plant in order, at most about max_bytes of GPU memory but at least one chunk if there is
  /// one. A chunk is handed out again until uploaded() acknowledges it.
  [[nodiscard]] std::span<const DecodedChunk> take_decoded(std::uint64_t max_bytes);
  /// Releases the bytes that were reserved for the chunk on the GPU and for a copy on its way; the GPU side reserves them now. False if a
  /// chunk of the last take_decoded does not wait any more: the failure of a page takes the later pages of its plant with it. Until
  /// uploaded() or upload_failed(), perhaps in a later frame, it is neither handed out again nor evicted, and its data stays valid.
  bool begin_upload(ChunkId id);
  /// Ends what begin_upload began without a result. The plant: may be closing
  void abandon_upload(ChunkId id);
  /// The copy is recorded in this frame's commands. id: begin_upload was true; pages of a plant in order (asserted).
  void uploaded(ChunkId id);
  /// The GPU side could not upload it. out_of_memory: it is requested again later; other errors: it has failed. Logged here.
  /// id: begin_upload was true (asserted)
  void upload_failed(ChunkId id, const Error& error);

  // For a host that acknowledges each chunk; these replace take_decoded to upload_failed.

  /// Hands out the waiting chunk of the highest value, if there is one. Its pointers are valid until it is acknowledged. One page of a
  /// plant at a time.
  [[nodiscard]] std::optional<DecodedChunk> next_pending();
  /// What the host has to acknowledge for a chunk.
  enum class Pending : std::uint8_t { no, added, dropped };
  /// Any plant and chunk.
  [[nodiscard]] Pending pending(ChunkId id) const;
  /// The host has copied a chunk: it is resident, unless its plant has been closed. before, here and below: pending() is added
  void acknowledge_taken(ChunkId id);
  /// The host had no memory for it: it is offered again later.
  void acknowledge_refused(ChunkId id);
  /// A chunk that came out of take_evicted is not released before acknowledge_freed().
  void await_freed(ChunkId id);
  /// The host has freed it. before: pending() is dropped
  void acknowledge_freed(ChunkId id);

  /// Lets chunks that have failed be requested again. Unreadable ones are read again after some seconds by themselves.
  void retry_failed();

  [[nodiscard]] StreamStats stats() const;
  /// StreamStats::hand_over_ns
  [[nodiscard]] std::uint64_t hand_over_ns() const;

 private:
  struct State;
  explicit Streamer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace coppice
