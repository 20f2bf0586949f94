#pragma once

// Pictures of coppice-forest, drawn by another process under validation: how drivers are compared.

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "made_once.h"
#include "places.h"
#include "process.h"

namespace coppice::test {

struct ForestScene {
  const char* species = "";
  const char* count = "";  ///< how many plants; one fills the picture
  const char* path = "";   ///< what --path gets
};

/// For names of cases: "corylus_near_compute".
inline std::string name_of(const ForestScene& scene) {
  return std::string(scene.species) + (std::string(scene.count) == "1" ? "_near_" : "_far_") + scene.path;
}

/// The folder of one plant, baked.
inline std::filesystem::path baked_for_drivers(const std::string& species) {
  return made_once(species + "_for_drivers", [&](const std::filesystem::path& folder) {
    const std::filesystem::path plant = folder / (species + ".glb");
    const auto run = [](const std::vector<std::string>& arguments) {
      const ProcessResult result = run_process(kTool, arguments);
      if (result.exit_code != 0) throw std::runtime_error(result.err);
    };
    run({"plant", species, "-o", plant});
    run({"bake", plant, "-o", folder / (species + ".coppice"), "--quick", "--quiet"});
  });
}

/// Draws 256 x 256 px. png  written when it succeeds; environment  NAME=VALUE, before those of this process
inline ProcessResult draw_forest(const ForestScene& scene, const std::filesystem::path& png, const std::vector<std::string>& environment) {
  // A driver that says that it is a GPU is still a processor, which others may be using: it gets as long as one that does not.
  return run_process(kForest,
                     {"--plants", baked_for_drivers(scene.species), "--count", scene.count, "--path", scene.path, "--size", "256x256",
                      "--frames", "2", "--no-taa", "--headless", "--gpu-wait-s", "600", "--validation", "--screenshot", png},
                     {.environment = environment});
}

}  // namespace coppice::test
