// The files that a glTF names lie in its folder, whatever way the name takes.

#include "gltf_references.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "gltf_builder.h"
#include "import_gltf.h"
#include "process.h"
#include "results.h"

namespace coppice::bake::gltf_references_test {

namespace fs = std::filesystem;

/// A plant in a folder of its own, and beside that folder what it must not read.
struct Folders {
  test::TemporaryFolder root;
  fs::path plant = root / "plant", secret = root / "secret.bin";
  test::GltfBuilder builder = test::small_plant();

  Folders() {
    fs::create_directories(plant / "inside");
    test::write_file(secret, builder.bin);
    test::write_file(plant / "leaf s.bin", builder.bin);
    test::write_file(root / "secret.png", test::png(2, 2, {10, 200, 30, 255}));
    fs::create_symlink("../secret.bin", plant / "link.bin");
    fs::create_symlink("leaf s.bin", plant / "link inside.bin");
    fs::create_directory_symlink("..", plant / "up");
  }
  [[nodiscard]] Result<Plant> import_buffer(const std::string& uri, OutsideFiles outside = OutsideFiles::refused) const {
    return import_gltf(test::write_file(plant / "plant.gltf", builder.gltf_beside(uri)), {.outside_files = outside});
  }
};

TEST(GltfReferences, OutsideTheFolderIsRefusedAndMayBeAllowed) {
  const Folders folders;
  const std::string absolute = folders.secret.string();
  for (const std::string& uri : {std::string("../secret.bin"), std::string("..%2fsecret.bin"), std::string("%2e%2E/secret.bin"),
                                 std::string("inside/../../secret.bin"), std::string("link.bin"), std::string("up/secret.bin"), absolute,
                                 "file://" + absolute, "file:" + absolute}) {
    test::expect_error(folders.import_buffer(uri), Status::invalid_argument, {"plant.gltf", "buffers[0].uri", uri, "--allow-outside"});
    const auto allowed = folders.import_buffer(uri, OutsideFiles::allowed);
    EXPECT_TRUE(allowed) << uri << ": " << allowed.error().message();
  }
}

TEST(GltfReferences, InsideTheFolderAllNamesAreRead) {
  const Folders folders;
  for (const char* uri : {"leaf s.bin", "leaf%20s.bin", "./leaf%20s.bin", "inside/../leaf%20s.bin", "link%20inside.bin"})
    EXPECT_TRUE(folders.import_buffer(uri)) << uri << ": " << folders.import_buffer(uri).error().message();
}

TEST(GltfReferences, ControlCharactersAreInNoName) {
  Folders folders;
  for (const char* uri : {"a%00b.bin", "a%0ab.bin", "a\tb.bin", "a%7F.bin"})
    test::expect_error(folders.import_buffer(uri), Status::bad_file, {"buffers[0].uri"});
  folders.builder.json["images"] = {{{"uri", "leaf.png%00"}}};
  test::expect_error(folders.import_buffer("leaf%20s.bin"), Status::bad_file, {"images[0].uri"});
}

TEST(GltfReferences, ImagesObeyTheSameRuleUsedOrNot) {
  Folders folders;
  fs::create_symlink("../secret.png", folders.plant / "leaf.png");
  for (const char* uri : {"../secret.png", "..%2fsecret.png", "leaf.png"}) {
    folders.builder.json["images"] = {{{"uri", uri}}};
    for (const bool used : {false, true}) {
      if (used) {
        folders.builder.json["textures"] = {{{"source", 0}}};
        folders.builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
      }
      test::expect_error(folders.import_buffer("leaf%20s.bin"), Status::invalid_argument, {"images[0].uri", uri});
    }
    const auto allowed = test::must(folders.import_buffer("leaf%20s.bin", OutsideFiles::allowed));
    EXPECT_EQ(allowed.images.size(), 1u);
    folders.builder.json.erase("textures");
    folders.builder.json["materials"][0].erase("pbrMetallicRoughness");
  }
}

TEST(GltfReferences, OfALargeFileOnlyWhatTheBufferTakesIsRead) {
  const Folders folders;
  fs::resize_file(folders.plant / "leaf s.bin", std::uintmax_t{20} << 30);  // takes no room on the disk
  EXPECT_TRUE(folders.import_buffer("leaf%20s.bin"));
}

TEST(GltfReferences, ABufferMayBeWhatGitLeftInItsPlace) {
  const Folders folders;
  std::vector<std::uint8_t> pointer(folders.builder.bin.size(), ' ');
  std::ranges::copy(std::string("version https://git-lfs.github.com/spec/v1\n"), pointer.begin());
  test::write_file(folders.plant / "leaf s.bin", pointer);
  test::expect_error(folders.import_buffer("leaf%20s.bin"), Status::io, {"buffers[0].uri", "git lfs pull"});
}

TEST(GltfReferences, AnImageFileThatIsTooLargeIsNotRead) {
  Folders folders;
  folders.builder.set_texture(0, test::png(2, 2, {10, 200, 30, 255}));
  folders.builder.json["images"] = {{{"uri", "large.png"}}};
  test::write_file(folders.plant / "leaf s.bin", folders.builder.bin);
  test::write_file(folders.plant / "large.png", test::png(2, 2, {10, 200, 30, 255}));
  fs::resize_file(folders.plant / "large.png", std::uintmax_t{20} << 30);
  test::expect_error(folders.import_buffer("leaf%20s.bin"), Status::unsupported, {"images[0].uri", "large.png", "1 GiB"});
}

TEST(GltfReferences, PercentSigns) {
  EXPECT_EQ(percent_decoded("a%20b%2Fc%2e"), "a b/c.");
  EXPECT_EQ(percent_decoded("%"), "%");
  EXPECT_EQ(percent_decoded("%2"), "%2");
  EXPECT_EQ(percent_decoded("%zz%41"), "%zzA");
}

}  // namespace coppice::bake::gltf_references_test
