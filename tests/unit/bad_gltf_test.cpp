// tests/data/bad/gltf: files that are wrong in one way each, as make_gltf_files wrote them.

#include "bad_gltf.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "expect_error.h"
#include "import_gltf.h"
#include "mentions.h"
#include "places.h"

namespace coppice::bake {
namespace bad_gltf_test {

const std::filesystem::path kFolder = std::filesystem::path(test::kTestData) / "bad/gltf";

class BadGltfTest : public testing::TestWithParam<test::BadGltf> {};

TEST_P(BadGltfTest, OneLineNamesFileFieldAndPlace) {
  const std::filesystem::path path = kFolder / GetParam().file;
  ASSERT_TRUE(std::filesystem::exists(path));
  const Result<Plant> plant = import_gltf(path, {});
  test::expect_error(plant, GetParam().status, {path.string()});
  const std::string message = plant.error().message();
  for (const std::string& name : GetParam().names) EXPECT_TRUE(test::mentions(message, {name}));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_LT(message.size(), 400u + path.string().size()) << message;
}

INSTANTIATE_TEST_SUITE_P(Files, BadGltfTest, testing::ValuesIn(test::read_bad_gltf_list(kFolder / "expected.txt")),
                         [](const testing::TestParamInfo<test::BadGltf>& bad) {
                           std::string name = bad.param.file;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

TEST(BadGltf, FolderListAndGeneratorAgree) {
  std::set<std::string> there, listed, generated;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) there.insert(entry.path().filename());
  for (const test::BadGltf& bad : test::read_bad_gltf_list(kFolder / "expected.txt")) listed.insert(bad.file);
  for (const test::BadGltf& bad : test::bad_gltf_files()) {
    EXPECT_TRUE(generated.insert(bad.file).second) << bad.file << " twice";
    EXPECT_FALSE(import_gltf_bytes(bad.bytes, kFolder / bad.file, {})) << bad.file;
  }
  there.erase("expected.txt");
  EXPECT_EQ(there, listed) << "a file that no list names is never tried";
  EXPECT_EQ(listed, generated);
  EXPECT_GE(listed.size(), 25u);
}

}  // namespace bad_gltf_test
}  // namespace coppice::bake
