// `coppice bake` on every file of tests/data/bad/gltf: exit code 1, one line that names the file, nothing left behind.

#include <algorithm>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "bad_gltf.h"
#include "mentions.h"
#include "places.h"
#include "process.h"

namespace bad_gltf_cli_test {

using coppice::test::ProcessResult;
using coppice::test::TemporaryFolder;

TEST(BadGltfCommandLine, EachIsOneLineAndExitCodeOne) {
  const std::filesystem::path folder = std::filesystem::path(coppice::test::kTestData) / "bad/gltf";
  const TemporaryFolder output;
  std::size_t count = 0;
  for (const coppice::test::BadGltf& bad : coppice::test::read_bad_gltf_list(folder / "expected.txt")) {
    const ProcessResult result =
        coppice::test::run_process(coppice::test::kTool, {"bake", folder / bad.file, "-o", output / "out.coppice"});
    EXPECT_EQ(result.exit_code, 1) << bad.file;
    EXPECT_EQ(result.signal, 0) << bad.file;
    EXPECT_EQ(result.out, "") << bad.file;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << bad.file << ":\n" << result.err;
    EXPECT_EQ(result.err.rfind("coppice: ", 0), 0u) << result.err;
    EXPECT_TRUE(coppice::test::mentions(result.err, {bad.file}));
    for (const std::string& name : bad.names) EXPECT_TRUE(coppice::test::mentions(result.err, {name}));
    EXPECT_TRUE(std::filesystem::is_empty(output.path())) << bad.file;
    ++count;
  }
  EXPECT_GE(count, 25u);
}

}  // namespace bad_gltf_cli_test
