#include "mesh_build.h"

#include <utility>

#include "check.h"

namespace coppice::gpu {

void build_mesh(MeshBuild& build) {
  const auto& [looks, light, box] = build.source;
  build.clusters = build.list < kMeshLists ? build_wood(build.mesh, {*looks, *light}) : build_leaf_mesh(build.mesh, {*looks, box, *light});
}

MeshJob::~MeshJob() {
  std::unique_lock lock(mutex_);
  ended_.wait(lock, [this] { return !running_; });
}

// Notifies under the lock: the waiter may destroy the job as soon as it can take it.
void MeshJob::run(void* argument) {
  auto* job = static_cast<MeshJob*>(argument);
  for (MeshBuild& build : job->builds_) build_mesh(build);
  const std::lock_guard lock(job->mutex_);
  job->running_ = false;
  job->ended_.notify_all();
}

void MeshJob::start(std::vector<MeshBuild> builds, const coppice_jobs& jobs) {
  COPPICE_ASSERT(idle());
  if (builds.empty()) return;
  builds_ = std::move(builds);
  for (const MeshBuild& build : builds_) kept_bytes_ += build.kept_bytes;
  running_ = true;  // nobody else looks yet
  if (jobs.submit != nullptr)
    jobs.submit(jobs.user, run, this);
  else
    run(this);
}

std::vector<MeshBuild> MeshJob::take() {
  const std::lock_guard lock(mutex_);
  if (running_) return {};
  kept_bytes_ = 0;
  return std::exchange(builds_, {});
}

}  // namespace coppice::gpu
