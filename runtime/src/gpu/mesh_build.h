#pragma once

// Clusters of wood and of leaf meshes on their way: a hold on all that they are built from, so that a job may build them while chunks come
// and go, and the job itself.

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "card_looks.h"
#include "coppice/coppice.h"
#include "crown_light.h"
#include "mesh_clusters.h"
#include "wood_codec.h"

namespace coppice::gpu {

/// What all meshes of a plant are built with. The pointers' contents never change.
struct MeshSource {
  std::shared_ptr<const PlantLooks> looks;
  std::shared_ptr<const CrownLight> light;
  LeafBox box;
};

struct MeshBuild {
  std::uint32_t plant = 0;
  std::uint64_t generation = 0;  ///< of the plant
  std::uint32_t list = 0;        ///< of the plant's, from kWoodLists on
  MeshSource source;
  WoodMesh mesh;
  std::uint64_t kept_bytes = 0;  ///< CPU memory it takes until it is on the device, at most

  MeshClusters clusters;  ///< out of build_mesh
};

/// Any thread.
void build_mesh(MeshBuild& build);

/// One job at a time. Thread: externally serialised; the job itself runs wherever the hook runs it.
class MeshJob {
 public:
  MeshJob() = default;
  MeshJob(const MeshJob&) = delete;
  MeshJob& operator=(const MeshJob&) = delete;
  /// Waits for a running job.
  ~MeshJob();

  /// idle() before. jobs: without a hook they are built before this returns
  void start(std::vector<MeshBuild> builds, const coppice_jobs& jobs);
  /// The builds of a job that has ended; none while it runs or where there was none. idle() after, unless it runs.
  std::vector<MeshBuild> take();
  /// Nothing runs and nothing waits to be taken.
  [[nodiscard]] bool idle() const { return builds_.empty(); }
  [[nodiscard]] std::uint64_t kept_bytes() const { return kept_bytes_; }
  [[nodiscard]] std::size_t count() const { return builds_.size(); }

 private:
  static void run(void* job);

  std::vector<MeshBuild> builds_;  ///< the job's while running_
  std::uint64_t kept_bytes_ = 0;   ///< of the builds
  std::mutex mutex_;
  std::condition_variable ended_;
  bool running_ = false;
};

}  // namespace coppice::gpu
