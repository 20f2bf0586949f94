// demo/hosts/engine, the example that engines copy: it runs without a message of validation or a report of a sanitizer, and its picture is
// right. Its own checks fail it too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "text_files.h"
#include "tool.h"

namespace coppice::test::engine_host_test {

namespace fs = std::filesystem;

ProcessResult run_host(const Words& options, const fs::path& picture, const Words& environment) {
  const std::string plant = fs::path(kSourceFolder) / "demo/src/doctor/hazel.coppice";
  ProcessOptions process;
  process.environment = environment;
  return run_process(kEngineHost, joined({plant, "--picture", picture}, options), process);
}

/// Every line of its output is one of the table's, and nothing is on standard error: a layer or a sanitizer has said nothing.
void expect_only_figures(const ProcessResult& result) {
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  std::istringstream lines(result.out);
  std::size_t line_count = 0;
  for (std::string line; std::getline(lines, line); ++line_count)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 7 + (line.starts_with("memory, ") ? 1 : 0)) << line;
  EXPECT_EQ(line_count, 8u) << result.out;
}

/// The share of a view's pixels that are more green than red and blue.
double green_share(const std::string& ppm, std::size_t view) {
  const std::size_t width = 512, height = 144, begin = ppm.size() - 3 * width * height;
  std::size_t green = 0;
  for (std::size_t i = 0; i < width * height; ++i) {
    const auto channel = [&](std::size_t c) { return int{static_cast<unsigned char>(ppm[begin + 3 * i + c])}; };
    if (i % width / 256 == view) green += channel(1) > channel(0) + 12 && channel(1) > channel(2) + 25 ? 1u : 0u;
  }
  return double(green) / double(width * height / 2);
}

const Words kSmall = {"--instances", "200", "--frames", "12", "--width", "256"};

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// The driver is not built with the sanitizer, and leaks 128 bytes.
TEST(EngineHost, RunsUnderTheSanitizer) {
  const TemporaryFolder folder;
  expect_only_figures(
      run_host(kSmall, folder / "picture.ppm", {"ASAN_OPTIONS=detect_leaks=0", "TSAN_OPTIONS=ignore_noninstrumented_modules=1"}));
}
#else
TEST(EngineHost, RunsUnderValidation) {
  const TemporaryFolder folder;
  const fs::path picture = folder / "picture.ppm";
  const Words validation = {"VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation",
                            "VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT"};
  expect_only_figures(run_host(kSmall, picture, validation));
  // Near the camera the wood fills the picture, seen from above it is loose.
  const std::string ppm = read_text(picture);
  EXPECT_NEAR(green_share(ppm, 0), 0.35, 0.2);
  EXPECT_NEAR(green_share(ppm, 1), 0.25, 0.15);
  // The layer is there, and would have spoken.
  const ProcessResult loaded =
      run_host({"--instances", "1", "--frames", "1", "--width", "16"}, picture, joined(validation, {"VK_LOADER_DEBUG=layer"}));
  EXPECT_NE(loaded.err.find("Loading layer library libVkLayer_khronos_validation.so"), std::string::npos) << loaded.err;
}

TEST(EngineHost, DrawsTheSameInEveryRunWithoutThreads) {
  const TemporaryFolder folder;
  const Words options = joined(kSmall, {"--threads", "0"});
  expect_only_figures(run_host(options, folder / "first.ppm", {}));
  expect_only_figures(run_host(options, folder / "second.ppm", {}));
  EXPECT_TRUE(read_text(folder / "first.ppm") == read_text(folder / "second.ppm"));
}
#endif

TEST(EngineHost, SaysWhatFailed) {
  const ProcessResult result = run_process(kEngineHost, {"never_written.coppice"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("never_written.coppice cannot be archived"), std::string::npos) << result.err;
}

}  // namespace coppice::test::engine_host_test
