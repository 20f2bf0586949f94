// Pictures of coppice-forest on other people's devices: those of the driver as it is, or a refusal that says what is missing.

#include <algorithm>
#include <filesystem>
#include <map>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "device_environment.h"
#include "device_rows.h"
#include "forest_picture.h"
#include "golden.h"
#include "mentions.h"

namespace coppice::test::limits_picture_test {

constexpr ForestScene kNear{"corylus", "1", "compute"}, kFar{"corylus", "400", "compute"}, kFarHardware{"corylus", "400", "hardware"};

bool lacks(const DeviceRow& row, std::string_view feature) {
  return std::ranges::find(row.missing_features, feature, [](const char* name) { return std::string_view(name); }) !=
         row.missing_features.end();
}

/// A picture under validation that nothing was refused for.
Picture picture_of(const ForestScene& scene, const std::vector<std::string>& environment) {
  const TemporaryFolder folder;
  const std::filesystem::path png = folder / "picture.png";
  const ProcessResult result = draw_forest(scene, png, environment);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"validation messages  0"})) << result.out << result.err;
  EXPECT_FALSE(stands_in(result.err, "limits_layer")) << result.err;
  return read_png(png);
}

/// The driver's, which is a GPU too: drawn once a process.
const Picture& reference(const ForestScene& scene) {
  static std::map<std::string, Picture> drawn;
  const std::string name = name_of(scene);
  if (!drawn.contains(name)) drawn[name] = picture_of(scene, environment_of_device("driver"));
  return drawn[name];
}

struct Case {
  const char* row;
  ForestScene scene;
};

void PrintTo(const Case& it, std::ostream* out) {
  *out << it.row << " " << name_of(it.scene);
}

class Limits : public testing::TestWithParam<Case> {};

TEST_P(Limits, ThePictureIsTheDriversOwn) {
  const DeviceRow& row = *find_row(GetParam().row);
  ForestScene drawn_as = GetParam().scene;
  const std::uint32_t storage_buffers = row.limits.maxPerStageDescriptorStorageBuffers;
  // Without enough of them the hardware draws whatever the path.
  if (storage_buffers != 0 && storage_buffers < 15) drawn_as.path = "hardware";
  const Picture picture = picture_of(GetParam().scene, environment_of_device(row.name));
  // Nothing that a device may do otherwise changes a pixel, but for textures that are decoded on the way in: their texels are rounded to
  // 8 bits before they are filtered, 0.14 in these scenes.
  EXPECT_LE(rmse(reference(drawn_as), picture), lacks(row, "textureCompressionBC") ? 0.5 : 0.0);
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const DeviceRow& row : device_rows())
    for (const ForestScene& scene : {kNear, kFar, kFarHardware})
      if (!lacks(row, "multiDrawIndirect") && std::string_view(row.name) != "driver") all.push_back({row.name, scene});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Devices, Limits, testing::ValuesIn(cases()),
                         [](const testing::TestParamInfo<Case>& it) { return it.param.row + ("_" + name_of(it.param.scene)); });

TEST(RefusedDevice, IsRefusedByTheNameOfWhatItLacks) {
  const TemporaryFolder folder;
  const std::filesystem::path png = folder / "picture.png";
  const ProcessResult result = draw_forest(kNear, png, environment_of_device("mali_g72"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(mentions(result.err, {"multiDrawIndirect"}));
  EXPECT_FALSE(stands_in(result.err, "limits_layer")) << "found by asking, not by being refused: " << result.err;
  EXPECT_FALSE(std::filesystem::exists(png));
}

TEST(RefusedDevice, ValidationStandsAboveTheLayer) {
  std::vector<std::string> environment = environment_of_device("mali_g72");
  environment.emplace_back("VK_LOADER_DEBUG=layer");
  const ProcessResult result = draw_forest(kNear, "never_written.png", environment);
  const std::size_t stack = result.err.find("callstack");
  ASSERT_NE(stack, std::string::npos) << result.err;
  EXPECT_LT(result.err.find("VK_LAYER_KHRONOS_validation", stack), result.err.find("VK_LAYER_COPPICE_limits", stack)) << result.err;
}

class DriverAsItIs : public testing::TestWithParam<ForestScene> {
 protected:
  static void expect_reference(const std::string& variable) {
    const Picture picture = picture_of(GetParam(), environment_of_device("driver", {variable}));
    EXPECT_TRUE(picture.rgba == reference(GetParam()).rgba) << variable << ": rmse " << rmse(picture, reference(GetParam()));
  }
};

TEST_P(DriverAsItIs, WhatIsInFreshMemoryShowsNowhere) {
  expect_reference("COPPICE_TEST_FILL=0xFF");
  expect_reference("COPPICE_TEST_FILL=0xCD");
}

TEST_P(DriverAsItIs, AGpuThatIsLateShowsNowhere) {
  expect_reference("COPPICE_TEST_LATE=1");
}

TEST_P(DriverAsItIs, OrderWithoutABarrierShowsNowhere) {
  expect_reference("COPPICE_TEST_REVERSE=1");
}

INSTANTIATE_TEST_SUITE_P(Scenes, DriverAsItIs, testing::Values(kNear, kFar, kFarHardware),
                         [](const testing::TestParamInfo<ForestScene>& scene) { return name_of(scene.param); });

}  // namespace coppice::test::limits_picture_test
