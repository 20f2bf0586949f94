// Leaves and triangles as clusters: what they hold of each cut, and that what they say of it is true.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <numeric>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "coppice/format.h"
#include "coppice_lod.h"
#include "coppice_transparency.h"
#include "fake_hooks.h"
#include "hook_array.h"
#include "hooks.h"
#include "made_mesh.h"
#include "mesh_clusters.h"
#include "page_clusters.h"
#include "random_tree.h"
#include "reader.h"

namespace coppice::gpu::clusters_test {

using test::hook_array;
using test::MadeMesh;

using Corners = std::array<std::uint32_t, 6>;
constexpr std::uint32_t kLeaves = 1500;  // three pages, the last one not full

using LeafName = std::pair<Corners, std::uint32_t>;  ///< corners and card

template <class T>
T read(std::span<const std::uint8_t> bytes, std::uint64_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::uint64_t address_of(const uvec2& address) {
  return address.x | std::uint64_t{address.y} << 32;
}

/// A cluster, taken apart.
struct Parts {
  Cluster cluster;
  std::vector<Leaf> leaves;
  std::vector<Splat> splats;

  Parts(std::span<const std::uint8_t> bytes, std::uint64_t cluster_at) : cluster(read<Cluster>(bytes, cluster_at)) {
    for (std::uint32_t at = 0; at < (cluster.counts & 0xffu); ++at) {
      leaves.push_back(read<Leaf>(bytes, address_of(cluster.leaves) + at * sizeof(Leaf)));
      splats.push_back(read<Splat>(bytes, address_of(cluster.splats) + at * sizeof(Splat)));
    }
  }
  [[nodiscard]] double side_m(std::size_t splat) const {
    return static_cast<double>(splats[splat].z_size >> 16) / 65535.0 * static_cast<double>(cluster.splat_size_m);
  }
  [[nodiscard]] std::uint32_t grains() const { return 1u << (cluster.counts >> kCountGrains & 3u); }
};

/// The clusters of a page.
std::vector<Parts> parts_of(std::span<const std::uint8_t> page) {
  std::vector<Parts> parts;
  for (std::uint32_t i = 0; i < kBlockClusters; ++i) parts.emplace_back(page, i * sizeof(Cluster));
  return parts;
}

Corners packed(const QuantisedQuad& quad) {
  Corners words{};
  for (std::uint32_t i = 0; i < 12; ++i) words[i / 2] |= std::uint32_t{quad[i / 3][i % 3]} << (i % 2 * 16);
  return words;
}

/// A crown of kLeaves leaves in the box [-1, 1]^3, quantised as the runtime has it.
struct Crown {
  std::vector<PageNode> nodes;
  std::vector<CardLook> looks{{{0.2f, 0.4f, 0.1f}, 1.0f, {~0u, ~0u}, 0.5f}, {{0.3f, 0.3f, 0.1f}, 0.5f, {~0u, 0u}, 0.5f}};
  CrownLight light;

  Crown() {
    const bake::BakedPlant plant = test::random_plant({.leaf_count = kLeaves, .seed = 4});
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
      nodes.push_back({.corners = quad, .card = static_cast<std::uint8_t>(id % 2), .split = plant.tree.node_split[id]});
    }
    light = measure_crown({nodes[0], page(0), looks, box()});
  }
  static LeafBox box() {
    constexpr float kStep = 2.0f / COPPICE_QUANTISED_MAX;
    return {{-1.0f, -1.0f, -1.0f}, {kStep, kStep, kStep}, COPPICE_QUANTISED_MAX};
  }
  [[nodiscard]] LeafSource source() const { return {nodes[0], looks, box(), &light, kLeaves}; }
  [[nodiscard]] std::span<const PageNode> page(std::uint32_t index) const {
    const std::size_t first = std::size_t{index} * kPageNodes + 1;
    return std::span(nodes).subspan(first, std::min<std::size_t>(kPageNodes, nodes.size() - first));
  }
  [[nodiscard]] std::vector<std::uint8_t> built_page(std::uint32_t index) const {
    std::vector<std::uint8_t> bytes(kPageBytes, 0xcd);
    const auto scratch = std::make_unique<ClusterScratch>();
    build_page(source(), index, page(index), *scratch, bytes);
    return bytes;
  }
  [[nodiscard]] ReadyCuts ready_cuts() const {
    ReadyCuts cuts;
    EXPECT_TRUE(allocate_into(cuts.bytes, default_allocator(), ready_cut_bytes(kLeaves)));
    const auto scratch = std::make_unique<ClusterScratch>();
    build_ready_cuts(source(), page(0), *scratch, cuts);
    return cuts;
  }
  /// Corners and card of each leaf of cut(leaf_count).
  [[nodiscard]] std::multiset<LeafName> cut(std::uint32_t leaf_count) const {
    std::multiset<LeafName> leaves;
    for (std::uint32_t id = 0; id < 2 * leaf_count - 1; ++id)
      if (lod::coppice_node_alive(id, nodes[id].split, leaf_count)) leaves.insert({packed(nodes[id].corners), nodes[id].card});
    return leaves;
  }
};

LeafName name_of(const Leaf& leaf) {
  Corners words{};
  std::ranges::copy(leaf.corners, words.begin());
  return {words, card_of_leaf(leaf.card)};
}

vec3 corner_m(const LeafBox& box, const Leaf& leaf, std::uint32_t corner) {
  const auto half_word = [&](std::uint32_t i) { return leaf.corners[i / 2] >> (i % 2 * 16) & 0xffffu; };
  return box.at({half_word(3 * corner), half_word(3 * corner + 1), half_word(3 * corner + 2)});
}

/// Adds what clusters.glsl shows of a page's cluster: its first leaves as far as they live, but for those that are not born.
void show(std::span<const std::uint8_t> page, std::uint32_t index, std::uint32_t leaf_count, std::multiset<LeafName>& shown) {
  const std::uint32_t splits = leaf_count - 1, first_split = index * kPageSplits;
  for (const auto& [cluster, leaves, splats] : parts_of(page)) {
    const std::uint32_t first_birth = first_split + (cluster.counts >> kCountFirstBirth & 511u);
    if (first_birth >= splits || cluster.last_death < splits) continue;
    for (const Leaf& leaf : leaves) {
      if ((leaf.life & kNoDeath) < splits) break;  // all behind it are dead
      const std::uint32_t birth = first_split + (leaf.life >> kBirthShift);
      EXPECT_GE(birth, first_birth);
      EXPECT_LE(birth, first_split + (cluster.counts >> kCountLastBirth & 511u));
      if (birth < splits) shown.insert(name_of(leaf));
    }
  }
}

TEST(Clusters, PagesHoldTheNodesOfEveryCutAndNoOthers) {
  const Crown crown;
  std::vector<std::vector<std::uint8_t>> pages;
  for (std::uint32_t page = 0; page < 3; ++page) pages.push_back(crown.built_page(page));
  for (const std::uint32_t leaf_count :
       {65u, 66u, 100u, 127u, 128u, 129u, 130u, 200u, 256u, 257u, 400u, 512u, 513u, 514u, 800u, 1024u, 1025u, 1026u, 1300u, 1499u, 1500u}) {
    std::multiset<LeafName> actual;
    for (std::uint32_t page = 0; page * kPageSplits < leaf_count - 1; ++page) show(pages[page], page, leaf_count, actual);
    EXPECT_EQ(actual, crown.cut(leaf_count)) << leaf_count;
  }
}

TEST(Clusters, ReadyCutsHoldTheNodesOfTheirs) {
  const Crown crown;
  const ReadyCuts cuts = crown.ready_cuts();
  for (std::uint32_t cut = 0; cut < kReadyCuts; ++cut) {
    const ClusterList& list = cuts.lists[cut];
    EXPECT_EQ(list.leaf_count, lod::coppice_ladder_leaf_count(cut));
    std::multiset<LeafName> actual;
    const std::uint64_t clusters = address_of(read<uvec2>(cuts.bytes.span(), address_of(list.blocks)));
    for (std::uint32_t i = 0; i < list.cluster_count; ++i)
      for (const Leaf& leaf : Parts(cuts.bytes.span(), clusters + i * sizeof(Cluster)).leaves) actual.insert(name_of(leaf));
    EXPECT_EQ(actual, crown.cut(list.leaf_count)) << cut;
  }
  EXPECT_EQ(cuts.lists[kReadyCuts - 1].leaf_count, kReadyLeaves);
}

TEST(Clusters, ThoseOfAPlantOfOneLeafAreItsRoot) {
  Crown crown;
  LeafSource source = crown.source();
  source.leaf_count = 1;
  ReadyCuts cuts;
  ASSERT_TRUE(allocate_into(cuts.bytes, default_allocator(), ready_cut_bytes(1)));
  const auto scratch = std::make_unique<ClusterScratch>();
  build_ready_cuts(source, {}, *scratch, cuts);
  for (const ClusterList& list : cuts.lists) {
    EXPECT_EQ(list.leaf_count, 1u);
    EXPECT_EQ(address_of(list.blocks), address_of(cuts.lists[0].blocks));
  }
}

// Leaves are drawn pixel by pixel, so that they carry their gaps; discs are smaller by them.
TEST(Clusters, CarryTheTransparencyOfTheirLeaves) {
  Crown crown;
  const std::vector<std::uint8_t> opaque = crown.built_page(0);
  EXPECT_FALSE(crown.ready_cuts().has_transparency);
  std::set<LeafName> gaps;  // a merged leaf may have the corners of one that it replaced
  for (std::size_t id = 0; id < crown.nodes.size(); ++id) {
    crown.nodes[id].opacity = static_cast<std::uint8_t>(1 + id % 16);
    gaps.insert({packed(crown.nodes[id].corners), 15 - id % 16});
  }
  EXPECT_FALSE(has_transparency(opaque));
  const std::vector<std::uint8_t> bytes = crown.built_page(0);
  EXPECT_TRUE(has_transparency(bytes));
  EXPECT_TRUE(crown.ready_cuts().has_transparency);
  const std::vector<Parts> with_gaps = parts_of(bytes), whole = parts_of(opaque);
  for (std::uint32_t i = 0; i < kBlockClusters; ++i) {
    EXPECT_EQ(with_gaps[i].cluster.grains_m, whole[i].cluster.grains_m) << "what decides who draws it";
    EXPECT_EQ(with_gaps[i].cluster.leaf_sizes_m, whole[i].cluster.leaf_sizes_m);
    for (std::size_t at = 0; at < with_gaps[i].leaves.size(); ++at) {
      const Leaf &leaf = with_gaps[i].leaves[at], &before = whole[i].leaves.at(at);
      const std::uint32_t gap = transparency_of_leaf(leaf.card);
      EXPECT_TRUE(gaps.contains({name_of(leaf).first, gap}));
      EXPECT_EQ(transparency_of_leaf(before.card), 0u);
      EXPECT_EQ(card_of_leaf(leaf.card), card_of_leaf(before.card));
      EXPECT_NEAR(std::pow(with_gaps[i].side_m(at) / whole[i].side_m(at), 2), opacity_of(gap), 1e-3);
    }
  }
}

TEST(Clusters, TakeNoMoreMemoryThanIsSaid) {
  EXPECT_LE(kPageBytes / kPageSplits, 113u) << "ARCHITECTURE.md, DECISIONS.md";
  EXPECT_LE(ready_cut_bytes(100000), 36u << 10);
  EXPECT_LE(ready_cut_bytes(1), 256u);
}

TEST(Clusters, BoundTheirLeavesAndSayHowLongTheyAre) {
  const Crown crown;
  for (std::uint32_t page = 0; page < 3; ++page)
    for (const auto& [cluster, leaves, splats] : parts_of(crown.built_page(page))) {
      EXPECT_LE(leaves.size(), kClusterLeaves);
      if (leaves.empty()) continue;
      EXPECT_GT(unpack_length(cluster.grains_m, 3), 0.0f);
      EXPECT_GT(unpack_length(cluster.leaf_sizes_m, 0), 0.0f);
      std::uint32_t last_death = 0;
      for (const Leaf& leaf : leaves) {
        last_death = std::max(last_death, leaf.life & kNoDeath);
        for (std::uint32_t corner = 0; corner < 4; ++corner)
          EXPECT_LE(distance(corner_m(Crown::box(), leaf, corner), cluster.center), cluster.radius_m * 1.0001f);
      }
      EXPECT_EQ(cluster.last_death, last_death);
    }
}

TEST(Clusters, SplatsCoverTheAreaOfTheirLeaves) {
  const Crown crown;
  double leaf_m2 = 0, splat_m2 = 0;
  for (const Parts& parts : parts_of(crown.built_page(1))) {
    EXPECT_LE(parts.grains(), kMaxGrains);
    for (std::size_t at = 0; at < parts.leaves.size(); ++at) {
      const Leaf& leaf = parts.leaves[at];
      std::array<vec3, 4> c;
      for (std::uint32_t corner = 0; corner < 4; ++corner) c[corner] = corner_m(Crown::box(), leaf, corner);
      leaf_m2 += static_cast<double>(quad_area(c) * crown.looks[card_of_leaf(leaf.card)].coverage);
      splat_m2 += parts.grains() * parts.side_m(at) * parts.side_m(at);
    }
  }
  EXPECT_NEAR(splat_m2, leaf_m2, 1e-3 * leaf_m2);
}

TEST(Clusters, AddressesMoveWithThem) {
  const Crown crown;
  constexpr std::uint64_t kBase = 0x1fffffff0ull;  // carries into the high word
  std::vector<std::uint8_t> moved = crown.built_page(1);
  const std::vector<std::uint8_t> page = moved;
  move_clusters(moved, kBlockClusters, kBase);
  ReadyCuts cuts = crown.ready_cuts();
  const ReadyCuts still = crown.ready_cuts();
  move_ready_cuts(kLeaves, cuts.lists, cuts.bytes.span(), kBase);
  for (std::uint32_t i = 0; i < kBlockClusters; ++i) {
    const auto from = read<Cluster>(page, i * sizeof(Cluster)), to = read<Cluster>(moved, i * sizeof(Cluster));
    EXPECT_EQ(address_of(to.leaves), address_of(from.leaves) + kBase);
    EXPECT_EQ(address_of(to.splats), address_of(from.splats) + kBase);
  }
  for (std::uint32_t cut = 0; cut < kReadyCuts; ++cut) {
    const std::uint64_t block = address_of(still.lists[cut].blocks);
    EXPECT_EQ(address_of(cuts.lists[cut].blocks), block + kBase);
    const std::uint64_t clusters = address_of(read<uvec2>(still.bytes.span(), block));
    EXPECT_EQ(address_of(read<uvec2>(cuts.bytes.span(), block)), clusters + kBase);
    EXPECT_EQ(address_of(read<Cluster>(cuts.bytes.span(), clusters).leaves),
              address_of(read<Cluster>(still.bytes.span(), clusters).leaves) + kBase);
  }
}

/// Where a mesh has its cluster `index`.
std::uint64_t cluster_at(const MeshBlock& built, std::uint32_t index) {
  const std::uint64_t block = address_of(built.list.blocks) + index / kBlockClusters * sizeof(uvec2);
  return address_of(read<uvec2>(built.bytes.span(), block)) + index % kBlockClusters * sizeof(Cluster);
}

/// The clusters of a mesh.
std::vector<Parts> parts_of(const MeshBlock& built) {
  std::vector<Parts> parts;
  for (std::uint32_t i = 0; i < built.list.cluster_count; ++i) parts.emplace_back(built.bytes.span(), cluster_at(built, i));
  return parts;
}

/// The only cluster of a mesh.
Parts only_part(const MeshBlock& built) {
  const std::vector<Parts> parts = parts_of(built);
  EXPECT_EQ(parts.size(), 1u);
  return parts.at(0);
}

LeafBox box_of(const ClusterList& list) {
  return {list.box_min, list.box_step, 65535};
}

MeshBlock block_of(MeshKind kind, const WoodSpan& mesh, const PlantLooks& looks, bool clusters = true) {
  return *build_mesh(kind, mesh, {{looks, CrownLight{}}, Crown::box(), clusters}, default_allocator());
}

/// A rectangle of 1 x 2 m in two triangles, lit from above; u of their corners in [low, high].
MadeMesh two_triangles(float low, float high) {
  MadeMesh mesh;
  for (const auto& [x, y] : {std::pair{0.0f, 0.0f}, std::pair{1.0f, 0.0f}, std::pair{0.0f, 2.0f}, std::pair{1.0f, 2.0f}})
    mesh.vertices.push_back({{x, y, 0}, {0, 0, 1}, {x > 0 ? high : low, 0.5f}, 1});
  mesh.indices = {0, 1, 2, 2, 1, 3};
  return mesh;
}

/// One card and two materials; the left half of the second one's texture is white, the right half a hole.
PlantLooks half_a_texture() {
  PlantLooks plant;
  plant.materials = hook_array(std::vector<coppice_file_material>(2));
  set_material_textures(plant.materials[0], COPPICE_NO_TEXTURE, COPPICE_NO_TEXTURE);
  plant.materials[1] = {.base_color = {0.25f, 0.5f, 0.125f, 1.0f}, .alpha_cutoff = 0.5f, .texture_or_none = 0};
  plant.looks = hook_array(std::vector<CardLook>(3));
  plant.wood_colors = hook_array(std::vector<std::uint32_t>(2000));
  plant.first_wood_color = hook_array<std::uint32_t>({0, 1});
  std::vector<std::uint8_t> rgba(4 * 16, 255);
  for (std::size_t x = 8; x < 16; ++x) rgba[4 * x + 3] = 0;
  plant.small = *HookArray<Texels>::allocate(default_allocator(), 1);
  plant.small[0] = {16, 1, hook_array(rgba)};
  return plant;
}

/// A material without a texture for each colour, and no card.
PlantLooks untextured_looks(const std::vector<std::uint32_t>& colors) {
  PlantLooks plant;
  plant.materials = hook_array(std::vector<coppice_file_material>(colors.size()));
  for (coppice_file_material& material : plant.materials) set_material_textures(material, COPPICE_NO_TEXTURE, COPPICE_NO_TEXTURE);
  plant.looks = hook_array(std::vector<CardLook>(colors.size()));
  plant.wood_colors = hook_array(colors);
  std::vector<std::uint32_t> first(colors.size());
  std::iota(first.begin(), first.end(), 0u);
  plant.first_wood_color = hook_array(first);
  return plant;
}

TEST(Clusters, WoodTrianglesKeepTheirMaterialAndNormal) {
  MadeMesh mesh;
  mesh.vertices = {
      {{0, 0, 0}, {0, 0, 1}, {}, 1}, {{1, 0, 0}, {0, 0, 1}, {}, 1}, {{0, 2, 0}, {0, 0, 1}, {}, 1}, {{0, 0, 3}, {-1, 0, 0}, {}, 0}};
  mesh.indices = {0, 1, 2, 3, 0, 2};
  PlantLooks looks = untextured_looks({70, 80});
  looks.looks = hook_array(std::vector<CardLook>(5));
  const MeshBlock built = block_of(MeshKind::wood, mesh, looks);
  const Parts list = only_part(built);
  ASSERT_EQ(list.leaves.size(), 2u);
  std::map<std::uint32_t, Leaf> by_look;
  std::map<std::uint32_t, Splat> splats;
  for (std::size_t i = 0; i < 2; ++i) {
    by_look[list.leaves[i].card] = list.leaves[i];
    splats[list.leaves[i].card] = list.splats[i];
  }
  ASSERT_TRUE(by_look.contains(4) && by_look.contains(3));
  EXPECT_EQ(splats[3].look & 0xffffffu, 70u);
  EXPECT_EQ(splats[4].look & 0xffffffu, 80u);
  EXPECT_FLOAT_EQ(built.list.facet_m, std::sqrt(3.0f));
  EXPECT_EQ(splats[4].normals & 0xffffu, 0u) << "straight up the octahedron is its middle";
  const vec3 corner = corner_m(box_of(built.list), by_look[4], 2), repeated = corner_m(box_of(built.list), by_look[4], 3);
  EXPECT_NEAR(corner.y, 2.0f, 1e-3f);
  EXPECT_EQ(corner, repeated);
}

/// A strip of two triangles, 0.1 m wide and 8 m high.
MadeMesh strip(const std::array<std::array<float, 3>, 4>& normals) {
  MadeMesh mesh;
  for (std::uint32_t i = 0; i < 4; ++i)
    mesh.vertices.push_back({{0.1f * static_cast<float>(i % 2), 8.0f * static_cast<float>(i / 2), 0}, normals[i], {}, 0});
  mesh.indices = {0, 1, 2, 2, 1, 3};
  return mesh;
}

TEST(Clusters, LightThatTurnsAlongALongTriangleMakesItAFacet) {
  const PlantLooks looks = untextured_looks({0});
  const std::array<float, 3> front{0, 0, 1}, side{1, 0, 0}, below{0, -1, 0};
  const auto facet_m = [&](const MadeMesh& mesh) { return block_of(MeshKind::wood, mesh, looks).list.facet_m; };
  const float size_m = std::sqrt(0.4f);
  EXPECT_FLOAT_EQ(facet_m(strip({front, front, front, front})), size_m);
  EXPECT_FLOAT_EQ(facet_m(strip({front, side, front, side})), size_m) << "a stem: its light turns across it, which is narrow";
  EXPECT_NEAR(facet_m(strip({below, below, front, front})), 0.4f * std::sqrt(2.0f) * 8.0f, 0.01f);
  EXPECT_NEAR(facet_m(strip({below, side, front, side})), 0.2f * std::sqrt(1.5f) * 8.0f, 0.1f) << "along one of the two";
}

TEST(Clusters, WoodTrianglesCoverWhatTheirTextureCovers) {
  const PlantLooks looks = half_a_texture();
  const auto covered_m2 = [](const MeshBlock& built) {
    const Parts list = only_part(built);
    double sum = 0;
    for (std::size_t splat = 0; splat < list.splats.size(); ++splat) sum += list.grains() * list.side_m(splat) * list.side_m(splat);
    return sum;
  };
  const auto is_surface = [](const MeshBlock& built) { return (only_part(built).cluster.counts >> kCountSurface & 1u) != 0; };
  const MeshBlock whole = block_of(MeshKind::wood, two_triangles(0.1f, 0.4f), looks);
  EXPECT_TRUE(is_surface(whole));
  EXPECT_EQ(whole.list.holed_m, 0.0f);
  EXPECT_NEAR(covered_m2(whole), 2.0, 0.01);
  const MeshBlock half = block_of(MeshKind::wood, two_triangles(0.1f, 0.9f), looks);
  EXPECT_FALSE(is_surface(half));
  EXPECT_EQ(half.list.holed_m, half.list.grain_m) << "where this is large, the texture has to make the outline";
  EXPECT_NEAR(covered_m2(half), 1.0, 0.1);
  EXPECT_EQ(block_of(MeshKind::wood, two_triangles(0.6f, 0.9f), looks).list.leaf_count, 0u) << "nothing but hole";
  // The same, but without holes.
  PlantLooks opaque = half_a_texture();
  opaque.materials[1].alpha_cutoff = 0.0f;
  EXPECT_NEAR(covered_m2(block_of(MeshKind::wood, two_triangles(0.6f, 0.9f), opaque)), 2.0, 0.01);
}

TEST(Clusters, TrianglesOfLeafMeshesHaveTheirTexturesColourAndNoHoles) {
  const PlantLooks looks = half_a_texture();
  const Parts list = only_part(block_of(MeshKind::leaves, two_triangles(0.1f, 0.4f), looks));
  ASSERT_EQ(list.leaves.size(), 2u);
  for (std::size_t triangle = 0; triangle < 2; ++triangle) {
    EXPECT_EQ(list.leaves[triangle].card, 2u) << "the second material's";
    const auto channel = [&](std::uint32_t i) { return static_cast<float>(list.splats[triangle].look >> (8 * i) & 0xffu) / 255.0f; };
    for (const auto& [i, albedo] : {std::pair{0u, 0.25f}, std::pair{1u, 0.5f}, std::pair{2u, 0.125f}})
      EXPECT_NEAR(kMaxSplatAlbedo * channel(i) * channel(i) / albedo, 1.0f, 0.35f) << "but for the leaf's own variation";
  }
  EXPECT_EQ(block_of(MeshKind::leaves, two_triangles(0.6f, 0.9f), looks).list.leaf_count, 0u) << "nothing but hole";
  EXPECT_EQ(block_of(MeshKind::leaves, two_triangles(0.1f, 0.9f), looks).list.leaf_count, 0u) << "the texture makes the outline";
}

/// A right-angled triangle in the plane of z, of the second material; `u` of all its corners.
void add_triangle(MadeMesh& mesh, const vec3& at, float width, float height, float u, std::uint32_t stalk) {
  for (const vec3& corner : {at, at + vec3(width, 0, 0), at + vec3(0, height, 0)}) {
    mesh.indices.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    mesh.vertices.push_back({{corner.x, corner.y, corner.z}, {0, 0, 1}, {u, 0.5f}, 1, {static_cast<std::uint16_t>(stalk), 0, 0}});
  }
}

/// Shadows of other plants are a cluster's: they would cut a leaf in two.
TEST(Clusters, TrianglesOfALeafAreOfOneCluster) {
  const PlantLooks looks = half_a_texture();
  for (const std::uint32_t triangles : {2u, 12u, 33u, 64u, 100u, 200u}) {
    // Leaf `i` at x = i, its triangles of different sizes and anywhere in the file.
    constexpr std::uint32_t kStalks = 50;
    MadeMesh mesh;
    for (std::uint32_t triangle = 0; triangle < triangles; ++triangle)
      for (std::uint32_t leaf = 0; leaf < kStalks; ++leaf) {
        const auto x = static_cast<float>(leaf), size = 0.05f + 0.5f * static_cast<float>(triangle % 7);
        add_triangle(mesh, {x, 0, 0}, 0.3f, size, 0.1f, 300 * leaf);
      }
    const MeshBlock built = block_of(MeshKind::leaves, mesh, looks);
    std::uint32_t split = 0;
    std::size_t leaf_count = 0;
    for (const auto& [cluster, leaves, splats] : parts_of(built)) {
      EXPECT_LE(leaves.size(), kClusterLeaves);
      leaf_count += leaves.size();
      std::map<int, std::uint32_t> members;
      for (const Leaf& leaf : leaves) ++members[static_cast<int>(corner_m(box_of(built.list), leaf, 0).x + 0.1f)];
      for (const auto& [leaf, count] : members) split += count != triangles;
    }
    EXPECT_EQ(leaf_count, std::size_t{kStalks} * triangles);
    EXPECT_EQ(split, triangles <= kClusterLeaves ? 0u : 2 * kStalks) << triangles;
  }
}

/// Whoever draws a mesh in parts draws runs of its clusters.
TEST(Clusters, TrianglesOfAMeshFollowOneAnotherAsItsClustersDo) {
  const PlantLooks looks = half_a_texture();
  std::mt19937 random(4);
  const auto number = [&] { return static_cast<float>(random() % 1000) * 0.01f; };
  MadeMesh mesh;
  for (std::uint32_t triangle = 0; triangle < 1000; ++triangle) {
    const float x = number(), y = number(), z = number(), size = 0.01f + 0.01f * number(), u = triangle % 3 == 0 ? 0.9f : 0.1f;
    add_triangle(mesh, {x, y, z}, size, size, u, triangle);
  }
  for (const MeshKind kind : {MeshKind::wood, MeshKind::leaves})
    for (const bool leaves : {true, false}) {
      const MeshBlock block = block_of(kind, mesh, looks, leaves);
      EXPECT_LT(block.list.cluster_count, block.list.range_count) << "a third is nothing but hole";
      EXPECT_TRUE(leaves || block.list.cluster_count == 0);
      std::vector<std::uint32_t> indices(block.index_count);
      std::memcpy(indices.data(), block.bytes.data(), indices.size() * sizeof indices[0]);
      std::uint32_t next = 0;
      for (std::uint32_t i = 0; i < block.list.range_count; ++i) {
        const auto cluster = read<Cluster>(block.bytes.span(), cluster_at(block, i));
        EXPECT_EQ(cluster.last_death, next);
        next += cluster.counts & 0xffu;
        for (std::uint32_t index = 3 * cluster.last_death; index < 3 * next; ++index)
          EXPECT_LE(distance(vec3(mesh.vertices[indices[index]].position), cluster.center), cluster.radius_m + 1e-3f);
      }
      EXPECT_EQ(3 * next, block.index_count);
      std::ranges::sort(indices);
      EXPECT_EQ(indices, mesh.indices) << "each once";
    }
}

TEST(Clusters, AMeshIsWholeInItsBlock) {
  const PlantLooks looks = half_a_texture();
  const MadeMesh mesh = two_triangles(0.1f, 0.9f);
  for (const MeshKind kind : {MeshKind::wood, MeshKind::leaves})
    for (const bool clusters : {true, false}) {
      constexpr std::uint64_t kBase = 0x1fffffff0ull;
      MeshBlock block = block_of(kind, mesh, looks, clusters);
      EXPECT_LE(block.bytes.size(), max_mesh_bytes(kind, 4, 2, clusters));
      EXPECT_EQ(block.index_count, 6u);
      EXPECT_EQ(block.materials.count(), 1u);
      EXPECT_TRUE(block.materials[1]);
      EXPECT_EQ(block.high.x, 1.0f);
      EXPECT_EQ(block.high.y, 2.0f);
      std::set<std::array<std::uint32_t, 3>> triangles;
      for (std::size_t i = 0; i < 2; ++i) triangles.insert(read<std::array<std::uint32_t, 3>>(block.bytes.span(), 12 * i));
      EXPECT_EQ(triangles, (std::set<std::array<std::uint32_t, 3>>{{mesh.indices[0], mesh.indices[1], mesh.indices[2]},
                                                                   {mesh.indices[3], mesh.indices[4], mesh.indices[5]}}));
      EXPECT_EQ(read<WoodVertex>(block.bytes.span(), block.vertices_at).position.y, 0.0f);
      EXPECT_EQ(block.list.cluster_count, clusters && kind == MeshKind::wood ? 1u : 0u);
      const std::uint64_t list = address_of(block.list.blocks);
      block.move(kBase);
      if (block.list.cluster_count == 0) continue;
      EXPECT_EQ(address_of(block.list.blocks), list + kBase);
      const std::uint64_t cluster = address_of(read<uvec2>(block.bytes.span(), list)) - kBase;
      EXPECT_EQ(address_of(read<Cluster>(block.bytes.span(), cluster).leaves), cluster + sizeof(Cluster) + kBase);
    }
}

TEST(Clusters, WithoutMemoryThereIsNoMesh) {
  const PlantLooks looks = half_a_texture();
  for (std::size_t most = 0; most < 2; ++most) {
    test::FakeAllocator allocator{.fail_at = most, .fail_for_good = true};
    const auto block = build_mesh(MeshKind::wood, two_triangles(0.1f, 0.4f), {{looks, CrownLight{}}, Crown::box()}, allocator.hook());
    EXPECT_EQ(block.error().status, Status::out_of_memory) << most;
    EXPECT_EQ(allocator.live_count, 0u) << most;
  }
}

TEST(Clusters, TheLadderRisesAndItsRungsHoldWhatIsAskedFor) {
  for (std::uint32_t leaves = 1; leaves <= kReadyLeaves; ++leaves) {
    const std::uint32_t rung = lod::coppice_ladder_rung(leaves);
    EXPECT_LT(rung, kReadyCuts);
    EXPECT_GE(lod::coppice_ladder_leaf_count(rung), leaves);
    EXPECT_LE(lod::coppice_ladder_leaf_count(rung), 1 + leaves * 9 / 8);
    EXPECT_LE(lod::coppice_ladder_leaf_count(rung), lod::coppice_ladder_leaf_count(rung + 1));
  }
  EXPECT_EQ(lod::coppice_ladder_rung(1), 0u);
  EXPECT_EQ(lod::coppice_ladder_rung(kReadyLeaves), kReadyCuts - 1);
}

}  // namespace coppice::gpu::clusters_test
