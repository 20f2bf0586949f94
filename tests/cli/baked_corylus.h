#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "places.h"
#include "process.h"

namespace coppice::test {

/// Corylus, baked small: quick, and looks are judged elsewhere.
inline std::filesystem::path bake_corylus(const TemporaryFolder& folder, const std::vector<std::string>& options = {}) {
  const std::string glb = folder / "corylus.glb", coppice = folder / "corylus.coppice";
  const ProcessResult grown = run_process(test::kTool, {"plant", "corylus", "-o", glb});
  EXPECT_EQ(grown.exit_code, 0) << grown.err;
  std::vector<std::string> arguments{"bake", glb, "-o", coppice, "--resolution", "64", "--quiet"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const ProcessResult baked = run_process(test::kTool, arguments);
  EXPECT_EQ(baked.exit_code, 0) << baked.err;
  return coppice;
}

}  // namespace coppice::test
