#include <algorithm>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "collapse_geometric.h"
#include "gltf_write.h"
#include "lines_and_voxels.h"
#include "mentions.h"
#include "methods.h"
#include "normal_sum.h"
#include "pruning.h"
#include "quad_merge.h"
#include "results.h"
#include "surface_distance.h"
#include "test_foliage.h"

namespace coppice::bake::evaluate_methods_test {

/// Facing +Z.
Quad square_at(const glm::vec3& center, float side_m) {
  return test::rectangle(center - glm::vec3(0.5f * side_m, 0.5f * side_m, 0), {side_m, 0, 0}, {0, side_m, 0});
}

/// Facing +X.
Quad sideways_at(const glm::vec3& center, float side_m) {
  return test::rectangle(center - glm::vec3(0, 0.5f * side_m, 0.5f * side_m), {0, side_m, 0}, {0, 0, side_m});
}

TEST(Geometric, DissimilarityIsDistancePlusSizePlusNormal) {
  const Quad unit = square_at({0, 0, 0}, 1);
  EXPECT_DOUBLE_EQ(leaf_dissimilarity(unit, unit, 1.0), 0.0);
  EXPECT_DOUBLE_EQ(leaf_dissimilarity(unit, square_at({0, 3, 4}, 1), 2.0), 2.5);
  EXPECT_DOUBLE_EQ(leaf_dissimilarity(unit, square_at({0, 0, 0}, 2), 1.0), 0.6);  // |1 - 4| / 5
  EXPECT_DOUBLE_EQ(leaf_dissimilarity(unit, sideways_at({0, 0, 0}, 1), 1.0), 1.0);
  EXPECT_DOUBLE_EQ(leaf_dissimilarity(unit, Quad{unit[3], unit[2], unit[1], unit[0]}, 1.0), 0.0) << "a leaf has no front";
  EXPECT_DOUBLE_EQ(mean_leaf_size_m(test::plain_foliage({square_at({0, 0, 0}, 1), square_at({0, 0, 0}, 3)})), 2.0);
}

TEST(Geometric, CollapsesTheMostSimilarPairFirst) {
  // 2 and 3 are nearer than 0 and 1, the two pairs are far apart.
  const Foliage foliage =
      test::plain_foliage({square_at({0, 0, 0}, 1), square_at({1, 0, 0}, 1), square_at({50, 0, 0}, 1), square_at({50.5f, 0, 0}, 1)});
  const CollapseSequence sequence = collapse_by_similarity(foliage, {});
  ASSERT_EQ(sequence.merges.size(), 3u);
  const auto pair = [&](std::size_t i) { return std::pair(sequence.merges[i].first, sequence.merges[i].second); };
  EXPECT_EQ(pair(0), std::pair(2u, 3u));
  EXPECT_EQ(pair(1), std::pair(0u, 1u));
  EXPECT_EQ(pair(2), std::pair(4u, 5u));
  EXPECT_EQ(sequence.merges[0].corners, merge_corners(foliage.quads[2], foliage.quads[3]));
}

TEST(Geometric, ALeafThatLooksAnotherWayIsFartherThanOneBeside) {
  // 0 to 1: 1 leaf size apart, parallel: 1. 0 to 2: 0.5 apart, across: 1.5.
  const Foliage foliage = test::plain_foliage({square_at({0, 0, 0}, 1), square_at({1, 0, 0}, 1), sideways_at({-0.5f, 0, 0}, 1)});
  const Merge first = collapse_by_similarity(foliage, {}).merges.front();
  EXPECT_EQ(std::pair(first.first, first.second), std::pair(0u, 1u));
}

TEST(Geometric, APartnerThatIsGoneIsReplaced) {
  // On a line at 0, 1, 1.9, 4: 1 and 2 go first; 0 wanted 1 and has to look again.
  const Foliage foliage =
      test::plain_foliage({square_at({0, 0, 0}, 1), square_at({1, 0, 0}, 1), square_at({1.9f, 0, 0}, 1), square_at({4, 0, 0}, 1)});
  const CollapseSequence sequence = collapse_by_similarity(foliage, {});
  std::multiset<std::uint32_t> used;
  for (const Merge& merge : sequence.merges) used.insert({merge.first, merge.second});
  EXPECT_EQ(used, (std::multiset<std::uint32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(std::pair(sequence.merges[0].first, sequence.merges[0].second), std::pair(1u, 2u));
  EXPECT_EQ(std::pair(sequence.merges[1].first, sequence.merges[1].second), std::pair(0u, 4u));
  EXPECT_TRUE(collapse_by_similarity(test::plain_foliage({square_at({0, 0, 0}, 1)}), {}).merges.empty());
}

TEST(Stochastic, KeptLeavesMakeUpForThePruned) {
  std::vector<Quad> quads;
  for (int i = 0; i < 8; ++i) quads.push_back(square_at({3.0f * static_cast<float>(i), 0, 0}, 1));
  const Foliage foliage = test::plain_foliage(quads);
  const Foliage half = prune_stochastically(foliage, 4, 9);
  ASSERT_EQ(half.leaf_count(), 4u);
  const std::vector<std::uint32_t> order = stochastic_order(8, 9);
  std::vector<std::uint32_t> kept(order.begin(), order.begin() + 4);
  std::ranges::sort(kept);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(quad_area(half.quads[i]), 2.0, 1e-5);
    EXPECT_NEAR(glm::distance(quad_centroid(half.quads[i]), quad_centroid(quads[kept[i]])), 0.0, 1e-5);
  }
  EXPECT_EQ(prune_stochastically(foliage, 8, 9).quads, foliage.quads);
}

TEST(Stochastic, TheOrderIsAPermutationThatDependsOnTheSeed) {
  std::vector<std::uint32_t> order = stochastic_order(100, 1);
  EXPECT_EQ(order, stochastic_order(100, 1));
  EXPECT_NE(order, stochastic_order(100, 2));
  std::ranges::sort(order);
  for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(order[i], i);
}

TEST(Prune, TheHiddenLeafGoesAndItsNearestNeighbourGrows) {
  // A closed box of 2 m and a leaf of 1 m^2 inside, nearest to the face at z = 1, which is leaf 1.
  const Foliage foliage = test::plain_foliage({square_at({0, 0, -1}, 2), square_at({0, 0, 1}, 2), sideways_at({-1, 0, 0}, 2),
                                               sideways_at({1, 0, 0}, 2), test::rectangle({-1, -1, -1}, {2, 0, 0}, {0, 0, 2}),
                                               test::rectangle({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}), square_at({0, 0, 0.5f}, 1)});
  CollapseOptions options;
  options.resolution_px = 64;
  for (const bool count_background : {true, false}) {
    options.count_background = count_background;
    const auto result =
        test::must(prune_by_mutual_information({foliage, test::plain_materials(), {}}, *viewpoints(20), options, {6, 7, 5}, {}));
    ASSERT_EQ(result.steps.size(), 2u);
    EXPECT_EQ(result.steps[0].pruned, 6u);
    EXPECT_EQ(result.steps[0].grown, 1u);
    ASSERT_EQ(result.levels[0].leaf_count(), 6u);
    EXPECT_NEAR(quad_area(result.levels[0].quads[1]), 5.0, 1e-5);
    EXPECT_EQ(quad_centroid(result.levels[0].quads[1]), glm::dvec3(0, 0, 1));
    EXPECT_EQ(result.levels[0].quads[0], foliage.quads[0]);
    EXPECT_EQ(result.levels[1].quads, foliage.quads);
    EXPECT_EQ(result.levels[2].leaf_count(), 5u);
  }
}

TEST(Prune, KeepsTheAreaOfAWholeCrown) {
  const Foliage foliage = test::ball_crown(80, 5);
  CollapseOptions options;
  options.resolution_px = 64;
  const auto result =
      test::must(prune_by_mutual_information({foliage, test::plain_materials(), {}}, *viewpoints(20), options, {1, 20}, {}));
  const double area = surface_area_m2(foliage_mesh(foliage));
  ASSERT_EQ(result.levels[0].leaf_count(), 1u);
  EXPECT_NEAR(surface_area_m2(foliage_mesh(result.levels[0])), area, 1e-4 * area);
  EXPECT_NEAR(surface_area_m2(foliage_mesh(result.levels[1])), area, 1e-4 * area);
  std::set<std::uint32_t> pruned;
  for (const PruneStep& step : result.steps) {
    EXPECT_TRUE(pruned.insert(step.pruned).second) << step.pruned << " was pruned twice";
    EXPECT_EQ(pruned.count(step.grown), 0u) << step.grown << " grew after it was pruned";
  }
}

/// Unit squares in the plane z = 0 that share their vertices.
Mesh grid(std::uint32_t columns, std::uint32_t rows, std::uint32_t material) {
  Mesh mesh;
  for (std::uint32_t x = 0; x <= columns; ++x)
    for (std::uint32_t y = 0; y <= rows; ++y) mesh.positions.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0f);
  mesh.normals.assign(mesh.positions.size(), glm::vec3(0, 0, 1));
  mesh.uvs.assign(mesh.positions.size(), glm::vec2(0));
  for (std::uint32_t x = 0; x < columns; ++x)
    for (std::uint32_t y = 0; y < rows; ++y) {
      const std::uint32_t near = x * (rows + 1) + y, far = near + rows + 1;
      mesh.indices.insert(mesh.indices.end(), {near, far, far + 1, near, far + 1, near + 1});
      mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, material);
    }
  return mesh;
}

TEST(Meshopt, AFlatStripBecomesTwoTriangles) {
  const Mesh simple = simplify_mesh(grid(4, 1, 3), 2, MeshSimplifier::collapse);
  EXPECT_EQ(simple.triangle_materials, (std::vector<std::uint32_t>{3, 3}));
  EXPECT_DOUBLE_EQ(surface_area_m2(simple), 4.0);
  const Mesh same = simplify_mesh(grid(4, 1, 3), 8, MeshSimplifier::collapse);
  EXPECT_DOUBLE_EQ(surface_area_m2(same), 4.0);
  EXPECT_EQ(same.triangle_materials.size(), 8u);
}

TEST(Meshopt, SloppyStaysWithinItsTriangles) {
  const Mesh source = grid(16, 16, 1);
  const Mesh simple = simplify_mesh(source, 128, MeshSimplifier::sloppy);
  EXPECT_GT(simple.triangle_materials.size(), 0u);
  EXPECT_LE(simple.triangle_materials.size(), 128u);
  EXPECT_EQ(simple.positions, source.positions);
  EXPECT_GT(surface_area_m2(simple), 128.0) << "over half of the flat source, whose area is 256";
  for (const std::uint32_t material : simple.triangle_materials) EXPECT_EQ(material, 1u);
  EXPECT_TRUE(simplify_mesh({}, 4, MeshSimplifier::sloppy).indices.empty());
}

TEST(Meshopt, TrianglesKeepTheMaterialOfTheirLeaf) {
  Foliage foliage = test::plain_foliage({square_at({0, 0, 0}, 1), square_at({9, 0, 0}, 3), square_at({-9, 0, 0}, 3)});
  foliage.card_table.push_back({1, foliage.card_table[0].uv});
  foliage.cards = {0, 1, 1};
  const Mesh mesh = simplify_mesh(foliage_mesh(foliage), 4, MeshSimplifier::collapse);
  ASSERT_FALSE(mesh.triangle_materials.empty());
  EXPECT_LE(mesh.triangle_materials.size(), 4u);
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t)
    EXPECT_EQ(mesh.triangle_materials[t], mesh.indices[3 * t] < 4 ? 0u : 1u) << t;
}

TEST(Methods, NamesRoundTrip) {
  for (const Method method : all_methods()) EXPECT_EQ(*method_from_name(method_name(method)), method);
  test::expect_error(method_from_name("beauty"), Status::invalid_argument, {"meshopt_sloppy"});
}

TEST(Methods, TheDefaultOnesComeFirst) {
  EXPECT_EQ(default_methods().size(), 7u);
  EXPECT_EQ(default_methods().back(), Method::meshopt_sloppy);
  EXPECT_GT(all_methods().size(), default_methods().size());
}

/// Leaves, or triangles of methods that do not work on leaves.
std::size_t triangles_of(const Level& level) {
  return level.mesh.triangle_materials.size();
}

TEST(Methods, GiveEveryLevelItsTriangles) {
  const Foliage foliage = test::ball_crown(60, 11);
  const std::vector<Material> materials = test::plain_materials();
  const double area = surface_area_m2(foliage_mesh(foliage));
  for (const Method method : all_methods()) {
    const auto variants = test::must(simplify_foliage(method, {{foliage, materials, {}}, {60, 12, 30}}, {}));
    ASSERT_FALSE(variants.empty()) << method_name(method);
    for (const Variant& variant : variants) {
      SCOPED_TRACE(std::string(method_name(method)) + " " + variant.parameters);
      EXPECT_EQ(variant.parameters.empty(), variants.size() == 1) << "a sweep says what each is";
      ASSERT_EQ(variant.levels.size(), 3u);
      const bool by_area = method != Method::meshopt && method != Method::meshopt_sloppy;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t wanted = std::array{120u, 24u, 60u}[i], found = triangles_of(variant.levels[i]);
        if (method == Method::lines) {
          EXPECT_EQ(variant.levels[i].needles.size(), std::min<std::size_t>(wanted, 60));
        } else if (method == Method::voxels) {
          EXPECT_LE(variant.levels[i].voxels.size() * kVoxelBytes, wanted / 2 * kLeafBytes);
          EXPECT_GT(variant.levels[i].voxels.size(), 0u);
        } else if (by_area) {
          EXPECT_EQ(found, wanted);
        } else {
          EXPECT_LE(found, wanted);
        }
      }
      if (by_area && method != Method::voxels) {
        EXPECT_NEAR(level_area_m2(variant.levels[0]), area, 1e-5 * area) << "it changes a plant it should not";
      }
    }
  }
}

TEST(Methods, NodesOfOursCarryNormalsAndMergedLeavesOfOthersAreFlat) {
  const Foliage foliage = test::ball_crown(60, 11);
  const std::vector<Material> materials = test::plain_materials();
  for (const Method method : all_methods()) {
    const bool is_ours = method == Method::default_metric || method == Method::mi;
    for (const Variant& variant : test::must(simplify_foliage(method, {{foliage, materials, {}}, {60, 12}}, {}))) {
      SCOPED_TRACE(std::string(method_name(method)) + " " + variant.parameters);
      EXPECT_TRUE(variant.levels[0].normals.empty()) << "leaves of the plant lie as they lie";
      ASSERT_EQ(variant.levels[1].normals.empty(), !is_ours);
      if (!is_ours) continue;
      ASSERT_EQ(variant.levels[1].normals.size(), 24u);
      EXPECT_TRUE(std::ranges::any_of(variant.levels[1].normals, [](const ShadingNormals& normals) { return normals.along < 0.9f; }));
      EXPECT_TRUE(std::ranges::none_of(variant.levels[1].normals, &ShadingNormals::is_sided));
    }
  }
}

TEST(Methods, LeavesThatAreKeptKeepAnArtistsNormals) {
  Foliage foliage = test::ball_crown(60, 11);
  foliage.normals.assign(60, node_normals(normal_sum({0, 1, 0}, 1.0, true)));
  for (const Method method : {Method::geometric, Method::stochastic, Method::prune, Method::meshopt}) {
    const auto variants = test::must(simplify_foliage(method, {{foliage, test::plain_materials(), {}}, {60, 50}}, {}));
    for (const Level& level : variants.at(0).levels) {
      SCOPED_TRACE(std::string(method_name(method)) + " " + std::to_string(level.mesh.triangle_materials.size()));
      ASSERT_FALSE(level.normals.empty());
      const auto upward = std::ranges::count_if(level.normals, [](const ShadingNormals& n) { return n.is_sided && n.axis[1] > 0.99f; });
      const auto all = static_cast<std::ptrdiff_t>(level.normals.size());
      if (method == Method::geometric && all < 120) {
        EXPECT_LT(upward, all) << "merged leaves are flat";
        EXPECT_GE(upward, all - 20) << "ten merges leave 40 leaves";
      } else {
        EXPECT_EQ(upward, all);
      }
    }
  }
}

TEST(LeafScale, GrowsAboutTheCentroid) {
  const Quad scaled = scaled_quad(square_at({5, 1, 2}, 1), 3.0);
  EXPECT_EQ(scaled, square_at({5, 1, 2}, 3));
}

}  // namespace coppice::bake::evaluate_methods_test
