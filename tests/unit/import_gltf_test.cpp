#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "gltf_builder.h"
#include "imported.h"
#include "process.h"
#include "results.h"

namespace coppice::bake::import_gltf_test {

using nlohmann::json;
using test::corner;
using test::expect_near;
using test::expect_warning;
using test::GltfBuilder;
using test::imported;

glm::vec3 area_vector(const Mesh& mesh, std::size_t triangle) {
  const glm::vec3 a = corner(mesh, 3 * triangle);
  return 0.5f * glm::cross(corner(mesh, 3 * triangle + 1) - a, corner(mesh, 3 * triangle + 2) - a);
}

glm::vec3 total_area_vector(const Mesh& mesh) {
  glm::vec3 sum(0.0f);
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) sum += area_vector(mesh, t);
  return sum;
}

/// The wood's triangles become those of one mesh of the material "bark", on a leaf far away.
GltfBuilder wood_of(const std::vector<glm::vec3>& positions, const json& members = json::object()) {
  GltfBuilder builder = test::small_plant();
  const int mesh = builder.add_mesh({{"POSITION", builder.add_positions(positions)}}, std::nullopt, 1);
  builder.json["nodes"][1] = members;
  builder.json["nodes"][1]["mesh"] = mesh;
  return builder;
}

const std::vector<glm::vec3> kTriangle{{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};

TEST(ImportGltf, SplitsLeavesFromWoodByMaterialName) {
  const Plant plant = imported(test::small_plant());
  EXPECT_EQ(plant.name, "plant");
  ASSERT_EQ(plant.leaves.size(), 1u);
  EXPECT_EQ(plant.leaves[0].first_triangle, 0u);
  EXPECT_EQ(plant.leaves[0].triangle_count, 2u);
  EXPECT_EQ(plant.foliage.positions.size(), 4u);
  EXPECT_EQ(plant.wood.triangle_materials.size(), 1u);
  ASSERT_EQ(plant.materials.size(), 2u);
  EXPECT_EQ(plant.materials[plant.foliage.triangle_materials[0]].name, "leaves");
  EXPECT_EQ(plant.materials[plant.wood.triangle_materials[0]].name, "bark");
  EXPECT_TRUE(plant.warnings.empty());
}

TEST(ImportGltf, ReadsTextWithDataUri) {
  // By its contents, not by its name.
  const auto plant = test::must(import_gltf_bytes(test::small_plant().gltf(), "plant.glb", {}));
  EXPECT_EQ(plant.leaves.size(), 1u);
}

TEST(ImportGltf, ReadsBufferBesideTheFileEvenIfItIsLonger) {
  const test::TemporaryFolder folder;
  const GltfBuilder builder = test::small_plant();
  std::vector<std::uint8_t> bin = builder.bin;
  bin.resize(bin.size() + 100);
  test::write_file(folder / "my buffer.bin", bin);
  const auto plant = test::must(import_gltf(test::write_file(folder / "plant.gltf", builder.gltf_beside("my%20buffer.bin")), {}));
  EXPECT_EQ(plant.leaves.size(), 1u);
}

TEST(ImportGltf, NestedTransformsMultiplyFromTheRoot) {
  // (1,0,0) -> child +5 z (1,0,5) -> scale 2 (2,0,10) -> 90 degrees about y (10,0,-2) -> translate (11,2,1).
  const float half = std::sqrt(0.5f);
  GltfBuilder builder =
      wood_of({{1.0f, 0.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 0.0f}}, {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1}}});
  builder.json["nodes"].push_back({{"translation", {1, 2, 3}}, {"rotation", {0, half, 0, half}}, {"scale", {2, 2, 2}}, {"children", {1}}});
  builder.json["scenes"][0]["nodes"] = {0, 2};
  const Plant plant = imported(builder);
  expect_near(corner(plant.wood, 0), {11.0f, 2.0f, 1.0f});
  expect_near(corner(plant.wood, 2), {11.0f, 4.0f, 1.0f});
}

TEST(ImportGltf, NonUniformScaleKeepsNormalsPerpendicular) {
  GltfBuilder builder = wood_of({{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, -1.0f}, {0.0f, 1.0f, 0.0f}}, {{"scale", {4, 1, 1}}});
  const Plant plant = imported(builder);
  expect_near(plant.wood.normals.at(0), glm::normalize(total_area_vector(plant.wood)));
}

TEST(ImportGltf, MirrorFlipsWindingSoThatFrontsStayFronts) {
  const Plant plant = imported(wood_of(kTriangle, {{"scale", {-1, 1, 1}}}));
  expect_near(total_area_vector(plant.wood), {0.0f, 0.0f, 0.5f});
  expect_near(plant.wood.normals.at(0), {0.0f, 0.0f, 1.0f});
  expect_near(corner(plant.wood, 0), {0.0f, 0.0f, 0.0f});
  const Plant turned = imported(wood_of(kTriangle, {{"scale", {-1, -1, 1}}}));
  expect_near(total_area_vector(turned.wood), {0.0f, 0.0f, 0.5f});
}

TEST(ImportGltf, EveryIndexTypeGivesTheSameMesh) {
  const std::vector<std::uint8_t> indices{0, 1, 2, 0, 2, 3};
  const Mesh expected = imported(test::small_plant()).foliage;
  for (const int component : std::vector<int>{test::kUnsignedByte, test::kUnsignedShort, test::kUnsignedInt, 0}) {
    GltfBuilder builder = test::small_plant();
    json& primitive = builder.primitive();
    if (component == test::kUnsignedByte) primitive["indices"] = builder.add_indices(indices);
    if (component == test::kUnsignedInt)
      primitive["indices"] = builder.add_indices(std::vector<std::uint32_t>(indices.begin(), indices.end()));
    if (component == 0) {
      primitive.erase("indices");
      primitive["attributes"]["POSITION"] = builder.add_positions({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}});
    }
    const Plant plant = imported(builder);
    ASSERT_EQ(plant.leaves.size(), 1u) << component;
    for (std::size_t i = 0; i < 6; ++i) expect_near(corner(plant.foliage, i), corner(expected, i), 0.0f);
  }
}

TEST(ImportGltf, InterleavedAttributesByStrideAndOffset) {
  GltfBuilder builder = test::small_plant();
  const std::vector<float> interleaved{0, 0, 0, 0.1f, 0.2f, 1, 0, 0, 0.3f, 0.4f, 0, 1, 0, 0.5f, 0.6f};
  const int view = builder.add_view(interleaved, 20);
  const int mesh = builder.add_mesh({{"POSITION", builder.add_accessor(view, test::kFloat, "VEC3", 3)},
                                     {"TEXCOORD_0", builder.add_accessor(view, test::kFloat, "VEC2", 3, false, 12)}},
                                    std::nullopt, 1);
  builder.json["nodes"][1]["mesh"] = mesh;
  const Mesh wood = imported(builder).wood;
  ASSERT_EQ(wood.positions.size(), 3u);
  expect_near(wood.positions[1], {1.0f, 0.0f, 0.0f});
  EXPECT_EQ(wood.uvs[0], glm::vec2(0.1f, 0.2f));
  EXPECT_EQ(wood.uvs[2], glm::vec2(0.5f, 0.6f));
}

TEST(ImportGltf, SparseValuesReplaceTheirElements) {
  GltfBuilder builder = wood_of(kTriangle);
  const int indices = builder.add_view(std::vector<std::uint8_t>{1, 2});
  const int values = builder.add_view(std::vector<glm::vec3>{{5.0f, 0.0f, 0.0f}, {0.0f, 7.0f, 0.0f}});
  const json sparse{
      {"count", 2}, {"indices", {{"bufferView", indices}, {"componentType", test::kUnsignedByte}}}, {"values", {{"bufferView", values}}}};
  builder.json["accessors"].back()["sparse"] = sparse;
  expect_near(corner(imported(builder).wood, 1), {5.0f, 0.0f, 0.0f});
  // Without a buffer view the rest is zero.
  builder.json["accessors"].back().erase("bufferView");
  const Mesh wood = imported(builder).wood;
  expect_near(corner(wood, 0), {0.0f, 0.0f, 0.0f});
  expect_near(corner(wood, 2), {0.0f, 7.0f, 0.0f});
}

TEST(ImportGltf, QuantisedPositionsAndNormals) {
  GltfBuilder builder = wood_of(kTriangle, {{"scale", {0.5, 0.5, 0.5}}});
  builder.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  json& attributes = builder.json["meshes"].back()["primitives"][0]["attributes"];
  const int positions = builder.add_view(std::vector<std::int16_t>{0, 0, 0, 0, -100, 0, 0, 0, 0, 100, 0, 0}, 8);
  attributes["POSITION"] = builder.add_accessor(positions, test::kShort, "VEC3", 3);
  const int normals = builder.add_view(std::vector<std::int8_t>{0, 0, -127, 0, 0, 0, -128, 0, 0, 0, 127, 0}, 4);
  attributes["NORMAL"] = builder.add_accessor(normals, test::kByte, "VEC3", 3, true);
  const Mesh wood = imported(builder).wood;
  expect_near(wood.positions[1], {-50.0f, 0.0f, 0.0f});
  expect_near(wood.normals[0], {0.0f, 0.0f, -1.0f});
  expect_near(wood.normals[1], {0.0f, 0.0f, -1.0f});
  expect_near(wood.normals[2], {0.0f, 0.0f, 1.0f});
}

TEST(ImportGltf, AMeshSharedByManyNodesGivesOneLeafEach) {
  GltfBuilder builder = test::small_plant();
  // Side by side, edge on edge: positions coincide, but the nodes keep the leaves apart.
  for (int i = 1; i < 100; ++i) builder.add_node(0, {{"translation", {i, 0, 0}}});
  const Plant plant = imported(builder);
  ASSERT_EQ(plant.leaves.size(), 100u);
  expect_near(corner(plant.foliage, std::size_t{3} * plant.leaves[57].first_triangle), {57.0f, 0.0f, 0.0f});
}

TEST(ImportGltf, MissingMaterialNormalsAndUvs) {
  GltfBuilder builder = wood_of(kTriangle);
  builder.json["meshes"].back()["primitives"][0].erase("material");
  const Plant plant = imported(builder);
  EXPECT_EQ(plant.materials.at(plant.wood.triangle_materials.at(0)).name, "default");
  for (std::size_t i = 0; i < 3; ++i) {
    expect_near(plant.wood.normals.at(i), {0.0f, 0.0f, 1.0f});
    EXPECT_EQ(plant.wood.uvs.at(i), glm::vec2(0.0f));
  }
}

TEST(ImportGltf, NormalsThatAreNotAreComputed) {
  GltfBuilder builder = wood_of(kTriangle);
  const float nan = std::nanf("");
  builder.json["meshes"].back()["primitives"][0]["attributes"]["NORMAL"] =
      builder.add_positions({{0.0f, 0.0f, 0.0f}, {nan, 0.0f, 1.0f}, {0.0f, 3.0f, 4.0f}});
  const Mesh wood = imported(builder).wood;
  expect_near(wood.normals[0], {0.0f, 0.0f, 1.0f});
  expect_near(wood.normals[1], {0.0f, 0.0f, 1.0f});
  expect_near(wood.normals[2], {0.0f, 0.6f, 0.8f});
}

TEST(ImportGltf, TheTexturesOwnUvSet) {
  GltfBuilder builder = wood_of(kTriangle);
  builder.set_texture(1, test::png(2, 2, {9, 9, 9, 255}));
  builder.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  json& attributes = builder.json["meshes"].back()["primitives"][0]["attributes"];
  attributes["TEXCOORD_0"] = builder.add_uvs({{0.0f, 0.0f}, {0.0f, 0.0f}, {0.0f, 0.0f}});
  attributes["TEXCOORD_1"] = builder.add_uvs({{0.5f, 0.5f}, {0.0f, 0.0f}, {0.0f, 0.0f}});
  EXPECT_EQ(imported(builder).wood.uvs[0], glm::vec2(0.5f));
}

TEST(ImportGltf, APatternNamesTheLeaves) {
  const Plant swapped = imported(test::small_plant(), {.leaf_material = "^b.rk$"});
  EXPECT_EQ(swapped.leaves.size(), 1u);
  EXPECT_EQ(swapped.foliage.triangle_materials.size(), 1u);
  EXPECT_EQ(swapped.wood.triangle_materials.size(), 2u);
}

TEST(ImportGltf, WoodPatternAndClasses) {
  const ClassRule bark_is_leaf{.material = "bark", .part = PlantPart::leaf, .source = "test"};
  EXPECT_EQ(imported(test::small_plant(), {.wood_material = "^lea", .classes = {bark_is_leaf}}).leaves.size(), 1u);
  EXPECT_EQ(imported(test::small_plant(), {.classes = {bark_is_leaf}}).leaves.size(), 2u) << "the other is found out";
  const Plant shown = imported(test::small_plant(), {.wood_material = "."});
  EXPECT_TRUE(shown.leaves.empty());
  EXPECT_EQ(shown.wood.triangle_materials.size(), 3u);
  EXPECT_EQ(shown.warnings.size(), 1u);
  ASSERT_EQ(shown.classes.size(), 2u);
  EXPECT_EQ(shown.classes[0].reason, "--wood-material");
  expect_warning(imported(test::small_plant(), {.wood_material = "brak"}), {"'brak'"});
}

TEST(ImportGltf, APlantWithoutLeavesIsAllWoodAndSaysSoOnce) {
  test::GltfBuilder builder;
  const int crown = builder.add_positions({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}});
  const int indices =
      builder.add_indices(std::vector<std::uint16_t>{0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5});
  const int material = builder.add_material("leaves");
  builder.add_node(builder.add_mesh({{"POSITION", crown}}, indices, material));
  for (const char* name : {"leaves", "paint", "bark"}) {
    builder.json["materials"][0]["name"] = name;
    const Plant plant = imported(builder);
    EXPECT_TRUE(plant.leaves.empty());
    EXPECT_EQ(plant.wood.triangle_materials.size(), 8u);
    expect_warning(plant, {"--leaf-material"});
  }
}

TEST(ImportGltf, FoliageWithoutAreaBesideWood) {
  GltfBuilder builder = test::small_plant();
  builder.json["nodes"][0]["scale"] = {1, 0, 0};
  const Plant plant = imported(builder);
  EXPECT_TRUE(plant.leaves.empty());
  EXPECT_EQ(plant.wood.triangle_materials.size(), 1u);
  ASSERT_EQ(plant.warnings.size(), 2u);
  EXPECT_TRUE(test::mentions(plant.warnings[0], {"1"}));
}

TEST(ImportGltf, ScenesDecideWhatThereIs) {
  GltfBuilder builder = test::small_plant();
  builder.json["scenes"].push_back({{"nodes", {0}}});
  EXPECT_EQ(imported(builder).wood.triangle_materials.size(), 1u);
  builder.json["scene"] = 1;
  EXPECT_EQ(imported(builder).wood.triangle_materials.size(), 0u);
  builder.json.erase("scene");
  EXPECT_EQ(imported(builder).wood.triangle_materials.size(), 1u) << "the first scene where none is the default";
  builder.json.erase("scenes");
  EXPECT_EQ(imported(builder).wood.triangle_materials.size(), 1u) << "every root where there are no scenes";
}

/// Foliage of triangles that share no vertices: [a b c] [d e f] ...
Plant triangles(const std::vector<glm::vec3>& positions) {
  GltfBuilder builder = test::small_plant();
  builder.primitive() = {{"attributes", {{"POSITION", builder.add_positions(positions)}}}, {"material", 0}};
  return imported(builder);
}

TEST(ImportGltf, SeamsDoNotSplitLeavesAndGapsDo) {
  const auto at_gap = [](float gap) { return triangles({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {gap, 0, 0}, {1.0f + gap, 1, 0}, {0, 1, 0}}); };
  EXPECT_EQ(at_gap(0.0f).leaves.size(), 1u);
  const Plant rounded = at_gap(2e-7f);
  EXPECT_EQ(rounded.leaves.size(), 1u);
  EXPECT_EQ(corner(rounded.foliage, 3), corner(rounded.foliage, 0)) << "welded positions become equal";
  EXPECT_EQ(at_gap(1e-4f).leaves.size(), 2u);
}

TEST(ImportGltf, LeavesWithoutAreaAreDroppedAndCounted) {
  // A leaf, a point, a line, and a sliver of the first.
  const Plant plant = triangles(
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(plant.leaves.size(), 1u);
  EXPECT_EQ(plant.leaves.at(0).triangle_count, 1u);
  expect_warning(plant, {"2"});
}

TEST(ImportGltf, MaterialsAreRead) {
  GltfBuilder builder = test::small_plant();
  builder.json["materials"][0].update({{"alphaMode", "MASK"}, {"alphaCutoff", 0.25}, {"doubleSided", true}});
  builder.json["materials"][0]["pbrMetallicRoughness"] = {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"roughnessFactor", 0.75}};
  builder.json["materials"][1]["alphaMode"] = "BLEND";
  const Plant plant = imported(builder);
  const Material& leaves = plant.materials.at(0);
  EXPECT_EQ(leaves.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(leaves.alpha_cutoff, 0.25f);
  EXPECT_EQ(leaves.roughness, 0.75f);
  EXPECT_TRUE(leaves.double_sided);
  EXPECT_EQ(leaves.image, kNone);
  EXPECT_EQ(plant.materials.at(1).alpha_cutoff, 0.5f);
  EXPECT_FALSE(plant.materials.at(1).double_sided);
  expect_warning(plant, {"'bark'"});
}

TEST(ImportGltf, NormalMapsAreReadWithTheirScale) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(1024, 1024, {204, 128, 230, 255}));  // (0.6, 0, 0.8)
  builder.json["materials"][0]["normalTexture"] = {{"index", 0}};
  builder.json["materials"][1]["normalTexture"] = {{"index", 0}, {"scale", 2.0}};
  const Plant plant = imported(builder);
  EXPECT_TRUE(plant.warnings.empty()) << plant.warnings[0];
  ASSERT_EQ(plant.images.size(), 3u) << "a colour and two maps";
  EXPECT_FALSE(plant.images.at(plant.materials.at(0).image).is_normal_map);
  const auto first_texel = [&](std::size_t material) {
    const Image& map = plant.images.at(plant.materials.at(material).normal_map);
    EXPECT_TRUE(map.is_normal_map);
    EXPECT_EQ(map.width, 512u);
    return std::vector<std::uint8_t>(map.rgba.begin(), map.rgba.begin() + 4);
  };
  EXPECT_EQ(first_texel(0), (std::vector<std::uint8_t>{204, 128, 230, 255}));
  const std::vector<std::uint8_t> scaled = first_texel(1);  // (1.2, 0, 0.8), made unit
  EXPECT_NEAR(scaled[0], 127.5 * (1 + 1.2 / std::hypot(1.2, 0.8)), 1.5);
  EXPECT_NEAR(scaled[2], 127.5 * (1 + 0.8 / std::hypot(1.2, 0.8)), 1.5);
}

TEST(ImportGltf, ANormalMapWithUvsOfItsOwnIsLeftOut) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(2, 2, {128, 128, 255, 255}));
  builder.json["materials"][0]["normalTexture"] = {{"index", 0}, {"texCoord", 1}};
  const Plant plant = imported(builder);
  EXPECT_EQ(plant.materials.at(0).normal_map, kNone);
  expect_warning(plant, {"'leaves'"});
}

TEST(ImportGltf, ImagesAreDecodedSharedAndLimitedTo512) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(1024, 256, {200, 100, 50, 128}));
  builder.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
  for (auto& material : builder.json["materials"]) material["alphaMode"] = "MASK";
  const Plant plant = imported(builder);
  ASSERT_EQ(plant.images.size(), 1u);
  EXPECT_EQ(plant.images[0].width, 512u);
  EXPECT_EQ(plant.images[0].height, 128u);
  EXPECT_EQ(plant.materials[0].image, 0u);
  EXPECT_EQ(plant.materials[1].image, 0u);
  const std::vector<int> expected{200, 100, 50, 128};
  for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(plant.images[0].rgba.at(4 * 1000 + c), expected[c], 1);
}

TEST(ImportGltf, WhatTheMaskHidesDoesNotBleedIntoTheColour) {
  // Columns of opaque green and of invisible red, halved: the mean is green.
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::striped_png(1024, {0, 255, 0, 255}, {255, 0, 0, 0}));
  builder.json["materials"][0]["alphaMode"] = "MASK";
  const Plant plant = imported(builder);
  ASSERT_EQ(plant.images.at(0).width, 512u);
  const std::uint8_t* texel = &plant.images[0].rgba.at(4 * 100);
  EXPECT_LT(texel[0], 8);
  EXPECT_GT(texel[1], 247);
  EXPECT_NEAR(texel[3], 128, 2);
}

}  // namespace coppice::bake::import_gltf_test
