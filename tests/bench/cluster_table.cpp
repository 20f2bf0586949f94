// What a cluster of two nodes with a processor each takes for a batch, against bake-all on one of these processors, and against two shards
// by hand, one on each, at the same time: nodes on one machine share its memory, which real ones do not. Generated plants of the three
// species, each of a seed of its own, in small views. Needs Slurm (slurm_cluster.h), root and two idle processors.
//   cluster_table [PLANTS [VIEWS [RESOLUTION]]]     200, 8, 96

#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>

#include "slurm_cluster.h"
#include "stopwatch.h"
#include "tool.h"

namespace {

namespace fs = std::filesystem;
using namespace coppice::test;

double seconds_of(const std::string& program, const Words& arguments, const ProcessOptions& options) {
  const Stopwatch watch;
  const ProcessResult result = run_process(program, arguments, options);
  if (result.exit_code != 0) throw std::runtime_error(program + ": " + result.err);
  const double seconds = watch.seconds();
  const std::size_t last = result.out.find_last_of('\n', result.out.size() - 2);
  std::printf("%s", result.out.substr(last == std::string::npos ? 0 : last + 1).c_str());
  return seconds;
}

void measure(const std::string& count, const std::string& views, const std::string& resolution) {
  const TemporaryFolder folder;
  const fs::path plants = folder / "plants";
  fs::create_directories(plants);
  const char* const species[] = {"corylus", "juniper", "willow"};
  for (int i = 0; i < std::stoi(count); ++i) {
    const std::string name = species[i % 3] + std::to_string(i) + ".glb";
    if (run_tool({"plant", species[i % 3], "-o", plants / name, "--seed", std::to_string(i)}).exit_code != 0)
      throw std::runtime_error("cannot grow " + name);
  }
  const Words bake{"bake-all", plants, "--views", views, "--resolution", resolution, "--candidates", "4", "-o"};
  const auto with = [&](const Words& words, const Words& more) { return joined(joined(words, bake), more); };
  const auto shard = [&](const char* processor, const char* folder_name, const char* part) {
    return seconds_of(program_on_path("taskset"), with({"--cpu-list", processor, kTool}, {folder / folder_name, "--shard", part}), {});
  };
  // Machines are faster at some times than at others: one half of it before the rest and one after.
  const double before = shard("0", "one", "1/2");
  const Stopwatch watch;
  std::thread other([&] { shard("1", "hand", "2/2"); });
  shard("0", "hand", "1/2");
  other.join();
  const double hand = watch.seconds();
  double two = 0.0, warm = 0.0;
  {
    const SlurmCluster cluster(2);
    two = seconds_of(kTool, with({}, {folder / "two", "--slurm"}), cluster.environment());
    warm = seconds_of(kTool, with({}, {folder / "two", "--slurm"}), cluster.environment());
  }
  const double one = before + shard("0", "one", "2/2");
  const auto files = [&](const char* name) { return outputs(folder / name, ".coppice-"); };
  std::printf(
      "%s plants: %.1f s on one processor; two shards by hand %.1f s, %.3f of half; two nodes %.1f s, %.3f of half, %.3f of by hand; "
      "warm %.1f s; bytes are %s\n",
      count.c_str(), one, hand, hand / (one / 2.0), two, two / (one / 2.0), two / hand, warm,
      files("one") == files("two") && files("one") == files("hand") ? "equal" : "NOT EQUAL");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string missing = SlurmCluster::missing();
    if (!missing.empty()) throw std::runtime_error(missing);
    measure(argc > 1 ? argv[1] : "200", argc > 2 ? argv[2] : "8", argc > 3 ? argv[3] : "96");
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cluster_table: %s\n", error.what());
    return 1;
  }
}
