// Pictures of coppice-forest on a second Vulkan driver beside those of the first.

#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "forest_picture.h"
#include "golden.h"
#include "tool.h"

namespace coppice::test::drivers_test {

Picture picture_of(const ForestScene& scene, const char* driver, const Words& environment) {
  const TemporaryFolder folder;
  const std::filesystem::path png = folder / "picture.png";
  const ProcessResult result = draw_forest(scene, png, environment);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {driver, "validation messages  0"})) << result.err;
  return read_png(png);
}

class Drivers : public testing::TestWithParam<ForestScene> {};

TEST_P(Drivers, DrawTheSame) {
  if (std::string(kSwiftShader).ends_with("NOTFOUND")) GTEST_SKIP() << "no SwiftShader: Debian has it in chromium-common";
  const Picture first = picture_of(GetParam(), "llvmpipe", {});
  const Picture second = picture_of(GetParam(), "SwiftShader", {std::string("VK_DRIVER_FILES=") + kSwiftShader});
  EXPECT_LT(rmse(first, second), 0.06 * 255.0);
}

std::vector<ForestScene> scenes() {
  std::vector<ForestScene> all;
  for (const char* species : {"corylus", "willow", "juniper"})
    for (const char* count : {"1", "400"})
      for (const char* path : {"compute", "hardware"}) all.push_back({species, count, path});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Drivers, testing::ValuesIn(scenes()),
                         [](const testing::TestParamInfo<ForestScene>& scene) { return name_of(scene.param); });

// What the validation layer calls bad practice, and here is none.
const std::set<std::string> kFine = {
    "ImageBarrierAccessLayout",                // it does not know VK_ACCESS_2_SHADER_SAMPLED_READ_BIT
    "SpirvDeprecated_WorkgroupSize",           // sizes of groups are constants; its other way needs maintenance4
    "TransitionUndefinedToReadOnly",           // an image that is bound and never read, where there are no shadows
    "vkAllocateMemory-small-allocation",       // a small scene
    "vkBindMemory-small-dedicated-allocation"  // the demo's own images
};

class BestPractices : public testing::TestWithParam<const char*> {};

TEST_P(BestPractices, AreKeptButForThoseListed) {
  const TemporaryFolder folder;
  const ProcessResult result = draw_forest({"corylus", "400", GetParam()}, folder / "picture.png",
                                           {"VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_BEST_PRACTICES_EXT"});
  const std::string out = result.out + result.err;
  const std::regex message("Validation (?:Warning|Error|Performance Warning): \\[ ([^ ]+) \\]");
  std::set<std::string> found;
  for (std::sregex_iterator it(out.begin(), out.end(), message), end; it != end; ++it) {
    const std::string id = (*it)[1];
    const std::string prefix = "UNASSIGNED-BestPractices-";
    found.insert(id.starts_with(prefix) ? id.substr(prefix.size()) : id);
  }
  EXPECT_TRUE(found.contains("SpirvDeprecated_WorkgroupSize")) << "the layer did not look:\n" << out;
  for (const std::string& id : found) EXPECT_TRUE(kFine.contains(id)) << id << ":\n" << out.substr(0, 4000);
}

INSTANTIATE_TEST_SUITE_P(Paths, BestPractices, testing::Values("hardware", "compute"),
                         [](const auto& path) { return std::string(path.param); });

}  // namespace coppice::test::drivers_test
