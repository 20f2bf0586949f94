// What a cluster of two nodes with a processor each takes for a batch, against bake-all on one of these processors, and against two shards
// by hand, one on each, at the same time: nodes on one machine share its memory, which real ones do not. Generated plants of the three
// species, each of a seed of its own, in small views. Needs Slurm (servers.h), root and two idle processors.
//   cluster_table [PLANTS [VIEWS [RESOLUTION]]]     200, 8, 96

#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>

#include "servers.h"
#include "stopwatch.h"
#include "tool.h"

namespace {

namespace fs = std::filesystem;
using namespace coppice::test;

/// Prints the last line of what the program prints.
double seconds_of(const std::string& program, const Words& arguments, const ProcessOptions& options = {}) {
  const Stopwatch watch;
  const ProcessResult result = run_process(program, arguments, options);
  const double seconds = watch.seconds();
  if (result.exit_code != 0) throw std::runtime_error(program + ": " + result.err);
  std::printf("%s", result.out.substr(result.out.find_last_of('\n', result.out.size() - 2) + 1).c_str());
  return seconds;
}

void measure(int count, const std::string& views, const std::string& resolution) {
  const TemporaryFolder folder;
  const fs::path plants = folder / "plants";
  fs::create_directories(plants);
  const char* const species[] = {"corylus", "juniper", "willow"};
  for (int i = 0; i < count; ++i) {
    const std::string name = species[i % 3] + std::to_string(i) + ".glb";
    if (run_tool({"plant", species[i % 3], "-o", plants / name, "--seed", std::to_string(i)}).exit_code != 0)
      throw std::runtime_error("cannot grow " + name);
  }
  const Words bake{"bake-all", plants, "--views", views, "--resolution", resolution, "--candidates", "4", "-o"};
  const auto shard = [&](const char* processor, const char* out, const char* part) {
    const Words on_processor{"--cpu-list", processor, kTool};
    return seconds_of(program_on_path("taskset"), joined(joined(on_processor, bake), {folder / out, "--shard", part}));
  };
  // Machines are faster at some times than at others: one half of it before the rest and one after.
  const double before = shard("0", "one", "1/2");
  const Stopwatch watch;
  std::thread other([&] { shard("1", "hand", "2/2"); });
  shard("0", "hand", "1/2");
  other.join();
  const double hand = watch.seconds();
  const auto on_cluster = [&](const SlurmCluster& cluster) {
    return seconds_of(kTool, joined(bake, {folder / "two", "--slurm"}), cluster.environment());
  };
  double two = 0.0, warm = 0.0;
  {
    const SlurmCluster cluster;
    two = on_cluster(cluster);
    warm = on_cluster(cluster);
  }
  const double one = before + shard("0", "one", "2/2");
  const auto files = [&](const char* name) { return outputs(folder / name, ".coppice-"); };
  std::printf(
      "%d plants: %.1f s on one processor; two shards by hand %.1f s, %.3f of half; two nodes %.1f s, %.3f of half, %.3f of by hand; "
      "warm %.1f s; bytes are %s\n",
      count, one, hand, hand / (one / 2.0), two, two / (one / 2.0), two / hand, warm,
      files("one") == files("two") && files("one") == files("hand") ? "equal" : "NOT EQUAL");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (const std::string missing = SlurmCluster::missing(); !missing.empty()) throw std::runtime_error(missing);
    measure(argc > 1 ? std::stoi(argv[1]) : 200, argc > 2 ? argv[2] : "8", argc > 3 ? argv[3] : "96");
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cluster_table: %s\n", error.what());
    return 1;
  }
}
