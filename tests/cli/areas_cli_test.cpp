// coppice bake --areas vulkan from outside: a whole bake under validation, the same bytes again, and what is said where it cannot be.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "mentions.h"
#include "places.h"
#include "process.h"
#include "text_files.h"

namespace areas_cli_test {

namespace fs = std::filesystem;
using coppice::test::mentions;
using coppice::test::ProcessOptions;
using coppice::test::ProcessResult;
using coppice::test::read_text;
using coppice::test::TemporaryFolder;

const std::vector<std::string> kValidation = {"VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation",
                                              "VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT"};
const std::vector<std::string> kNoDriver = {"VK_DRIVER_FILES=/nonexistent.json", "VK_ICD_FILENAMES=/nonexistent.json"};

ProcessResult coppice_tool(const std::vector<std::string>& arguments, const std::vector<std::string>& environment = {}) {
  ProcessOptions options;
  options.environment = environment;
  return coppice::test::run_process(coppice::test::kTool, arguments, options);
}

nlohmann::json read_json(const fs::path& path) {
  return nlohmann::json::parse(read_text(path));
}

class AreasCli : public testing::Test {
 protected:
  /// A hazel of 60 leaf quads: a bake of all 386 leaves takes a minute here.
  void SetUp() override {
    const std::string whole = folder_ / "whole.glb", baked = folder_ / "whole.coppice";
    ASSERT_EQ(coppice_tool({"plant", "corylus", "-o", whole}).exit_code, 0);
    ASSERT_EQ(coppice_tool({"bake", whole, "-o", baked, "--metric", "geometric", "--views", "1", "--resolution", "16"}).exit_code, 0);
    ASSERT_EQ(coppice_tool({"export", baked, "--leaves", "60", "-o", plant_}).exit_code, 0);
  }

  /// A quick bake by mutual information.
  [[nodiscard]] std::vector<std::string> bake(const char* output, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"bake", plant_,         "-o", folder_ / output, "--metric", "mi", "--views",
                                       "2",    "--resolution", "32", "--candidates",   "2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  TemporaryFolder folder_;
  std::string plant_ = folder_ / "corylus.glb";
};

TEST_F(AreasCli, ABakeOfASmallPlantMeasuresEveryStepAndVerifies) {
  const ProcessResult baked = coppice_tool(bake("a.coppice", {"--areas", "vulkan", "--report", folder_ / "a.json"}), kValidation);
  ASSERT_EQ(baked.exit_code, 0) << baked.err;
  EXPECT_EQ(baked.err, "");
  EXPECT_EQ(std::count(baked.out.begin(), baked.out.end(), '\n'), 1) << "validation has something to say:\n" << baked.out;
  const ProcessResult verified = coppice_tool({"verify", folder_ / "a.coppice"});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;

  const nlohmann::json areas = read_json(folder_ / "a.json")["areas"];
  EXPECT_EQ(areas["initial"], "vulkan");
  EXPECT_EQ(areas["steps"], "vulkan");
  EXPECT_NE(areas["device"], "");

  ASSERT_EQ(coppice_tool(bake("b.coppice", {"--areas", "vulkan", "--threads", "1", "--quiet"})).exit_code, 0);
  EXPECT_EQ(read_text(folder_ / "a.coppice"), read_text(folder_ / "b.coppice")) << "another bake on the same device";
}

TEST_F(AreasCli, ItemBuffersNeedNoVulkan) {
  std::vector<std::string> environment = kNoDriver;
  environment.push_back(std::string("LD_PRELOAD=") + coppice::test::kNoVulkanLibrary);
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--areas", "item-buffers"}}) {
    const ProcessResult baked = coppice_tool(bake("a.coppice", more), environment);
    EXPECT_EQ(baked.exit_code, 0) << baked.err;
  }
  const ProcessResult libraries = coppice_tool({}, {"LD_TRACE_LOADED_OBJECTS=1"});
  EXPECT_NE(libraries.out.find("libc.so"), std::string::npos) << libraries.out;
  EXPECT_EQ(libraries.out.find("vulkan"), std::string::npos) << libraries.out;
}

TEST_F(AreasCli, WithoutDriverOrLoaderOneLineSaysWhatToDo) {
  const std::vector<std::string> no_loader = {std::string("LD_PRELOAD=") + coppice::test::kNoVulkanLibrary};
  for (const auto& environment : {kNoDriver, no_loader}) {
    const ProcessResult baked = coppice_tool(bake("a.coppice", {"--areas", "vulkan"}), environment);
    EXPECT_EQ(baked.exit_code, 1);
    EXPECT_EQ(std::count(baked.err.begin(), baked.err.end(), '\n'), 1) << baked.err;
    EXPECT_TRUE(mentions(baked.err, {"corylus.glb", "Vulkan", "mesa-vulkan-drivers", "--areas"}));
    EXPECT_FALSE(fs::exists(folder_ / "a.coppice"));
  }
}

TEST_F(AreasCli, OtherMetricsRefuseIt) {
  for (const char* metric : {"default", "geometric"}) {
    for (const std::string command : {"bake", "bake-all", "view"}) {
      std::vector<std::string> arguments{command, plant_, "--areas", "vulkan", "--metric", metric};
      if (command != "view") arguments.insert(arguments.end(), {"-o", folder_ / "out"});
      const ProcessResult refused = coppice_tool(arguments);
      EXPECT_EQ(refused.exit_code, 2) << command;
      EXPECT_TRUE(mentions(refused.err, {"--areas", "--metric mi"}));
    }
  }
  EXPECT_EQ(coppice_tool(bake("a.coppice", {"--areas", "paper"})).exit_code, 2);
}

/// A list's entry has what the command does not; the cache keeps bakes of a device apart from others.
TEST_F(AreasCli, AListTakesItAndTheCacheTellsThemApart) {
  std::ofstream(folder_ / "list.json") << R"([
    {"input": "corylus.glb", "output": "a.coppice", "metric": "mi"},
    {"input": "corylus.glb", "output": "b.coppice", "metric": "mi", "areas": "vulkan"}])";
  const std::vector<std::string> batch{
      "bake-all", folder_ / "list.json", "-o", folder_ / "out", "--views", "2", "--resolution", "32", "--candidates", "2", "--quiet",
      "--report", folder_ / "r.json"};
  const ProcessResult first = coppice_tool(batch);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const nlohmann::json plants = read_json(folder_ / "r.json")["plants"];
  EXPECT_NE(plants[0]["key"], plants[1]["key"]);
  ASSERT_EQ(coppice_tool(batch).exit_code, 0);
  EXPECT_EQ(read_json(folder_ / "r.json")["cached"], 2);
  // What is in the cache was measured by a device that may be another now.
  const ProcessResult without = coppice_tool(batch, kNoDriver);
  EXPECT_EQ(without.exit_code, 1);
  EXPECT_TRUE(mentions(without.err, {"Vulkan"}));

  std::ofstream(folder_ / "bad.json") << R"([{"input": "corylus.glb", "areas": "vulkan"}])";
  const ProcessResult bad = coppice_tool({"bake-all", folder_ / "bad.json", "-o", folder_ / "out"});
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_TRUE(mentions(bad.err, {"bad.json", "--areas", "--metric mi"}));
}

}  // namespace areas_cli_test
