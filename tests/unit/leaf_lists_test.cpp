// The lists of the compute rasteriser: what they hold, and that what they say of it is true.

#include "leaf_lists.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "coppice/format.h"
#include "coppice_lod.h"
#include "hooks.h"
#include "list_build.h"
#include "page_spans.h"
#include "random_tree.h"
#include "reader.h"

namespace coppice::gpu {
namespace {

using Corners = std::array<std::uint32_t, 6>;

/// A crown of 700 leaves in the box [-1, 1]^3, quantised as the runtime has it.
struct Crown {
  std::vector<PageNode> nodes;
  std::vector<SharedNodes> pages;
  std::vector<RasterCard> looks{{{0.2f, 0.4f, 0.1f}, 1.0f, {~0u, ~0u}, 0.5f}, {{0.3f, 0.3f, 0.1f}, 0.5f, {~0u, 0u}, 0.5f}};
  CrownLight light;

  Crown() {
    const bake::BakedPlant plant = test::random_plant({.leaf_count = 700, .seed = 4});
    glm::vec3 low(1e9f), high(-1e9f);
    for (const glm::vec3& vertex : plant.tree.vertices) {
      low = glm::min(low, vertex);
      high = glm::max(high, vertex);
    }
    for (std::size_t id = 0; id < plant.tree.nodes.size(); ++id) {
      QuantisedQuad quad{};
      for (std::size_t corner = 0; corner < 4; ++corner) {
        const glm::vec3 unit = (plant.tree.vertices[plant.tree.nodes[id].vertices[corner]] - low) / (high - low);
        for (int axis = 0; axis < 3; ++axis)
          quad[corner][static_cast<std::size_t>(axis)] = static_cast<std::uint16_t>(std::lround(unit[axis] * COPPICE_QUANTISED_MAX));
      }
      nodes.push_back({.corners = quad, .card = static_cast<std::uint16_t>(id % 2), .split = plant.tree.node_split[id]});
    }
    pages = test::page_spans(nodes);
    light = measure_crown({nodes, std::vector{1.0f, 0.5f}, box()}, 700);
  }
  static LeafBox box() {
    constexpr float kStep = 2.0f / COPPICE_QUANTISED_MAX;
    return {{-1.0f, -1.0f, -1.0f}, {kStep, kStep, kStep}, COPPICE_QUANTISED_MAX};
  }
  [[nodiscard]] LeafSource source() const { return {nodes[0], pages, looks, box(), light, 700}; }
};

Corners packed(const QuantisedQuad& quad) {
  Corners words{};
  for (std::uint32_t i = 0; i < 12; ++i) words[i / 2] |= std::uint32_t{quad[i / 3][i % 3]} << (i % 2 * 16);
  return words;
}

Corners corners_of(const RasterLeaf& leaf) {
  Corners words{};
  std::ranges::copy(leaf.corners, words.begin());
  return words;
}

std::array<float, 3> corner_m(const RasterList& list, const RasterLeaf& leaf, std::uint32_t corner) {
  const std::array<float, 3> low{list.box_min.x, list.box_min.y, list.box_min.z}, step{list.box_step.x, list.box_step.y, list.box_step.z};
  std::array<float, 3> at{};
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const std::uint32_t half_word = corner * 3 + axis;
    at[axis] = low[axis] + step[axis] * static_cast<float>(leaf.corners[half_word / 2] >> (half_word % 2 * 16) & 0xffffu);
  }
  return at;
}

TEST(LeafLists, HoldTheNodesOfTheCutAndNoOthers) {
  const Crown crown;
  for (const std::uint32_t leaf_count : {1u, 2u, 63u, 64u, 65u, 300u, 700u}) {
    std::multiset<std::pair<Corners, std::uint32_t>> expected, actual;
    for (std::uint32_t id = 0; id < 2 * leaf_count - 1; ++id)
      if (crown.nodes[id].split >= leaf_count - 1) expected.insert({packed(crown.nodes[id].corners), crown.nodes[id].card});
    const BuiltList list = build_leaf_list(crown.source(), leaf_count);
    for (const RasterLeaf& leaf : list.leaves) actual.insert({corners_of(leaf), leaf.card});
    EXPECT_EQ(actual, expected) << leaf_count;
    EXPECT_EQ(list.header.leaf_count, leaf_count);
  }
}

/// As RasterPlants asks for them.
ListBuild build_of(const Crown& crown, std::vector<std::uint32_t> leaf_counts) {
  ListBuild build;
  build.source = {.looks = std::make_shared<PlantLooks>(PlantLooks{{}, crown.looks, {}, {}, {}}),
                  .light = std::make_shared<CrownLight>(crown.light),
                  .box = Crown::box(),
                  .leaf_count = 700};
  build.root = crown.nodes[0];
  build.pages = crown.pages;
  build.leaf_counts = std::move(leaf_counts);
  build.kept_bytes = 1000;
  return build;
}

TEST(LeafLists, AJobOfAnotherThreadBuildsTheSame) {
  Crown crown;
  const auto hooks = complete_hooks({});
  ASSERT_TRUE(hooks);
  for (int round = 0; round < 20; ++round) {
    ListJob job;
    job.start({build_of(crown, {1, 64, 300}), build_of(crown, {700})}, hooks->hooks.jobs);
    if (round % 4 == 0) continue;  // nobody takes it: the destructor waits
    std::vector<ListBuild> builds;
    while (builds.empty()) {
      EXPECT_FALSE(job.idle());
      EXPECT_EQ(job.kept_bytes(), 2000u);
      builds = job.take();
    }
    EXPECT_TRUE(job.idle());
    EXPECT_EQ(job.kept_bytes(), 0u);
    ASSERT_EQ(builds.size(), 2u);
    ASSERT_EQ(builds[0].headers.size(), 3u);
    const BuiltList expected = build_leaf_list(crown.source(), 300);
    const auto& [clusters, leaves, splats] = builds[0].addresses[2];
    EXPECT_EQ(builds[0].headers[2].leaf_count, 300u);
    EXPECT_EQ(std::memcmp(builds[0].bytes.data() + clusters, expected.clusters.data(), leaves - clusters), 0);
    EXPECT_EQ(std::memcmp(builds[0].bytes.data() + leaves, expected.leaves.data(), splats - leaves), 0);
    EXPECT_EQ(builds[0].bytes.size() - splats, expected.splats.size() * sizeof(RasterSplat));
    EXPECT_EQ(builds[1].headers[0].leaf_count, 700u);
  }
}

TEST(LeafLists, ClustersPartTheLeavesAndBoundThem) {
  const Crown crown;
  const BuiltList list = build_leaf_list(crown.source(), 700);
  EXPECT_EQ(list.header.cluster_count, list.clusters.size());
  std::uint32_t leaves = 0, splats = 0;
  for (const RasterCluster& cluster : list.clusters) {
    EXPECT_EQ(cluster.first_leaf, leaves);
    EXPECT_EQ(cluster.first_splat, splats);
    EXPECT_LE(cluster.leaf_count, kClusterLeaves);
    EXPECT_GE(cluster.splat_count, cluster.leaf_count);
    EXPECT_LE(cluster.splat_count, cluster.leaf_count * kMaxGrains);
    leaves += cluster.leaf_count;
    splats += cluster.splat_count;
    for (std::uint32_t i = cluster.first_leaf; i < leaves; ++i)
      for (std::uint32_t corner = 0; corner < 4; ++corner) {
        const auto at = corner_m(list.header, list.leaves[i], corner);
        const float x = at[0] - cluster.center.x, y = at[1] - cluster.center.y, z = at[2] - cluster.center.z;
        EXPECT_LE(std::sqrt(x * x + y * y + z * z), cluster.radius_m * 1.0001f);
      }
  }
  EXPECT_EQ(leaves, list.leaves.size());
  EXPECT_EQ(splats, list.splats.size());
}

TEST(LeafLists, SplatsCoverTheAreaOfTheirLeaves) {
  const Crown crown;
  const BuiltList list = build_leaf_list(crown.source(), 700);
  double leaf_m2 = 0, splat_m2 = 0;
  for (const RasterLeaf& leaf : list.leaves) {
    std::array<std::array<float, 3>, 4> c{};
    for (std::uint32_t i = 0; i < 4; ++i) c[i] = corner_m(list.header, leaf, i);
    const auto area = [&](std::size_t a, std::size_t b) {
      std::array<double, 3> u{}, v{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        u[axis] = static_cast<double>(c[a][axis] - c[0][axis]);
        v[axis] = static_cast<double>(c[b][axis] - c[0][axis]);
      }
      const double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2], z = u[0] * v[1] - u[1] * v[0];
      return 0.5 * std::sqrt(x * x + y * y + z * z);
    };
    leaf_m2 += (area(1, 2) + area(2, 3)) * static_cast<double>(crown.looks[leaf.card].coverage);
  }
  for (const RasterSplat& splat : list.splats) {
    const double side_m = static_cast<double>(splat.z_size >> 16) / 65535.0 * static_cast<double>(list.header.splat_size_m);
    splat_m2 += side_m * side_m;
  }
  EXPECT_NEAR(splat_m2, leaf_m2, 1e-3 * leaf_m2);
}

/// A rectangle of 1 x 2 m in two triangles, lit from above; u of their corners in [low, high].
WoodMesh two_triangles(float low, float high) {
  WoodMesh mesh;
  for (const auto& [x, y] : {std::pair{0.0f, 0.0f}, std::pair{1.0f, 0.0f}, std::pair{0.0f, 2.0f}, std::pair{1.0f, 2.0f}})
    mesh.vertices.push_back({{x, y, 0}, {0, 0, 1}, {x > 0 ? high : low, 0.5f}, 1});
  mesh.indices = {0, 1, 2, 2, 1, 3};
  return mesh;
}

/// One card and two materials; the left half of the second one's texture is white, the right half a hole.
PlantLooks half_a_texture() {
  PlantLooks plant;
  plant.materials.resize(2);
  set_material_textures(plant.materials[0], COPPICE_NO_TEXTURE, COPPICE_NO_TEXTURE);
  plant.materials[1] = {.base_color = {0.25f, 0.5f, 0.125f, 1.0f}, .alpha_cutoff = 0.5f, .texture_or_none = 0};
  plant.looks.resize(3);
  plant.first_wood_color = {0, 1};
  plant.small.push_back({16, 1, {}});
  for (int x = 0; x < 16; ++x)
    plant.small[0].rgba.insert(plant.small[0].rgba.end(), {255, 255, 255, static_cast<std::uint8_t>(x < 8 ? 255 : 0)});
  return plant;
}

TEST(LeafLists, WoodTrianglesKeepTheirMaterialAndNormal) {
  WoodMesh mesh;
  mesh.vertices = {
      {{0, 0, 0}, {0, 0, 1}, {}, 1}, {{1, 0, 0}, {0, 0, 1}, {}, 1}, {{0, 2, 0}, {0, 0, 1}, {}, 1}, {{0, 0, 3}, {-1, 0, 0}, {}, 0}};
  mesh.indices = {0, 1, 2, 3, 0, 2};
  PlantLooks looks;
  looks.looks.resize(5);
  looks.materials.resize(2);
  for (coppice_file_material& material : looks.materials) set_material_textures(material, COPPICE_NO_TEXTURE, COPPICE_NO_TEXTURE);
  looks.first_wood_color = {7, 8};
  const BuiltList list = build_wood_list(mesh, {looks, CrownLight{}});
  ASSERT_EQ(list.leaves.size(), 2u);
  std::map<std::uint32_t, RasterLeaf> by_look;
  for (const RasterLeaf& leaf : list.leaves) by_look[leaf.card] = leaf;
  ASSERT_TRUE(by_look.contains(4) && by_look.contains(3));
  EXPECT_EQ(by_look[3].look & 0xffffffu, 7u) << "its colour is looked up: textures may come later";
  EXPECT_EQ(by_look[4].look & 0xffffffu, 8u);
  EXPECT_FLOAT_EQ(list.header.facet_m, std::sqrt(3.0f));
  EXPECT_EQ(by_look[4].normals & 0xffffu, 0u) << "straight up the octahedron is its middle";
  const auto corner = corner_m(list.header, by_look[4], 2), repeated = corner_m(list.header, by_look[4], 3);
  EXPECT_NEAR(corner[1], 2.0f, 1e-3f);
  EXPECT_EQ(corner, repeated);
  EXPECT_TRUE(build_wood_list({}, {looks, CrownLight{}}).leaves.empty());
}

/// A strip of two triangles, 0.1 m wide and 8 m high.
WoodMesh strip(const std::array<std::array<float, 3>, 4>& normals) {
  WoodMesh mesh;
  for (std::uint32_t i = 0; i < 4; ++i)
    mesh.vertices.push_back({{0.1f * static_cast<float>(i % 2), 8.0f * static_cast<float>(i / 2), 0}, normals[i], {}, 0});
  mesh.indices = {0, 1, 2, 2, 1, 3};
  return mesh;
}

TEST(LeafLists, LightThatTurnsAlongALongTriangleMakesItAFacet) {
  PlantLooks looks;
  looks.materials.resize(1);
  looks.looks.resize(1);
  set_material_textures(looks.materials[0], COPPICE_NO_TEXTURE, COPPICE_NO_TEXTURE);
  looks.first_wood_color = {0};
  const std::array<float, 3> front{0, 0, 1}, side{1, 0, 0}, below{0, -1, 0};
  const auto facet_m = [&](const WoodMesh& mesh) { return build_wood_list(mesh, {looks, CrownLight{}}).header.facet_m; };
  const float size_m = std::sqrt(0.4f);
  EXPECT_FLOAT_EQ(facet_m(strip({front, front, front, front})), size_m);
  EXPECT_FLOAT_EQ(facet_m(strip({front, side, front, side})), size_m) << "a stem: its light turns across it, which is narrow";
  EXPECT_NEAR(facet_m(strip({below, below, front, front})), 0.4f * std::sqrt(2.0f) * 8.0f, 0.01f);
  EXPECT_NEAR(facet_m(strip({below, side, front, side})), 0.2f * std::sqrt(1.5f) * 8.0f, 0.1f) << "along one of the two";
}

TEST(LeafLists, WoodTrianglesCoverWhatTheirTextureCovers) {
  const PlantLooks looks = half_a_texture();
  const CrownLight light;
  const auto covered_m2 = [](const BuiltList& list) {
    double sum = 0;
    for (const RasterSplat& splat : list.splats) {
      const double side_m = static_cast<double>(splat.z_size >> 16) / 65535.0 * static_cast<double>(list.header.splat_size_m);
      sum += side_m * side_m;
    }
    return sum;
  };
  const BuiltList whole = build_wood_list(two_triangles(0.1f, 0.4f), {looks, light});
  ASSERT_EQ(whole.clusters.size(), 1u);
  EXPECT_EQ(whole.clusters[0].is_surface, 1u);
  EXPECT_EQ(whole.header.holed_m, 0.0f);
  EXPECT_NEAR(covered_m2(whole), 2.0, 0.01);
  const BuiltList half = build_wood_list(two_triangles(0.1f, 0.9f), {looks, light});
  ASSERT_EQ(half.clusters.size(), 1u);
  EXPECT_EQ(half.clusters[0].is_surface, 0u);
  EXPECT_EQ(half.header.holed_m, half.header.grain_m) << "where this is large, the texture has to make the outline";
  EXPECT_NEAR(covered_m2(half), 1.0, 0.1);
  EXPECT_TRUE(build_wood_list(two_triangles(0.6f, 0.9f), {looks, light}).leaves.empty()) << "nothing but hole";
  // The same, but without holes.
  PlantLooks opaque = looks;
  opaque.materials[1].alpha_cutoff = 0.0f;
  EXPECT_NEAR(covered_m2(build_wood_list(two_triangles(0.6f, 0.9f), {opaque, light})), 2.0, 0.01);
}

TEST(LeafLists, TrianglesOfLeafMeshesHaveTheirTexturesColourAndNoHoles) {
  const PlantLooks looks = half_a_texture();
  const CrownLight light;
  const LeafMeshSource source{looks, Crown::box(), light};
  const BuiltList list = build_leaf_mesh_list(two_triangles(0.1f, 0.4f), source);
  ASSERT_EQ(list.leaves.size(), 2u);
  EXPECT_EQ(list.header.cluster_count, 1u);
  for (const RasterLeaf& leaf : list.leaves) {
    EXPECT_EQ(leaf.card, 2u) << "the second material's";
    const auto channel = [&](std::uint32_t i) { return static_cast<float>(leaf.look >> (8 * i) & 0xffu) / 255.0f; };
    for (const auto& [i, albedo] : {std::pair{0u, 0.25f}, std::pair{1u, 0.5f}, std::pair{2u, 0.125f}})
      EXPECT_NEAR(kMaxSplatAlbedo * channel(i) * channel(i) / albedo, 1.0f, 0.35f) << "but for the leaf's own variation";
  }
  EXPECT_TRUE(build_leaf_mesh_list(two_triangles(0.6f, 0.9f), source).leaves.empty()) << "nothing but hole";
  EXPECT_TRUE(build_leaf_mesh_list(two_triangles(0.1f, 0.9f), source).leaves.empty()) << "the texture makes the outline";
}

/// Shadows of other plants are a cluster's: they would cut a leaf in two.
TEST(LeafLists, TrianglesOfALeafAreOfOneCluster) {
  const PlantLooks looks = half_a_texture();
  const CrownLight light;
  for (const std::uint32_t triangles : {2u, 12u, 33u, 64u, 100u}) {
    // Leaf `i` at x = i, its triangles of different sizes and anywhere in the file.
    constexpr std::uint32_t kLeaves = 50;
    WoodMesh mesh;
    for (std::uint32_t triangle = 0; triangle < triangles; ++triangle)
      for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf) {
        const auto x = static_cast<float>(leaf), size = 0.05f + 0.5f * static_cast<float>(triangle % 7);
        const auto stalk = static_cast<std::uint16_t>(300 * leaf);
        for (const auto& [dx, y] : {std::pair{0.0f, 0.0f}, std::pair{0.3f, 0.0f}, std::pair{0.0f, size}}) {
          mesh.indices.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
          mesh.vertices.push_back({{x + dx, y, 0}, {0, 0, 1}, {0.1f, 0.5f}, 1, {stalk, 0, 0}});
        }
      }
    const BuiltList list = build_leaf_mesh_list(mesh, {looks, Crown::box(), light});
    ASSERT_EQ(list.leaves.size(), std::size_t{kLeaves} * triangles);
    std::uint32_t split = 0;
    for (const RasterCluster& cluster : list.clusters) {
      EXPECT_LE(cluster.leaf_count, kClusterLeaves);
      std::map<int, std::uint32_t> members;
      for (std::uint32_t i = 0; i < cluster.leaf_count; ++i)
        ++members[static_cast<int>(corner_m(list.header, list.leaves[cluster.first_leaf + i], 0)[0] + 0.1f)];
      for (const auto& [leaf, count] : members) split += count != triangles;
    }
    EXPECT_EQ(split, triangles <= kClusterLeaves ? 0u : 2 * kLeaves) << triangles;
  }
}

TEST(LeafLists, TheLadderRisesAndItsRungsHoldWhatIsAskedFor) {
  for (std::uint32_t leaves = 1; leaves < 200000; leaves += 1 + leaves / 7) {
    const std::uint32_t rung = lod::coppice_ladder_level(static_cast<float>(leaves));
    EXPECT_GE(static_cast<float>(lod::coppice_ladder_leaf_count(rung)) * 1.003f, static_cast<float>(leaves));
    if (leaves > 16) {
      EXPECT_LT(static_cast<float>(lod::coppice_ladder_leaf_count(rung)), 1.27f * static_cast<float>(leaves));
    }
    EXPECT_LE(lod::coppice_ladder_leaf_count(rung), lod::coppice_ladder_leaf_count(rung + 1));
  }
  EXPECT_EQ(lod::coppice_ladder_level(1.0f), 0u);
  // 64 leaves are rung 18, which is for 51 to 64.
  for (const float leaves : {51.0f, 60.0f, 64.0f}) EXPECT_EQ(lod::coppice_kept_ladder_level(leaves, 40), 18u) << leaves;
  for (const float leaves : {49.0f, 60.0f, 67.0f}) EXPECT_EQ(lod::coppice_kept_ladder_level(leaves, 18), 18u) << leaves;
  EXPECT_EQ(lod::coppice_kept_ladder_level(68.5f, 18), 19u);
  EXPECT_EQ(lod::coppice_kept_ladder_level(47.0f, 18), 17u);
  EXPECT_EQ(lod::coppice_kept_ladder_level(60.0f, ~0u), 18u);
  EXPECT_LT(lod::coppice_ladder_level(static_cast<float>(COPPICE_MAX_LEAVES)), kRasterLevels);
}

}  // namespace
}  // namespace coppice::gpu
