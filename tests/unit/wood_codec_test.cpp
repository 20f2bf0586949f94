#include "wood_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "coppice/format.h"
#include "fake_hooks.h"
#include "random_tree.h"
#include "results.h"
#include "wood_encode.h"

namespace coppice::wood_codec_test {

bake::Mesh stem() {
  return test::random_plant({.leaf_count = 4}).wood.lods[0];
}

WoodShape shape_of(const bake::EncodedWood& wood, std::uint32_t material_count = 2) {
  static const std::vector<coppice_file_material> materials(2);
  return {wood.vertex_count, wood.triangle_count, std::span(materials).first(material_count)};
}

using Corner = std::array<float, 3>;

/// Triangles as positions in eights of a quantisation step, each starting at its least corner, sorted: the same surface gives the same
/// list. position_at: of a corner
template <class PositionAt>
std::vector<std::array<Corner, 3>> surface(std::size_t corner_count, PositionAt&& position_at) {
  const float step = 2.0f / 16383.0f;  // the stem is 2 m tall; Draco quantises all axes by the longest
  std::vector<std::array<Corner, 3>> triangles(corner_count / 3);
  for (std::size_t i = 0; i < corner_count; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) triangles[i / 3][i % 3][axis] = std::round(position_at(i, axis) / (8.0f * step));
  for (auto& triangle : triangles) std::rotate(triangle.begin(), std::ranges::min_element(triangle), triangle.end());
  std::ranges::sort(triangles);
  return triangles;
}

TEST(WoodCodec, KeepsEveryTriangleWithinTheQuantisation) {
  const bake::Mesh mesh = stem();
  const auto wood = test::must(bake::encode_wood(mesh, 2));
  const auto decoded = test::must(decode_wood(wood.bytes, shape_of(wood)));
  ASSERT_EQ(decoded.indices.size(), mesh.indices.size());
  const auto before = surface(mesh.indices.size(), [&](std::size_t i, std::size_t axis) {
    return mesh.positions[mesh.indices[i]][static_cast<glm::length_t>(axis)];
  });
  const auto after =
      surface(mesh.indices.size(), [&](std::size_t i, std::size_t axis) { return decoded.vertices[decoded.indices[i]].position[axis]; });
  for (std::size_t i = 0; i < mesh.indices.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(before[i / 3][i % 3][axis], after[i / 3][i % 3][axis], 1.0f);
}

TEST(WoodCodec, NormalsStayUnitAndPointOutward) {
  const auto wood = bake::encode_wood(stem(), 2);
  const auto decoded = test::must(decode_wood(wood->bytes, shape_of(*wood)));
  for (const WoodVertex& vertex : decoded.vertices) {
    const auto& n = vertex.normal;
    EXPECT_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1.0f, 1e-4f);
    const float radius = std::hypot(vertex.position[0], vertex.position[2]);
    EXPECT_GT((n[0] * vertex.position[0] + n[2] * vertex.position[2]) / radius, 0.999f);
    EXPECT_EQ(vertex.material, 1u);
  }
}

TEST(WoodCodec, DoublesVerticesWhereMaterialsMeet) {
  bake::Mesh mesh = stem();
  for (std::size_t i = 0; i < mesh.triangle_materials.size(); i += 2) mesh.triangle_materials[i] = 0;
  const auto wood = bake::encode_wood(mesh, 2);
  const auto decoded = test::must(decode_wood(wood->bytes, shape_of(*wood)));
  std::size_t of_first = 0;
  for (std::size_t i = 0; i < decoded.indices.size(); i += 3) {
    const std::uint32_t material = decoded.vertices[decoded.indices[i]].material;
    of_first += material == 0 ? 1u : 0u;
    for (std::size_t k = 1; k < 3; ++k) EXPECT_EQ(decoded.vertices[decoded.indices[i + k]].material, material);
  }
  EXPECT_EQ(of_first, (mesh.triangle_materials.size() + 1) / 2);
}

TEST(WoodCodec, DropsTrianglesWithoutArea) {
  bake::Mesh mesh = stem();
  mesh.indices.insert(mesh.indices.end(), {0, 0, 1});
  mesh.triangle_materials.push_back(1);
  EXPECT_EQ(bake::encode_wood(mesh, 2)->triangle_count, mesh.triangle_materials.size() - 1);
  mesh.indices = {0, 0, 1};
  mesh.triangle_materials = {1};
  EXPECT_TRUE(bake::encode_wood(mesh, 2)->bytes.empty());
}

TEST(WoodCodec, EncoderRefusesBadMeshes) {
  bake::Mesh mesh = stem();
  mesh.positions[0].x = NAN;
  EXPECT_EQ(bake::encode_wood(mesh, 2).error().status, Status::invalid_argument);
  mesh = stem();
  mesh.indices[0] = 100000;
  EXPECT_EQ(bake::encode_wood(mesh, 2).error().status, Status::invalid_argument);
  EXPECT_EQ(bake::encode_wood(stem(), 1).error().status, Status::invalid_argument);
}

TEST(WoodCodec, RefusesWhatDisagreesWithTheFront) {
  auto wood = bake::encode_wood(stem(), 2);
  WoodShape shape = shape_of(*wood);
  ++shape.triangle_count;
  EXPECT_STREQ(decode_wood(wood->bytes, shape).error().what, "wood triangle count");
  shape = shape_of(*wood);
  ++shape.vertex_count;
  EXPECT_STREQ(decode_wood(wood->bytes, shape).error().what, "wood counts");
  EXPECT_STREQ(decode_wood(wood->bytes, shape_of(*wood, 1)).error().what, "wood material");
  wood->bytes.push_back(0);
  EXPECT_STREQ(decode_wood(wood->bytes, shape_of(*wood)).error().what, "wood length");
}

TEST(LeafMeshCodec, StalksComeBackAndAreAskedFor) {
  const bake::Mesh mesh = stem();
  std::vector<QuantisedPoint> stalks;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) stalks.push_back({static_cast<std::uint16_t>(16383 - i / 9), 5, 16383});
  const auto coded = test::must(bake::encode_leaf_mesh(mesh, stalks, 2, 15));
  WoodShape shape = shape_of(coded);
  EXPECT_STREQ(decode_wood(coded.bytes, shape).error().what, "wood attribute") << "wood has no stalks";
  shape.has_stalks = true;
  const auto decoded = test::must(decode_wood(coded.bytes, shape));
  std::set<QuantisedPoint> before(stalks.begin(), stalks.end()), after;
  for (const WoodVertex& vertex : decoded.vertices) after.insert(vertex.stalk);
  EXPECT_EQ(after, before);

  const auto wood = bake::encode_wood(mesh, 2);
  shape = shape_of(*wood);
  shape.has_stalks = true;
  EXPECT_STREQ(decode_wood(wood->bytes, shape).error().what, "wood attribute") << "leaf meshes have";
}

TEST(LeafMeshCodec, RefusesAStalkOutsideTheLeafBox) {
  const bake::Mesh mesh = stem();
  std::vector<QuantisedPoint> stalks(mesh.positions.size(), {0, 0, 0});
  stalks[mesh.indices[0]] = {0, 16384, 0};
  const auto coded = bake::encode_leaf_mesh(mesh, stalks, 2, 15);
  WoodShape shape = shape_of(*coded);
  shape.has_stalks = true;
  EXPECT_STREQ(decode_wood(coded->bytes, shape).error().what, "leaf mesh stalk");
  stalks.pop_back();
  EXPECT_EQ(bake::encode_leaf_mesh(mesh, stalks, 2, 15).error().status, Status::invalid_argument);
}

TEST(WoodCodec, WithoutMemoryThereIsNoMesh) {
  const auto wood = bake::encode_wood(stem(), 2);
  for (std::size_t n = 0; n < 3; ++n) {
    test::FakeAllocator allocator{.fail_at = n};
    {
      const auto mesh = decode_wood(wood->bytes, shape_of(*wood), allocator.hook());
      ASSERT_EQ(bool(mesh), n == 2);
      EXPECT_TRUE(mesh || mesh.error().status == Status::out_of_memory);
      EXPECT_EQ(allocator.live_bytes, mesh ? mesh->vertices.bytes() + mesh->indices.bytes() : 0u);
    }
    EXPECT_EQ(allocator.live_count, 0u);
  }
}

void expect_valid(const WoodMesh& mesh, const WoodShape& shape) {
  EXPECT_EQ(mesh.vertices.size(), shape.vertex_count);
  EXPECT_EQ(mesh.indices.size(), 3 * shape.triangle_count);
  for (std::uint32_t index : mesh.indices) ASSERT_LT(index, shape.vertex_count);
  for (const WoodVertex& vertex : mesh.vertices) {
    ASSERT_LT(vertex.material, shape.materials.size());
    for (float value : vertex.position) ASSERT_TRUE(std::isfinite(value));
  }
}

TEST(WoodCodec, ATruncatedOrFlippedStreamGivesAnErrorOrAValidMesh) {
  const auto wood = bake::encode_wood(stem(), 2);
  const WoodShape shape = shape_of(*wood);
  for (std::size_t length = 0; length < wood->bytes.size(); ++length) {
    const std::vector<std::uint8_t> exact(wood->bytes.data(), wood->bytes.data() + length);
    if (const auto mesh = decode_wood(exact, shape)) expect_valid(*mesh, shape);
  }
  for (std::size_t at = 0; at < wood->bytes.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<std::uint8_t> bytes(wood->bytes.begin(), wood->bytes.end());
      bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1 << bit));
      if (const auto mesh = decode_wood(bytes, shape)) expect_valid(*mesh, shape);
    }
}

}  // namespace coppice::wood_codec_test
