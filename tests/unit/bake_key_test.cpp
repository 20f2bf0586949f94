// What makes two bakes the same. The cache that relies on it: shared_cache_test.

#include "bake_key.h"

#include <array>
#include <functional>
#include <map>
#include <set>
#include <string_view>

#include <gtest/gtest.h>

#include "atomic_file.h"
#include "bake_cache.h"
#include "generate_plant.h"
#include "gltf_builder.h"
#include "gltf_write.h"
#include "mentions.h"
#include "process.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace bake_key_test {

namespace fs = std::filesystem;

std::string key_of(const fs::path& input, const BakeOptions& options = {}) {
  const auto key = bake_key(input, options);
  EXPECT_TRUE(key) << key.error().message();
  return key ? *key : "";
}

/// A .gltf whose buffer and image are files beside it, one of them with a name that a URI cannot hold as it is.
struct PlantOfFiles {
  test::TemporaryFolder folder;
  fs::path gltf = folder / "plant.gltf", buffer = folder / "leaves of it.bin", image = folder / "leaf.png";

  PlantOfFiles() {
    test::GltfBuilder builder = test::small_plant();
    builder.json["images"] = {{{"uri", "leaf.png"}}};
    builder.json["textures"] = {{{"source", 0}}};
    test::write_file(gltf, builder.gltf_beside("leaves%20of%20it.bin"));
    test::write_file(buffer, builder.bin);
    test::write_file(image, test::png(2, 2, {10, 200, 10, 255}));
  }
};

TEST(BakeKey, EveryFileTheInputRefersToCounts) {
  const PlantOfFiles plant;
  const std::vector<GltfReference> referred = referred_files(*read_file(plant.gltf));
  ASSERT_EQ(referred.size(), 2u);
  EXPECT_EQ(referred[0].place(), "buffers[0].uri");
  EXPECT_EQ(percent_decoded(referred[0].uri), plant.buffer.filename());
  EXPECT_EQ(referred[1].place(), "images[0].uri");
  const std::string before = key_of(plant.gltf);
  EXPECT_EQ(before.size(), 32u);
  EXPECT_EQ(key_of(plant.gltf), before);
  std::set<std::string> keys{before};
  for (const fs::path& file : {plant.gltf, plant.buffer, plant.image}) {
    const std::vector<std::uint8_t> bytes = *read_file(file);
    std::vector<std::uint8_t> changed = bytes;
    changed.back() = changed.back() == ' ' ? '\n' : ' ';
    test::write_file(file, changed);
    EXPECT_TRUE(keys.insert(key_of(plant.gltf)).second) << file << " changed";
    test::write_file(file, bytes);
    EXPECT_EQ(key_of(plant.gltf), before) << file << " changed back";
  }
  fs::remove(plant.image);
  EXPECT_TRUE(keys.insert(key_of(plant.gltf)).second) << "the image is gone";
  test::write_file(plant.image, std::vector<std::uint8_t>());
  EXPECT_TRUE(keys.insert(key_of(plant.gltf)).second) << "the image is empty";
}

TEST(BakeKey, NamesAndEveryOptionCountThreadsDoNot) {
  const PlantOfFiles plant;
  const std::vector<std::function<void(BakeOptions&)>> changes = {
      [](BakeOptions&) {},
      [](BakeOptions& options) { options.metric = Metric::mi; },
      [](BakeOptions& options) { options.metric = Metric::geometric; },
      [](BakeOptions& options) { options.view_count = 20; },
      [](BakeOptions& options) { options.import.leaf_material = ""; },
      [](BakeOptions& options) { options.import.leaf_material = "leaves"; },
      [](BakeOptions& options) { options.import.wood_material = "leaves"; },
      [](BakeOptions& options) { options.import.classes = {{.material = "leaves"}}; },
      [](BakeOptions& options) { options.import.classes = {{.material = "leaves", .part = PlantPart::dropped}}; },
      [](BakeOptions& options) { options.import.classes = {{.material = "leaves", .max_triangles = 7}}; },
      [](BakeOptions& options) { options.import.plant.node = "oak_LOD1"; },
      [](BakeOptions& options) { options.import.plant.variant = 2; },
      [](BakeOptions& options) { options.import.plant.whole = true; },
      [](BakeOptions& options) { options.import.up = UpAxis::z; },
      [](BakeOptions& options) { options.import.metres_per_unit = 1e-8; },
      [](BakeOptions& options) { options.import.metres_per_unit = 2e-8; },
      [](BakeOptions& options) { options.collapse.resolution_px = 128; },
      [](BakeOptions& options) { options.collapse.count_background = false; },
      [](BakeOptions& options) { options.collapse.candidate_count = 9; },
      [](BakeOptions& options) { options.textures = TextureCoding::rgba8; },
      [](BakeOptions& options) { options.crown_normals = 0.0f; },
      [](BakeOptions& options) { options.leaf_meshes = false; },
      [](BakeOptions& options) { options.wind.moves = false; },
      [](BakeOptions& options) { options.wind.stiffness = 2.0f; },
      [](BakeOptions& options) { options.import.wind_color_set = 0; },
      [](BakeOptions& options) { options.import.wind_color_set = 1; },
  };
  std::set<std::string> keys;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    BakeOptions options;
    changes[i](options);
    EXPECT_TRUE(keys.insert(key_of(plant.gltf, options)).second) << "change " << i;
  }
  BakeOptions options;
  options.thread_count = 7;
  EXPECT_FALSE(keys.insert(key_of(plant.gltf, options)).second);
  fs::copy(plant.gltf, plant.folder / "other.gltf");
  EXPECT_TRUE(keys.insert(key_of(plant.folder / "other.gltf")).second) << "the file keeps the plant's name";
}

/// The key itself holds the device too, which a test of Vulkan's looks at.
TEST(BakeKey, WhoMeasuresAreasIsAnOption) {
  BakeOptions options;
  options.metric = Metric::mi;
  const std::vector<KeyPart> by_item_buffers = option_parts(options);
  options.areas = Areas::vulkan;
  EXPECT_NE(option_parts(options), by_item_buffers);
}

TEST(BakeKey, OfALargeFileOnlyWhatTheBufferTakesIsRead) {
  const PlantOfFiles plant;
  const std::string before = key_of(plant.gltf);
  fs::resize_file(plant.buffer, std::uintmax_t{20} << 30);  // takes no room on the disk; read whole it would not fit the memory
  EXPECT_EQ(key_of(plant.gltf), before);
}

TEST(BakeKey, AFileOutsideTheFolderHasAnErrorUnlessItIsAllowed) {
  const PlantOfFiles plant;
  const fs::path inner = plant.folder / "inner";
  fs::create_directories(inner);
  fs::copy(plant.gltf, inner / "plant.gltf");
  fs::copy(plant.buffer, inner / plant.buffer.filename());
  fs::create_symlink(plant.image, inner / "leaf.png");
  const auto key = bake_key(inner / "plant.gltf", {});
  ASSERT_FALSE(key) << "nothing outside is read";
  EXPECT_EQ(key.error().status, Status::invalid_argument);
  EXPECT_TRUE(test::mentions(key.error().message(), {"images[0].uri", "leaf.png", "--allow-outside"}));
  BakeOptions options;
  options.import.outside_files = OutsideFiles::allowed;
  EXPECT_EQ(key_of(inner / "plant.gltf", options), key_of(plant.gltf));
}

TEST(BakeKey, AnythingHasOneAndWhatCannotBeReadHasAnError) {
  const test::TemporaryFolder folder;
  const auto key_of_bytes = [&](const std::string& bytes) {
    test::write_file(folder / "any.glb", std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
    return key_of(folder / "any.glb");
  };
  std::set<std::string> keys;
  const std::string cut_short("glTF\2\0\0\0\xff\xff\xff\xff\xff\xff\xff\xffJSON", 20);
  for (const std::string& bytes : {std::string(), std::string("glTF"), cut_short, std::string("{"), std::string("[{\"uri\":\"any.glb\"}]"),
                                   std::string("{\"uri\":7}")})
    EXPECT_TRUE(keys.insert(key_of_bytes(bytes)).second) << bytes;
  EXPECT_TRUE(keys.insert(key_of_bytes("{\"a\":{\"uri\":\"/dev/zero\"}}")).second) << "a device is not read";
  EXPECT_FALSE(bake_key(folder / "nowhere.glb", {}));
  EXPECT_FALSE(bake_key(folder.path(), {}));
}

TEST(Checksum, PartsDoNotRunIntoEachOther) {
  EXPECT_NE(checksum_of(std::array<std::string_view, 2>{"ab", "c"}), checksum_of(std::array<std::string_view, 2>{"a", "bc"}));
}

TEST(BakeVersion, IsRaisedWhenABakeGivesOtherBytes) {
  const std::map<Metric, std::string> expected = {{Metric::default_metric, "2c46ccb2addc3986d3bda20df19ed280"},
                                                  {Metric::mi, "a6301177a27625b1924210dac9374cc6"}};
  const std::uint32_t expected_at_version = 26;

  const test::TemporaryFolder folder;
  const auto plant = generate_plant("corylus", 1);
  ASSERT_TRUE(plant) << plant.error().message();
  const fs::path input = folder / "corylus.glb";
  ASSERT_TRUE(write_glb(input, {{"leaves", &plant->foliage}, {"wood", &plant->wood}}, plant->materials, plant->images));
  for (const auto& [metric, checksum_text] : expected) {
    BakeOptions options;
    options.metric = metric;
    options.view_count = 6;
    options.collapse.resolution_px = 64;
    BakeReport report;
    const auto bytes = bake(
        input, options, [](const char*, double) {}, report);
    ASSERT_TRUE(bytes) << bytes.error().message();
    EXPECT_EQ(checksum_of(std::array{as_text(*bytes)}), checksum_text)
        << "A bake gives other bytes than at version " << expected_at_version
        << " of the baker. If that is meant, raise kBakeVersion in bake_key.h, so that caches bake "
           "again, and put version and checksum here.";
  }
  EXPECT_EQ(kBakeVersion, expected_at_version) << "put the new version here";
}

}  // namespace bake_key_test
}  // namespace coppice::bake
