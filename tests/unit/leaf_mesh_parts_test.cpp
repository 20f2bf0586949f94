#include "leaf_mesh_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "coppice/format.h"
#include "error_image.h"
#include "error_table.h"
#include "inspect.h"
#include "item_areas.h"
#include "leaf_cards.h"
#include "mentions.h"
#include "mesh_error.h"
#include "packed_plant.h"
#include "reader.h"
#include "results.h"
#include "test_foliage.h"
#include "texture_regions.h"
#include "tree_order.h"
#include "unpack.h"
#include "visibility.h"

namespace coppice::bake::leaf_mesh_parts_test {

Quad square_at(const glm::vec3& center, float half) {
  return test::rectangle(center - glm::vec3(half, half, 0), {2 * half, 0, 0}, {0, 2 * half, 0});
}

/// A leaf of `rows` strips, two triangles each, that fills the square, with uvs from (u, 0) to (u + 1, 1).
void add_leaf(Plant& plant, Foliage& foliage, const Quad& square, std::uint32_t rows, float u = 0.0f) {
  Mesh& mesh = plant.foliage;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  plant.leaves.push_back({static_cast<std::uint32_t>(mesh.triangle_materials.size()), 2 * rows});
  for (std::uint32_t row = 0; row <= rows; ++row) {
    const float share = static_cast<float>(row) / static_cast<float>(rows);
    mesh.positions.push_back(square[0] + share * (square[1] - square[0]));
    mesh.positions.push_back(square[3] + share * (square[2] - square[3]));
    mesh.uvs.insert(mesh.uvs.end(), {{u, share}, {u + 1.0f, share}});
    mesh.normals.insert(mesh.normals.end(), 2, {0, 0, 1});
  }
  for (std::uint32_t row = 0; row < rows; ++row) {
    const std::uint32_t a = first + 2 * row;
    mesh.indices.insert(mesh.indices.end(), {a, a + 2, a + 3, a, a + 3, a + 1});
    mesh.triangle_materials.insert(mesh.triangle_materials.end(), {0, 0});
  }
  foliage.quads.push_back(square);
  foliage.cards.push_back(0);
  foliage.card_table = {{0, {glm::vec2(0, 0), glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0)}}};
}

TEST(KeepLeafMeshes, LeavesThatAreQuadsNeedNone) {
  Plant plant;
  Foliage foliage;
  for (int i = 0; i < 3; ++i) add_leaf(plant, foliage, square_at({static_cast<float>(i) * 3.0f, 0, 0}, 1.0f), 1);
  const KeptLeafMeshes none = keep_leaf_meshes(plant, foliage);
  EXPECT_TRUE(none.meshes.parts.empty());
  EXPECT_NE(none.note, "");
  EXPECT_FALSE(none.too_large);

  add_leaf(plant, foliage, square_at({9, 0, 0}, 1.0f), 2);
  const KeptLeafMeshes all = keep_leaf_meshes(plant, foliage);
  EXPECT_EQ(triangle_count(all.meshes), 3u * 2u + 4u) << "one leaf that is none, and all are drawn as meshes";
  EXPECT_TRUE(all.note.empty()) << all.note;
}

TEST(KeepLeafMeshes, AQuadThatIsFoldedAlongTheOtherDiagonalIsNotTheLeaf) {
  for (const float raised_m : {0.0f, 0.5f}) {
    Plant plant;
    Foliage foliage;
    add_leaf(plant, foliage, square_at({0, 0, 0}, 1.0f), 1);
    plant.foliage.positions[1].z = foliage.quads[0][3].z = raised_m;
    plant.foliage.indices = {0, 2, 1, 1, 2, 3};  // the edge runs from corner 1 to 3, the quad's from 0 to 2
    EXPECT_EQ(keep_leaf_meshes(plant, foliage).meshes.parts.empty(), raised_m == 0.0f) << "flat, both are the same";
    plant.foliage.indices = {0, 2, 3, 0, 3, 1};
    EXPECT_TRUE(keep_leaf_meshes(plant, foliage).meshes.parts.empty());
  }
}

TEST(KeepLeafMeshes, PartsHoldWholeLeavesAndAreAboutEquallyLarge) {
  Plant plant;
  Foliage foliage;
  constexpr std::uint32_t kLeaves = 700, kRows = 50;  // 70,000 triangles
  for (std::uint32_t i = 0; i < kLeaves; ++i)
    add_leaf(plant, foliage, square_at({static_cast<float>(i * 37 % kLeaves) * 3.0f, static_cast<float>(i), 0}, 1.0f), kRows);
  const LeafMeshes meshes = keep_leaf_meshes(plant, foliage).meshes;
  ASSERT_EQ(meshes.parts.size(), 2u);
  for (const LeafMeshPart& part : meshes.parts) {
    EXPECT_EQ(part.mesh.triangle_materials.size(), 35000u);
    ASSERT_EQ(part.stalks.size(), part.mesh.positions.size());
    for (std::size_t corner = 0; corner < part.mesh.indices.size(); ++corner) {
      const std::uint32_t vertex = part.mesh.indices[corner];
      ASSERT_EQ(part.stalks[vertex], part.stalks[part.mesh.indices[corner / 3 * 3]]) << "a triangle of two leaves";
      // The leaf reaches from its stalk, corner 0 of its quad, 2 m to the right and up.
      ASSERT_GE(part.mesh.positions[vertex].x, part.stalks[vertex].x);
      ASSERT_LE(part.mesh.positions[vertex].x, part.stalks[vertex].x + 2.001f);
    }
  }
  EXPECT_EQ(triangle_count(meshes), kLeaves * kRows * 2);
  EXPECT_EQ(whole_leaf_mesh(meshes).indices.size(), plant.foliage.indices.size());
}

TEST(KeepLeafMeshes, WhatIsTooLargeIsNotKeptAndSaysSo) {
  Plant plant;
  Foliage foliage;
  add_leaf(plant, foliage, square_at({0, 0, 0}, 1.0f), COPPICE_MAX_LEAF_MESH_TRIANGLES / 2);
  EXPECT_EQ(keep_leaf_meshes(plant, foliage).meshes.parts.size(), 1u) << "just fits";
  add_leaf(plant, foliage, square_at({3, 0, 0}, 1.0f), COPPICE_MAX_LEAF_MESH_TRIANGLES / 2 + 1);
  const KeptLeafMeshes kept = keep_leaf_meshes(plant, foliage);
  EXPECT_TRUE(kept.too_large);
  EXPECT_TRUE(kept.meshes.parts.empty());
  EXPECT_TRUE(test::mentions(kept.note, {"131074"}));
}

TEST(KeepLeafMeshes, UvsOfEachLeafStartInTheFirstTile) {
  Plant plant;
  Foliage foliage;
  add_leaf(plant, foliage, square_at({0, 0, 0}, 1.0f), 2, 17.25f);
  add_leaf(plant, foliage, square_at({3, 0, 0}, 1.0f), 2, -4.5f);
  const Mesh mesh = whole_leaf_mesh(keep_leaf_meshes(plant, foliage).meshes);
  std::vector<float> us;
  for (const glm::vec2& uv : mesh.uvs) us.push_back(uv.x);
  std::ranges::sort(us);
  EXPECT_EQ(us.front(), 0.25f);
  EXPECT_EQ(us.back(), 1.5f);
}

using Corner = std::tuple<std::array<std::int64_t, 3>, std::array<std::int64_t, 2>, std::array<std::int64_t, 3>>;
using Triangle = std::array<Corner, 3>;

/// Every triangle as its corners' rounded position, uv and stalk, in an order that does not depend on that of the mesh. `round_m` is coarse
/// enough for what coding moves.
std::vector<Triangle> triangles_of(const LeafMeshes& meshes, float round_m) {
  std::vector<Triangle> triangles;
  const auto rounded = [&](float value, float step) { return std::llround(value / step); };
  for (const LeafMeshPart& part : meshes.parts)
    for (std::size_t i = 0; i < part.mesh.indices.size(); i += 3) {
      Triangle triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = part.mesh.indices[i + k];
        const glm::vec3 &p = part.mesh.positions[v], &s = part.stalks[v];
        const glm::vec2& uv = part.mesh.uvs[v];
        triangle[k] = {{rounded(p.x, round_m), rounded(p.y, round_m), rounded(p.z, round_m)},
                       {rounded(uv.x, 0.01f), rounded(uv.y, 0.01f)},
                       {rounded(s.x, round_m), rounded(s.y, round_m), rounded(s.z, round_m)}};
      }
      std::rotate(triangle.begin(), std::ranges::min_element(triangle), triangle.end());
      triangles.push_back(triangle);
    }
  std::ranges::sort(triangles);
  return triangles;
}

/// Squares in a grid of 0.1 m: quantisation moves nothing over a rounding edge of half that.
struct Squares {
  Plant plant;
  Foliage foliage;
  BakedPlant baked;

  Squares() {
    for (int i = 0; i < 40; ++i) {
      const int row = i / 8;
      add_leaf(plant, foliage,
               square_at({static_cast<float>(i % 8) * 0.4f, static_cast<float>(row) * 0.4f, 0.1f * static_cast<float>(i % 3)}, 0.1f), 2);
    }
    CollapseSequence sequence;
    for (std::uint32_t i = 0; i < 39; ++i) sequence.merges.push_back({2 * i, 2 * i + 1, {0, 1, 2, 3}});
    baked.tree = build_tree(foliage, sequence);
    baked.metric = COPPICE_METRIC_MI;
    baked.card_table = foliage.card_table;
    baked.card_table[0].material = 1;
    baked.materials = {{.name = "leaf", .image = 0}, {.name = "card"}, {.name = "nobody's"}};
    baked.images = {{1, 1, {10, 200, 30, 255}}};
    baked.errors = {{1, 40}, {64.0f, 512.0f}, {9.0f, 9.0f, 0.0f, 0.0f}};
    baked.leaf_meshes = keep_leaf_meshes(plant, foliage).meshes;
    baked.leaf_meshes.error_px = {1.0f, 3.0f};
    baked.sphere = plant_sphere(foliage, {}, baked.leaf_meshes);
    drop_unused_materials(baked);
  }
};

TEST(PackLeafMeshes, KeepsEveryTriangleUvAndStalk) {
  const Squares squares;
  PackSizes sizes;
  const auto file = test::must(pack(squares.baked, sizes));
  EXPECT_GT(sizes.leaf_mesh_bytes, 0u);
  const auto back = test::must(unpack(file));
  EXPECT_EQ(triangles_of(back.leaf_meshes, 0.1f), triangles_of(squares.baked.leaf_meshes, 0.1f));
  EXPECT_EQ(back.leaf_meshes.error_px, squares.baked.leaf_meshes.error_px);
  for (const LeafMeshPart& part : back.leaf_meshes.parts)
    for (const glm::vec3& normal : part.mesh.normals) EXPECT_NEAR(normal.z, 1.0f, 1e-4f);
  EXPECT_EQ(*pack(squares.baked, sizes), file) << "same plant, same bytes";
}

TEST(PackLeafMeshes, OneThatReachesOutOfThePlantsSphereIsNotVerified) {
  BakedPlant plant = test::random_plant({.leaf_count = 300, .leaf_mesh_count = 1});
  plant.wood.lods.clear();
  EXPECT_TRUE(verify(test::packed(plant)));
  // A corner of the leaves' box.
  glm::vec3 low = plant.tree.vertices[0];
  for (const glm::vec3& vertex : plant.tree.vertices) low = glm::min(low, vertex);
  plant.leaf_meshes.parts[0].mesh.positions[0] = low;
  ASSERT_GT(glm::distance(low, plant.sphere.center), 1.1f * plant.sphere.radius);
  EXPECT_STREQ(verify(test::packed(plant)).error().what, "plant sphere");
}

TEST(PackLeafMeshes, PositionsAreWithinTheStepsOfTheQuads) {
  BakedPlant plant = test::random_plant({.leaf_count = 300, .leaf_mesh_count = 1});
  // A plant ten times as tall as wide: Draco's steps are those of its height.
  for (glm::vec3& vertex : plant.tree.vertices) vertex.y *= 10.0f;
  for (glm::vec3& vertex : plant.leaf_meshes.parts[0].mesh.positions) vertex.y *= 10.0f;
  for (glm::vec3& stalk : plant.leaf_meshes.parts[0].stalks) stalk.y *= 10.0f;
  plant.wood.lods.clear();
  plant.sphere.radius *= 10.0f;
  glm::vec3 low = plant.tree.vertices[0], high = low;
  for (const glm::vec3& vertex : plant.tree.vertices) low = glm::min(low, vertex), high = glm::max(high, vertex);
  const auto back = test::must(unpack(test::packed(plant)));
  const std::vector<glm::vec3>& before = plant.leaf_meshes.parts[0].mesh.positions;
  for (const glm::vec3& position : back.leaf_meshes.parts[0].mesh.positions) {
    float nearest = 1e9f;
    for (const glm::vec3& other : before) {
      const glm::vec3 steps = glm::abs(position - other) / ((high - low) / static_cast<float>(COPPICE_QUANTISED_MAX));
      nearest = std::min(nearest, std::max({steps.x, steps.y, steps.z}));
    }
    ASSERT_LE(nearest, 0.51f) << "half a step";
  }
}

TEST(PackLeafMeshes, TheirMaterialTravelsAndIsMarkedAsTheirs) {
  const Squares squares;
  ASSERT_EQ(squares.baked.materials.size(), 2u) << "what nothing shows is dropped";
  ASSERT_EQ(squares.baked.images.size(), 1u);
  const auto file = test::packed(squares.baked);
  const auto front = test::must(read_front(file, file.size()));
  EXPECT_EQ(front.plant.texture_count, 1u);
  EXPECT_NE(front.materials[0].flags & COPPICE_MATERIAL_LEAF_MESH_ONLY, 0u);
  EXPECT_EQ(front.materials[1].flags & COPPICE_MATERIAL_LEAF_MESH_ONLY, 0u);
}

TEST(LeafMeshError, LeavesThatAreTheirQuadsHaveNone) {
  Squares squares;
  squares.baked.card_table[0] = {.material = 0, .uv = squares.foliage.card_table[0].uv};
  const auto error_px = test::must(measure_leaf_mesh_error(squares.baked));
  ASSERT_EQ(error_px.size(), 7u);
  for (const float error : error_px) EXPECT_LT(error, 1.0f) << "an edge pixel here and there";
}

TEST(LeafMeshError, IsTheSideOfTheSquareOfWrongPixels) {
  // Black leaves on white; the quads also cover a square far off that no mesh has.
  Plant plant;
  Foliage foliage;
  add_leaf(plant, foliage, square_at({-4, 0, 0}, 1.0f), 2);
  Foliage quads = foliage;
  quads.quads.push_back(square_at({4, 0, 0}, 1.0f));
  quads.cards.push_back(0);
  CollapseSequence sequence;
  sequence.merges = {{0, 1, {0, 1, 2, 3}}};
  BakedPlant baked;
  baked.tree = build_tree(quads, sequence);
  baked.card_table = quads.card_table;
  baked.materials = {{.name = "leaf", .base_color = {0, 0, 0, 1}}};
  baked.leaf_meshes = keep_leaf_meshes(plant, foliage).meshes;
  baked.sphere = plant_sphere(quads, {});
  const auto error_px = test::must(measure_leaf_mesh_error(baked));

  const auto buffers = test::must(render_item_buffers({quads, {{}}, {}}, error_viewpoints(), 512));
  const std::vector<std::uint32_t> areas = leaf_areas_px(buffers);
  double mean_area = 0.0;
  for (std::size_t view = 0; view < 6; ++view) mean_area += areas[view * 2 + 1] / 6.0;
  ASSERT_GT(mean_area, 100.0);
  EXPECT_NEAR(error_px.back(), std::sqrt(mean_area), 0.02 * std::sqrt(mean_area));
  for (std::size_t size = 1; size < error_px.size(); ++size) EXPECT_GE(error_px[size], error_px[size - 1]);
}

TEST(LeafMeshError, SeesWhatIsPaintedOnThem) {
  Squares squares;  // meshes show a green image, quads plain white
  const auto error_px = test::must(measure_leaf_mesh_error(squares.baked));
  EXPECT_GT(error_px.back(), 15.0f);
}

}  // namespace coppice::bake::leaf_mesh_parts_test
