// One plant, one file: whatever the processor that bakes, and however many there are. Other processors are played by what glibc and
// libjpeg-turbo take from the environment, and by QEMU (Debian: qemu-user) where it is installed.

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tool.h"

namespace coppice::test::same_bytes_test {

namespace fs = std::filesystem;

constexpr const char* kNoVectors = "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX2,-AVX,-FMA,-FMA4,-SSE4_1,-SSE4_2,-SSSE3,-BMI2";

class SameBytes : public testing::Test {
 protected:
  /// What plant and bake write, run by a program, in an environment.
  std::string bake(const Words& runner = {}, const Words& environment = {}) {
    const fs::path plant = folder_ / "hazel.glb", baked = folder_ / "hazel.coppice";
    for (const Words& arguments :
         {Words{"plant", "corylus", "-o", plant}, {"bake", plant, "-o", baked, "--quiet", "--views", "5", "--resolution", "48"}}) {
      const Words words = joined(joined(runner, {kTool}), arguments);
      const ProcessResult result = run_process(words.front(), {words.begin() + 1, words.end()}, {.environment = environment});
      EXPECT_EQ(result.exit_code, 0) << result.err;
    }
    const std::string bytes = read_text(plant) + read_text(baked);
    fs::remove(plant);
    fs::remove(baked);
    return bytes;
  }

  TemporaryFolder folder_;
};

TEST_F(SameBytes, WithoutFusedOperationsAndVectors) {
  const std::string here = bake();
  EXPECT_GT(here.size(), 100'000u);
  EXPECT_TRUE(bake({}, {kNoVectors, "JSIMD_FORCENONE=1"}) == here);
}

TEST_F(SameBytes, OnOneProcessor) {
  const fs::path taskset = program_on_path("taskset");
  if (taskset.empty()) GTEST_SKIP() << "no taskset";
  EXPECT_TRUE(bake({taskset, "1"}) == bake());
}

TEST_F(SameBytes, OnAProcessorOf2008) {
  const fs::path qemu = program_on_path("qemu-x86_64");
  if (qemu.empty()) GTEST_SKIP() << "no qemu-x86_64: third_party/install --optional installs qemu-user";
  EXPECT_TRUE(bake({qemu, "-cpu", "Nehalem"}) == bake());
}

}  // namespace coppice::test::same_bytes_test
