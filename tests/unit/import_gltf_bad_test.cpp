// Files that are wrong in one way each, made here or committed (tests/data/bad/gltf): one clear line that names the file, the field and the
// place, and nothing worse.

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gltf_builder.h"
#include "gltf_screen.h"
#include "import_gltf.h"
#include "imported.h"
#include "places.h"
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

/// The import failed with this status and one line that names the file and each of `names`.
void expect_line(const Result<Plant>& plant, Status status, const std::string& path, const std::vector<std::string>& names) {
  test::expect_error(plant, status, {path});
  const std::string message = plant.error().message();
  for (const std::string& name : names) EXPECT_TRUE(test::mentions(message, {name}));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_LT(message.size(), 593u + path.size()) << message;
}

void expect_error(const Bytes& bytes, Status status, const std::vector<std::string>& names, const ImportOptions& options = {}) {
  expect_line(import_bytes(bytes, options), status, "bad.glb", names);
}

/// Members of the small plant's JSON by their pointers, with other values or null for none, and what the message must name.
struct BadJson {
  const char* changes;
  std::vector<std::string> names;
};

const std::vector<BadJson> kBadJson{
    {R"({"/asset": null})", {"asset"}},
    {R"({"/extensionsRequired": 3})", {"extensionsRequired"}},
    {R"({"/buffers": [{"byteLength": 1000000000}]})", {"buffers[0].byteLength", "1000000000"}},
    {R"({"/buffers": [{"byteLength": 4}, {"byteLength": 4}]})", {"buffers[1].uri"}},
    {R"({"/images": [{"uri": "leaf.png%00"}]})", {"images[0].uri"}},
    {R"({"/buffers": [{"byteLength": 96, "uri": 5}]})", {"buffers[0].uri"}},
    {R"({"/bufferViews/1/buffer": 7})", {"bufferViews[1].buffer", "7", "1"}},
    {R"({"/bufferViews/0/byteStride": 3})", {"bufferViews[0].byteStride"}},
    {R"({"/bufferViews/0/byteStride": 4})", {"accessors[0]", "stride"}},
    {R"({"/bufferViews/0": 3})", {"bufferViews[0]"}},
    {R"({"/accessors/0/bufferView": 30})", {"accessors[0].bufferView", "30", "3"}},
    {R"({"/accessors/0/bufferView": -1})", {"accessors[0].bufferView"}},
    {R"({"/accessors/0/count": 18446744073709551615})", {"accessors[0]"}},
    {R"({"/accessors/0/count": 0})", {"accessors[0].count"}},
    {R"({"/accessors/0/count": 1.5})", {"accessors[0].count"}},
    {R"({"/accessors/0/byteOffset": 4})", {"accessors[0]", "byteOffset", "4"}},
    {R"({"/accessors/0/type": "VEC7"})", {"accessors[0].type", "VEC7"}},
    {R"({"/accessors/0/type": null})", {"accessors[0].type"}},
    {R"({"/meshes/0/primitives/0/indices": 0})", {"accessors[0]", "indices"}},
    {R"({"/accessors/0/sparse": {"count": 5, "indices": {"bufferView": 0, "componentType": 5123}, "values": {"bufferView": 0}}})",
     {"accessors[0].sparse.count"}},
    {R"({"/accessors/0/sparse": {"count": 1, "indices": {"bufferView": 9, "componentType": 5123}, "values": {"bufferView": 9}}})",
     {"accessors[0].sparse.indices.bufferView"}},
    {R"({"/meshes/0/primitives/0/attributes": null})", {"meshes[0].primitives[0].attributes"}},
    {R"({"/meshes/1/primitives/0/attributes": {"NORMAL": 0}})", {"meshes[1].primitives[0].attributes.POSITION"}},
    {R"({"/meshes/0/primitives/0/attributes/POSITION": 12})", {"meshes[0].primitives[0].attributes.POSITION", "12", "3"}},
    {R"({"/meshes/0/primitives/0/indices": 12})", {"meshes[0].primitives[0].indices"}},
    {R"({"/meshes/0/primitives/0/mode": 7})", {"meshes[0].primitives[0].mode"}},
    {R"({"/meshes/0/primitives": "x"})", {"meshes[0].primitives"}},
    {R"({"/nodes/0/mesh": 2})", {"nodes[0].mesh", "2"}},
    {R"({"/nodes/0/children": [0]})", {"nodes[0]"}},
    {R"({"/scenes/0/nodes": [0, 44]})", {"scenes[0].nodes[1]", "44", "2"}},
    {R"({"/scenes/0/nodes": [0, 0]})", {"scenes[0].nodes"}},
    {R"({"/scenes/0/nodes": []})", {}},
    {R"({"/meshes": null, "/nodes": null, "/scenes": null, "/scene": null})", {}},
    {R"({"/materials/0/pbrMetallicRoughness/baseColorTexture/index": 0})", {"materials[0].pbrMetallicRoughness.baseColorTexture.index"}},
    {R"({"/images": [{"bufferView": 40}]})", {"images[0].bufferView"}},
    {R"({"/images": [{}]})", {"images[0]"}},
};

TEST(ImportGltfBad, AMemberThatIsWrongIsNamed) {
  for (const BadJson& bad : kBadJson) {
    SCOPED_TRACE(bad.changes);
    GltfBuilder builder = test::small_plant();
    const json changes = json::parse(bad.changes);
    for (const auto& [pointer, value] : changes.items()) {
      if (value.is_null())
        builder.json = builder.json.patch(json::array({{{"op", "remove"}, {"path", pointer}}}));
      else
        builder.json[json::json_pointer(pointer)] = value;
    }
    expect_error(builder.glb(), Status::bad_file, bad.names);
  }
}

TEST(ImportGltfBad, NotGltf) {
  expect_error({}, Status::bad_file, {});
  expect_error(text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 3\n"), Status::bad_file, {"git"});
  expect_error(text("[1, 2, 3]"), Status::bad_file, {"glTF"});
  expect_error(text("{}"), Status::bad_file, {"asset"});
  expect_error(text("{\"a\": 1e999}"), Status::bad_file, {"JSON"});
  expect_error(text("{\"asset\": {\"version\": \"2.0\"}, \"extras\": " + std::string(100000, '[')), Status::bad_file,
               {"JSON", "64", "byte 103"});
}

TEST(ImportGltfBad, GlbContainer) {
  Bytes bytes = test::small_plant().glb();
  expect_error(first_bytes(bytes, 16), Status::bad_file, {"byte 16"});
  bytes[8] = 12;
  bytes[9] = 0;
  expect_error(bytes, Status::bad_file, {"byte 8"});
}

TEST(ImportGltfBad, LeafPattern) {
  expect_error(test::small_plant().glb(), Status::invalid_argument, {"--leaf-material", "(("}, {.leaf_material = "(("});
  expect_error(test::small_plant().glb(), Status::invalid_argument, {"--wood-material", "(("}, {.wood_material = "(("});
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
  instanced.node(node)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = places;
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

TEST(ImportGltfBad, ChainOfManyNodes) {
  GltfBuilder builder = test::small_plant();
  const std::size_t first = builder.json["nodes"].size();
  for (std::size_t i = 0; i < 20000; ++i) builder.json["nodes"].push_back({{"children", {first + i + 1}}});
  builder.json["nodes"].push_back({{"mesh", 0}});
  builder.json["scenes"][0]["nodes"].push_back(first);
  const auto plant = test::must(import_bytes(builder.glb()));
  EXPECT_EQ(plant.leaves.size(), 2u);
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

/// expected.txt lists the committed files, a line each: "file|status|name|name...", the status as a number.
TEST(ImportGltfBad, EachCommittedFileIsRefusedForItsReason) {
  const std::filesystem::path folder = std::filesystem::path(test::kTestData) / "bad/gltf";
  std::set<std::string> there, listed{"expected.txt"};
  for (const auto& entry : std::filesystem::directory_iterator(folder)) there.insert(entry.path().filename());
  std::ifstream list(folder / "expected.txt");
  for (std::string line; std::getline(list, line);) {
    SCOPED_TRACE(line);
    std::istringstream fields(line);
    std::string file, status;
    std::getline(fields, file, '|');
    std::getline(fields, status, '|');
    std::vector<std::string> names;
    for (std::string name; std::getline(fields, name, '|');) names.push_back(name);
    expect_line(import_gltf(folder / file, {}), static_cast<Status>(std::stoi(status)), folder / file, names);
    EXPECT_TRUE(listed.insert(file).second) << "listed twice";
  }
  EXPECT_EQ(there, listed) << "a file that no list names is never tried";
  EXPECT_GE(listed.size(), 25u);
}

}  // namespace coppice::bake::import_gltf_bad_test
