#include "gltf_write.h"

#include <array>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "atomic_file.h"
#include "image_decode.h"
#include "parse_glb.h"
#include "process.h"
#include "results.h"

namespace coppice::bake {
namespace gltf_write_test {

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

/// With these materials and the chequers as the only image.
tinygltf::Model written(const std::vector<GltfPart>& meshes) {
  return test::parse_glb(test::must(encode_glb(meshes, two_materials(), {chequers()})));
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

TEST(GltfWrite, TranslucentLeavesAreBlendedWithTheirOpacityAsAlphaAndTheirBrightnessAsGrey) {
  Mesh mesh = two_triangles();
  mesh.indices = {0, 1, 2, 3, 4, 5};  // a leaf each
  for (auto* points : {&mesh.positions, &mesh.normals}) points->resize(6, glm::vec3(0, 0, 1));
  mesh.uvs.resize(6, glm::vec2(0.0f));
  mesh.triangle_materials = {0, 0};
  const std::uint8_t darker = fade_of(4, 4);  // three quarters of it on a display
  mesh.vertex_fades = {kNoFade, kNoFade, kNoFade, darker, darker, darker};
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
                                        {143, 143, 143, 64},
                                        {143, 143, 143, 64},
                                        {143, 143, 143, 64}}));

  mesh.vertex_fades.assign(6, kNoFade);
  const tinygltf::Model opaque = written({{"leaves", &mesh}});
  EXPECT_EQ(opaque.materials.size(), 2u);
  EXPECT_EQ(opaque.meshes.at(0).primitives.at(0).attributes.count("COLOR_0"), 0u);
}

TEST(GltfWrite, EmptyMeshesAreLeftOut) {
  const Mesh mesh = two_triangles(), empty;
  EXPECT_EQ(written({{"leaves", &mesh}, {"wood", &empty}}).meshes.size(), 1u);
  const tinygltf::Model model = test::parse_glb(*encode_glb({{"wood", &empty}}, {}, {}));
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
    const tinygltf::Model model = test::parse_glb(*encode_glb({{"big", &mesh}}, {Material{}}, {}));
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
}

}  // namespace gltf_write_test
}  // namespace coppice::bake
