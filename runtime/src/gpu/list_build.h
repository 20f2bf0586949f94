#pragma once

// Lists of the compute rasteriser on their way: a hold on all that they are built from, so that a job may build them while chunks come and
// go, and the job itself.

#include <array>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "card_looks.h"
#include "coppice/coppice.h"
#include "crown_light.h"
#include "leaf_lists.h"
#include "raster_shared.h"
#include "tree.h"
#include "wood_codec.h"

namespace coppice::gpu {

/// What all lists of a plant are built from. The pointers' contents never change.
struct ListSource {
  std::shared_ptr<const PlantLooks> looks;
  std::shared_ptr<const CrownLight> light;
  LeafBox box;
  std::uint32_t leaf_count = 0;  ///< of the whole plant
};

/// Lists of one plant that share a buffer: some cuts, or a mesh.
struct ListBuild {
  std::uint32_t plant = 0;
  std::uint64_t generation = 0;  ///< of the plant
  std::uint32_t first = 0;       ///< of the plant's lists
  ListSource source;
  std::vector<std::uint32_t> leaf_counts;  ///< of the cuts, growing; none: a mesh
  PageNode root;
  std::vector<SharedNodes> pages;  ///< those of the finest
  WoodMesh mesh;
  std::uint64_t kept_bytes = 0;  ///< CPU memory it takes until its lists are on the device, at most; without pages

  // Out of build_lists.
  std::vector<RasterList> headers;                      ///< [leaf_counts], or of the mesh; none where its triangles are not to be drawn
  std::vector<std::array<std::uint64_t, 3>> addresses;  ///< of each: of its clusters, leaves and splats in `bytes`
  std::vector<std::uint8_t> bytes;
};

/// Any thread.
void build_lists(ListBuild& build);

/// One job at a time. Thread: externally serialised; the job itself runs wherever the hook runs it.
class ListJob {
 public:
  ListJob() = default;
  ListJob(const ListJob&) = delete;
  ListJob& operator=(const ListJob&) = delete;
  /// Waits for a running job.
  ~ListJob();

  /// idle() before. jobs: without a hook they are built before this returns
  void start(std::vector<ListBuild> builds, const coppice_jobs& jobs);
  /// The builds of a job that has ended; none while it runs or where there was none. idle() after, unless it runs.
  std::vector<ListBuild> take();
  /// Nothing runs and nothing waits to be taken.
  [[nodiscard]] bool idle() const { return builds_.empty(); }
  [[nodiscard]] std::uint64_t kept_bytes() const { return kept_bytes_; }
  /// While it runs, nothing but what they are built from may be looked at.
  [[nodiscard]] std::span<const ListBuild> builds() const { return builds_; }

 private:
  static void run(void* job);

  std::vector<ListBuild> builds_;  ///< the job's while running_
  std::uint64_t kept_bytes_ = 0;   ///< of the builds
  std::mutex mutex_;
  std::condition_variable ended_;
  bool running_ = false;
};

}  // namespace coppice::gpu
