#include "list_build.h"

#include <cstring>
#include <span>
#include <utility>

#include "check.h"

namespace coppice::gpu {
namespace {

/// returns  where in `bytes` they begin
template <class T>
std::uint64_t append(std::vector<std::uint8_t>& bytes, const std::vector<T>& values) {
  const std::size_t at = bytes.size();
  bytes.resize(at + values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(bytes.data() + at, values.data(), values.size() * sizeof(T));
  return at;
}

void add_list(ListBuild& build, const BuiltList& list) {
  build.headers.push_back(list.header);
  auto& [clusters, leaves, splats] = build.addresses.emplace_back();
  clusters = append(build.bytes, list.clusters);
  leaves = append(build.bytes, list.leaves);
  splats = append(build.bytes, list.splats);
}

BuiltList build_mesh_list(const ListBuild& build) {
  const auto& [looks, light, box, leaf_count] = build.source;
  if (build.first < kRasterMeshes) return build_wood_list(build.mesh, {*looks, *light});
  return build_leaf_mesh_list(build.mesh, {*looks, box, *light});
}

}  // namespace

void build_lists(ListBuild& build) {
  const auto& [looks, light, box, leaf_count] = build.source;
  for (const std::uint32_t count : build.leaf_counts)
    add_list(build, build_leaf_list({build.root, build.pages, looks->looks, box, *light, leaf_count}, count));
  if (!build.leaf_counts.empty()) return;
  const BuiltList list = build_mesh_list(build);
  if (!list.leaves.empty()) add_list(build, list);
}

ListJob::~ListJob() {
  std::unique_lock lock(mutex_);
  ended_.wait(lock, [this] { return !running_; });
}

// Notifies under the lock: the waiter may destroy the job as soon as it can take it.
void ListJob::run(void* argument) {
  auto* job = static_cast<ListJob*>(argument);
  for (ListBuild& build : job->builds_) build_lists(build);
  const std::lock_guard lock(job->mutex_);
  job->running_ = false;
  job->ended_.notify_all();
}

void ListJob::start(std::vector<ListBuild> builds, const coppice_jobs& jobs) {
  COPPICE_ASSERT(idle());
  if (builds.empty()) return;
  builds_ = std::move(builds);
  for (const ListBuild& build : builds_) kept_bytes_ += build.kept_bytes;
  running_ = true;  // nobody else looks yet
  if (jobs.submit != nullptr)
    jobs.submit(jobs.user, run, this);
  else
    run(this);
}

std::vector<ListBuild> ListJob::take() {
  const std::lock_guard lock(mutex_);
  if (running_) return {};
  kept_bytes_ = 0;
  return std::exchange(builds_, {});
}

}  // namespace coppice::gpu
