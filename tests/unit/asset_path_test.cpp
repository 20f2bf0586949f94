#include "asset_path.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "process.h"
#include "results.h"

namespace coppice::asset_path_test {

namespace fs = std::filesystem;

TEST(AssetPath, StaysInsideByItsLetters) {
  for (const char* name : {"oak.png", "textures/oak.png", "a/../oak.png", "./oak.png", "..oak", "a/b/../../oak.png"})
    EXPECT_TRUE(stays_inside(name)) << name;
  for (const char* name : {"", "..", "../oak.png", "a/../../oak.png", "/etc/passwd", "a/b/../../../oak.png"})
    EXPECT_FALSE(stays_inside(name)) << name;
}

class ResolveInside : public testing::Test {
 protected:
  ResolveInside() {
    fs::create_directories(folder / "textures");
    std::ofstream(folder / "textures/oak.png") << "in";
    std::ofstream(base / "secret") << "out";
    fs::create_symlink("textures/oak.png", folder / "link_in.png");
    fs::create_symlink("../secret", folder / "link_out.png");
    fs::create_directory_symlink("..", folder / "up");
    fs::create_directory_symlink("plant", base / "alias");
  }

  test::TemporaryFolder temporary;
  fs::path base = temporary.path();
  fs::path folder = base / "plant";
};

TEST_F(ResolveInside, FindsFilesAndFollowsLinks) {
  for (const fs::path& root : {folder, base / "alias"})
    for (const char* name : {"textures/oak.png", "link_in.png", "textures/../textures/oak.png"}) {
      const auto file = test::must(resolve_inside(root, name));
      EXPECT_EQ(file, fs::canonical(folder / "textures/oak.png"));
    }
}

TEST_F(ResolveInside, RefusesWhatIsOutside) {
  for (const char* name : {"../secret", "link_out.png", "up/secret", "textures/../../secret", "/etc/passwd", ".."})
    test::expect_error(resolve_inside(folder, name), Status::invalid_argument, {name});
}

TEST_F(ResolveInside, AFolderWhoseNameBeginsAlikeIsOutside) {
  fs::create_directories(base / "plant_other");
  std::ofstream(base / "plant_other/oak.png") << "out";
  fs::create_symlink("../plant_other/oak.png", folder / "sly.png");
  EXPECT_FALSE(resolve_inside(folder, "sly.png"));
}

TEST_F(ResolveInside, SaysThatAFileIsMissing) {
  test::expect_error(resolve_inside(folder, "birch.png"), Status::io, {"birch.png", std::strerror(ENOENT)});
}

}  // namespace coppice::asset_path_test
