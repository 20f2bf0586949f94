// The example that draws a forest without a GPU API: its picture shows plants, fewer pixels of them from afar.

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "golden.h"
#include "tool.h"

namespace coppice::test::no_gpu_test {

namespace fs = std::filesystem;

/// Every pixel of the sky has it.
constexpr std::uint8_t kSkyBlue = 225;

/// Share of pixels that are not sky.
double coverage(const fs::path& png) {
  const Picture picture = read_png(png);
  std::size_t covered = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) covered += picture.rgba[i + 2] != kSkyBlue ? 1u : 0u;
  return static_cast<double>(covered) / (static_cast<double>(picture.rgba.size()) / 4.0);
}

double coverage_from(const char* distance_m) {
  const fs::path png = fs::path(testing::TempDir()) / (std::string("no_gpu_") + distance_m + ".png");
  const ProcessResult result = run_process(kNoGpu, {png, distance_m, (std::string(kTestData) + "/plants/two_pages.coppice"),
                                                    (std::string(kTestData) + "/plants/leaf_meshes.coppice")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out, "");
  const double share = coverage(png);
  fs::remove(png);
  return share;
}

TEST(NoGpu, DrawsAForest) {
  const double near = coverage_from("4"), far = coverage_from("40");
  EXPECT_NEAR(near, 0.175, 0.02);
  EXPECT_GT(far, 0.002);
  EXPECT_LT(far, 0.25 * near);
}

TEST(NoGpu, SaysWhatFailed) {
  expect_failure(run_process(kNoGpu, {"never_written.png", "4", "/dev/null"}), {"coppice_plant_open"});
  EXPECT_EQ(run_process(kNoGpu, {"a.coppice", "4", "b.coppice"}).exit_code, 2) << "no picture's name";
  EXPECT_EQ(run_process(kNoGpu, {"a.png", "b.coppice", "c.coppice"}).exit_code, 2) << "no distance";
}

}  // namespace coppice::test::no_gpu_test
