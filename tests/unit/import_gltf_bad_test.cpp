// Files that are wrong in one way each, made here or committed (tests/data/bad/gltf): one clear line that names the file, the field and the
// place, and nothing worse.

#include <sys/resource.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
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
#include "process.h"
#include "results.h"
#include "usable_memory.h"

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
  for (const std::size_t node : {0u, 1u}) builder.json["nodes"][node]["scale"] = {1, 0, 0};
  expect_error(builder.glb(), Status::bad_file, {"'leaves'", "'bark'"});
}

/// With a description of its one buffer, for screen_gltf.
GltfBuilder with_buffer(GltfBuilder builder) {
  builder.json["buffers"] = {{{"byteLength", builder.bin.size()}}};
  return builder;
}

/// What the document counts as, in triangles: the least limit under which it is read.
std::uint64_t cost_of(const GltfBuilder& builder) {
  const std::string document = builder.json.dump();
  for (std::uint64_t limit = 1; limit < 10000; ++limit)
    if (screen_gltf(document, builder.bin.size(), {limit})) return limit;
  return 0;
}

json instancing(int accessor) {
  return {{"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", accessor}}}}}}}};
}

TEST(SourceCost, TheLimitIsTheLeastThatBoundsTheProcess) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "a" / "b");
  const auto limit = [&folder](const char* group) { return group_memory_bytes(folder.path(), group); };
  EXPECT_EQ(limit("0::/a/b"), std::numeric_limits<std::uint64_t>::max());
  for (const auto& [group, bytes] : {std::pair{"a/b", "max\n"}, std::pair{"a", "3000000\n"}, std::pair{".", "5000000\n"}})
    test::write_text(folder / group / "memory.max", bytes);
  EXPECT_EQ(limit("0::/a/b"), 3000000u) << "the group above";
  EXPECT_EQ(limit("0::/"), 5000000u);
  EXPECT_EQ(limit("0::/../c"), 5000000u) << "not among those that the process sees";
  EXPECT_EQ(limit("4:memory:/a"), std::numeric_limits<std::uint64_t>::max()) << "version 1";
  EXPECT_EQ(limit(""), std::numeric_limits<std::uint64_t>::max());

  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
  const rlimit less{(std::uint64_t{1} << 30) + 1024, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &less), 0);
  const std::uint64_t triangles = CostLimit{}.triangles();
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &before), 0);
  EXPECT_LE(triangles, (1u << 20) + 1);
}

TEST(SourceCost, IsASumOfProducts) {
  GltfBuilder plain = with_buffer(test::small_plant());  // a leaf of two triangles and four vertices, a twig of one triangle
  plain.json["accessors"].push_back({{"componentType", test::kFloat}, {"type", "VEC3"}, {"count", 6}});
  ASSERT_EQ(cost_of(plain), 3u);
  struct Case {
    const char* patch;  // RFC 6902; the operation is "add"
    std::uint64_t cost;
  };
  const std::vector<Case> cases{
      {R"([{"path": "/nodes/-", "value": {"mesh": 0}}])", 3},  // the scene does not show it
      {R"([{"path": "/nodes/-", "value": {"mesh": 0}}, {"path": "/scenes/0/nodes/-", "value": 2}])", 5},
      {R"([{"path": "/nodes/-", "value": {"mesh": 0}}, {"path": "/nodes/1/children", "value": [2]}])", 5},
      {R"([{"path": "/nodes/-", "value": {"mesh": 0}}, {"path": "/scenes", "value": []}, {"path": "/scene", "op": "remove"}])", 5},
      {R"([{"path": "/nodes/0/extensions", "value": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 3}}}}])", 6 * 2 + 1},
      {R"([{"path": "/meshes/1/primitives/-", "value": {"attributes": {}, "mode": 0}}])", 3 + 1},  // points count as one
      {R"([{"path": "/meshes/0/primitives/0/mode", "value": 5}])", 6 + 1},                         // a strip has a triangle an index
      {R"([{"path": "/meshes/1/primitives/0/mode", "value": 1}])",
       2 + 3 + 3},  // separate lines have two corners and become two triangles, made once more
      {R"([{"path": "/meshes/1/primitives/0/attributes/POSITION", "value": 3}, {"path": "/meshes/1/primitives/0/indices", "value": 1}])",
       4},
      {R"([{"path": "/meshes/0/primitives", "value": []}])", 1 + 1},
      {R"([{"path": "/nodes/0/weights", "value": [0.5, 0, 1]}])", 3 + (4 + 2 * 4) / 3},
      {R"([{"path": "/meshes/0/weights", "value": [1]}, {"path": "/meshes/1/weights", "value": [0]}])", 3 + 3},
      {R"([{"path": "/skins", "value": [{"joints": [1]}]}, {"path": "/nodes/0/skin", "value": 0}])", 3 + 2},
      {R"([{"path": "/buffers/-", "value": {"byteLength": 4096, "uri": "a.bin"}}])", 3 + 4},
  };
  for (const Case& each : cases) {
    SCOPED_TRACE(each.patch);
    json patch = json::parse(each.patch);
    for (json& step : patch) step.emplace("op", "add");
    GltfBuilder builder = plain;
    builder.json.patch_inplace(patch);
    EXPECT_EQ(cost_of(builder), each.cost);
  }
}

TEST(SourceCost, OfALevelCountsPlacesAlone) {
  const GltfBuilder builder = with_buffer(test::small_plant());
  EXPECT_FALSE(screen_gltf(builder.json.dump(), builder.bin.size(), {2}));
  EXPECT_TRUE(screen_gltf(builder.json.dump(), builder.bin.size(), {2, true}));
  EXPECT_FALSE(screen_gltf(builder.json.dump(), builder.bin.size(), {1, true}));
}

TEST(SourceCost, IsRefusedWithNumbersBeforeAnythingIsRead) {
  // 4000 nodes, each of 4000 times the same 3000 vertices, which would be an error: they are not numbers.
  GltfBuilder builder = test::small_plant();
  const int positions = builder.add_positions(std::vector<glm::vec3>(3000, glm::vec3(std::nanf(""))));
  builder.add_mesh({{"POSITION", positions}}, std::nullopt, 1);
  const json primitive = builder.primitive(2);
  for (int i = 1; i < 4000; ++i) builder.json["meshes"].back()["primitives"].push_back(primitive);
  for (int i = 0; i < 4000; ++i) builder.add_node(2);
  expect_error(builder.glb(), Status::unsupported, {"meshes[2]", "4000", "4000000", "16000000003", "--max-source-triangles"});
  expect_error(test::small_plant().glb(), Status::unsupported, {"meshes[0]", "3", "2", "--max-source-triangles"},
               {.max_source_triangles = 2});
}

TEST(SourceCost, StaysAtTheLargestNumber) {
  GltfBuilder builder = test::small_plant();
  json& primitive = builder.primitive();
  builder.json["accessors"][0].erase("bufferView");
  builder.json["accessors"][0]["count"] = std::numeric_limits<std::uint64_t>::max();
  primitive.erase("indices");
  primitive["extensions"][kDracoExtension] = {{"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
  builder.add_node(0);
  builder.add_node(0);
  builder.add_node(0);
  expect_error(builder.glb(), Status::unsupported, {"meshes[0]", "18446744073709551615", "--max-source-triangles"});
}

TEST(SourceCost, ElementsThatNoBytesBackAreFew) {
  GltfBuilder builder = with_buffer(test::small_plant());
  builder.json["accessors"].push_back({{"componentType", test::kFloat}, {"type", "VEC3"}, {"count", 40000}});
  builder.add_node(0, instancing(3));
  EXPECT_TRUE(screen_gltf(builder.json.dump(), builder.bin.size()));
  builder.add_node(0, instancing(3));
  test::expect_error(screen_gltf(builder.json.dump(), builder.bin.size()), Status::bad_file, {"accessors[3].count", "40000", "65536"});
}

TEST(SourceCost, NamesThatManyNodesCopyAreShort) {
  GltfBuilder builder = test::small_plant();
  builder.json["meshes"][1]["name"] = std::string(1024, 'a');
  EXPECT_TRUE(import_bytes(builder.glb()));
  builder.json["meshes"][1]["name"] = std::string(1025, 'a');
  expect_error(builder.glb(), Status::unsupported, {"meshes[1].name", "1025", "1024"});
}

TEST(SourceCost, ImagesCountAsTheyAreDecoded) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(64, 64, {10, 200, 30, 255}));
  EXPECT_TRUE(import_bytes(builder.glb(), {.max_source_triangles = 16}));
  expect_error(builder.glb(), Status::unsupported, {"images[0]", "16", "15", "--max-source-triangles"}, {.max_source_triangles = 15});
}

// These would take minutes if they took time by the product of their lists.

TEST(SourceCost, OfTexturesIsNotTimesRequiredExtensions) {
  GltfBuilder builder = with_buffer(test::small_plant());
  builder.json["images"] = {{{"uri", "leaf.png"}}};
  for (int i = 0; i < 20000; ++i) {
    builder.json["extensionsRequired"].push_back("KHR_materials_" + std::to_string(i));
    builder.json["textures"].push_back({{"source", 0}});
  }
  EXPECT_TRUE(screen_gltf(builder.json.dump(), builder.bin.size()));
}

TEST(SourceCost, OfManyNodesIsNotTimesWhatOthersShow) {
  GltfBuilder lines = test::small_plant(), boards = lines;
  const json line{{"primitives", {{{"attributes", {{"POSITION", 2}}}, {"mode", 1}}}}};
  for (int i = 0; i < 40000; ++i) {
    lines.json["meshes"].push_back(line);
    lines.add_node(2 + i);
    boards.add_node(i % 2 == 0 ? 0 : 1, {{"name", i % 2 == 0 ? "oak" : "oak_billboard"}});
  }
  EXPECT_TRUE(import_bytes(lines.glb()));
  EXPECT_TRUE(import_bytes(boards.glb()));
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
