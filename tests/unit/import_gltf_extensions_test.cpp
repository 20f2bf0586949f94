// The forms in which a glTF may hold its meshes, instances, colours and images: each must import as the plain form does.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "gltf_builder.h"
#include "gltf_compress.h"
#include "gltf_screen.h"
#include "import_gltf.h"
#include "imported.h"
#include "mentions.h"
#include "plants_folder.h"
#include "process.h"
#include "results.h"

namespace coppice::bake::import_gltf_extensions_test {

using nlohmann::json;
using test::corner;
using test::expect_error;
using test::expect_near;
using test::expect_warning;
using test::GltfBuilder;
using test::import_built;
using test::imported;

/// Corners of a mesh's triangles, each triangle from its smallest corner on, sorted: what is the same whatever the order.
std::vector<std::array<std::array<float, 3>, 3>> sorted_triangles(const Mesh& mesh) {
  std::vector<std::array<std::array<float, 3>, 3>> triangles;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    std::array<std::array<float, 3>, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) triangle[k] = {corner(mesh, i + k).x, corner(mesh, i + k).y, corner(mesh, i + k).z};
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
    triangles.push_back(triangle);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// A strip of `count` squares, each with four vertices of its own: `count` leaves.
test::DracoMesh squares(std::uint32_t count) {
  test::DracoMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto x = static_cast<float>(2 * i);
    for (const glm::vec2 at : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
      mesh.positions.push_back({x + at.x, at.y, 0.25f * x});
      mesh.uvs.push_back(at);
    }
    mesh.triangles.push_back({4 * i, 4 * i + 1, 4 * i + 2});
    mesh.triangles.push_back({4 * i, 4 * i + 2, 4 * i + 3});
  }
  return mesh;
}

std::vector<std::uint32_t> flat(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<std::uint32_t> indices;
  for (const auto& triangle : triangles) indices.insert(indices.end(), triangle.begin(), triangle.end());
  return indices;
}

/// The small plant with those leaves instead of its one, not compressed.
GltfBuilder plain_plant(const test::DracoMesh& mesh) {
  GltfBuilder builder = test::small_plant();
  const int positions = builder.add_positions(mesh.positions), uvs = builder.add_uvs(mesh.uvs);
  builder.primitive()["attributes"] = {{"POSITION", positions}, {"TEXCOORD_0", uvs}};
  builder.primitive()["indices"] = builder.add_indices(flat(mesh.triangles));
  return builder;
}

/// plain_plant with accessors that hold nothing, and the mesh coded.
GltfBuilder draco_plant(const test::DracoMesh& mesh) {
  GltfBuilder builder = test::small_plant();
  json& primitive = builder.primitive();
  const auto add_empty = [&](int component, const char* type, std::size_t count) {
    builder.json["accessors"].push_back({{"componentType", component}, {"type", type}, {"count", count}});
    return builder.json["accessors"].size() - 1;
  };
  primitive["attributes"] = {{"POSITION", add_empty(test::kFloat, "VEC3", mesh.positions.size())}};
  json ids{{"POSITION", 0}};
  if (!mesh.uvs.empty()) {
    primitive["attributes"]["TEXCOORD_0"] = add_empty(test::kFloat, "VEC2", mesh.positions.size());
    ids["TEXCOORD_0"] = 1;
  }
  primitive["indices"] = add_empty(test::kUnsignedInt, "SCALAR", 3 * mesh.triangles.size());
  test::add_draco(builder, primitive, test::encode_draco(mesh), ids);
  return builder;
}

TEST(ImportDraco, BothMethodsGiveThePlainMesh) {
  test::DracoMesh mesh = squares(50);
  const Plant plain = imported(plain_plant(mesh));
  for (const bool edgebreaker : {true, false}) {
    mesh.edgebreaker = edgebreaker;
    const Plant plant = imported(draco_plant(mesh));
    ASSERT_EQ(plant.leaves.size(), 50u) << edgebreaker;
    EXPECT_EQ(sorted_triangles(plant.foliage), sorted_triangles(plain.foliage)) << edgebreaker;
    for (std::size_t i = 0; i < plant.foliage.positions.size(); ++i) {
      const float x = plant.foliage.positions[i].x;
      EXPECT_FLOAT_EQ(plant.foliage.uvs[i].x, std::fmod(x, 2.0f)) << x;
    }
    EXPECT_TRUE(plant.warnings.empty());
  }
}

TEST(ImportDraco, QuantisedPositionsAreWithinAStep) {
  test::DracoMesh mesh = squares(20);
  mesh.position_bits = 12;
  const Plant plant = imported(draco_plant(mesh));
  ASSERT_EQ(plant.leaves.size(), 20u);
  const float step_m = 39.0f / 4095.0f;
  float largest = 0.0f;
  for (const glm::vec3& position : plant.foliage.positions) largest = std::max(largest, position.x);
  EXPECT_NEAR(largest, 39.0f, step_m);
}

TEST(ImportDraco, AttributesThatAreNotCodedAreReadFromTheirAccessors) {
  test::DracoMesh mesh = squares(3);
  const std::vector<glm::vec2> uvs = mesh.uvs;
  mesh.uvs.clear();
  mesh.edgebreaker = false;
  GltfBuilder builder = draco_plant(mesh);
  builder.primitive()["attributes"]["TEXCOORD_0"] = builder.add_uvs(uvs);
  const Plant plant = imported(builder);
  ASSERT_EQ(plant.foliage.uvs.size(), uvs.size());
  EXPECT_EQ(std::count(plant.foliage.uvs.begin(), plant.foliage.uvs.end(), glm::vec2(1.0f, 1.0f)), 3);
}

TEST(ImportDraco, OneViewForTwoPrimitivesAndAStripBecomesTriangles) {
  GltfBuilder builder = draco_plant(squares(4));
  json second = builder.primitive();
  second["material"] = 1;
  second["mode"] = 5;
  builder.json["meshes"][0]["primitives"].push_back(second);
  const Plant plant = imported(builder);
  EXPECT_EQ(plant.leaves.size(), 4u);
  EXPECT_EQ(plant.wood.triangle_materials.size(), 8u + 1u);
}

TEST(ImportDraco, ViewsThatShareTheirBytesAreRefused) {
  GltfBuilder builder = draco_plant(squares(50));
  const json first = builder.primitive();
  const std::size_t view = first["extensions"]["KHR_draco_mesh_compression"]["bufferView"];
  for (int i = 0; i < 20; ++i) {
    json copy = first;
    copy["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = builder.json["bufferViews"].size();
    builder.json["bufferViews"].push_back(json(builder.json["bufferViews"][view]));
    builder.json["meshes"][0]["primitives"].push_back(copy);
  }
  expect_error(import_built(builder), Status::bad_file, {"plant.glb", "primitives[", "KHR_draco_mesh_compression"});
}

TEST(ImportDraco, CountsOfCodedAccessorsLimitWhatIsDecoded) {
  GltfBuilder builder = draco_plant(squares(4));
  const auto set_counts = [&builder](std::size_t count) {
    for (std::size_t i = 3; i < builder.json["accessors"].size(); ++i) builder.json["accessors"][i]["count"] = count;
  };
  set_counts(1000000000);
  expect_error(import_built(builder), Status::unsupported, {"meshes[0]", "--max-source-triangles"});
  set_counts(1000);
  EXPECT_EQ(imported(builder).leaves.size(), 4u);
  set_counts(3);
  builder.primitive()["extensions"]["KHR_draco_mesh_compression"]["triangles"] = 1000;
  expect_error(import_built(builder), Status::bad_file, {"meshes[0].primitives[0]", "KHR_draco_mesh_compression", "8", "16"});
}

TEST(ImportDraco, ColoursKeepTheirNormalisation) {
  test::DracoMesh mesh = squares(1);
  mesh.colors.assign(4, {51, 102, 255, 255});
  GltfBuilder builder = draco_plant(mesh);
  builder.json["accessors"].push_back({{"componentType", test::kUnsignedByte}, {"type", "VEC4"}, {"count", 4}, {"normalized", true}});
  builder.primitive()["attributes"]["COLOR_0"] = builder.json["accessors"].size() - 1;
  builder.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["COLOR_0"] = 2;
  const Plant plant = imported(builder);
  expect_near(glm::vec3(plant.materials.at(0).base_color), {0.2f, 0.4f, 1.0f});
}

/// Accessors of plain_plant: 3 positions, 4 uvs, 5 indices; the views have the same numbers.
TEST(ImportMeshopt, EveryModeGivesThePlainMesh) {
  const test::DracoMesh mesh = squares(300);
  const GltfBuilder plain = plain_plant(mesh);
  const auto expected = sorted_triangles(imported(plain).foliage);
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
    for (const char* mode : {"TRIANGLES", "INDICES"})
      for (const bool is_short : {false, true}) {
        GltfBuilder builder = plain;
        int indices = 5;
        if (is_short) {
          const std::vector<std::uint32_t> wide = flat(mesh.triangles);
          const int accessor = builder.add_indices(std::vector<std::uint16_t>(wide.begin(), wide.end()));
          builder.primitive()["indices"] = accessor;
          indices = builder.json["accessors"][static_cast<std::size_t>(accessor)]["bufferView"];
        }
        test::compress_view(builder, 3, {.stride = 12, .extension = extension});
        test::compress_view(builder, 4, {.stride = 8, .extension = extension});
        test::compress_view(builder, indices, {.mode = mode, .stride = is_short ? 2 : 4, .extension = extension});
        const Plant plant = imported(builder);
        EXPECT_EQ(plant.leaves.size(), 300u) << mode;
        EXPECT_EQ(sorted_triangles(plant.foliage), expected) << mode << " " << is_short;
        EXPECT_EQ(plant.foliage.uvs, imported(plain).foliage.uvs);
      }
}

/// Wood of three vertices with an attribute in four numbers, coded by one of meshoptimizer's filters.
GltfBuilder filtered(const std::string& attribute, const std::vector<std::uint8_t>& bytes, int stride, int component, bool normalized,
                     const std::string& filter) {
  GltfBuilder builder = test::small_plant();
  const int view = builder.add_view(std::span<const std::uint8_t>(bytes), stride);
  const int accessor = builder.add_accessor(view, component, "VEC3", 3, normalized);
  builder.primitive(1)["attributes"][attribute] = accessor;
  test::compress_view(builder, view, {.filter = filter, .stride = stride});
  return builder;
}

TEST(ImportMeshopt, OctahedralFilterGivesNormals) {
  const std::vector<glm::vec4> normals{{0.0f, 0.6f, 0.8f, 0.0f}, {-1.0f, 0.0f, 0.0f, 0.0f}, {0.48f, -0.6f, -0.64f, 0.0f}};
  for (const int stride : {4, 8}) {
    std::vector<std::uint8_t> bytes(3 * static_cast<std::size_t>(stride));
    meshopt_encodeFilterOct(bytes.data(), 3, static_cast<std::size_t>(stride), stride == 4 ? 8 : 16, &normals[0].x);
    const GltfBuilder builder = filtered("NORMAL", bytes, stride, stride == 4 ? test::kByte : test::kShort, true, "OCTAHEDRAL");
    const Mesh wood = imported(builder).wood;
    for (std::size_t i = 0; i < 3; ++i) expect_near(wood.normals.at(i), glm::vec3(normals[i]), stride == 4 ? 0.02f : 1e-3f);
  }
}

TEST(ImportMeshopt, ExponentialFilterGivesPositions) {
  const std::vector<glm::vec3> positions{{0.0f, -1.0f, 0.0f}, {0.5f, -1.0f, 0.125f}, {0.0f, 0.0f, 1000.0f}};
  std::vector<std::uint8_t> bytes(36);
  meshopt_encodeFilterExp(bytes.data(), 3, 12, 23, &positions[0].x);
  const Mesh wood = imported(filtered("POSITION", bytes, 12, test::kFloat, false, "EXPONENTIAL")).wood;
  for (std::size_t i = 0; i < 3; ++i) expect_near(corner(wood, i), positions[i], 1e-3f);
}

TEST(ImportMeshopt, AFallbackBufferNeedsNoMarkAndItsFileIsNotRead) {
  const test::TemporaryFolder folder;
  GltfBuilder builder = plain_plant(squares(2));
  test::compress_view(builder, 3, {.stride = 12});
  builder.json["buffers"] = {{{"byteLength", builder.bin.size()}}, {{"byteLength", builder.fallback_bytes}}};
  EXPECT_EQ(imported(builder).leaves.size(), 2u) << "no mark";
  builder.json["buffers"][1]["uri"] = "not_there.bin";
  EXPECT_FALSE(import_gltf_bytes(builder.glb(), folder / "plant.glb", {})) << "a buffer that is no fallback is read";
  builder.json["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
  EXPECT_EQ(imported(builder).leaves.size(), 2u) << "marked";
}

TEST(ImportInstancing, EachInstanceIsALeafOfItsOwn) {
  GltfBuilder builder = test::small_plant();
  const float half = std::sqrt(0.5f);
  const int translations = builder.add_positions({{10.0f, 0.0f, 0.0f}, {20.0f, 0.0f, 0.0f}, {30.0f, 1.0f, 2.0f}});
  const int scales = builder.add_positions({{1.0f, 1.0f, 1.0f}, {2.0f, 3.0f, 1.0f}, {-1.0f, 1.0f, 1.0f}});
  const int rotation_view = builder.add_view(std::vector<glm::vec4>{{0, 0, 0, 1}, {0, 0, 0, 1}, {0, half, 0, half}});
  json& node = builder.json["nodes"][0];
  json& attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes = {
      {"TRANSLATION", translations}, {"SCALE", scales}, {"ROTATION", builder.add_accessor(rotation_view, test::kFloat, "VEC4", 3)}};
  node["scale"] = {2, 2, 2};
  builder.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  Plant plant = imported(builder);
  ASSERT_EQ(plant.leaves.size(), 3u);
  // Corner 2 is (1, 1, 0): scaled, turned, moved by the instance, then by the node.
  const auto third_corner = [&](std::size_t leaf) { return corner(plant.foliage, 3 * std::size_t{plant.leaves[leaf].first_triangle} + 2); };
  expect_near(third_corner(0), {22.0f, 2.0f, 0.0f});
  expect_near(third_corner(1), {44.0f, 6.0f, 0.0f});
  // Mirrored: the winding is turned round, so that corner 2 of the triangle is vertex 1, (1, 0, 0).
  expect_near(third_corner(2), {60.0f, 2.0f, 6.0f});

  const int shorts = builder.add_view(std::vector<std::int16_t>{0, 0, 0, 32767, 0, 0, 0, 32767, 0, 23170, 0, 23170});
  attributes["ROTATION"] = builder.add_accessor(shorts, test::kShort, "VEC4", 3, true);
  plant = imported(builder);
  expect_near(third_corner(2), {60.0f, 2.0f, 6.0f}, 1e-3f);
}

TEST(ImportInstancing, QuaternionFilterAndAttributesOfOurOwn) {
  GltfBuilder builder = test::small_plant();
  const float half = std::sqrt(0.5f);
  const std::vector<glm::vec4> rotations{{0.0f, 0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, half, half}};
  std::vector<std::uint8_t> bytes(16);
  meshopt_encodeFilterQuat(bytes.data(), 2, 8, 16, &rotations[0].x);
  const int view = builder.add_view(std::span<const std::uint8_t>(bytes), 8);
  test::compress_view(builder, view, {.filter = "QUATERNION", .stride = 8});
  builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"ROTATION", builder.add_accessor(view, test::kShort, "VEC4", 2, true)},
      {"_ID", builder.add_indices(std::vector<std::uint16_t>{7, 8})}};
  const Plant plant = imported(builder);
  ASSERT_EQ(plant.leaves.size(), 2u);
  expect_near(corner(plant.foliage, 3 * std::size_t{plant.leaves[1].first_triangle} + 1), {0.0f, 1.0f, 0.0f}, 1e-3f);
}

template <class T>
std::vector<std::uint8_t> packed(const std::vector<double>& values, std::size_t per_vertex, bool normalized) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double scale = normalized ? static_cast<double>(std::numeric_limits<T>::max()) : 1.0;
    const auto value = static_cast<T>(std::lround(values[i] * scale));
    const auto* first = reinterpret_cast<const std::uint8_t*>(&value);
    bytes.insert(bytes.end(), first, first + sizeof value);
    if ((i + 1) % per_vertex == 0) bytes.resize((bytes.size() + 3) / 4 * 4);
  }
  return bytes;
}

std::vector<std::uint8_t> packed(int component, const std::vector<double>& values, std::size_t per_vertex, bool normalized) {
  switch (component) {
    case test::kByte:
      return packed<std::int8_t>(values, per_vertex, normalized);
    case test::kUnsignedByte:
      return packed<std::uint8_t>(values, per_vertex, normalized);
    case test::kShort:
      return packed<std::int16_t>(values, per_vertex, normalized);
    default:
      return packed<std::uint16_t>(values, per_vertex, normalized);
  }
}

void expect_quantised(int component, float step_count, bool normalized) {
  GltfBuilder builder = test::small_plant();
  builder.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  json& attributes = builder.primitive(1)["attributes"];
  const bool wide = component == test::kShort || component == test::kUnsignedShort;
  const auto add = [&](const std::vector<double>& values, std::size_t per_vertex, const char* type) {
    const int view = builder.add_view(packed(component, values, per_vertex, normalized), wide && per_vertex == 3 ? 8 : 4);
    return builder.add_accessor(view, component, type, 3, normalized);
  };
  attributes["POSITION"] = add({0, 0, 0, 1, 0, 0, 0, 1, 1}, 3, "VEC3");
  attributes["TEXCOORD_0"] = add({0, 1, 0.2, 0.4, 1, 0}, 2, "VEC2");
  builder.json["nodes"][1]["scale"] = {5, 5, 5};
  const Mesh wood = imported(builder).wood;
  expect_near(corner(wood, 1), {5.0f, 0.0f, 0.0f});
  expect_near(corner(wood, 2), {0.0f, 5.0f, 5.0f});
  EXPECT_EQ(wood.uvs.at(0), glm::vec2(0.0f, 1.0f));
  EXPECT_EQ(wood.uvs.at(2), glm::vec2(1.0f, 0.0f));
  if (!normalized) return;
  EXPECT_NEAR(wood.uvs.at(1).x, std::round(0.2f * step_count) / step_count, 1e-6f);
  EXPECT_NEAR(wood.uvs.at(1).y, std::round(0.4f * step_count) / step_count, 1e-6f);
  if (component != test::kUnsignedByte && component != test::kUnsignedShort) return;
  builder.json.erase("extensionsRequired");  // core glTF has these
  attributes["POSITION"] = builder.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 1}});
  EXPECT_EQ(imported(builder).wood.uvs, wood.uvs);
}

TEST(ImportQuantised, PositionsAndTextureCoordinates) {
  for (const auto& [component, steps] :
       {std::pair{test::kByte, 127.0f}, {test::kUnsignedByte, 255.0f}, {test::kShort, 32767.0f}, {test::kUnsignedShort, 65535.0f}})
    for (const bool normalized : {false, true}) {
      SCOPED_TRACE(std::to_string(component) + (normalized ? ", normalised" : ""));
      expect_quantised(component, steps, normalized);
    }
}

/// The uvs of a triangle's corners (0, 0), (1, 0), (0, 1) under a material whose texture is transformed.
std::vector<glm::vec2> transformed_uvs(const json& transform) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(1, test::png(2, 2, {9, 9, 9, 255}));
  builder.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = transform;
  builder.json["extensionsRequired"] = {"KHR_texture_transform"};
  json& attributes = builder.primitive(1)["attributes"];
  attributes["TEXCOORD_0"] = builder.add_uvs({{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}});
  attributes["TEXCOORD_3"] = builder.add_uvs({{0.5f, 0.5f}, {0.5f, 0.5f}, {0.5f, 0.5f}});
  const Plant plant = imported(builder);
  EXPECT_TRUE(plant.warnings.empty());
  return plant.wood.uvs;
}

void expect_uvs(const std::vector<glm::vec2>& actual, const std::vector<glm::vec2>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    EXPECT_NEAR(actual[i].x, expected[i].x, 1e-6f) << i;
    EXPECT_NEAR(actual[i].y, expected[i].y, 1e-6f) << i;
  }
}

TEST(ImportTextureTransform, IsBakedIntoTheUvs) {
  expect_uvs(transformed_uvs(json::object()), {{0, 0}, {1, 0}, {0, 1}});
  expect_uvs(transformed_uvs({{"offset", {0, 1}}, {"scale", {1, -1}}}), {{0, 1}, {1, 1}, {0, 0}});
  // The extension's own example: the lower left quadrant of the image, turned by 90 degrees.
  expect_uvs(transformed_uvs({{"offset", {0, 1}}, {"rotation", 1.57079632679}, {"scale", {0.5, 0.5}}}), {{0, 1}, {0, 0.5}, {0.5, 1}});
  expect_uvs(transformed_uvs({{"texCoord", 3}, {"offset", {0.25, 0}}}), {{0.75, 0.5}, {0.75, 0.5}, {0.75, 0.5}});
}

TEST(ImportVertexColours, TintTheirMaterialByTheirMean) {
  GltfBuilder builder = test::small_plant();
  builder.json["materials"][1]["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 0.5, 1.0, 1.0};
  json& attributes = builder.primitive(1)["attributes"];
  attributes["COLOR_0"] = builder.add_positions({{0.5f, 0.5f, 0.25f}, {0.5f, 0.5f, 0.25f}, {0.5f, 0.5f, 0.25f}});
  Plant plant = imported(builder);
  expect_near(glm::vec3(plant.materials.at(1).base_color), {0.5f, 0.25f, 0.25f});
  EXPECT_EQ(plant.materials.at(0).base_color, glm::vec4(1.0f));
  EXPECT_TRUE(plant.warnings.empty());

  const int view = builder.add_view(std::vector<std::uint8_t>{255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 0});
  attributes["COLOR_0"] = builder.add_accessor(view, test::kUnsignedByte, "VEC4", 3, true);
  plant = imported(builder);
  const float third = 1.0f / 3.0f;
  expect_near(glm::vec3(plant.materials.at(1).base_color), {third, 0.5f * third, third});
  ASSERT_EQ(plant.warnings.size(), 2u);
  EXPECT_TRUE(test::mentions(plant.warnings[0], {"'bark'"}));
  EXPECT_TRUE(test::mentions(plant.warnings[1], {"alpha"}));

  // A second primitive of the same material, without colours and of the same area, is white.
  json white = builder.primitive(1);
  white["attributes"].erase("COLOR_0");
  builder.json["meshes"][1]["primitives"].push_back(white);
  expect_near(glm::vec3(imported(builder).materials.at(1).base_color), {2 * third, third, 2 * third});
}

Plant weighted_plant(const GltfBuilder& builder, std::optional<std::uint32_t> wind_color_set) {
  ImportOptions options;
  options.wind_color_set = wind_color_set;
  return imported(builder, options);
}

std::vector<float> sorted(std::vector<float> values) {
  std::ranges::sort(values);
  return values;
}

TEST(ImportWindWeights, AttributesAndNamedColoursAreRead) {
  GltfBuilder builder = test::small_plant();
  EXPECT_TRUE(weighted_plant(builder, {}).wood.wind_weights.empty());
  json& bark = builder.primitive(1)["attributes"];
  bark["_WIND"] = builder.add_accessor(builder.add_view(std::vector<float>{0.25f, 2.0f, -1.0f}), test::kFloat, "SCALAR", 3);
  Plant plant = weighted_plant(builder, {});
  EXPECT_EQ(sorted(plant.wood.wind_weights), (std::vector{0.0f, 0.25f, 1.0f})) << "limited to 0..1";
  EXPECT_EQ(plant.foliage.wind_weights, std::vector<float>(4, -1.0f)) << "no other mesh has any";
  bark["_WIND_WEIGHT"] = builder.add_accessor(builder.add_view(std::vector<std::uint8_t>{51, 9, 0, 0, 102, 9, 0, 0, 255, 9, 0, 0}, 4),
                                              test::kUnsignedByte, "VEC2", 3, true);
  EXPECT_EQ(sorted(weighted_plant(builder, {}).wood.wind_weights), (std::vector{0.2f, 0.4f, 1.0f})) << "goes before _WIND";

  bark["COLOR_0"] = builder.add_positions({{0.5f, 0.1f, 0.1f}, {0.5f, 0.2f, 0.9f}, {0.75f, 0.3f, 0.2f}});
  EXPECT_EQ(sorted(weighted_plant(builder, 0).wood.wind_weights), (std::vector{0.5f, 0.5f, 0.75f}));
  EXPECT_EQ(weighted_plant(builder, 0).materials.at(1).base_color, glm::vec4(1.0f)) << "and no tint";
  EXPECT_EQ(sorted(weighted_plant(builder, {}).wood.wind_weights), (std::vector{0.2f, 0.4f, 1.0f}));
  EXPECT_NE(weighted_plant(builder, {}).materials.at(1).base_color, glm::vec4(1.0f)) << "unnamed, colours are a tint";
}

TEST(ImportWindWeights, WhatCannotBeReadIsLeftOut) {
  GltfBuilder builder = test::small_plant();
  json& bark = builder.primitive(1)["attributes"];
  bark["_WIND"] = builder.add_accessor(builder.add_view(std::vector<std::uint32_t>{1, 2, 3}), test::kUnsignedInt, "SCALAR", 3);
  const Plant plant = weighted_plant(builder, {});
  EXPECT_TRUE(plant.wood.wind_weights.empty());
  expect_warning(plant, {"_WIND"});
  bark.erase("_WIND");
  expect_warning(weighted_plant(builder, 3), {"COLOR_3"});
}

TEST(ImportSpread, IsReadWithOpacityBesideIt) {
  GltfBuilder builder = test::small_plant();
  json& leaf = builder.primitive()["attributes"];
  const std::vector<std::uint8_t> half{255, 255, 255, 128, 255, 255, 255, 128, 255, 255, 255, 128, 255, 255, 255, 0};
  leaf["COLOR_0"] = builder.add_accessor(builder.add_view(half), test::kUnsignedByte, "VEC4", 4, true);
  Plant plant = imported(builder);
  EXPECT_TRUE(plant.foliage.vertex_alongs.empty());
  EXPECT_TRUE(plant.foliage.vertex_opacities.empty()) << "alpha alone is anybody's";

  const float infinite = std::numeric_limits<float>::infinity();
  leaf["_SPREAD"] = builder.add_accessor(builder.add_view(std::vector<float>{0.25f, -0.5f, -7.0f, infinite}), test::kFloat, "SCALAR", 4);
  plant = imported(builder);
  EXPECT_EQ(sorted(plant.foliage.vertex_alongs), (std::vector{-1.0f, -0.5f, 0.25f, 1.0f}));
  std::vector<std::uint8_t> opacities = plant.foliage.vertex_opacities;
  std::ranges::sort(opacities);
  EXPECT_EQ(opacities, (std::vector<std::uint8_t>{1, 8, 8, 8})) << "nothing is drawn of 0";
  EXPECT_TRUE(plant.wood.vertex_alongs.empty());

  leaf.erase("COLOR_0");
  leaf["_SPREAD"] = builder.add_accessor(builder.add_view(std::vector<float>{1, 1, 1}), test::kFloat, "SCALAR", 3);
  plant = imported(builder);
  EXPECT_TRUE(plant.foliage.vertex_alongs.empty());
  expect_warning(plant, {"_SPREAD"});
}

TEST(ImportImages, EmbeddedAndExternalInEveryForm) {
  const test::TemporaryFolder folder;
  const std::vector<std::uint8_t> green_png = test::png(4, 2, {10, 200, 30, 255}), green_webp = test::webp(4, 2, {10, 200, 30, 255});
  test::write_file(folder / "a leaf.png", green_png);
  test::write_file(folder / "leaf.webp", green_webp);
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, green_webp);
  const json embedded = builder.json["images"][0];
  for (const json& image : {embedded, json{{"uri", "a%20leaf.png"}}, json{{"uri", "leaf.webp"}},
                            json{{"uri", "data:image/png;base64," + test::base64(green_png)}},
                            json{{"uri", "data:image/webp;base64," + test::base64(green_webp)}}}) {
    builder.json["images"][0] = image;
    const auto plant = test::must(import_gltf_bytes(builder.glb(), folder / "plant.glb", {}));
    ASSERT_EQ(plant.images.size(), 1u) << image.dump().substr(0, 60);
    EXPECT_EQ(plant.images[0].width, 4u);
    const std::array<std::uint8_t, 4> texel{10, 200, 30, 255};
    EXPECT_TRUE(std::equal(texel.begin(), texel.end(), plant.images[0].rgba.begin()));
    EXPECT_TRUE(plant.warnings.empty());
  }
}

TEST(ImportImages, WebpExtensionReplacesTheSource) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(2, 2, {255, 0, 0, 255}));
  builder.json["images"].push_back({{"bufferView", builder.add_view(test::webp(3, 3, {0, 0, 255, 255}))}, {"mimeType", "image/webp"}});
  builder.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
  EXPECT_EQ(imported(builder).images.at(0).width, 3u);
  builder.json["textures"][0].erase("source");
  builder.json["extensionsRequired"] = {"EXT_texture_webp"};
  EXPECT_EQ(imported(builder).images.at(0).width, 3u);
}

TEST(ImportImages, OfATextureWithKtx2ThePngIsTaken) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(2, 2, {255, 0, 0, 255}));
  const std::vector<std::uint8_t> ktx{0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
  builder.json["images"].push_back({{"bufferView", builder.add_view(ktx)}, {"mimeType", "image/ktx2"}});
  builder.json["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = 1;
  for (const bool required : {false, true}) {
    if (required) builder.json["extensionsRequired"] = {"KHR_texture_basisu"};
    const Plant plant = imported(builder);
    ASSERT_EQ(plant.images.size(), 1u);
    EXPECT_EQ(plant.images[0].width, 2u);
    EXPECT_TRUE(plant.warnings.empty()) << plant.warnings[0];
  }
  builder.json["textures"][0].erase("source");
  expect_error(import_built(builder), Status::unsupported,
               {"textures[0].extensions.KHR_texture_basisu", "gltf-transform", "ktxdecompress"});
  // A file that says nothing of the extension, but whose image is KTX2 all the same.
  builder.json.erase("extensionsRequired");
  builder.json["textures"][0] = {{"source", 1}};
  expect_error(import_built(builder), Status::unsupported, {"images[1]", "ktxdecompress"});
}

TEST(ImportImages, AnOpaqueMaterialShowsColoursWhateverTheirAlpha) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(2, 2, {200, 100, 50, 0}));
  builder.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
  builder.json["materials"][0]["alphaMode"] = "MASK";
  builder.json["materials"][1].erase("alphaMode");
  const Plant plant = imported(builder);
  ASSERT_EQ(plant.images.size(), 2u) << "with its holes and without";
  EXPECT_EQ(plant.images[plant.materials[0].image].rgba[3], 0);
  EXPECT_EQ(plant.images[plant.materials[1].image].rgba[3], 255);
  EXPECT_EQ(plant.images[plant.materials[1].image].rgba[0], 200);
  builder.set_texture(0, test::png(2, 2, {200, 100, 50, 255}));
  builder.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"] =
      builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  EXPECT_EQ(imported(builder).images.size(), 1u) << "without holes one does for both";
}

TEST(ImportMaterials, DiffuseOfSpecularGlossinessIsTheBaseColour) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(2, 2, {255, 0, 0, 255}));
  json& material = builder.json["materials"][0];
  json diffuse = {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"offset", {0.5, 0.0}}}}}}};
  material["pbrMetallicRoughness"] = {{"baseColorFactor", {1.0, 0.0, 1.0, 1.0}}};
  material["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {
      {"diffuseFactor", {0.5, 1.0, 0.25, 1.0}}, {"diffuseTexture", diffuse}, {"glossinessFactor", 0.25}};
  builder.json["extensionsRequired"] = {"KHR_materials_pbrSpecularGlossiness"};
  const Plant plant = imported(builder);
  EXPECT_EQ(plant.images.at(plant.materials.at(0).image).width, 2u);
  expect_near(glm::vec3(plant.materials[0].base_color), {0.5f, 1.0f, 0.25f});
  EXPECT_NEAR(plant.materials[0].roughness, 0.75f, 1e-6f);
  EXPECT_TRUE(plant.warnings.empty());
  builder.json["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"]["diffuseTexture"]["index"] = 9;
  expect_error(import_built(builder), Status::bad_file,
               {"materials[0].extensions.KHR_materials_pbrSpecularGlossiness.diffuseTexture.index"});
}

TEST(Extensions, APlantMayRequireEachThatIsKnown) {
  const auto may_require = [](std::string_view known) {
    std::string name(known);
    if (name.ends_with('*')) name.back() = 'x';
    EXPECT_TRUE(is_supported_extension(name)) << name;
    GltfBuilder builder = test::small_plant();
    builder.json["extensionsRequired"] = {name};
    EXPECT_EQ(imported(builder).leaves.size(), imported(test::small_plant()).leaves.size()) << name;
  };
  std::ranges::for_each(kReadExtensions, may_require);
  std::ranges::for_each(kOtherExtensions, may_require);
  EXPECT_FALSE(is_supported_extension("KHR_nothing"));
}

TEST(OtherFormats, OneLineSaysHowToConvert) {
  const test::TemporaryFolder folder;
  for (const auto& [name, operation] : {std::pair{"pine.obj", "wm.obj_import"}, std::pair{"Pine.FBX", "import_scene.fbx"},
                                        std::pair{"pine.usdz", "wm.usd_import"}, std::pair{"pine.blend", "wm.open_mainfile"}}) {
    test::write_file(folder / name, std::vector<std::uint8_t>{'#', '\n'});
    const Result<Plant> plant = import_gltf(folder / name, {});
    expect_error(plant, Status::unsupported, {name, "blender", "--background", operation, "export_scene.gltf"});
    EXPECT_EQ(plant.error().message().find('\n'), std::string::npos);
  }
}

TEST(ImportForms, StripsAndFansKeepTheirFront) {
  struct Form {
    int mode;
    std::vector<glm::vec3> positions;
    std::vector<std::uint16_t> indices;  ///< empty: none
  };
  const std::vector<glm::vec3> around{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, zigzag{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  // Each is the unit square, front towards +z; one strip has a repeated vertex as a seam.
  for (const Form& form : {Form{5, zigzag, {}}, Form{6, around, {}}, Form{5, around, {0, 1, 3, 2}}, Form{5, around, {0, 0, 0, 1, 3, 2, 2}},
                           Form{6, around, {0, 1, 2, 3}}}) {
    GltfBuilder builder = test::small_plant();
    const auto indices = form.indices.empty() ? std::nullopt : std::optional(builder.add_indices(form.indices));
    builder.json["nodes"][1]["mesh"] = builder.add_mesh({{"POSITION", builder.add_positions(form.positions)}}, indices, 1, form.mode);
    const Mesh wood = imported(builder).wood;
    ASSERT_EQ(wood.triangle_materials.size(), 2u) << form.mode;
    for (std::size_t t = 0; t < 2; ++t) {
      const glm::vec3 a = corner(wood, 3 * t);
      expect_near(glm::cross(corner(wood, 3 * t + 1) - a, corner(wood, 3 * t + 2) - a), {0.0f, 0.0f, 1.0f});
    }
  }
}

TEST(ImportForms, TrianglesThatRepeatOthersAreLeftOut) {
  // Each triangle once more on vertices of its own, the other way round: the back, as some tools write it.
  GltfBuilder builder = test::small_plant();
  const Plant plain = imported(builder);
  builder.primitive()["attributes"] = {
      {"POSITION", builder.add_positions({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}})}};
  builder.primitive()["indices"] = builder.add_indices(std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3, 6, 5, 4, 7, 6, 4});
  const Plant plant = imported(builder);
  EXPECT_EQ(plant.leaves.size(), plain.leaves.size());
  EXPECT_EQ(plant.foliage.triangle_materials.size(), plain.foliage.triangle_materials.size());
  for (const glm::vec3& normal : plant.foliage.normals) expect_near(normal, {0.0f, 0.0f, 1.0f});
}

TEST(ImportForms, SparseIndices) {
  GltfBuilder builder = test::small_plant();
  const int which = builder.add_view(std::vector<std::uint16_t>{3});
  const int index = builder.add_view(std::vector<std::uint16_t>{1});
  builder.json["accessors"][1]["sparse"] = {
      {"count", 1}, {"indices", {{"bufferView", which}, {"componentType", test::kUnsignedShort}}}, {"values", {{"bufferView", index}}}};
  const Plant plant = imported(builder);
  expect_near(corner(plant.foliage, 3), {1.0f, 0.0f, 0.0f});
}

TEST(ImportOptions, UpAxisAndUnit) {
  GltfBuilder builder = test::small_plant();
  builder.json["nodes"][0]["translation"] = {100, 200, 300};
  Plant plant = imported(builder, {.up = UpAxis::z, .metres_per_unit = 0.01});
  expect_near(corner(plant.foliage, 0), {1.0f, 3.0f, -2.0f});
  // The leaf's front looked along +z of the file, which is now up.
  expect_near(plant.foliage.normals.at(0), {0.0f, 1.0f, 0.0f});
  plant = imported(builder, {.metres_per_unit = 0.0254});
  expect_near(corner(plant.foliage, 0), {2.54f, 5.08f, 7.62f});
  for (const double unit : {0.0, -1.0, std::nan(""), static_cast<double>(INFINITY)})
    EXPECT_FALSE(import_built(builder, {.metres_per_unit = unit})) << unit;
}

PointBox<glm::vec3> box_of(const Plant& plant) {
  PointBox<glm::vec3> box;
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for (const glm::vec3& position : mesh->positions) box.add(position);
  return box;
}

/// A third-party plant and the same plant compressed.
void expect_plain_one(const std::string& plain_file, const std::string& compressed_file, double leaf_count, double welded_leaves) {
  COPPICE_PLANT_OR_SKIP(plain_path, plain_file);
  COPPICE_PLANT_OR_SKIP(compressed_path, compressed_file);
  const ImportOptions options{.leaf_material = "^Leaves$"};
  const auto plain = test::must(import_gltf(plain_path, options)), compressed = test::must(import_gltf(compressed_path, options));
  EXPECT_NEAR(static_cast<double>(plain.leaves.size()) / leaf_count, 1.0, 0.01) << plain.leaves.size();
  EXPECT_NEAR(static_cast<double>(compressed.leaves.size()), static_cast<double>(plain.leaves.size()), welded_leaves);
  EXPECT_EQ(compressed.images.size(), plain.images.size());
  const auto expected = box_of(plain), actual = box_of(compressed);
  // Both were quantised to 14 bits or finer.
  const float step_m = glm::length(expected.extent()) / 16384.0f;
  expect_near(actual.low, expected.low, step_m);
  expect_near(actual.high, expected.high, step_m);
  const auto triangles = static_cast<double>(plain.wood.triangle_materials.size());
  EXPECT_NEAR(static_cast<double>(compressed.wood.triangle_materials.size()), triangles, 0.001 * triangles);
}

TEST(CompressedPlant, ByDracoIsThePlainOne) {
  expect_plain_one("scopia_poplar.glb", "scopia_poplar.draco.glb", 5100, 0);
}

// Quantisation may bring two leaves together that almost touched: one pair of the coconut's leaflets.
TEST(CompressedPlant, ByMeshoptIsThePlainOne) {
  expect_plain_one("scopia_coconut.glb", "scopia_coconut.meshopt.glb", 11245, 1);
}

}  // namespace coppice::bake::import_gltf_extensions_test
