// Measures plants as looks_test does, plants that anybody has: each file's plant at five distances on both paths beside full detail.
//
//     looks_report FOLDER ERROR_PX PLANT.coppice...       ERROR_PX: coppice_camera's error_px, 2 by default there
//
// One line a picture; what fails is marked, and FOLDER gets every picture: reference, picture, difference. Exit 1 if any fails.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>

#include "golden.h"
#include "looks_stage.h"

namespace {

namespace fs = std::filesystem;
using namespace coppice::test;

/// returns  whether all its pictures pass
bool report(const fs::path& folder, float error_px, const fs::path& plant) {
  LooksStage hardware(vulkan_device(), plant, LooksPath::hardware), compute(vulkan_device(), plant, LooksPath::compute);
  bool passed = true;
  for (const float size_px : {240.0f, 72.0f, 24.0f, 12.0f}) {
    const MeanPicture reference = hardware.draw({.sphere = hardware.sphere(), .size_px = size_px, .lod = COPPICE_LOD_FULL});
    const auto compare = [&](const char* path, LooksStage& stage) {
      const MeanPicture picture = stage.draw({.sphere = hardware.sphere(), .size_px = size_px, .error_px = error_px});
      const LooksDifference difference = compare_looks(reference, picture);
      const bool alike = looks_alike(difference);
      passed = passed && alike;
      std::printf("%s %s.%s.%.0f: %s\n", alike ? "    " : "FAIL", plant.stem().c_str(), path, size_px, describe(difference).c_str());
      write_png(folder / (plant.stem().string() + "." + path + "." + std::to_string(static_cast<int>(size_px)) + ".png"),
                side_by_side(reference, picture));
    };
    compare("hardware", hardware);
    compare("compute", compute);
  }
  return passed;
}

}  // namespace

int main(int argc, char** argv) {
  const float error_px = argc > 2 ? std::strtof(argv[2], nullptr) : 0.0f;
  if (argc < 4 || !(error_px > 0.0f)) {
    std::fprintf(stderr, "looks_report FOLDER ERROR_PX PLANT.coppice...: measures plants beside themselves in full detail\n");
    return 2;
  }
  bool passed = true;
  for (int i = 3; i < argc; ++i) try {
      fs::create_directories(argv[1]);
      passed = report(argv[1], error_px, argv[i]) && passed;
      std::fflush(stdout);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", argv[i], error.what());
      passed = false;
    }
  return passed ? 0 : 1;
}
