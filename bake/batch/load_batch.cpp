#include "load_batch.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "batch_caches.h"
#include "batch_result_json.h"
#include "cached_bake.h"
#include "job_processes.h"

namespace coppice::bake {
namespace {

// More than there are processors: they wait for a server.
constexpr std::size_t kMostJobs = 8;
// A process for each of many would cost more than the look.
constexpr std::size_t kMostPlantsOfJob = 8;

/// Whether it is worth while to go on.
class Search {
 public:
  void looked_for(const BatchResult& result) {
    ++looked_;
    if (result.outcome == BatchOutcome::cached) ++found_;
  }
  [[nodiscard]] bool is_over() const {
    constexpr double kSeconds = 5.0;
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count() > kSeconds && 2 * found_ < looked_;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::size_t looked_ = 0, found_ = 0;
};

}  // namespace

Result<std::vector<BatchResult>> load_batch(const std::vector<BatchPlant>& plants, BatchOptions options) {
  options.other_batches = true;
  options.explain = false;
  options.shared.only_indexed = true;
  const std::size_t plants_of_job = std::clamp<std::size_t>(plants.size() / (4 * kMostJobs), 1, kMostPlantsOfJob);
  const std::size_t job_count = (plants.size() + plants_of_job - 1) / plants_of_job;
  const std::size_t at_a_time = std::clamp<std::size_t>(job_count, 1, kMostJobs);
  COPPICE_TRY(caches, BatchCaches::open(options, at_a_time));
  std::vector<BatchResult> results(plants.size());
  Search search;

  JobCallbacks callbacks;
  // In a process of its own, with what the search was when that began.
  callbacks.run = [&](std::size_t job, const JobProgress&) {
    std::vector<BatchResult> looked_for;
    const std::size_t first = job * plants_of_job, end = std::min(first + plants_of_job, plants.size());
    for (std::size_t plant = first; plant < end && !search.is_over(); ++plant) {
      looked_for.push_back(load_one(plants[plant], caches.jobs()));
      search.looked_for(looked_for.back());
    }
    return nlohmann::json(looked_for).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  };
  callbacks.progressed = [](std::size_t, double) {};
  callbacks.ended = [&](std::size_t job, const JobEnd& end) {
    if (!end.failure.empty()) return;  // whoever bakes them finds out why
    std::size_t plant = job * plants_of_job;
    for (BatchResult& result : nlohmann::json::parse(end.result).get<std::vector<BatchResult>>()) {
      search.looked_for(result);
      if (result.outcome == BatchOutcome::cached)
        caches.ended(result);
      else if (plants[plant].failure.empty())
        caches.missed();
      results[plant++] = std::move(result);
    }
  };
  run_jobs(job_count, at_a_time, callbacks);
  const CacheReport report = caches.finish();
  if (options.cache_reported) options.cache_reported(report);
  return results;
}

}  // namespace coppice::bake
