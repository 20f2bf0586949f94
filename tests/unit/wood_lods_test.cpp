#include "wood_lods.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "error_image.h"
#include "error_table.h"
#include "mesh_error.h"
#include "polygons.h"
#include "random_tree.h"
#include "raster.h"
#include "results.h"
#include "wood_plants.h"
#include "wood_proxies.h"

namespace coppice::bake::wood_lods_test {

constexpr std::uint32_t kSides = 16, kRings = 60;

/// The first mesh of each level.
WoodLods simplify_wood(const Mesh& wood) {
  WoodLods chain;
  for (const WoodLevel& level : wood_levels(wood)) chain.lods.push_back(level.front());
  return chain;
}

/// Appends a tube of kSides x kRings quads along `axis` from `foot`, open at both ends. tip_share  of the radius
void append_tube(Mesh& mesh, const glm::vec3& foot, const glm::vec3& axis, float radius_m, std::uint32_t material, float tip_share = 0.1f) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const glm::vec3 along = glm::normalize(axis);
  const glm::vec3 side =
      glm::normalize(glm::cross(along, std::abs(along.x) < 0.9f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0.0f, 1.0f, 0.0f)));
  const glm::vec3 other = glm::cross(along, side);
  for (std::uint32_t ring = 0; ring <= kRings; ++ring)
    for (std::uint32_t i = 0; i <= kSides; ++i) {
      const float t = static_cast<float>(ring) / kRings, turn = 2.0f * std::numbers::pi_v<float> * static_cast<float>(i % kSides) / kSides;
      const glm::vec3 normal = std::cos(turn) * side + std::sin(turn) * other;
      mesh.positions.push_back(foot + t * axis + radius_m * (1.0f - (1.0f - tip_share) * t) * normal);
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
  coppice::test::add_polygon(mesh, std::array{glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)});
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

/// Pixels of each material in six views of 512 px, of wood alone.
std::map<std::uint32_t, double> seen_pixels(const Mesh& mesh, const Sphere& sphere) {
  constexpr auto kSide = static_cast<std::int32_t>(kErrorImagePx);
  std::map<std::uint32_t, double> seen;
  for (const Projection& projection : error_projections(sphere)) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pixels(std::size_t{kErrorImagePx} * kErrorImagePx,
                                                                {~0u, kNone});  // depth, material
    for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
      const auto corner = [&](std::size_t k) { return project(projection, mesh.positions[mesh.indices[3 * t + k]]); };
      const RasterTriangle triangle(corner(0), corner(1), corner(2));
      for (std::int32_t y = std::max(triangle.first_row(), 0); y <= std::min(triangle.last_row(), kSide - 1); ++y) {
        const Span span = triangle.row(y, kErrorImagePx);
        for (std::int32_t x = span.first; x <= span.last; ++x) {
          auto& pixel = pixels[static_cast<std::size_t>(y) * kErrorImagePx + static_cast<std::size_t>(x)];
          pixel = std::min(pixel, std::pair(triangle.depth(x, y), mesh.triangle_materials[t]));
        }
      }
    }
    for (const auto& [depth, material] : pixels)
      if (material != kNone) ++seen[material];
  }
  return seen;
}

double sum(const std::map<std::uint32_t, double>& pixels) {
  double all = 0.0;
  for (const auto& [material, count] : pixels) all += count;
  return all;
}

/// The plant's wood alone, with one leaf that is a point.
BakedPlant bare_plant(const Plant& plant) {
  BakedPlant baked = coppice::test::random_plant({.leaf_count = 1, .wood_lod_count = 0, .texture_side = 0});
  baked.materials = plant.materials;
  baked.card_table[0].material = 0;
  for (glm::vec3& vertex : baked.tree.vertices) vertex = plant.wood.positions[0];
  Foliage leaf;
  leaf.quads.emplace_back().fill(plant.wood.positions[0]);
  baked.sphere = plant_sphere(leaf, plant.wood);
  baked.errors.sizes_px.assign(kErrorSizesPx.begin(), kErrorSizesPx.end());
  return baked;
}

class DifficultWood : public ::testing::TestWithParam<test::WoodPlant> {};

TEST_P(DifficultWood, WhatMayBeDrawnKeepsAreaAndColours) {
  const Plant plant = GetParam().grow();
  const BakedPlant baked = bare_plant(plant);
  const auto chain = coppice::test::must(choose_wood_lods(baked, wood_levels(plant.wood)));
  const auto whole = seen_pixels(plant.wood, baked.sphere);
  glm::dvec3 whole_mean(0.0);
  for (const auto& [material, count] : whole) whole_mean += count / sum(whole) * glm::dvec3(plant.materials[material].base_color);
  std::size_t drawn = 0;
  for (std::size_t i = 1; i < chain.lods.size(); ++i) {
    const Mesh& lod = chain.lods[i];
    expect_valid(lod);
    auto seen = seen_pixels(lod, baked.sphere);
    glm::dvec3 mean(0.0);
    for (const auto& [material, count] : whole) mean += seen[material] / sum(seen) * glm::dvec3(plant.materials[material].base_color);
    const double share = sum(seen) / sum(whole), off = glm::length(mean - whole_mean);
    constexpr std::size_t kAt64Px = 3;
    const float error_px = chain.error_px[i * kErrorSizesPx.size() + kAt64Px];
    std::printf("%s: %zu triangles, error %.1f px, %.2f of the pixels, mean colour off by %.3f\n", plant.name.c_str(),
                lod.triangle_materials.size(), static_cast<double>(error_px), share, off);
    if (error_px > 14.6f) continue;  // not drawn at 64 px, even at a threshold of 7.3 px
    ++drawn;
    EXPECT_NEAR(share, 1.0, 0.15) << lod.triangle_materials.size() << " triangles";
    EXPECT_LT(off, 0.1) << lod.triangle_materials.size() << " triangles";
  }
  EXPECT_GE(drawn, 1u) << "the finest is not all that may be drawn";
}

INSTANTIATE_TEST_SUITE_P(Plants, DifficultWood, ::testing::ValuesIn(test::wood_plants()),
                         [](const auto& plant) { return std::string(plant.param.name); });

/// A box of 1 m whose sides are 12 x 12 squares each, lit as flat: no two triangles share a vertex, so that edge collapse gets nowhere.
Mesh faceted_box() {
  constexpr int kSquares = 12;
  Mesh box;
  const auto at = [](int side, int u, int v) {
    const int axis = side / 2;
    glm::vec3 position(0.0f);
    position[axis] = side % 2 == 0 ? 0.5f : -0.5f;
    position[(axis + 1) % 3] = static_cast<float>(side % 2 == 0 ? u : kSquares - u) / kSquares - 0.5f;
    position[(axis + 2) % 3] = static_cast<float>(v) / kSquares - 0.5f;
    return position;
  };
  const auto add = [&](const std::array<glm::vec3, 3>& corners) {
    coppice::test::add_polygon(box, corners);
    std::fill(box.normals.end() - 3, box.normals.end(), glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0])));
  };
  for (int side = 0; side < 6; ++side)
    for (int v = 0; v < kSquares; ++v)
      for (int u = 0; u < kSquares; ++u) {
        add({at(side, u, v), at(side, u + 1, v), at(side, u + 1, v + 1)});
        add({at(side, u, v), at(side, u + 1, v + 1), at(side, u, v + 1)});
      }
  return box;
}

TEST(WoodLods, FacetsAreLitAsTheyFace) {
  const std::vector<WoodLevel> levels = wood_levels(faceted_box());
  ASSERT_GE(levels.size(), 2u);
  for (const WoodLevel& level : levels)
    for (const Mesh& lod : level) {
      expect_valid(lod);
      for (std::size_t i = 0; i < lod.indices.size(); i += 3) {
        const auto at = [&](std::size_t k) { return lod.positions[lod.indices[i + k]]; };
        const glm::vec3 face = glm::cross(at(1) - at(0), at(2) - at(0));
        if (!(glm::length(face) > 1e-6f)) continue;
        const glm::vec3 middle = (at(0) + at(1) + at(2)) / 3.0f;  // from the box's
        for (std::size_t k = 0; k < 3; ++k) {
          EXPECT_GT(glm::dot(lod.normals[lod.indices[i + k]], middle), 0.0f) << "it is lit from within";
          // Either way round: a simplifier turns triangles over in their plane, and nothing is culled by that.
          EXPECT_GT(std::abs(glm::dot(lod.normals[lod.indices[i + k]], glm::normalize(face))), 0.24f)
              << "a triangle of " << lod.triangle_materials.size() << " is lit as if it faced elsewhere";
        }
      }
    }
}

TEST(WoodLods, EveryCulmKeepsItsFoot) {
  const Plant plant = test::wood_plants()[0].grow();
  ASSERT_EQ(plant.name, "bamboo");
  std::vector<glm::vec3> feet;
  for (const glm::vec3& position : plant.wood.positions)
    if (position.y < 0.01f && std::ranges::none_of(feet, [&](const glm::vec3& foot) { return glm::distance(foot, position) < 0.06f; }))
      feet.push_back(position);
  ASSERT_EQ(feet.size(), 30u);
  const WoodLods chain = simplify_wood(plant.wood);
  for (std::size_t i = 1; i <= 2; ++i) {
    std::size_t found = 0;
    for (const glm::vec3& foot : feet)
      found += std::ranges::any_of(chain.lods[i].positions, [&](const glm::vec3& position) { return glm::distance(foot, position) < 0.1f; })
                   ? 1u
                   : 0u;
    EXPECT_EQ(found, feet.size()) << chain.lods[i].triangle_materials.size() << " triangles";
  }
}

TEST(WoodLods, PiecesLeftOutAreSpreadOverThePlant) {
  // 800 equal spines in file order from the foot to the tip: those that stay are not all at the foot.
  Mesh spines;
  for (int i = 0; i < 800; ++i) {
    const auto first = static_cast<std::uint32_t>(spines.positions.size());
    const glm::vec3 foot(0.0f, 0.01f * static_cast<float>(i), 0.0f);
    for (const glm::vec3& corner : {glm::vec3(0, 0, 0), glm::vec3(0, 0.002f, 0), glm::vec3(0, 0, 0.002f), glm::vec3(0.05f, 0, 0)})
      spines.positions.push_back(foot + corner), spines.normals.emplace_back(0.0f, 1.0f, 0.0f), spines.uvs.emplace_back(0.0f);
    for (const std::uint32_t corner : {0u, 1u, 3u, 1u, 2u, 3u, 2u, 0u, 3u}) spines.indices.push_back(first + corner);
    spines.triangle_materials.insert(spines.triangle_materials.end(), 3, 0u);
  }
  for (const Mesh& lod : simplify_wood(spines).lods) {
    std::array<std::size_t, 4> in_quarter{};
    for (const glm::vec3& position : lod.positions)
      ++in_quarter[std::min<std::size_t>(static_cast<std::size_t>(std::max(position.y, 0.0f) / 2.0f), 3)];
    const auto [least, most] = std::ranges::minmax(in_quarter);
    EXPECT_LE(most, 2 * least + 8) << lod.triangle_materials.size() << " triangles";
  }
}

TEST(Proxy, HasTheProjectedAreaThatIsAskedForAndThePiecesEnds) {
  const Mesh wood = tree();
  for (const WoodPiece& piece : split_wood(wood))
    for (const Proxy form : {Proxy{1, 2}, Proxy{4, 2}, Proxy{1, 3}, Proxy{8, 3}, Proxy{0, 3}, Proxy{0, 4}}) {
      Mesh mesh;
      append_proxy(wood, piece, {form, 1.5 * piece.projected_m2, 0.7}, mesh);
      EXPECT_EQ(mesh.triangle_materials.size(), form.triangle_count());
      expect_valid(mesh);
      EXPECT_NEAR(projected_area_m2(mesh.positions, mesh.indices), 1.5 * piece.projected_m2, 1e-3 * piece.projected_m2);
      if (form.sections == 0) continue;
      for (const double end_m : {piece.first_m, piece.last_m}) {
        const glm::vec3 end(piece.center + end_m * piece.axes[0]);
        const bool reached = std::ranges::any_of(
            mesh.positions, [&](const glm::vec3& p) { return glm::distance(p, end) < 2.0 * piece.girth_m() + 0.2 * piece.length_m(); });
        EXPECT_TRUE(reached) << form.sections << " sections";
      }
    }
}

TEST(Proxy, TapersAsItsPieceDoes) {
  Mesh wood;
  append_tube(wood, {0, 0, 0}, {0, 4, 0}, 0.1f, 0);
  const WoodPiece piece = split_wood(wood)[0];
  for (const std::uint32_t sections : {1u, 4u}) {
    Mesh strip;
    append_proxy(wood, piece, {{sections, 2}, 2.0 * piece.projected_m2, 0.0}, strip);
    const double foot_m = glm::distance(strip.positions[0], strip.positions[1]);
    const double tip_m = glm::distance(strip.positions.end()[-2], strip.positions.end()[-1]);
    EXPECT_NEAR(std::min(foot_m, tip_m) / std::max(foot_m, tip_m), 0.1, 0.03) << sections << " sections";
  }
}

TEST(Proxy, LineFitsWhatIsStraightAndNotWhatForks) {
  Mesh straight, fork;
  append_tube(straight, {0, 0, 0}, {0, 4, 0}, 0.1f, 0);
  append_tube(fork, {0, 0, 0}, {1.5f, 4, 0}, 0.1f, 0);
  append_tube(fork, {0, 0, 0}, {-1.5f, 4, 0}, 0.1f, 0);
  fork.positions[(kSides + 1) * (kRings + 1)] = fork.positions[0];  // one piece
  const auto misfit_m2 = [](const Mesh& mesh) { return line_misfit_m2(split_wood(mesh)[0], 1); };
  EXPECT_LT(misfit_m2(straight), 0.3 * 0.1 * 0.1);
  EXPECT_GT(misfit_m2(fork), 3.0 * 0.1 * 0.1);
}

/// A trunk and boughs of one surface: the first corner of each bough is one of the trunk's.
Mesh welded_tree() {
  Mesh mesh;
  append_tube(mesh, {0, 0, 0}, {0, 10, 0}, 0.5f, 0);
  for (int i = 0; i < 4; ++i) {
    const float turn = 1.6f * static_cast<float>(i);
    const std::size_t first = mesh.positions.size();
    append_tube(mesh, {0, 2.0f + static_cast<float>(i), 0}, {3.0f * std::cos(turn), 2.0f, 3.0f * std::sin(turn)}, 0.15f, 0);
    // One corner of the trunk near the bough's foot is a corner of the bough, too.
    glm::vec3& corner = mesh.positions[first];
    const auto distance_m = [&](std::size_t k) { return glm::distance(mesh.positions[k], corner); };
    std::size_t nearest = 0;
    for (std::size_t k = 0; k < (kSides + 1) * (kRings + 1); ++k)
      if (distance_m(k) < distance_m(nearest)) nearest = k;
    mesh.positions[first + kSides] = corner = mesh.positions[nearest];
  }
  return mesh;
}

TEST(WoodPieces, APieceThatForksHasLimbs) {
  const std::vector<WoodPiece> pieces = split_wood(welded_tree());
  ASSERT_EQ(pieces.size(), 1u) << "it is one surface";
  const std::vector<WoodPiece> limbs = by_weight(limbs_of(pieces[0]));
  ASSERT_EQ(limbs.size(), 5u);
  EXPECT_NEAR(limbs[0].length_m(), 10.0, 0.5) << "the trunk goes from the foot to the tip";
  std::size_t triangles = 0;
  for (const WoodPiece& limb : limbs) triangles += limb.triangle_count();
  EXPECT_EQ(triangles, pieces[0].triangle_count());
  const std::vector<WoodPiece> tubes = split_wood(tree());
  for (const WoodPiece& tube : tubes) EXPECT_EQ(limbs_of(tube).size(), 1u) << "it does not fork";
}

TEST(WoodPieces, TubesThatContinueEachOtherAreOne) {
  Mesh cane;
  for (int i = 0; i < 5; ++i) append_tube(cane, {0.0f, 1.02f * static_cast<float>(i), 0.0f}, {0.0f, 1.0f, 0.0f}, 0.03f, 0);
  append_tube(cane, {0.1f, 1.5f, 0.0f}, {1.0f, 0.0f, 0.0f}, 0.03f, 0);
  const std::vector<WoodPiece> pieces = split_wood(cane);
  ASSERT_EQ(pieces.size(), 2u) << "the bough at a right angle stays by itself";
  EXPECT_NEAR(pieces[0].length_m(), 5.08, 0.05);
}

TEST(WoodPieces, RingsOfATrunkAreOneTube) {
  for (const float gap_m : {0.02f, -0.02f}) {
    Mesh palm;
    for (int i = 0; i < 20; ++i)
      append_tube(palm, {0.0f, 0.15f * static_cast<float>(i), 0.0f}, {0.0f, 0.15f - gap_m, 0.0f}, 0.13f, 0, 1.2f);
    append_tube(palm, {0.5f, 0.0f, 0.0f}, {0.0f, 0.15f, 0.0f}, 0.13f, 0, 1.2f);
    const std::vector<WoodPiece> pieces = split_wood(palm);
    ASSERT_EQ(pieces.size(), 2u) << "a pot beside it stays by itself";
    EXPECT_NEAR(pieces[0].length_m(), 3.0, 0.05);
    EXPECT_EQ(pieces[0].part_count, 20u);
    const double seen_m2 = 0.25 * std::numbers::pi * 0.286 * (gap_m > 0.0f ? 2.6 : 3.0);
    EXPECT_NEAR(pieces[0].projected_m2, seen_m2, 0.05 * seen_m2) << "its rings close each other";
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

}  // namespace coppice::bake::wood_lods_test
