// Pictures of coppice-forest on a second Vulkan driver beside those of the first.

#include <filesystem>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "golden.h"
#include "made_once.h"
#include "mentions.h"
#include "places.h"
#include "process.h"

namespace drivers_test {

namespace fs = std::filesystem;
using coppice::test::Picture;
using coppice::test::ProcessResult;
using coppice::test::run_process;
using coppice::test::TemporaryFolder;

struct Scene {
  const char* species = "";
  const char* count = "";  ///< of plants; of one the picture is full
  const char* path = "";   ///< of --path
};

/// The folder of one plant, baked.
fs::path baked(const std::string& species) {
  return coppice::test::made_once(species + "_for_drivers", [&](const fs::path& folder) {
    const fs::path plant = folder / (species + ".glb");
    const auto run = [](const std::vector<std::string>& arguments) {
      const ProcessResult result = run_process(coppice::test::kTool, arguments);
      if (result.exit_code != 0) throw std::runtime_error(result.err);
    };
    run({"plant", species, "-o", plant});
    run({"bake", plant, "-o", folder / (species + ".coppice"), "--quick", "--quiet"});
  });
}

std::vector<std::string> arguments_of(const Scene& scene) {
  return {"--plants", baked(scene.species), "--count", scene.count, "--path",     scene.path,    "--size",
          "256x256",  "--frames",           "2",       "--no-taa",  "--headless", "--validation"};
}

Picture picture_of(const Scene& scene, const char* driver, const std::vector<std::string>& environment) {
  const TemporaryFolder folder;
  const fs::path png = folder / "picture.png";
  std::vector<std::string> arguments = arguments_of(scene);
  arguments.insert(arguments.end(), {"--screenshot", png});
  const ProcessResult result = run_process(coppice::test::kForest, arguments, {.environment = environment});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(coppice::test::mentions(result.out, {driver}));
  EXPECT_TRUE(coppice::test::mentions(result.out, {"validation messages  0"})) << result.out << result.err;
  return coppice::test::read_png(png);
}

std::string name_of_scene(const testing::TestParamInfo<Scene>& scene) {
  return std::string(scene.param.species) + (std::string(scene.param.count) == "1" ? "_near_" : "_far_") + scene.param.path;
}

class Drivers : public testing::TestWithParam<Scene> {};

TEST_P(Drivers, DrawTheSame) {
  if (std::string(coppice::test::kSwiftShader).ends_with("NOTFOUND")) GTEST_SKIP() << "no SwiftShader: Debian has it in chromium-common";
  const Picture first = picture_of(GetParam(), "llvmpipe", {});
  const Picture second = picture_of(GetParam(), "SwiftShader", {std::string("VK_DRIVER_FILES=") + coppice::test::kSwiftShader});
  EXPECT_LT(coppice::test::rmse(first, second), 0.06 * 255.0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Drivers,
                         testing::Values(Scene{"corylus", "1", "compute"}, Scene{"corylus", "1", "hardware"},
                                         Scene{"corylus", "400", "compute"}, Scene{"corylus", "400", "hardware"},
                                         Scene{"willow", "1", "compute"}, Scene{"willow", "1", "hardware"},
                                         Scene{"willow", "400", "compute"}, Scene{"willow", "400", "hardware"},
                                         Scene{"juniper", "1", "compute"}, Scene{"juniper", "1", "hardware"},
                                         Scene{"juniper", "400", "compute"}, Scene{"juniper", "400", "hardware"}),
                         name_of_scene);

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
  const ProcessResult result = run_process(coppice::test::kForest, arguments_of({"corylus", "400", GetParam()}),
                                           {.environment = {"VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_BEST_PRACTICES_EXT"}});
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

}  // namespace drivers_test
