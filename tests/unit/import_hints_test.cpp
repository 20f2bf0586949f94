// What a file holds that a plant has not, or has otherwise: each is said, and nothing is lost in silence.

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "encoded_images.h"
#include "gltf_builder.h"
#include "imported.h"
#include "mentions.h"
#include "process.h"
#include "results.h"
#include "texture_regions.h"

namespace coppice::bake::import_hints_test {

using nlohmann::json;
using test::expect_warning;
using test::GltfBuilder;
using test::imported;
using Bytes = std::vector<std::uint8_t>;

Bytes text(const std::string& characters) {
  return {characters.begin(), characters.end()};
}

TEST(ImportHints, EmittedLightIsNamedOnce) {
  GltfBuilder builder = test::small_plant();
  EXPECT_TRUE(imported(builder).warnings.empty());
  builder.json["materials"][0]["emissiveFactor"] = {0, 0, 0};
  EXPECT_TRUE(imported(builder).warnings.empty()) << "it is dark";
  for (auto& material : builder.json["materials"]) material["emissiveFactor"] = {0, 0.5, 0};
  expect_warning(imported(builder), {"'leaves'", "'bark'"});
}

TEST(ImportHints, OtherScenesCamerasAndLightsAreCounted) {
  GltfBuilder builder = test::small_plant();
  const auto scenery = [&] {
    const Bytes file = builder.glb();
    const test::TemporaryFolder folder;
    return test::must(read_contents(test::write_file(folder / "plant.glb", file), {})).scenery;
  };
  EXPECT_TRUE(scenery().empty());
  builder.json["scenes"].push_back({{"nodes", {0}}});
  builder.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
  builder.add_node(-1, {{"camera", 0}});
  builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}}};
  for (int i = 0; i < 3; ++i) builder.add_node(-1, {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  EXPECT_TRUE(test::mentions(scenery(), {"1", "3"}));
  EXPECT_TRUE(imported(builder).warnings.empty()) << "no plant lacks them";
}

TEST(ImportHints, AnEmptyDefaultSceneIsNotTheOnlyOne) {
  GltfBuilder builder = test::small_plant();
  const json empty = {{"nodes", json::array()}};
  builder.json["scenes"].insert(builder.json["scenes"].begin(), empty);
  const auto plant = test::import_built(builder);
  ASSERT_FALSE(plant);
  EXPECT_TRUE(test::mentions(plant.error().message(), {"no triangles", "2 scenes"}));
}

TEST(ImportHints, ImagesWithoutTextureCoordinates) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::striped_png(8, {20, 200, 20, 255}, {10, 100, 10, 255}));
  builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  expect_warning(imported(builder), {"'leaves'", "TEXCOORD_1"});
}

TEST(ImportHints, HolesThatAnOpaqueMaterialDoesNotShow) {
  const auto holes = test::striped_png(8, {20, 200, 20, 255}, {0, 0, 0, 0});
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, holes);
  expect_warning(imported(builder), {"'leaves'", "MASK"});
  builder.json["materials"][1]["pbrMetallicRoughness"] = builder.json["materials"][0]["pbrMetallicRoughness"];
  builder.json["materials"][0]["alphaMode"] = "MASK";
  EXPECT_TRUE(imported(builder).warnings.empty()) << "the bark shows another part of the leaves' image";
  GltfBuilder packed = test::small_plant();
  packed.set_texture(0, test::striped_png(8, {20, 200, 20, 90}, {20, 200, 20, 160}));
  EXPECT_TRUE(imported(packed).warnings.empty()) << "that is no mask";
}

TEST(ImportHints, BlackVertexColours) {
  GltfBuilder builder = test::small_plant();
  const int black = builder.add_view(std::vector<glm::vec4>(4, glm::vec4(0.0f, 0.0f, 0.0f, 1.0f)));
  builder.primitive()["attributes"]["COLOR_0"] = builder.add_accessor(black, test::kFloat, "VEC4", 4);
  expect_warning(imported(builder), {"'leaves'", "COLOR_0"});
}

TEST(ImportHints, ABaseColourThatIsNotReadIsAnErrorAndANormalMapIsNot) {
  const Bytes dds = text("DDS |\x07"), pointer = text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 3\n");
  for (const Bytes& image : {test::empty_pnm(), test::empty_tga(), Bytes{1, 2, 3, 4}, dds, pointer}) {
    GltfBuilder builder = test::small_plant();
    builder.set_texture(0, image);
    test::expect_error(test::import_built(builder), Status::unsupported, {"images[0]"});
    builder.json["materials"][0]["normalTexture"]["index"] = 0;
    builder.json["materials"][0].erase("pbrMetallicRoughness");
    builder.json["materials"][1]["normalTexture"]["index"] = 0;
    const Plant plant = imported(builder);
    expect_warning(plant, {"images[0]"});
    EXPECT_EQ(plant.materials.at(0).normal_map, kNone);
  }
}

TEST(ImportHints, AMissingOrDamagedNormalMapIsAWarning) {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::jpeg_without_scan());
  builder.json["materials"][0].erase("pbrMetallicRoughness");
  builder.json["materials"][0]["normalTexture"]["index"] = 0;
  expect_warning(imported(builder), {"images[0]"});
  builder.json["images"][0] = {{"uri", "not_there.png"}};
  expect_warning(imported(builder), {"images[0].uri", "not_there.png"});
}

TEST(NearUvs, ALeafMovesAsAWholeByWholeNumbers) {
  Mesh mesh;
  // Two leaves of a triangle each, and a leaf of two triangles that share no vertex, over an edge of the image.
  mesh.uvs = {{4000.25f, -999.5f}, {4000.75f, -999.5f}, {4000.5f, -999.25f}, {3.25f, 0.5f},    {3.5f, 0.5f},    {3.5f, 0.75f},
              {999.5f, 0.0f},      {999.75f, 0.0f},     {999.5f, 0.5f},      {1000.25f, 0.0f}, {1000.5f, 0.0f}, {1000.25f, 0.5f}};
  mesh.positions.resize(mesh.uvs.size());
  for (std::uint32_t i = 0; i < 12; ++i) mesh.indices.push_back(i);
  mesh.triangle_materials.assign(4, 0);
  const std::vector<LeafRange> leaves{{0, 1}, {1, 1}, {2, 2}};
  const std::vector<glm::vec2> before = mesh.uvs;
  bring_uvs_near_zero(mesh, leaves);
  EXPECT_EQ(mesh.uvs[0], glm::vec2(0.25f, 0.5f));
  EXPECT_EQ(mesh.uvs[2], glm::vec2(0.5f, 0.75f));
  for (std::size_t i = 3; i < 6; ++i) EXPECT_EQ(mesh.uvs[i], before[i]) << "near enough";
  EXPECT_EQ(mesh.uvs[9].x - mesh.uvs[6].x, 0.75f);
  EXPECT_LT(std::abs(mesh.uvs[6].x), 2.0f);
}

TEST(NearUvs, ImportedLeavesAndWood) {
  GltfBuilder builder = test::small_plant();
  json& meshes = builder.json["meshes"];
  meshes[0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
      builder.add_uvs({{1000.0f, 4000.0f}, {1001.0f, 4000.0f}, {1001.0f, 4001.0f}, {1000.0f, 4001.0f}});
  meshes[1]["primitives"][0]["attributes"]["TEXCOORD_0"] = builder.add_uvs({{-3000.0f, 0.0f}, {-2999.5f, 0.0f}, {-3000.0f, 0.5f}});
  const Plant plant = imported(builder);
  EXPECT_EQ(plant.foliage.uvs.at(2), glm::vec2(1.0f));
  EXPECT_EQ(plant.wood.uvs.at(1), glm::vec2(0.5f, 0.0f));
}

}  // namespace coppice::bake::import_hints_test
