// Measures how plants are lit: each file's plant at five distances, on both paths and under eight suns beside full detail.
//
//     light_report ERROR_PX PLANT.coppice...       ERROR_PX: coppice_camera's error_px, 2 by default there
//
// A line for each distance and path: by how many per cent the mean luminance and the mean of a colour channel of the plant's pixels are
// off under the eight suns, in the mean and at worst; what the plant covers; and the root mean squared differences of luminance on a meadow
// and before dark trees.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <vector>

#include "leaf_shade.h"
#include "looks_stage.h"

namespace {

namespace fs = std::filesystem;
using namespace coppice::test;

constexpr glm::vec3 kMeadow(96, 122, 58), kTrees(38, 48, 28);

std::vector<glm::vec3> eight_suns() {
  std::vector<glm::vec3> suns;
  for (const float height : {0.3f, 1.1f})  // radians
    for (const float turn : {0.4f, 2.0f, 3.5f, 5.1f})
      suns.emplace_back(std::cos(height) * std::cos(turn), std::sin(height), std::cos(height) * std::sin(turn));
  return suns;
}

struct Sums {
  double luminance = 0, worst_luminance = 0, channel = 0, worst_channel = 0;  ///< per cent off
  double coverage = 0, meadow = 0, trees = 0;
};

void add_off(double off, double& mean, double& worst) {
  mean += off / 8;
  worst = std::abs(off) > std::abs(worst) ? off : worst;
}

void add(const MeanPicture& reference, const MeanPicture& picture, Sums& sums) {
  const glm::vec3 expected = mean_color(reference), found = mean_color(picture);
  const float luminance = coppice::bake::luminance(expected);
  add_off(100.0 * (coppice::bake::luminance(found) / luminance - 1.0f), sums.luminance, sums.worst_luminance);
  double channel = 0;
  for (int i = 0; i < 3; ++i) {
    const double off = 100.0 * static_cast<double>(found[i] - expected[i]) / static_cast<double>(std::max(luminance, 1.0f));
    channel = std::abs(off) > std::abs(channel) ? off : channel;
  }
  add_off(channel, sums.channel, sums.worst_channel);
  sums.coverage += compare_looks(reference, picture).coverage / 8;
  sums.meadow += rmse_on(reference, picture, kMeadow) / 8;
  sums.trees += rmse_on(reference, picture, kTrees) / 8;
}

void report(float error_px, const fs::path& plant) {
  LooksStage hardware(vulkan_device(), plant, LooksPath::hardware), compute(vulkan_device(), plant, LooksPath::compute);
  for (const float size_px : {240.0f, 120.0f, 60.0f, 24.0f, 12.0f}) {
    Sums sums[2];
    float turn = 0;
    for (const glm::vec3& sun : eight_suns()) {
      LooksView view{.sphere = hardware.sphere(),
                     .size_px = size_px,
                     .lod = COPPICE_LOD_FULL,
                     .error_px = error_px,
                     .sun = sun,
                     .mean_of_light = true};
      view.from = {std::cos(turn), 0.25f, std::sin(turn)};
      turn += 0.7f;
      const MeanPicture reference = hardware.draw(view);
      view.lod = COPPICE_LOD_CUT;
      add(reference, hardware.draw(view), sums[0]);
      add(reference, compute.draw(view), sums[1]);
    }
    for (int path = 0; path < 2; ++path)
      std::printf(
          "%s %3.0f px %s: luminance %+.1f (%+.1f) %%, channel %+.1f (%+.1f) %%, coverage %.3f, rmse %.2f on a meadow, %.2f before trees\n",
          plant.stem().c_str(), static_cast<double>(size_px), path == 0 ? "hardware" : "compute ", sums[path].luminance,
          sums[path].worst_luminance, sums[path].channel, sums[path].worst_channel, sums[path].coverage, sums[path].meadow,
          sums[path].trees);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const float error_px = argc > 1 ? std::strtof(argv[1], nullptr) : 0.0f;
  if (argc < 3 || !(error_px > 0.0f)) {
    std::fprintf(stderr, "light_report ERROR_PX PLANT.coppice...: measures the light of plants beside themselves in full detail\n");
    return 2;
  }
  int status = 0;
  for (int i = 2; i < argc; ++i) try {
      report(error_px, argv[i]);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", argv[i], error.what());
      status = 1;
    }
  return status;
}
