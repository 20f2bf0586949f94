#pragma once

#include <cstdlib>
#include <filesystem>

#include "places.h"

namespace coppice::test {

/// The folder of third-party plants: $COPPICE_PLANTS, by default ../shared/plants beside the repository. They are no part of it: a test
/// that wants one skips, and says so, when it is absent.
inline std::filesystem::path plants_folder() {
  const char* folder = std::getenv("COPPICE_PLANTS");
  return folder != nullptr ? std::filesystem::path(folder) : std::filesystem::path(kDefaultPlants);
}

}  // namespace coppice::test

/// Skips the running test unless the plant is there; declares `variable`, its path.
#define COPPICE_PLANT_OR_SKIP(variable, file)                                     \
  const std::filesystem::path variable = coppice::test::plants_folder() / (file); \
  if (!std::filesystem::exists(variable))                                         \
  GTEST_SKIP() << variable.string() << " is absent; set COPPICE_PLANTS to the folder of third-party plants"
