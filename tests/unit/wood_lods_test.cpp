#include "wood_lods.h"

#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace coppice::bake {
namespace {

constexpr std::uint32_t kSides = 16, kRings = 60;

/// Appends a closed-up tube of kSides x kRings quads along `axis` from `foot`, tapering to a tenth.
void append_tube(Mesh& mesh, const glm::vec3& foot, const glm::vec3& axis, float radius_m, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const glm::vec3 along = glm::normalize(axis);
  const glm::vec3 side =
      glm::normalize(glm::cross(along, std::abs(along.x) < 0.9f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0.0f, 1.0f, 0.0f)));
  const glm::vec3 other = glm::cross(along, side);
  for (std::uint32_t ring = 0; ring <= kRings; ++ring)
    for (std::uint32_t i = 0; i <= kSides; ++i) {
      const float t = static_cast<float>(ring) / kRings, turn = 2.0f * std::numbers::pi_v<float> * static_cast<float>(i % kSides) / kSides;
      const glm::vec3 normal = std::cos(turn) * side + std::sin(turn) * other;
      mesh.positions.push_back(foot + t * axis + radius_m * (1.0f - 0.9f * t) * normal);
      mesh.normals.push_back(normal);
      mesh.uvs.emplace_back(static_cast<float>(i) / kSides, t);
    }
  for (std::uint32_t ring = 0; ring < kRings; ++ring)
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const std::uint32_t a = first + ring * (kSides + 1) + i, b = a + 1, c = a + kSides + 1, d = c + 1;
      mesh.indices.insert(mesh.indices.end(), {a, b, d, a, d, c});
      mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, material);
    }
}

/// A trunk with eight boughs in one material, and a fruit stalk in another.
Mesh tree() {
  Mesh mesh;
  append_tube(mesh, {0.0f, 0.0f, 0.0f}, {0.0f, 10.0f, 0.0f}, 0.5f, 3);
  for (int i = 0; i < 8; ++i) {
    const float turn = static_cast<float>(i) * 2.4f;
    append_tube(mesh, {0.0f, 2.0f + static_cast<float>(i), 0.0f}, {3.0f * std::cos(turn), 1.0f, 3.0f * std::sin(turn)}, 0.12f, 3);
  }
  append_tube(mesh, {0.0f, 9.0f, 0.0f}, {0.5f, 0.5f, 0.0f}, 0.05f, 1);
  return mesh;
}

double area_m2(const Mesh& mesh) {
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]), c(mesh.positions[mesh.indices[i + 2]]);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return area;
}

void expect_valid(const Mesh& mesh) {
  ASSERT_EQ(mesh.indices.size(), 3 * mesh.triangle_materials.size());
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
  std::vector<bool> used(mesh.positions.size(), false);
  for (const std::uint32_t index : mesh.indices) {
    ASSERT_LT(index, mesh.positions.size());
    used[index] = true;
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0) << "vertices that no triangle uses";
}

TEST(WoodLods, NoWoodNoLods) {
  EXPECT_TRUE(simplify_wood({}).lods.empty());
}

TEST(WoodLods, AFewTrianglesStayAsTheyAre) {
  Mesh mesh;
  mesh.positions = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
  mesh.normals.assign(3, {0.0f, 0.0f, 1.0f});
  mesh.uvs.assign(3, {0.0f, 0.0f});
  mesh.indices = {0, 1, 2};
  mesh.triangle_materials = {0};
  const WoodLods chain = simplify_wood(mesh);
  ASSERT_EQ(chain.lods.size(), 1u);
  EXPECT_EQ(chain.lods[0].indices.size(), 3u);
}

TEST(WoodLods, ChainGoesDownByAboutFourToSomeTens) {
  const Mesh wood = tree();
  const WoodLods chain = simplify_wood(wood);
  ASSERT_GE(chain.lods.size(), 4u);
  ASSERT_LE(chain.lods.size(), 7u);
  EXPECT_EQ(chain.lods[0].triangle_materials.size(), wood.triangle_materials.size());
  EXPECT_NEAR(area_m2(chain.lods[0]), area_m2(wood), 1e-6 * area_m2(wood));
  for (const Mesh& lod : chain.lods) expect_valid(lod);
  for (std::size_t i = 1; i < chain.lods.size(); ++i)
    EXPECT_LE(chain.lods[i].triangle_materials.size(), 0.7 * static_cast<double>(chain.lods[i - 1].triangle_materials.size()));
  EXPECT_LE(chain.lods.back().triangle_materials.size(), 150u);
}

TEST(WoodLods, TheTreeKeepsItsShape) {
  const Mesh wood = tree();
  const WoodLods chain = simplify_wood(wood);
  for (const Mesh& lod : chain.lods) {
    glm::vec3 low = lod.positions[0], high = low;
    for (const glm::vec3& position : lod.positions) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
    EXPECT_LT(low.y, 0.7f) << lod.triangle_materials.size() << " triangles: the trunk's foot is gone";
    EXPECT_GT(high.y, 9.0f) << lod.triangle_materials.size() << " triangles: the crown is gone";
    EXPECT_GT(area_m2(lod), 0.3 * area_m2(wood)) << lod.triangle_materials.size() << " triangles";
    const std::set<std::uint32_t> materials(lod.triangle_materials.begin(), lod.triangle_materials.end());
    EXPECT_EQ(materials, (std::set<std::uint32_t>{1, 3})) << lod.triangle_materials.size() << " triangles";
  }
}

TEST(WoodLods, SameWoodSameLods) {
  const WoodLods first = simplify_wood(tree()), second = simplify_wood(tree());
  ASSERT_EQ(first.lods.size(), second.lods.size());
  for (std::size_t i = 0; i < first.lods.size(); ++i) {
    EXPECT_EQ(first.lods[i].indices, second.lods[i].indices);
    EXPECT_EQ(first.lods[i].positions, second.lods[i].positions);
  }
}

}  // namespace
}  // namespace coppice::bake
