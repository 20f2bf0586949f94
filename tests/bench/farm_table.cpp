// What a cluster of two nodes with a processor each takes for a batch, against bake-all on one of these processors: generated plants of the
// three species, each of a seed of its own, in small views. Needs Slurm (slurm_cluster.h), root and two idle processors.
//   farm_table [PLANTS [VIEWS [RESOLUTION]]]     200, 8, 96

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "process.h"
#include "slurm_cluster.h"
#include "text_files.h"

namespace {

namespace fs = std::filesystem;
using namespace coppice::test;

double seconds_of(const std::string& program, const std::vector<std::string>& arguments, const ProcessOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const ProcessResult result = run_process(program, arguments, options);
  if (result.exit_code != 0) throw std::runtime_error(program + ": " + result.err);
  const std::size_t last = result.out.find_last_of('\n', result.out.size() - 2);
  std::printf("%s", result.out.substr(last == std::string::npos ? 0 : last + 1).c_str());
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void measure(const std::string& count, const std::string& views, const std::string& resolution) {
  const TemporaryFolder folder;
  const fs::path plants = folder / "plants";
  fs::create_directories(plants);
  const char* const species[] = {"corylus", "juniper", "willow"};
  for (int i = 0; i < std::stoi(count); ++i) {
    const std::string name = species[i % 3] + std::to_string(i) + ".glb";
    if (run_process(COPPICE_TOOL, {"plant", species[i % 3], "-o", plants / name, "--seed", std::to_string(i)}).exit_code != 0)
      throw std::runtime_error("cannot grow " + name);
  }
  const std::vector<std::string> bake{"bake-all", plants, "--views", views, "--resolution", resolution, "--candidates", "4", "-o"};
  const auto with = [&](std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), bake.begin(), bake.end());
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const double one = seconds_of(program_on_path("taskset"), with({"--cpu-list", "0", COPPICE_TOOL}, {folder / "one"}), {});
  const SlurmCluster cluster(2);
  const double two = seconds_of(COPPICE_TOOL, with({}, {folder / "two", "--slurm"}), cluster.environment());
  const double warm = seconds_of(COPPICE_TOOL, with({}, {folder / "two", "--slurm"}), cluster.environment());
  std::printf("%s plants: %.1f s on one processor, %.1f s on two nodes: %.3f of half; warm %.1f s; bytes are %s\n", count.c_str(), one, two,
              two / (one / 2.0), warm,
              outputs(folder / "one", ".coppice-") == outputs(folder / "two", ".coppice-") ? "equal" : "NOT EQUAL");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string missing = SlurmCluster::missing();
    if (!missing.empty()) throw std::runtime_error(missing);
    measure(argc > 1 ? argv[1] : "200", argc > 2 ? argv[2] : "8", argc > 3 ? argv[3] : "96");
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "farm_table: %s\n", error.what());
    return 1;
  }
}
