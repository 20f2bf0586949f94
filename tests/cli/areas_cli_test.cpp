// coppice bake --areas vulkan from outside: a whole bake under validation, the same bytes again, and what is said where it cannot be.

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tool.h"

namespace coppice::test::areas_cli_test {

namespace fs = std::filesystem;

const Words kValidation = {"VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation",
                           "VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT"};
const Words kNoDriver = {"VK_DRIVER_FILES=/nonexistent.json", "VK_ICD_FILENAMES=/nonexistent.json"};
const Words kNoLoader = {std::string("LD_PRELOAD=") + kNoVulkanLibrary};

ProcessResult tool(const Words& arguments, const Words& environment = {}) {
  return run_tool(arguments, {.environment = environment});
}

class AreasCli : public testing::Test {
 protected:
  /// A hazel of 60 leaf quads: a bake of all 386 leaves takes a minute here.
  void SetUp() override {
    const std::string whole = folder_ / "whole.glb", baked = folder_ / "whole.coppice";
    ASSERT_EQ(tool({"plant", "corylus", "-o", whole}).exit_code, 0);
    ASSERT_EQ(tool({"bake", whole, "-o", baked, "--metric", "geometric", "--views", "1", "--resolution", "16"}).exit_code, 0);
    ASSERT_EQ(tool({"export", baked, "--leaves", "60", "-o", plant_}).exit_code, 0);
  }

  /// A quick bake by mutual information.
  [[nodiscard]] Words bake(const char* output, const Words& more) const {
    return joined({"bake", plant_, "-o", folder_ / output, "--metric", "mi", "--views", "2", "--resolution", "32", "--candidates", "2"},
                  more);
  }

  TemporaryFolder folder_;
  std::string plant_ = folder_ / "corylus.glb";
};

TEST_F(AreasCli, ABakeOfASmallPlantMeasuresEveryStepAndVerifies) {
  const ProcessResult baked = tool(bake("a.coppice", {"--areas", "vulkan", "--report", folder_ / "a.json"}), kValidation);
  ASSERT_EQ(baked.exit_code, 0) << baked.err;
  EXPECT_EQ(baked.err, "");
  EXPECT_EQ(count_of(baked.out, "\n"), 1u) << "validation has something to say:\n" << baked.out;
  const ProcessResult verified = tool({"verify", folder_ / "a.coppice"});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;

  const nlohmann::json areas = read_json(folder_ / "a.json")["areas"];
  EXPECT_EQ(areas["initial"], "vulkan");
  EXPECT_EQ(areas["steps"], "vulkan");
  EXPECT_NE(areas["device"], "");

  ASSERT_EQ(tool(bake("b.coppice", {"--areas", "vulkan", "--threads", "1", "--quiet"})).exit_code, 0);
  EXPECT_EQ(read_text(folder_ / "a.coppice"), read_text(folder_ / "b.coppice")) << "another bake on the same device";
}

TEST_F(AreasCli, ItemBuffersNeedNoVulkan) {
  for (const Words& more : {Words{}, {"--areas", "item-buffers"}}) {
    const ProcessResult baked = tool(bake("a.coppice", more), joined(kNoDriver, kNoLoader));
    EXPECT_EQ(baked.exit_code, 0) << baked.err;
  }
  const ProcessResult libraries = tool({}, {"LD_TRACE_LOADED_OBJECTS=1"});
  EXPECT_NE(libraries.out.find("libc.so"), std::string::npos) << libraries.out;
  EXPECT_EQ(libraries.out.find("vulkan"), std::string::npos) << libraries.out;
}

TEST_F(AreasCli, WithoutDriverOrLoaderOneLineSaysWhatToDo) {
  for (const Words& environment : {kNoDriver, kNoLoader}) {
    expect_one_line_error(tool(bake("a.coppice", {"--areas", "vulkan"}), environment),
                          {"corylus.glb", "Vulkan", "mesa-vulkan-drivers", "--areas"});
    EXPECT_FALSE(fs::exists(folder_ / "a.coppice"));
  }
}

TEST_F(AreasCli, OtherMetricsRefuseIt) {
  for (const char* metric : {"default", "geometric"}) {
    for (const std::string command : {"bake", "bake-all", "view"}) {
      const Words output = command == "view" ? Words{} : Words{"-o", folder_ / "out"};
      expect_failure(tool(joined({command, plant_, "--areas", "vulkan", "--metric", metric}, output)), {"--areas", "--metric mi"}, 2);
    }
  }
  EXPECT_EQ(tool(bake("a.coppice", {"--areas", "paper"})).exit_code, 2);
}

/// A list's entry has what the command does not; the cache keeps bakes of a device apart from others.
TEST_F(AreasCli, AListTakesItAndTheCacheTellsThemApart) {
  write_text(folder_ / "list.json", R"([
    {"input": "corylus.glb", "output": "a.coppice", "metric": "mi"},
    {"input": "corylus.glb", "output": "b.coppice", "metric": "mi", "areas": "vulkan"}])");
  const Words batch{
      "bake-all", folder_ / "list.json", "-o", folder_ / "out", "--views", "2", "--resolution", "32", "--candidates", "2", "--quiet",
      "--report", folder_ / "r.json"};
  const ProcessResult first = tool(batch);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const nlohmann::json plants = read_json(folder_ / "r.json")["plants"];
  EXPECT_NE(plants[0]["key"], plants[1]["key"]);
  ASSERT_EQ(tool(batch).exit_code, 0);
  EXPECT_EQ(read_json(folder_ / "r.json")["cached"], 2);
  // What is in the cache was measured by a device that may be another now.
  expect_failure(tool(batch, kNoDriver), {"Vulkan"});

  write_text(folder_ / "bad.json", R"([{"input": "corylus.glb", "areas": "vulkan"}])");
  expect_error(tool({"bake-all", folder_ / "bad.json", "-o", folder_ / "out"}), {"bad.json", "--areas", "--metric mi"});
}

}  // namespace coppice::test::areas_cli_test
