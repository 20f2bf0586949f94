#include "verify_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "coppice/scene_format.h"
#include "coppice_file.h"
#include "gltf_builder.h"
#include "inspect.h"
#include "mentions.h"
#include "packed_plant.h"
#include "process.h"
#include "scene_file.h"
#include "scene_write.h"

namespace coppice::test::verify_scene_test {

namespace fs = std::filesystem;

std::vector<std::uint8_t> packed_oak(std::uint32_t seed, const std::string& name = "oak") {
  bake::BakedPlant plant = random_plant({.leaf_count = 30, .seed = seed});
  plant.name = name;
  return packed(plant);
}

/// Two species, one in a folder of its own, and a scene of 5,000 plants of them.
class VerifyScene : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(scene_folder_ / "trees");
    write_file(scene_folder_ / "fern.coppice", packed_oak(1));
    write_file(scene_folder_ / "trees" / "oak.coppice", packed_oak(2));
  }

  /// The scene of species at these paths from its folder, with the spheres of the two plants.
  [[nodiscard]] static std::vector<std::uint8_t> scene(const std::vector<std::string>& paths) {
    std::vector<SceneSpecies> species;
    for (const std::string& path : paths) {
      const bake::Sphere sphere = random_plant({.leaf_count = 30, .seed = static_cast<std::uint32_t>(species.size() % 2 + 1)}).sphere;
      species.push_back({path, {sphere.center.x, sphere.center.y, sphere.center.z}, sphere.radius});
    }
    auto plants = random_scene_plants(5000, 400.0f, 3);
    return *bake::encode_scene(species, plants);
  }

  [[nodiscard]] std::vector<std::string> errors(const std::vector<std::uint8_t>& file, OutsideFiles outside = OutsideFiles::refused) const {
    std::vector<std::string> lines;
    for (const Error& error : bake::verify_scene(file, scene_folder_, outside).errors) lines.push_back(error.message());
    return lines;
  }

  TemporaryFolder folder_;
  fs::path scene_folder_ = folder_ / "scene";
  const std::vector<std::string> good_ = {"fern.coppice", "trees/oak.coppice"};
};

TEST_F(VerifyScene, PassesAWholeScene) {
  const auto file = scene(good_);
  ASSERT_TRUE(bake::is_scene(file));
  const auto report = bake::verify_scene(file, scene_folder_, OutsideFiles::refused);
  EXPECT_TRUE(report.errors.empty()) << report.errors.front().message();
  EXPECT_EQ(report.plants_checked, 5000u);
  EXPECT_GT(report.tiles_checked, 1u);
  EXPECT_EQ(report.species_checked, 2u);
  EXPECT_EQ(report.bytes_checked, file.size());
  EXPECT_FALSE(bake::is_scene(packed_oak(1)));
}

TEST_F(VerifyScene, ListsEverySpeciesThatIsWrong) {
  fs::create_directories(folder_ / "other");
  write_file(folder_ / "other" / "oak.coppice", packed_oak(2));
  auto damaged = packed_oak(1);
  damaged[damaged.size() - 9] ^= 0x10;
  write_file(scene_folder_ / "damaged.coppice", damaged);
  fs::create_symlink("../other/oak.coppice", scene_folder_ / "link.coppice");
  const auto file = scene({"missing.coppice", "trees/oak.coppice", "damaged.coppice", "../other/oak.coppice", "trees", "link.coppice"});
  const auto lines = errors(file);
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_TRUE(mentions(lines[0], {"missing.coppice", std::strerror(ENOENT)}));
  EXPECT_TRUE(mentions(lines[1], {"2", "damaged.coppice"}));
  EXPECT_TRUE(mentions(lines[2], {"../other/oak.coppice"}));
  EXPECT_TRUE(mentions(lines[3], {"trees", std::strerror(EISDIR)}));
  EXPECT_TRUE(mentions(lines[4], {"link.coppice"}));
  EXPECT_EQ(errors(file, OutsideFiles::allowed).size(), 3u);
}

TEST_F(VerifyScene, FindsAPlantThatHasChanged) {
  bake::BakedPlant plant = random_plant({.leaf_count = 30, .seed = 2});
  plant.sphere.radius *= 1.05f;
  write_file(scene_folder_ / "trees" / "oak.coppice", packed(plant));
  const auto lines = errors(scene(good_));
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(mentions(lines[0], {"1", "trees/oak.coppice"}));
}

TEST_F(VerifyScene, ListsEveryTileThatIsWrong) {
  auto file = scene(good_);
  file[file.size() - 5] ^= 1;
  file[file.size() - 5 - 12 * 4000] ^= 1;
  const auto lines = errors(file);
  ASSERT_EQ(lines.size(), 2u);
  for (const std::string& line : lines) EXPECT_TRUE(mentions(line, {"tile checksum"}));
  file[20] ^= 1;
  EXPECT_EQ(errors(file).size(), 1u) << "of a front that is wrong nothing else is known";
}

TEST_F(VerifyScene, RefusesControlCharactersInNames) {
  auto file = scene(good_);
  const auto at = std::search(file.begin(), file.end(), good_[0].begin(), good_[0].end());
  ASSERT_NE(at, file.end());
  *at = 0x1b;
  fix_scene_checksums(file);
  const auto lines = errors(file);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(mentions(lines[0], {"0"}));
  std::vector<SceneSpecies> species{{"o\x1bk.coppice", {0, 0, 0}, 1.0f}};
  auto plants = random_scene_plants(1, 1.0f, 1);
  plants[0].species = 0;
  EXPECT_FALSE(bake::encode_scene(species, plants)) << "no scene is written that verify refuses";
}

TEST(VerifyPlant, RefusesControlCharactersInTheName) {
  EXPECT_TRUE(bake::verify(packed_oak(1, "\xc3\xa9rable")));
  for (const char* name : {"o\x1b[31mk", "oak\n", "\xc2\x9b", "oak\xe2\x80\xae"}) {
    const auto file = packed_oak(1, name);
    EXPECT_TRUE(bake::inspect(file)) << "the reader takes it";
    const auto verified = bake::verify(file);
    ASSERT_FALSE(verified);
    EXPECT_TRUE(mentions(verified.error().message(), {"plant name"}));
    EXPECT_EQ(std::memcmp(file.data() + verified.error().offset, name, std::strlen(name)), 0);
  }
}

}  // namespace coppice::test::verify_scene_test
