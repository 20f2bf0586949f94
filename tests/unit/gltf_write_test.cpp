#include "gltf_write.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <string>

#include <gtest/gtest.h>
#include <tiny_gltf.h>
#include <glm/geometric.hpp>

#include "atomic_file.h"
#include "image_decode.h"
#include "import_gltf.h"
#include "normal_sum.h"
#include "process.h"
#include "results.h"

namespace coppice::bake::gltf_write_test {

/// Two triangles of two materials over four vertices.
Mesh two_triangles() {
  Mesh mesh;
  mesh.positions = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {1.0f, 2.0f, 0.0f}, {0.0f, 2.0f, -3.0f}};
  mesh.normals.assign(4, {0.0f, 0.0f, 1.0f});
  mesh.uvs = {{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  mesh.triangle_materials = {1, 0};
  return mesh;
}

std::vector<Material> two_materials() {
  Material masked{.name = "leaves", .base_color = {0.1f, 0.25f, 0.05f, 1.0f}, .image = 0, .alpha_cutoff = 0.4f};
  Material opaque{.name = "wood", .base_color = {0.2f, 0.1f, 0.05f, 1.0f}, .roughness = 0.75f, .double_sided = false};
  return {masked, opaque};
}

Image chequers() {
  Image image{.width = 3, .height = 2, .rgba = {}};
  for (std::uint8_t i = 0; i < 24; ++i) image.rgba.push_back(static_cast<std::uint8_t>(i * 10));
  return image;
}

/// What tinygltf reads of a .glb, without complaints; images stay as they are encoded.
tinygltf::Model parse_glb(std::span<const std::uint8_t> bytes) {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(
      [](tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* encoded, int size, void*) {
        image->image.assign(encoded, encoded + size);
        return true;
      },
      nullptr);
  tinygltf::Model model;
  std::string error, warning;
  EXPECT_TRUE(loader.LoadBinaryFromMemory(&model, &error, &warning, bytes.data(), static_cast<unsigned>(bytes.size()))) << error;
  EXPECT_TRUE(warning.empty()) << warning;
  return model;
}

/// With these materials and the chequers as the only image.
tinygltf::Model written(const std::vector<GltfPart>& meshes) {
  return parse_glb(test::must(encode_glb(meshes, two_materials(), {chequers()})));
}

template <class T>
std::vector<T> values(const tinygltf::Model& model, int accessor_index) {
  const auto& accessor = model.accessors.at(static_cast<std::size_t>(accessor_index));
  const auto& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
  EXPECT_EQ(view.byteOffset % 4, 0u);
  EXPECT_EQ(view.byteLength, accessor.count * sizeof(T));
  std::vector<T> out(accessor.count);
  std::memcpy(out.data(), &model.buffers.at(0).data.at(view.byteOffset), view.byteLength);
  return out;
}

TEST(GltfWrite, MeshComesBackPerMaterial) {
  const Mesh mesh = two_triangles();
  const tinygltf::Model model = written({{"plant", &mesh}});
  ASSERT_EQ(model.meshes.size(), 1u);
  ASSERT_EQ(model.scenes.at(0).nodes.size(), 1u);
  EXPECT_EQ(model.nodes.at(0).name, "plant");
  const auto& primitives = model.meshes[0].primitives;
  ASSERT_EQ(primitives.size(), 2u);
  EXPECT_EQ(primitives[0].material, 0);
  EXPECT_EQ(values<std::uint16_t>(model, primitives[0].indices), (std::vector<std::uint16_t>{0, 2, 3}));
  EXPECT_EQ(values<std::uint16_t>(model, primitives[1].indices), (std::vector<std::uint16_t>{0, 1, 2}));
  for (const auto& primitive : primitives) {
    EXPECT_EQ(values<glm::vec3>(model, primitive.attributes.at("POSITION")), mesh.positions);
    EXPECT_EQ(values<glm::vec3>(model, primitive.attributes.at("NORMAL")), mesh.normals);
    EXPECT_EQ(values<glm::vec2>(model, primitive.attributes.at("TEXCOORD_0")), mesh.uvs);
  }
  const auto& positions = model.accessors.at(static_cast<std::size_t>(primitives[0].attributes.at("POSITION")));
  EXPECT_EQ(positions.minValues, (std::vector<double>{0.0, 0.0, -3.0}));
  EXPECT_EQ(positions.maxValues, (std::vector<double>{1.0, 2.0, 0.0}));
}

TEST(GltfWrite, MaterialsAndImagesComeBack) {
  const Mesh mesh = two_triangles();
  const tinygltf::Model model = written({{"plant", &mesh}});
  ASSERT_EQ(model.materials.size(), 2u);
  EXPECT_EQ(model.materials[0].name, "leaves");
  EXPECT_EQ(model.materials[0].alphaMode, "MASK");
  EXPECT_FLOAT_EQ(static_cast<float>(model.materials[0].alphaCutoff), 0.4f);
  EXPECT_TRUE(model.materials[0].doubleSided);
  EXPECT_EQ(model.materials[0].pbrMetallicRoughness.baseColorTexture.index, 0);
  EXPECT_EQ(model.materials[1].alphaMode, "OPAQUE");
  EXPECT_FALSE(model.materials[1].doubleSided);
  EXPECT_EQ(model.materials[1].pbrMetallicRoughness.baseColorTexture.index, -1);
  EXPECT_FLOAT_EQ(static_cast<float>(model.materials[1].pbrMetallicRoughness.baseColorFactor.at(0)), 0.2f);
  EXPECT_FLOAT_EQ(static_cast<float>(model.materials[1].pbrMetallicRoughness.roughnessFactor), 0.75f);
  EXPECT_EQ(model.materials[1].pbrMetallicRoughness.metallicFactor, 0.0);
  ASSERT_EQ(model.images.size(), 1u);
  EXPECT_EQ(model.images[0].mimeType, "image/png");
  const auto image = test::must(decode_image(model.images[0].image, 16));
  EXPECT_EQ(image.width, 3u);
  EXPECT_EQ(image.rgba, chequers().rgba);
}

TEST(GltfWrite, TranslucentLeavesAreBlendedWithTheirOpacityAsAlphaOfWhite) {
  Mesh mesh = two_triangles();
  mesh.indices = {0, 1, 2, 3, 4, 5};  // a leaf each
  for (auto* points : {&mesh.positions, &mesh.normals}) points->resize(6, glm::vec3(0, 0, 1));
  mesh.uvs.resize(6, glm::vec2(0.0f));
  mesh.triangle_materials = {0, 0};
  mesh.vertex_opacities = {kOpaque, kOpaque, kOpaque, 4, 4, 4};
  const tinygltf::Model model = written({{"leaves", &mesh}});
  ASSERT_EQ(model.materials.size(), 3u);
  EXPECT_EQ(model.materials[0].alphaMode, "MASK");
  EXPECT_EQ(model.materials[2].alphaMode, "BLEND");
  EXPECT_EQ(model.materials[2].name, model.materials[0].name);
  EXPECT_EQ(model.materials[2].pbrMetallicRoughness.baseColorTexture.index, 0);
  const auto& primitives = model.meshes.at(0).primitives;
  ASSERT_EQ(primitives.size(), 2u);
  EXPECT_EQ(primitives[0].material, 0);
  EXPECT_EQ(primitives[1].material, 2);
  EXPECT_EQ(values<std::uint16_t>(model, primitives[1].indices), (std::vector<std::uint16_t>{3, 4, 5}));
  using Color = std::array<std::uint8_t, 4>;
  const std::vector<Color> colors = values<Color>(model, primitives[1].attributes.at("COLOR_0"));
  EXPECT_EQ(colors, (std::vector<Color>{{255, 255, 255, 255},
                                        {255, 255, 255, 255},
                                        {255, 255, 255, 255},
                                        {255, 255, 255, 64},
                                        {255, 255, 255, 64},
                                        {255, 255, 255, 64}}));

  mesh.vertex_opacities.assign(6, kOpaque);
  const tinygltf::Model opaque = written({{"leaves", &mesh}});
  EXPECT_EQ(opaque.materials.size(), 2u);
  EXPECT_EQ(opaque.meshes.at(0).primitives.at(0).attributes.count("COLOR_0"), 0u);
}

TEST(GltfWrite, AlongsAreAFloatAttributeOfEachVertexAndLeftOutWithoutAny) {
  Mesh mesh = two_triangles();
  EXPECT_EQ(written({{"leaves", &mesh}}).meshes.at(0).primitives.at(0).attributes.count("_SPREAD"), 0u);
  mesh.vertex_alongs = {0.25f, -0.5f, 1.0f, -0.0f};
  const tinygltf::Model model = written({{"leaves", &mesh}});
  for (const auto& primitive : model.meshes.at(0).primitives) {
    const int spread = primitive.attributes.at("_SPREAD");
    EXPECT_EQ(model.accessors.at(static_cast<std::size_t>(spread)).componentType, TINYGLTF_COMPONENT_TYPE_FLOAT);
    EXPECT_EQ(model.accessors.at(static_cast<std::size_t>(spread)).type, TINYGLTF_TYPE_SCALAR);
    const std::vector<float> alongs = values<float>(model, spread);
    EXPECT_EQ(alongs, mesh.vertex_alongs);
    EXPECT_TRUE(std::signbit(alongs.at(3)));
  }
}

TEST(GltfWrite, EmptyMeshesAreLeftOut) {
  const Mesh mesh = two_triangles(), empty;
  EXPECT_EQ(written({{"leaves", &mesh}, {"wood", &empty}}).meshes.size(), 1u);
  const tinygltf::Model model = parse_glb(*encode_glb({{"wood", &empty}}, {}, {}));
  EXPECT_TRUE(model.meshes.empty() && model.nodes.empty() && model.buffers.empty());
}

TEST(GltfWrite, WideIndicesFromSixtyFiveThousandVertices) {
  for (const std::uint32_t vertex_count : {0xffffu, 0x10000u}) {
    Mesh mesh;
    mesh.positions.assign(vertex_count, glm::vec3(1.0f));
    mesh.normals.assign(vertex_count, {0.0f, 1.0f, 0.0f});
    mesh.uvs.assign(vertex_count, glm::vec2(0.0f));
    mesh.indices = {0, 1, vertex_count - 1};
    mesh.triangle_materials = {0};
    const tinygltf::Model model = parse_glb(*encode_glb({{"big", &mesh}}, {Material{}}, {}));
    const int indices = model.meshes.at(0).primitives.at(0).indices;
    if (vertex_count == 0xffffu)
      EXPECT_EQ(values<std::uint16_t>(model, indices).at(2), vertex_count - 1);
    else
      EXPECT_EQ(values<std::uint32_t>(model, indices).at(2), vertex_count - 1);
  }
}

TEST(GltfWrite, SameArgumentsSameBytesInTheFileToo) {
  const Mesh mesh = two_triangles();
  const auto first = encode_glb({{"plant", &mesh}}, two_materials(), {chequers()});
  const auto second = encode_glb({{"plant", &mesh}}, two_materials(), {chequers()});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second);
  const test::TemporaryFolder folder;
  ASSERT_TRUE(write_glb(folder / "plant.glb", {{"plant", &mesh}}, two_materials(), {chequers()}));
  EXPECT_EQ(*read_file(folder / "plant.glb"), *first);
}

TEST(GltfWrite, InfinitePositionIsRefusedByName) {
  Mesh mesh = two_triangles();
  mesh.positions[2].y = std::numeric_limits<float>::infinity();
  test::expect_error(encode_glb({{"twig", &mesh}}, two_materials(), {chequers()}), Status::invalid_argument, {"twig"});
}

TEST(GltfWrite, UnwritableFolderIsNamed) {
  const Mesh mesh = two_triangles();
  test::expect_error(write_glb("/nonexistent-folder/plant.glb", {{"plant", &mesh}}, two_materials(), {chequers()}), Status::io,
                     {"/nonexistent-folder/plant.glb"});
}

TEST(FoliageMesh, QuadsBecomeTwoTrianglesEach) {
  Foliage foliage;
  foliage.quads = {{{{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}}},
                   {{{2.0f, 0.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {2.0f, 0.0f, 0.0f}}}};
  foliage.cards = {1, 0};
  foliage.card_table = {{.material = 3, .uv = {}}, {.material = 5, .uv = {{{0.0f, 1.0f}, {1.0f, 1.0f}, {1.0f, 0.0f}, {0.0f, 0.0f}}}}};
  const Mesh mesh = foliage_mesh(foliage);
  EXPECT_EQ(mesh.indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7}));
  EXPECT_EQ(mesh.triangle_materials, (std::vector<std::uint32_t>{5, 5, 3, 3}));
  EXPECT_EQ(mesh.uvs.at(1), glm::vec2(1.0f, 1.0f));
  EXPECT_EQ(mesh.normals.at(2), glm::vec3(0.0f, 0.0f, 1.0f));
  EXPECT_EQ(mesh.normals.at(6), glm::vec3(0.0f, 1.0f, 0.0f)) << "a quad without area still has a unit normal";
  EXPECT_TRUE(mesh.vertex_alongs.empty());
  EXPECT_TRUE(mesh.vertex_opacities.empty());
  foliage.normals = {kFlatNormals, kFlatNormals};
  EXPECT_TRUE(foliage_mesh(foliage).vertex_alongs.empty()) << "all flat";
}

/// A quad in the plane z = 0 that faces +Z.
Foliage facing_z(std::size_t leaf_count) {
  Foliage foliage;
  foliage.quads.assign(leaf_count, {{{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}}});
  foliage.cards.assign(leaf_count, 0);
  foliage.card_table = {Card{}};
  return foliage;
}

TEST(FoliageMesh, NormalsAreAxesOnTheQuadsSideOrOnTheFront) {
  Foliage foliage = facing_z(5);
  const NormalSum away = normal_sum({0, 0.6, -0.8}, 1.0), sided = normal_sum({0, 0.6, -0.8}, 1.0, true);
  const NormalSum behind = normal_sum({0, -0.6, 0.8}, 1.0, true), many = away + normal_sum({1, 0, 0}, 0.5) + normal_sum({0, 0.8, 0.6}, 0.5);
  foliage.normals = {kFlatNormals, node_normals(away), node_normals(sided), node_normals(behind), node_normals(many)};
  foliage.opacities = {kOpaque, 12, 1, kOpaque, 3};
  const Mesh mesh = foliage_mesh(foliage);
  ASSERT_EQ(mesh.vertex_alongs.size(), 20u);
  ASSERT_EQ(mesh.vertex_opacities.size(), 20u);
  const std::array<glm::vec3, 5> axes{glm::vec3(0, 0, 1), {0, -0.6f, 0.8f}, {0, 0.6f, -0.8f}, {0, -0.6f, 0.8f}, {0, -0.6f, 0.8f}};
  const std::array alongs{1.0f, 1.0f, -1.0f, -1.0f, 0.5f};
  for (std::size_t vertex = 0; vertex < 20; ++vertex) {
    // The rounder a leaf, the coarser its axis.
    EXPECT_NEAR(glm::distance(mesh.normals[vertex], axes[vertex / 4]), 0.0f, vertex < 16 ? 0.08f : 0.42f) << vertex;
    EXPECT_NEAR(glm::length(mesh.normals[vertex]), 1.0f, 1e-5f);
    EXPECT_NEAR(mesh.vertex_alongs[vertex], alongs[vertex / 4], 0.034f) << vertex;
    EXPECT_EQ(mesh.vertex_opacities[vertex], foliage.opacities[vertex / 4]);
  }
}

TEST(FoliageMesh, ComesBackFromItsFileWithNormalsSpreadAndOpacity) {
  Foliage foliage = facing_z(3);
  for (std::size_t leaf = 0; leaf < 3; ++leaf)
    for (glm::vec3& corner : foliage.quads[leaf]) corner.z += static_cast<float>(leaf);
  foliage.normals = {node_normals(normal_sum({0, 0.6, -0.8}, 1.0, true)), kFlatNormals,
                     node_normals(normal_sum({1, 0, 0}, 0.75) + normal_sum({0, 1, 0}, 0.25))};
  foliage.opacities = {kOpaque, 5, 16};
  const Mesh mesh = foliage_mesh(foliage);
  const std::vector<std::uint8_t> file = test::must(encode_glb({{"leaves", &mesh}}, {Material{.name = "leaves"}}, {}));
  ImportOptions options;
  options.leaf_material = "";
  const Plant plant = test::must(import_gltf_bytes(file, "cut.glb", options));
  ASSERT_EQ(plant.foliage.positions.size(), 12u);
  ASSERT_EQ(plant.foliage.vertex_alongs.size(), 12u);
  ASSERT_EQ(plant.foliage.vertex_opacities.size(), 12u);
  std::size_t found = 0;
  for (std::size_t here = 0; here < 12; ++here)
    for (std::size_t there = 0; there < 12; ++there) {
      if (plant.foliage.positions[here] != mesh.positions[there]) continue;
      ++found;
      EXPECT_NEAR(glm::distance(plant.foliage.normals[here], mesh.normals[there]), 0.0f, 1e-6f);
      EXPECT_EQ(plant.foliage.vertex_alongs[here], mesh.vertex_alongs[there]);
      EXPECT_EQ(plant.foliage.vertex_opacities[here], mesh.vertex_opacities[there]);
    }
  EXPECT_EQ(found, 12u);
}

}  // namespace coppice::bake::gltf_write_test
