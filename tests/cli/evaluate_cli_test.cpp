// coppice evaluate from outside.

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.h"

namespace {

namespace fs = std::filesystem;
using coppice::test::ProcessResult;
using coppice::test::run_process;
using coppice::test::TemporaryFolder;

TEST(EvaluateCommand, WritesATableAndAFile) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", json = folder / "hazel.json";
  ASSERT_EQ(run_process(COPPICE_TOOL, {"plant", "corylus", "-o", plant}).exit_code, 0);
  const ProcessResult result =
      run_process(COPPICE_TOOL, {"evaluate", plant, "--methods", "geometric,stochastic", "--levels", ".2,.05", "--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  for (const char* part : {"hazel: 386 leaves", "level 0.200: 77 leaves", "level 0.050: 19 leaves", "geometric", "stochastic", "rmse_16"})
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  EXPECT_EQ(result.out.find("meshopt"), std::string::npos) << result.out;
  const auto parsed = nlohmann::json::parse(std::ifstream(json));
  EXPECT_EQ(parsed["methods"].size(), 2u);
  EXPECT_EQ(parsed["methods"][0]["levels"][0]["leaves"], 77);
}

TEST(EvaluateCommand, ErrorsAreOneLineAndUsageExitsWith2) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", json = folder / "hazel.json";
  ASSERT_EQ(run_process(COPPICE_TOOL, {"plant", "corylus", "-o", plant}).exit_code, 0);
  for (const auto& [option, value] : {std::pair{"--methods", "beauty"}, {"--levels", "1.5"}, {"--levels", "few"}, {"--levels", "0"}})
    EXPECT_EQ(run_process(COPPICE_TOOL, {"evaluate", plant, option, value, "--json", json}).exit_code, 2) << option << " " << value;
  const ProcessResult missing = run_process(COPPICE_TOOL, {"evaluate", folder / "nowhere.glb", "--json", json});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_NE(missing.err.find("nowhere.glb"), std::string::npos) << missing.err;
  const ProcessResult no_leaves = run_process(COPPICE_TOOL, {"evaluate", plant, "--leaf-material", "^petals$", "--json", json});
  EXPECT_EQ(no_leaves.exit_code, 1);
  EXPECT_NE(no_leaves.err.find("wood"), std::string::npos) << no_leaves.err;
  EXPECT_FALSE(fs::exists(json));
  const auto plant_bytes = fs::file_size(plant);
  EXPECT_EQ(run_process(COPPICE_TOOL, {"evaluate", plant, "--methods", "stochastic", "--json", plant}).exit_code, 1);
  EXPECT_EQ(fs::file_size(plant), plant_bytes) << "the input was overwritten";
  const ProcessResult nowhere =
      run_process(COPPICE_TOOL, {"evaluate", plant, "--methods", "stochastic", "--json", folder / "no/such.json"});
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_EQ(nowhere.out, "") << "it measured before it looked whether it can write";
}

}  // namespace
