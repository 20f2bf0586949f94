// How the bake grows with the number of leaves, and what it gains over doing it naively.
//   growth_table METHOD,... LEAVES...   METHOD is default or mi. The same crown (filled_crown) with so many leaves, each bake in a process
//                                       of its own: seconds of wall clock and of all cores, evaluations, peak memory, and the exponent of
//                                       the growth from 5,000 to 77,000 leaves once both have been baked.
//   growth_table naive LEAVES           mi against naive_collapse on one plant; fails if the sequences differ. 400 leaves take minutes.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "alpha_mask.h"
#include "bake.h"
#include "collapse_image.h"
#include "collapse_information.h"
#include "job_processes.h"
#include "naive_collapse.h"
#include "stopwatch.h"
#include "test_foliage.h"

namespace coppice::bake {
namespace {

Result<CollapseResult> collapse(const std::string& method, const Foliage& foliage) {
  const Metric metric = method == "mi" ? Metric::mi : Metric::default_metric;
  const std::vector<Viewpoint> views = *viewpoints(metric_view_count(metric, foliage.leaf_count()));
  if (metric == Metric::mi) return collapse_by_mutual_information({foliage, test::plain_materials(), {}}, views, CollapseOptions{}, {});
  return collapse_by_image_error({foliage, test::plain_materials(), {}}, views, CollapseOptions{}, ImageErrorOptions{}, {});
}

/// Processor time of this process, all threads.
double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Cost {
  double wall_seconds = 0.0, cpu_seconds = 0.0;
  std::uint64_t evaluations = 0;
  double peak_mib = 0.0;
};

/// One collapse in a process of its own, as is its peak memory then. evaluations 0: it failed
Cost measure(const std::string& method, std::uint32_t leaf_count) {
  Cost cost;
  const test::Stopwatch watch;
  JobCallbacks callbacks;
  callbacks.run = [&](std::size_t, const JobProgress&) {
    const auto result = collapse(method, test::filled_crown(leaf_count, 1));
    return std::to_string(result ? result->sequence.evaluations : 0) + " " + std::to_string(cpu_seconds());
  };
  callbacks.progressed = [](std::size_t, double) {};
  callbacks.ended = [&](std::size_t, const JobEnd& end) {
    std::istringstream(end.result) >> cost.evaluations >> cost.cpu_seconds;
    cost.peak_mib = static_cast<double>(end.peak_rss_bytes) / (1 << 20);
  };
  run_jobs(1, 1, callbacks);
  cost.wall_seconds = watch.seconds();
  return cost;
}

int print_growth(const std::string& method, const std::vector<std::uint32_t>& leaf_counts) {
  std::map<std::uint32_t, Cost> costs;
  for (const std::uint32_t leaf_count : leaf_counts) {
    const Cost cost = measure(method, leaf_count);
    if (cost.evaluations == 0) return std::fprintf(stderr, "%s: no collapse of %u leaves\n", method.c_str(), leaf_count), 1;
    std::printf("%-8s %7u leaves %8.1f s wall %8.1f s of cores %9llu evaluations %9.0f evaluations per core second %7.0f MiB\n",
                method.c_str(), leaf_count, cost.wall_seconds, cost.cpu_seconds, static_cast<unsigned long long>(cost.evaluations),
                static_cast<double>(cost.evaluations) / cost.cpu_seconds, cost.peak_mib);
    std::fflush(stdout);
    costs[leaf_count] = cost;
  }
  const auto few = costs.find(5000), many = costs.find(77000);
  if (few != costs.end() && many != costs.end()) {
    const double growth = std::log(77000.0 / 5000.0);
    std::printf("%-8s from 5000 to 77000 leaves: exponent %.2f of core seconds, %.2f of evaluations\n", method.c_str(),
                std::log(many->second.cpu_seconds / few->second.cpu_seconds) / growth,
                std::log(static_cast<double>(many->second.evaluations) / static_cast<double>(few->second.evaluations)) / growth);
  }
  return 0;
}

bool same(const Merge& a, const Merge& b) {
  return a.first == b.first && a.second == b.second && a.corners == b.corners;
}

int print_naive(std::uint32_t leaf_count) {
  test::NaiveScene scene;
  scene.source = test::filled_crown(leaf_count, 1);
  scene.views = *viewpoints(20);
  scene.masks = *alpha_masks(test::plain_materials(), {});
  const double start = cpu_seconds();
  const auto result = collapse("mi", scene.source);
  const double collapsed = cpu_seconds();
  const CollapseSequence naive = test::naive_collapse(scene);
  const double seconds = collapsed - start, naive_seconds = cpu_seconds() - collapsed;
  const auto& merges = result->sequence.merges;
  const bool is_same = std::equal(merges.begin(), merges.end(), naive.merges.begin(), naive.merges.end(), same);
  std::printf("%u leaves: %.2f s of cores; naive_collapse %.1f s, %.0f times as much; sequences %s\n", leaf_count, seconds, naive_seconds,
              naive_seconds / seconds, is_same ? "the same" : "DIFFER");
  return is_same ? 0 : 1;
}

int run(const std::vector<std::string>& words) {
  std::vector<std::uint32_t> leaf_counts;
  for (std::size_t i = 1; i < words.size(); ++i)
    leaf_counts.push_back(static_cast<std::uint32_t>(std::strtoul(words[i].c_str(), nullptr, 10)));
  if (leaf_counts.empty() || std::count(leaf_counts.begin(), leaf_counts.end(), 0u) > 0) return 2;
  if (words[0] == "naive") return print_naive(leaf_counts[0]);
  std::istringstream methods(words[0]);
  for (std::string method; std::getline(methods, method, ',');) {
    if (method != "mi" && method != "default") return 2;
    if (const int failed = print_growth(method, leaf_counts); failed != 0) return failed;
  }
  return 0;
}

}  // namespace
}  // namespace coppice::bake

int main(int argument_count, char** arguments) {
  const int status = coppice::bake::run(std::vector<std::string>(arguments + 1, arguments + argument_count));
  if (status == 2) std::fprintf(stderr, "usage: growth_table default,mi LEAVES... | growth_table naive LEAVES\n");
  return status;
}
