// Files that are wrong in one way each, made here or committed (tests/data/bad/gltf, as make_gltf_files wrote them): one clear line that
// names the file, the field and the place, and nothing worse.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bad_gltf.h"
#include "encoded_images.h"
#include "gltf_builder.h"
#include "gltf_screen.h"
#include "import_gltf.h"
#include "imported.h"
#include "mentions.h"
#include "places.h"
#include "process.h"
#include "results.h"

namespace coppice::bake::import_gltf_bad_test {

using nlohmann::json;
using test::GltfBuilder;
using Bytes = std::vector<std::uint8_t>;

Bytes text(const std::string& characters) {
  return {characters.begin(), characters.end()};
}

Bytes first_bytes(const Bytes& bytes, std::size_t count) {
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count)};
}

/// From a heap block of exactly the file's size, so that a sanitizer sees a read past its end.
Result<Plant> import_bytes(const Bytes& bytes, const ImportOptions& options = {}) {
  const Bytes exact(bytes.begin(), bytes.end());
  return import_gltf_bytes(exact, "bad.glb", options);
}

/// The import fails with this status and one line that names the file and each of `names`.
void expect_error(const Bytes& bytes, Status status, const std::vector<std::string>& names, const ImportOptions& options = {}) {
  const Result<Plant> plant = import_bytes(bytes, options);
  test::expect_error(plant, status, {"bad.glb"});
  const std::string message = plant.error().message();
  for (const std::string& name : names) EXPECT_TRUE(test::mentions(message, {name}));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_LT(message.size(), 600u) << message;
}

/// Members of the small plant's JSON by their pointers, with other values or null for none, and what the message must name.
struct BadJson {
  const char* name;
  const char* changes;
  std::vector<std::string> names;
  Status status = Status::bad_file;
};

// For GoogleTest. NOLINTNEXTLINE(readability-identifier-naming)
void PrintTo(const BadJson& bad, std::ostream* out) {
  *out << bad.name;
}

const std::vector<BadJson> kBadJson{
    {"AssetMissing", R"({"/asset": null})", {"asset"}},
    {"VersionOne", R"({"/asset/version": "1.0"})", {"asset.version", "1.0"}, Status::unsupported},
    {"RequiredExtension",
     R"({"/extensionsRequired": ["EXT_texture_unheard_of"]})",
     {"extensionsRequired", "EXT_texture_unheard_of"},
     Status::unsupported},
    {"ExtensionsNotAnArray", R"({"/extensionsRequired": 3})", {"extensionsRequired"}},
    {"BufferEmpty", R"({"/buffers": [{"byteLength": 0}]})", {"buffers[0].byteLength"}},
    {"BufferLongerThanBin", R"({"/buffers": [{"byteLength": 1000000000}]})", {"buffers[0].byteLength", "1000000000"}},
    {"SecondBufferWithoutUri", R"({"/buffers": [{"byteLength": 4}, {"byteLength": 4}]})", {"buffers[1].uri"}},
    {"BufferFileMissing", R"({"/buffers": [{"byteLength": 96, "uri": "not_there.bin"}]})", {"buffers[0].uri", "not_there.bin"}, Status::io},
    {"BufferOutsideFolder",
     R"({"/buffers": [{"byteLength": 96, "uri": "/dev/zero"}]})",
     {"buffers[0].uri", "/dev/zero", "--allow-outside"},
     Status::invalid_argument},
    {"ImageOutsideFolder",
     R"({"/images": [{"uri": "..%2f..%2fleaf.png"}]})",
     {"images[0].uri", "..%2f..%2fleaf.png", "--allow-outside"},
     Status::invalid_argument},
    {"ImageUriWithNul", R"({"/images": [{"uri": "leaf.png%00"}]})", {"images[0].uri"}},
    {"BufferDataUriNotBase64",
     R"({"/buffers": [{"byteLength": 96, "uri": "data:application/octet-stream;base64,!!!!"}]})",
     {"buffers[0].uri"},
     Status::io},
    {"BufferUriNotText", R"({"/buffers": [{"byteLength": 96, "uri": 5}]})", {"buffers[0].uri"}},
    {"ViewOfNoBuffer", R"({"/bufferViews/1/buffer": 7})", {"bufferViews[1].buffer", "7", "1"}},
    {"ViewPastBuffer", R"({"/bufferViews/0/byteLength": 99999})", {"bufferViews[0]", "99999"}},
    {"ViewOffsetWraps", R"({"/bufferViews/0/byteOffset": 18446744073709551612})", {"bufferViews[0]"}},
    {"ViewStride", R"({"/bufferViews/0/byteStride": 3})", {"bufferViews[0].byteStride"}},
    {"ViewStrideTooShort", R"({"/bufferViews/0/byteStride": 4})", {"accessors[0]", "stride"}},
    {"ViewIsNumber", R"({"/bufferViews/0": 3})", {"bufferViews[0]"}},
    {"AccessorOfNoView", R"({"/accessors/0/bufferView": 30})", {"accessors[0].bufferView", "30", "3"}},
    {"AccessorNegativeView", R"({"/accessors/0/bufferView": -1})", {"accessors[0].bufferView"}},
    {"AccessorPastView", R"({"/accessors/0/count": 5})", {"accessors[0]", "5"}},
    {"AccessorBillion", R"({"/accessors/0/count": 1000000000})", {"accessors[0]", "1000000000"}},
    {"AccessorBillionOfNothing",
     R"({"/accessors/0/count": 1000000000, "/accessors/0/bufferView": null})",
     {"accessors[0].count", "1000000000"}},
    {"AccessorHugeCount", R"({"/accessors/0/count": 18446744073709551615})", {"accessors[0]"}},
    {"AccessorEmpty", R"({"/accessors/0/count": 0})", {"accessors[0].count"}},
    {"AccessorFractionalCount", R"({"/accessors/0/count": 1.5})", {"accessors[0].count"}},
    {"AccessorOffset", R"({"/accessors/0/byteOffset": 4})", {"accessors[0]", "byteOffset", "4"}},
    {"AccessorComponentType", R"({"/accessors/0/componentType": 5124})", {"accessors[0].componentType", "5124"}},
    {"AccessorType", R"({"/accessors/0/type": "VEC7"})", {"accessors[0].type", "VEC7"}},
    {"AccessorTypeMissing", R"({"/accessors/0/type": null})", {"accessors[0].type"}},
    {"PositionsNotVec3", R"({"/accessors/0/type": "VEC2"})", {"meshes[0].primitives[0]", "accessors[0]", "VEC3"}},
    {"IndicesNotScalar", R"({"/meshes/0/primitives/0/indices": 0})", {"accessors[0]", "indices"}},
    {"IndicesFloat", R"({"/accessors/1/componentType": 5126, "/accessors/1/count": 3})", {"accessors[1]", "indices"}},
    {"SparseCount",
     R"({"/accessors/0/sparse": {"count": 5, "indices": {"bufferView": 0, "componentType": 5123},
                                            "values": {"bufferView": 0}}})",
     {"accessors[0].sparse.count"}},
    {"SparseViewMissing",
     R"({"/accessors/0/sparse": {"count": 1, "indices": {"bufferView": 9, "componentType": 5123},
                                            "values": {"bufferView": 9}}})",
     {"accessors[0].sparse.indices.bufferView"}},
    // The leaf's positions, read as 16-bit indices, hold 0x3f80.
    {"SparseIndexBeyond",
     R"({"/accessors/0/sparse": {"count": 1, "indices": {"bufferView": 0, "componentType": 5123, "byteOffset": 14},
                                            "values": {"bufferView": 0}}})",
     {"meshes[0].primitives[0]", "accessors[0]", "sparse"}},
    {"PrimitiveWithoutAttributes", R"({"/meshes/0/primitives/0/attributes": null})", {"meshes[0].primitives[0].attributes"}},
    {"PrimitiveWithoutPosition",
     R"({"/meshes/1/primitives/0/attributes": {"NORMAL": 0}})",
     {"meshes[1].primitives[0].attributes.POSITION"}},
    {"PositionOfNoAccessor",
     R"({"/meshes/0/primitives/0/attributes/POSITION": 12})",
     {"meshes[0].primitives[0].attributes.POSITION", "12", "3"}},
    {"IndicesOfNoAccessor", R"({"/meshes/0/primitives/0/indices": 12})", {"meshes[0].primitives[0].indices"}},
    {"MaterialMissing", R"({"/meshes/0/primitives/0/material": 2})", {"meshes[0].primitives[0].material", "2"}},
    {"Mode", R"({"/meshes/0/primitives/0/mode": 7})", {"meshes[0].primitives[0].mode"}},
    {"UnequalAttributes",
     R"({"/meshes/0/primitives/0/attributes/NORMAL": 2})",
     {"meshes[0].primitives[0]", "NORMAL", "3", "POSITION", "4"}},
    {"PrimitivesNotAnArray", R"({"/meshes/0/primitives": "x"})", {"meshes[0].primitives"}},
    {"NodeMesh", R"({"/nodes/0/mesh": 2})", {"nodes[0].mesh", "2"}},
    {"NodeChild", R"({"/nodes/0/children": [5]})", {"nodes[0].children[0]", "5", "2"}},
    {"NodeMatrix", R"({"/nodes/0/matrix": [1, 2, 3]})", {"nodes[0].matrix"}},
    {"NodeScaleOverflow", R"({"/nodes/0/scale": [1e300, 1e300, 1e300]})", {"nodes[0]", "1e8"}},
    {"NodeOwnChild", R"({"/nodes/0/children": [0]})", {"nodes[0]"}},
    {"NodesInACircle", R"({"/nodes/0/children": [1], "/nodes/1/children": [0], "/scenes/0/nodes": [0]})", {"nodes[1]"}},
    {"NodeWithTwoParents", R"({"/nodes/2": {"children": [0]}, "/nodes/3": {"children": [0]}})", {"nodes[0]"}},
    {"SceneNode", R"({"/scenes/0/nodes": [0, 44]})", {"scenes[0].nodes[1]", "44", "2"}},
    {"SceneNodeTwice", R"({"/scenes/0/nodes": [0, 0]})", {"scenes[0].nodes"}},
    {"SceneMissing", R"({"/scene": 3})", {"scene", "3", "1"}},
    {"NothingInTheScene", R"({"/scenes/0/nodes": []})", {}},
    {"NoMeshes", R"({"/meshes": null, "/nodes": null, "/scenes": null, "/scene": null})", {}},
    {"BaseColor", R"({"/materials/0/pbrMetallicRoughness/baseColorFactor": [1, 1]})", {"materials[0]", "baseColorFactor"}},
    {"TextureMissing",
     R"({"/materials/0/pbrMetallicRoughness/baseColorTexture/index": 0})",
     {"materials[0].pbrMetallicRoughness.baseColorTexture.index"}},
    {"ImageOfNoView", R"({"/images": [{"bufferView": 40}]})", {"images[0].bufferView"}},
    {"ImageFileMissing",
     R"({"/images": [{"uri": "not_there.png"}], "/textures": [{"source": 0}],
         "/materials/0/pbrMetallicRoughness/baseColorTexture": {"index": 0}})",
     {"images[0].uri", "not_there.png"},
     Status::io},
    {"ImageOfNothing", R"({"/images": [{}]})", {"images[0]"}},
};

class BadJsonTest : public testing::TestWithParam<BadJson> {};

TEST_P(BadJsonTest, NamesWhatIsWrong) {
  GltfBuilder builder = test::small_plant();
  const json changes = json::parse(GetParam().changes);
  for (const auto& [pointer, value] : changes.items()) {
    if (value.is_null())
      builder.json = builder.json.patch(json::array({{{"op", "remove"}, {"path", pointer}}}));
    else
      builder.json[json::json_pointer(pointer)] = value;
  }
  expect_error(builder.glb(), GetParam().status, GetParam().names);
}

INSTANTIATE_TEST_SUITE_P(ImportGltf, BadJsonTest, testing::ValuesIn(kBadJson),
                         [](const testing::TestParamInfo<BadJson>& bad) { return std::string(bad.param.name); });

TEST(ImportGltfBad, NoSuchFile) {
  test::expect_error(import_gltf("not/there.glb", {}), Status::io, {"not/there.glb"});
}

TEST(ImportGltfBad, AFolder) {
  const test::TemporaryFolder folder;
  test::expect_error(import_gltf(folder.path(), {}), Status::io);
}

TEST(ImportGltfBad, NotGltf) {
  expect_error({}, Status::bad_file, {});
  expect_error(text("Dear diary, today I planted a hazel.\n"), Status::bad_file, {"glTF"});
  expect_error(text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 3\n"), Status::bad_file, {"git"});
  expect_error(text("{\"asset\": {\"version\": \"2.0\"}, \"meshes\": ["), Status::bad_file, {"JSON", "byte 42"});
  expect_error(text("[1, 2, 3]"), Status::bad_file, {"glTF"});
  expect_error(text("{}"), Status::bad_file, {"asset"});
  expect_error(text("{\"a\": 1e999}"), Status::bad_file, {"JSON"});
  expect_error(text("{\"asset\": {\"version\": \"2.0\"}, \"extras\": " + std::string(100000, '[')), Status::bad_file,
               {"JSON", "64", "byte 103"});
}

TEST(ImportGltfBad, GlbContainer) {
  const Bytes good = test::small_plant().glb();
  expect_error(first_bytes(good, 16), Status::bad_file, {"byte 16"});
  expect_error(first_bytes(good, good.size() - 10), Status::bad_file,
               {std::to_string(good.size()), std::to_string(good.size() - 10), "byte 8"});
  const auto with = [&](std::size_t at, const Bytes& values) {
    Bytes bytes = good;
    std::ranges::copy(values, bytes.begin() + static_cast<std::ptrdiff_t>(at));
    return bytes;
  };
  expect_error(with(4, {1}), Status::unsupported, {"byte 4"});
  expect_error(with(15, {0x7f}), Status::bad_file, {"byte 12"});
  expect_error(with(16, {'X'}), Status::bad_file, {"JSON", "byte 16"});
  expect_error(with(8, {12, 0, 0, 0}), Status::bad_file, {"byte 8"});
}

TEST(ImportGltfBad, PositionsThatAreNotNumbers) {
  for (const float value : {std::nanf(""), INFINITY}) {
    GltfBuilder builder = test::small_plant();
    std::memcpy(&builder.bin[20], &value, sizeof value);
    expect_error(builder.glb(), Status::bad_file, {"meshes[0].primitives[0]", "accessors[0] element 1"});
  }
}

TEST(ImportGltfBad, IndexBeyondTheVertices) {
  GltfBuilder builder = test::small_plant();
  builder.bin[48 + 2 * 4] = 4;
  expect_error(builder.glb(), Status::bad_file, {"meshes[0].primitives[0]", "accessors[1] element 4"});
}

TEST(ImportGltfBad, LeafPattern) {
  expect_error(test::small_plant().glb(), Status::invalid_argument, {"--leaf-material", "(("}, {.leaf_material = "(("});
  expect_error(test::small_plant().glb(), Status::invalid_argument, {"--leaf-material", "'leaves'", "'bark'"}, {.leaf_material = "pear"});
}

TEST(ImportGltfBad, NothingHasArea) {
  GltfBuilder builder = test::small_plant();
  for (const std::size_t node : {0u, 1u}) builder.json["nodes"][node]["scale"] = {0, 0, 0};
  expect_error(builder.glb(), Status::bad_file, {"'leaves'", "'bark'"});
}

TEST(ImportGltfBad, ASmallFileThatAsksForBillionsOfTriangles) {
  // 4000 nodes, each of 4000 times the same 3000 vertices: 48 billion.
  GltfBuilder builder = test::small_plant();
  const int positions = builder.add_positions(std::vector<glm::vec3>(3000, glm::vec3(1.0f, 2.0f, 3.0f)));
  builder.add_mesh({{"POSITION", positions}}, std::nullopt, 1);
  const json primitive = builder.json["meshes"].back()["primitives"][0];
  for (int i = 0; i < 4000; ++i) builder.json["meshes"].back()["primitives"].push_back(primitive);
  for (int i = 0; i < 4000; ++i) builder.add_node(2);
  expect_error(builder.glb(), Status::unsupported, {"2^26"});
}

TEST(ImportGltfBad, TooManyTrianglesAreRefusedBeforeAnyIsRead) {
  // Read, the positions would be an error: one is not a number.
  const std::vector<glm::vec3> positions(3000, glm::vec3(std::nanf(""), 0.0f, 0.0f));
  GltfBuilder shared = test::small_plant();
  shared.add_mesh({{"POSITION", shared.add_positions(positions)}}, std::nullopt, 1);
  for (int i = 0; i < 50000; ++i) shared.add_node(2);
  expect_error(shared.glb(), Status::unsupported, {"2^26", "meshes[2].primitives[0]", "50000", "1000"});

  GltfBuilder instanced = test::small_plant();
  instanced.add_mesh({{"POSITION", instanced.add_positions(positions)}}, std::nullopt, 1);
  const int node = instanced.add_node(2);
  const int places = instanced.add_positions(std::vector<glm::vec3>(50000, glm::vec3(1.0f)));
  instanced.json["nodes"][static_cast<std::size_t>(node)]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = places;
  expect_error(instanced.glb(), Status::unsupported, {"2^26", "meshes[2].primitives[0]", "50000", "1000"});

  for (int i = 0; i < 100; ++i)
    instanced.add_node(0, {{"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}});
  expect_error(instanced.glb(), Status::unsupported, {"2^22", "nodes["});
}

TEST(ImportGltfBad, TooManyElementsAreRefusedBeforeTheyAreRead) {
  for (const char* name : {"nodes", "meshes", "materials", "images"}) {
    GltfBuilder builder = test::small_plant();
    for (int i = 0; i < 300000; ++i) builder.json[name].push_back(json::object());
    expect_error(builder.glb(), Status::unsupported, {name, std::to_string(builder.json[name].size())});
  }
}

TEST(ImportGltfBad, WhatIsNotReadTakesNoPlace) {
  GltfBuilder builder = test::small_plant();
  builder.json["nodes"][0]["extras"]["list"] = std::vector<int>(1000, 7);
  builder.json["materials"][0]["extensions"]["KHR_materials_sheen"]["list"] = std::vector<int>(1000, 7);
  const auto screened = screen_gltf(builder.json.dump(), std::nullopt);
  EXPECT_FALSE(screened) << "it has no buffer";
  const Bytes text = builder.gltf();
  const auto complete = test::must(screen_gltf({reinterpret_cast<const char*>(text.data()), text.size()}, std::nullopt));
  EXPECT_EQ(complete.json.find("7,7"), std::string::npos);
  EXPECT_NE(complete.json.find("KHR_materials_sheen"), std::string::npos) << "its name is told in warnings";
}

TEST(ImportGltfBad, ImagesThatEndEarlyAreErrors) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::jpeg_without_scan());
  expect_error(builder.glb(), Status::bad_file, {"images[0]"});
  const Bytes good = test::png(3, 3, {10, 200, 30, 255});
  for (std::size_t n = 1; n < good.size(); ++n) {
    GltfBuilder cut = test::small_plant();
    cut.set_texture(0, first_bytes(good, n));
    expect_error(cut.glb(), Status::bad_file, {"images[0]"});
  }
}

TEST(ImportGltfBad, ChainOfManyNodes) {
  GltfBuilder builder = test::small_plant();
  const std::size_t first = builder.json["nodes"].size();
  for (std::size_t i = 0; i < 20000; ++i) builder.json["nodes"].push_back({{"children", {first + i + 1}}});
  builder.json["nodes"].push_back({{"mesh", 0}});
  builder.json["scenes"][0]["nodes"].push_back(first);
  const auto plant = test::must(import_bytes(builder.glb()));
  EXPECT_EQ(plant.leaves.size(), 2u);
}

TEST(ImportGltfBad, LongMaterialNameDoesNotExhaustTheStack) {
  GltfBuilder builder = test::small_plant();
  builder.json["materials"][0]["name"] = std::string(1000000, 'a');
  expect_error(builder.glb(), Status::invalid_argument, {"--leaf-material"}, {.leaf_material = "(a|b)*c"});
}

/// A plant with every kind of part, small enough to damage everywhere.
GltfBuilder varied_plant() {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(2, 2, {10, 200, 30, 128}));
  builder.json["nodes"][0]["rotation"] = {0, 0, 0, 1};
  builder.json["meshes"][1]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"material", 0}, {"mode", 3}});
  const int indices = builder.add_view(std::vector<std::uint8_t>{1});
  const int values = builder.add_view(std::vector<glm::vec3>{{2.0f, 0.0f, 0.0f}});
  builder.json["accessors"][2]["sparse"] = {
      {"count", 1}, {"indices", {{"bufferView", indices}, {"componentType", test::kUnsignedByte}}}, {"values", {{"bufferView", values}}}};
  return builder;
}

/// Whatever comes back, a plant is a plant: indices in range, leaves that tile the foliage.
void expect_consistent(const Result<Plant>& plant) {
  if (!plant) {
    EXPECT_FALSE(plant.error().message().empty());
    return;
  }
  for (const Mesh* mesh : {&plant->foliage, &plant->wood}) {
    EXPECT_EQ(mesh->indices.size(), 3 * mesh->triangle_materials.size());
    for (const std::uint32_t index : mesh->indices) ASSERT_LT(index, mesh->positions.size());
    for (const std::uint32_t material : mesh->triangle_materials) ASSERT_LT(material, plant->materials.size());
  }
  std::uint32_t next = 0;
  for (const LeafRange& leaf : plant->leaves) {
    EXPECT_EQ(leaf.first_triangle, next);
    next += leaf.triangle_count;
  }
  EXPECT_EQ(next, plant->foliage.triangle_materials.size());
}

TEST(ImportGltfBad, EveryTruncationOfAGlbIsAnError) {
  const Bytes file = varied_plant().glb();
  ASSERT_TRUE(import_bytes(file));
  for (std::size_t n = 0; n < file.size(); ++n) EXPECT_FALSE(import_bytes(first_bytes(file, n))) << n << " of " << file.size();
}

TEST(ImportGltfBad, EveryDamagedByteGivesAnErrorOrAPlant) {
  const Bytes file = varied_plant().glb();
  for (const std::uint8_t mask : std::array<std::uint8_t, 3>{0x01, 0x10, 0x80})
    for (std::size_t n = 0; n < file.size(); ++n) {
      Bytes damaged = file;
      damaged[n] = static_cast<std::uint8_t>(damaged[n] ^ mask);
      expect_consistent(import_bytes(damaged));
    }
}

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

}  // namespace coppice::bake::import_gltf_bad_test
