#pragma once

// The interface of the side that receives plants, chunks and instances from a context: our renderer (vulkan/vulkan_backend.h), or a host
// that draws itself (host/host_backend.h). The context decides what is loaded; a backend stores it.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "coppice/coppice.h"
#include "frame_counts.h"
#include "frame_wind.h"
#include "hooks.h"
#include "instances.h"
#include "ledger.h"
#include "result.h"
#include "select.h"
#include "streamer.h"

namespace coppice {

namespace gpu {
class Renderer;
}

/// Arguments of a backend's creation.
struct BackendOptions {
  const Hooks& hooks;  ///< without jobs: the backend is only measured, and takes memory of the ledger alone
  coppice_log log{};
  Ledger& ledger;  ///< outlives the backend; has no budget while the backend is made
  std::uint32_t max_instances = 0, max_plants = 0;
  std::uint64_t memory_budget_bytes = 0;
  bool block_textures = false;  ///< the one of coppice_context_desc
};
class Backend;
using MakeBackend = std::function<Result<std::unique_ptr<Backend>>(const BackendOptions&)>;

/// Limits of a backend, fixed at its creation.
struct BackendLimits {
  std::uint32_t max_instances = 0, max_plants = 0;
  std::uint32_t max_view_width_px = 0, max_view_height_px = 0;
  GpuSizes sizes;  ///< sizes of chunks, for the streamer
};

/// Numbers of objects to reserve memory for.
struct SceneSize {
  std::uint32_t slots = 0, plants = 0;
};

/// FrameCounts and GPU times of a recent frame.
struct ViewCounts : gpu::FrameCounts {
  std::array<float, COPPICE_PASS_COUNT> pass_ms{};
};

/// A change for a program that draws by itself, other than an added chunk.
struct BackendEvent {
  coppice_change_kind kind = COPPICE_CHANGE_NONE;
  coppice_plant plant = 0;
  ChunkId chunk;  ///< its plant is the file
};

/// Calls in a frame: begin_frame; show_view for each view; upload_chunk and drop_chunk, any number of times; end_upload.
/// Thread: externally serialised; const functions may overlap.
class Backend {
 public:
  Backend() = default;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;
  /// Nobody draws its contents any more.
  virtual ~Backend() = default;

  [[nodiscard]] virtual const BackendLimits& limits() const = 0;
  virtual void set_memory_budget(std::uint64_t bytes) = 0;
  /// Bytes that the backend takes from the ledger now.
  [[nodiscard]] virtual std::uint64_t reserved_bytes() const = 0;
  /// Bytes that it takes at least with these slots and a budget once chunks are gone; and once buffers have shrunk and pictures are gone,
  /// if there are no more slots than now.
  [[nodiscard]] virtual std::uint64_t lasting_bytes(std::uint32_t slots, std::uint64_t budget_bytes) = 0;
  /// Makes buffers smaller that are larger than these slots, or the budget, need. False: call it again in the next frame
  [[nodiscard]] virtual bool shrink(std::uint32_t slots) = 0;
  /// Gives back the pictures of all views in the next upload, in which frames make those that they need if they fit.
  virtual void release_pictures() = 0;
  /// errors  device_lost: now or earlier
  [[nodiscard]] virtual Result<void> device_state() const = 0;
  virtual void fill_stats(coppice_stats& stats) const = 0;

  /// Number of plants with reserved memory.
  [[nodiscard]] virtual std::uint32_t plant_capacity() const = 0;
  /// Bytes that reserve() takes from the ledger at once.
  [[nodiscard]] virtual std::uint64_t reserve_bytes(const SceneSize& needed) = 0;
  /// needed: within limits(). errors  out_of_memory; nothing has changed
  virtual Result<void> reserve(const SceneSize& needed) = 0;
  /// Temporary bytes for taking over this many new slots in one frame.
  [[nodiscard]] virtual std::uint64_t slot_upload_bytes(std::uint32_t slot_count) const = 0;

  /// plant: an unused slot. lod_words: pack_lod_table of the file. errors  out_of_memory
  virtual Result<void> add_plant(std::uint32_t plant, const PlantFile& file, const gpu::PlantAppearance& appearance,
                                 std::span<const std::uint32_t> lod_words) = 0;
  /// Before: frames that drew the plant are finished, and its chunks have been dropped.
  virtual void remove_plant(std::uint32_t plant) = 0;

  virtual void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number, const FrameWind& wind) = 0;
  /// Bytes of chunks that upload_chunk accepts in this frame.
  [[nodiscard]] virtual std::uint64_t staging_bytes() const = 0;
  /// Copies at most about max_bytes of a chunk (a page whole), and returns true once the chunk is whole. Further calls go on from there, in
  /// this frame or in later ones. One chunk is uploaded in parts at a time; others may come in between, whole: with max_bytes UINT64_MAX.
  /// errors  out_of_memory: the chunk is not resident, try again; others: it never will be
  virtual Result<bool> upload_chunk(const DecodedChunk& chunk, std::uint64_t max_bytes) = 0;
  /// Forgets the chunk that is being uploaded in parts.
  virtual void abandon_upload() = 0;
  /// From here on no new frame may draw the chunk. drop_chunk follows once the frames that may have drawn it are finished.
  virtual void hide_chunk(ChunkId id) = 0;
  virtual void drop_chunk(ChunkId id) = 0;
  /// plants: all that were ever added, with what may be drawn of them. errors  out_of_memory: the frame draws nothing
  virtual Result<void> end_upload(gpu::InstanceTable& instances, std::span<const LodPlant> plants) = 0;

  /// view: the backend's own index, here and below
  virtual void remove_view(std::uint32_t view) = 0;
  virtual void show_view(std::uint32_t view, const coppice_camera& camera, const LodView& lod) = 0;
  [[nodiscard]] virtual bool has_reversed_depth(std::uint32_t view) const = 0;
  /// What the backend has drawn; nothing if the program draws by itself.
  [[nodiscard]] virtual std::optional<ViewCounts> view_counts(std::uint32_t view) const = 0;

  /// Keeps an event for next_event. True if the program will acknowledge that it has freed a dropped chunk.
  virtual bool tell(const BackendEvent&) { return false; }
  /// The first event that has not been handed out.
  virtual std::optional<BackendEvent> next_event() { return std::nullopt; }
  /// Our renderer; null if the program draws by itself.
  [[nodiscard]] virtual gpu::Renderer* renderer() { return nullptr; }
};

}  // namespace coppice
