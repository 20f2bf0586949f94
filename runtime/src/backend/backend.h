#pragma once

// What a context asks of the side that takes plants, chunks and instances from it: our renderer (vulkan/vulkan_backend.h), or a host that
// draws itself (host/host_backend.h). The context decides what is there; a backend keeps it.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "coppice/coppice.h"
#include "frame_counts.h"
#include "frame_wind.h"
#include "hooks.h"
#include "instances.h"
#include "ledger.h"
#include "plant_residency.h"
#include "result.h"
#include "select.h"
#include "streamer.h"

namespace coppice {

class HostBackend;
namespace gpu {
class Renderer;
}

/// What a backend is made with.
struct BackendOptions {
  const Hooks& hooks;  ///< without jobs: it is only measured, and takes no memory but the ledger's
  coppice_log log{};
  Ledger& ledger;  ///< outlives it; without a budget while it is made
  std::uint32_t max_instances = 0, max_plants = 0;
  std::uint64_t memory_budget_bytes = 0;
  bool block_textures = false;  ///< coppice_context_desc's
};
class Backend;
using MakeBackend = std::function<Result<std::unique_ptr<Backend>>(const BackendOptions&)>;

/// What a backend can hold; fixed once it is created.
struct BackendLimits {
  std::uint32_t max_instances = 0, max_plants = 0;
  std::uint32_t max_view_width_px = 0, max_view_height_px = 0;
  GpuSizes sizes;  ///< of chunks, for the streamer
};

/// How many there is to be room for.
struct SceneSize {
  std::uint32_t slots = 0, plants = 0;
};

/// FrameCounts, and GPU times of a recent frame.
struct ViewCounts : gpu::FrameCounts {
  std::array<float, COPPICE_PASS_COUNT> pass_ms{};
};

/// A frame: begin_frame; show_view of its views; upload_chunk and drop_chunk, any number of times; end_upload.
/// Thread: externally serialised; const functions may overlap.
class Backend {
 public:
  Backend() = default;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;
  /// Nobody draws what it holds any more.
  virtual ~Backend() = default;

  [[nodiscard]] virtual const BackendLimits& limits() const = 0;
  /// The least memory budget that holds what takes taken_bytes of the ledger now, before any plant.
  [[nodiscard]] virtual std::uint64_t least_budget_bytes(std::uint64_t taken_bytes) const = 0;
  virtual void set_memory_budget(std::uint64_t bytes) = 0;
  /// errors  device_lost: now or earlier
  [[nodiscard]] virtual Result<void> device_state() const = 0;
  virtual void fill_stats(coppice_stats& stats) const = 0;

  /// Plants that there is room for.
  [[nodiscard]] virtual std::uint32_t plant_capacity() const = 0;
  /// What reserve takes of the ledger at once.
  [[nodiscard]] virtual std::uint64_t reserve_bytes(const SceneSize& wanted) = 0;
  /// wanted: within limits(). errors  out_of_memory; nothing has changed
  virtual Result<void> reserve(const SceneSize& wanted) = 0;
  /// What taking over new slots, up to so many, in one frame takes on the way.
  [[nodiscard]] virtual std::uint64_t slot_upload_bytes(std::uint32_t slot_count) const = 0;

  /// plant: its slot, not in use. lod_words: pack_lod_table of the file. errors  out_of_memory
  virtual Result<void> add_plant(std::uint32_t plant, const PlantFile& file, const gpu::PlantAppearance& appearance,
                                 std::span<const std::uint32_t> lod_words) = 0;
  /// Frames that drew the plant are finished, and its chunks have been dropped.
  virtual void remove_plant(std::uint32_t plant) = 0;

  virtual void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number, const FrameWind& wind) = 0;
  /// For chunks that upload_chunk may take in this frame, bytes; a larger one than limits().sizes.most_staged_bytes needs none.
  [[nodiscard]] virtual std::uint64_t staging_bytes() const = 0;
  /// errors  out_of_memory: the chunk is not there; others: it never will be
  virtual Result<void> upload_chunk(const DecodedChunk& chunk) = 0;
  /// No frame that begins from here on may draw the chunk; drop_chunk follows once those that may have are finished.
  virtual void hide_chunk(ChunkId id) = 0;
  virtual void drop_chunk(ChunkId id) = 0;
  /// residency: [plants], of all that were ever added. errors  out_of_memory: the frame draws nothing
  virtual Result<void> end_upload(gpu::InstanceTable& instances, std::span<const gpu::PlantResidency> residency) = 0;

  /// view: an index of the backend's own, here and below.
  virtual void remove_view(std::uint32_t view) = 0;
  virtual void show_view(std::uint32_t view, const coppice_camera& camera, const LodView& lod) = 0;
  [[nodiscard]] virtual bool has_reversed_depth(std::uint32_t view) const = 0;
  [[nodiscard]] virtual ViewCounts view_counts(std::uint32_t view) const = 0;

  /// Which of the two it is; null: the other.
  [[nodiscard]] virtual gpu::Renderer* renderer() { return nullptr; }
  [[nodiscard]] virtual HostBackend* host() { return nullptr; }
};

}  // namespace coppice
