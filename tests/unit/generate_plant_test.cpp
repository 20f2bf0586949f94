#include "generate_plant.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <ostream>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "gltf_write.h"
#include "results.h"
#include "union_find.h"

namespace coppice::bake::generate_plant_test {

struct Expected {
  std::string_view species;
  std::uint32_t leaf_count;
  std::uint32_t min_leaf_triangles;
  std::uint32_t max_wood_triangles;
  float min_height_m, max_height_m;
};

void PrintTo(const Expected& expected, std::ostream* out) {
  *out << expected.species;
}

constexpr Expected kExpected[] = {
    {"corylus", 386, 12, 12000, 2.7f, 4.6f},
    {"willow", 4456, 6, 40000, 6.5f, 10.0f},
    {"juniper", 13162, 2, 30000, 2.9f, 4.6f},
};

using Cell = std::array<int, 3>;

Cell cell_of(const glm::vec3& point, float size) {
  const glm::vec3 cell = glm::floor(point / size);
  return {static_cast<int>(cell.x), static_cast<int>(cell.y), static_cast<int>(cell.z)};
}

template <class Function>
void for_each_neighbour(const Cell& cell, Function function) {
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) function(Cell{cell[0] + x, cell[1] + y, cell[2] + z});
}

/// Triangle counts of the connected components of a mesh whose vertices nearer than `weld_m` are one: what an importer sees as leaves.
std::vector<std::uint32_t> component_triangle_counts(const Mesh& mesh, float weld_m) {
  UnionFind components(mesh.positions.size());
  std::map<Cell, std::vector<std::uint32_t>> grid;
  for (std::uint32_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
    const Cell cell = cell_of(mesh.positions[vertex], weld_m);
    for_each_neighbour(cell, [&](const Cell& near) {
      const auto found = grid.find(near);
      if (found == grid.end()) return;
      for (const std::uint32_t other : found->second)
        if (glm::distance(mesh.positions[vertex], mesh.positions[other]) <= weld_m) components.join(vertex, other);
    });
    grid[cell].push_back(vertex);
  }
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) components.join(mesh.indices[i], mesh.indices[i / 3 * 3]);
  std::map<std::uint32_t, std::uint32_t> counts;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) ++counts[components.find(mesh.indices[i])];
  std::vector<std::uint32_t> out;
  for (const auto& [first, count] : counts) out.push_back(count);
  return out;
}

/// Cells of `size` metres that a mesh's surface passes through.
std::set<Cell> surface_cells(const Mesh& mesh, float size) {
  std::set<Cell> cells;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto [a, b, c] = at_corners(mesh.positions, mesh.indices, i);
    const float longest = std::max({glm::distance(a, b), glm::distance(a, c), glm::distance(b, c)});
    const int steps = 1 + static_cast<int>(2.0f * longest / size);
    const auto share = [&](int step) { return static_cast<float>(step) / static_cast<float>(steps); };
    for (int u = 0; u <= steps; ++u)
      for (int v = 0; u + v <= steps; ++v) cells.insert(cell_of(a + share(u) * (b - a) + share(v) * (c - a), size));
  }
  return cells;
}

/// Those of `cells` that can be reached from the ground through neighbouring ones.
std::set<Cell> rooted_cells(const std::set<Cell>& cells) {
  std::set<Cell> rooted;
  std::vector<Cell> open;
  const auto reach = [&](const Cell& cell) {
    if (cells.contains(cell) && rooted.insert(cell).second) open.push_back(cell);
  };
  for (const Cell& cell : cells)
    if (cell[1] <= 0) reach(cell);
  while (!open.empty()) {
    const Cell cell = open.back();
    open.pop_back();
    for_each_neighbour(cell, reach);
  }
  return rooted;
}

void expect_sound(const Mesh& mesh) {
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
  ASSERT_EQ(mesh.indices.size(), 3 * mesh.triangle_materials.size());
  for (const glm::vec3& normal : mesh.normals) ASSERT_NEAR(glm::length(normal), 1.0f, 1e-4f);
  for (const glm::vec2& uv : mesh.uvs) ASSERT_TRUE(std::isfinite(uv.x) && std::isfinite(uv.y));
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto [a, b, c] = at_corners(mesh.positions, mesh.indices, i);
    const auto normals = at_corners(mesh.normals, mesh.indices, i);
    const glm::vec3 area = glm::cross(b - a, c - a);
    ASSERT_GT(glm::length(area), 1e-8f) << "degenerate triangle " << i / 3;
    ASSERT_GT(glm::dot(area, normals[0] + normals[1] + normals[2]), 0.0f) << "triangle " << i / 3 << " faces its normals' back";
  }
}

std::vector<std::uint8_t> glb_of(const Plant& plant) {
  return test::must(encode_glb({{"leaves", &plant.foliage}, {"wood", &plant.wood}}, plant.materials, plant.images));
}

class GeneratePlant : public testing::TestWithParam<std::tuple<Expected, std::uint64_t>> {
 protected:
  void SetUp() override { plant_ = test::must(generate_plant(expected_.species, std::get<1>(GetParam()))); }
  Expected expected_ = std::get<0>(GetParam());
  Plant plant_;
};

TEST_P(GeneratePlant, HasExactlyThePapersLeafCount) {
  ASSERT_EQ(plant_.leaves.size(), expected_.leaf_count);
  std::uint32_t next = 0;
  for (const LeafRange& leaf : plant_.leaves) {
    ASSERT_EQ(leaf.first_triangle, next);
    ASSERT_GE(leaf.triangle_count, expected_.min_leaf_triangles);
    next += leaf.triangle_count;
  }
  EXPECT_EQ(next, plant_.foliage.triangle_materials.size());
}

TEST_P(GeneratePlant, EveryLeafIsOneComponentHoweverCloselyPositionsAreWelded) {
  const float diagonal_m = glm::length(box_of(plant_.foliage.positions).extent());
  for (const float weld : {1e-7f, 1e-5f}) {
    const auto counts = component_triangle_counts(plant_.foliage, weld * diagonal_m);
    EXPECT_EQ(counts.size(), expected_.leaf_count) << "welded at " << weld << " of the box";
    const auto [fewest, most] = std::ranges::minmax(counts);
    EXPECT_GE(fewest, expected_.min_leaf_triangles);
    EXPECT_EQ(fewest, most);
  }
}

TEST_P(GeneratePlant, MeshesAreSound) {
  expect_sound(plant_.foliage);
  expect_sound(plant_.wood);
  for (const glm::vec2& uv : plant_.foliage.uvs) ASSERT_TRUE(uv.x >= 0.0f && uv.x <= 1.0f && uv.y >= 0.0f && uv.y <= 1.0f);
  EXPECT_LE(plant_.wood.triangle_materials.size(), expected_.max_wood_triangles);
  ASSERT_EQ(plant_.materials.size(), 2u);
  const glm::vec4 &green = plant_.materials[0].base_color, &brown = plant_.materials[1].base_color;
  EXPECT_TRUE(green.g > green.r && green.g > green.b);
  EXPECT_TRUE(brown.r > brown.g && brown.g > brown.b);
}

TEST_P(GeneratePlant, WoodGrowsFromTheGroundInOnePiece) {
  const float foot_m = box_of(plant_.wood.positions).low.y;
  EXPECT_TRUE(foot_m <= 0.0f && foot_m > -0.2f) << foot_m;
  const std::set<Cell> cells = surface_cells(plant_.wood, 0.04f);
  EXPECT_EQ(rooted_cells(cells).size(), cells.size());
}

TEST_P(GeneratePlant, LeavesHangOnWoodInsideTheCrown) {
  const auto box = box_of(plant_.foliage.positions);
  EXPECT_GE(box.low.y, 0.0f);
  EXPECT_GE(box.high.y, expected_.min_height_m);
  EXPECT_LE(box.high.y, expected_.max_height_m);
  const std::set<Cell> wood = surface_cells(plant_.wood, 0.02f);
  const auto touches_wood = [&](std::uint32_t vertex) {
    bool touches = false;
    for_each_neighbour(cell_of(plant_.foliage.positions[vertex], 0.02f), [&](const Cell& near) { touches |= wood.contains(near); });
    return touches;
  };
  for (const LeafRange& leaf : plant_.leaves)
    EXPECT_TRUE(std::ranges::any_of(leaf_indices(plant_.foliage, leaf), touches_wood)) << "triangle " << leaf.first_triangle;
}

// A crown is full from every side: no eighth of the circle round its middle holds less than a third of its share of leaf area.
TEST_P(GeneratePlant, CrownIsFullFromEverySide) {
  const auto box = box_of(plant_.foliage.positions);
  const glm::vec3 middle = 0.5f * (box.low + box.high);
  std::array<double, 8> area{};
  for (std::size_t i = 0; i < plant_.foliage.indices.size(); i += 3) {
    const auto [a, b, c] = at_corners(plant_.foliage.positions, plant_.foliage.indices, i);
    const float turn = std::atan2(a.z - middle.z, a.x - middle.x) / 3.14159265f * 4.0f + 4.0f;
    area[std::min<std::size_t>(static_cast<std::size_t>(turn), 7)] += static_cast<double>(glm::length(glm::cross(b - a, c - a)));
  }
  const double total = std::accumulate(area.begin(), area.end(), 0.0);
  for (const double part : area) EXPECT_GT(part, total / 8.0 * 0.35);
}

// The image is the leaf's outline: every triangle of the leaf shows, and the corners of a quad that holds the leaf do not.
TEST_P(GeneratePlant, LeafPictureHasTheLeafsOutline) {
  const Material& material = plant_.materials.at(0);
  if (expected_.min_leaf_triangles == 2) {
    EXPECT_EQ(material.image, kNone) << "a leaf of two triangles is its own quad";
    return;
  }
  ASSERT_EQ(material.image, 0u);
  ASSERT_GT(material.alpha_cutoff, 0.0f);
  const Image& image = plant_.images.at(0);
  const auto shows = [&](const glm::vec2& uv) {
    const auto texel = [](float at, std::uint32_t size) {
      return std::min(static_cast<std::uint32_t>(at * static_cast<float>(size)), size - 1);
    };
    const std::size_t i = std::size_t{texel(uv.y, image.height)} * image.width + texel(uv.x, image.width);
    return static_cast<float>(image.rgba.at(4 * i + 3)) >= 255.0f * material.alpha_cutoff;
  };
  for (std::uint32_t i = 0; i < 3 * plant_.leaves.front().triangle_count; i += 3) {
    const auto [a, b, c] = at_corners(plant_.foliage.uvs, plant_.foliage.indices, i);
    for (int u = 0; u <= 20; ++u)
      for (int v = 0; u + v <= 20; ++v)
        ASSERT_TRUE(shows(a + 0.05f * static_cast<float>(u) * (b - a) + 0.05f * static_cast<float>(v) * (c - a)))
            << "triangle at index " << i;
  }
  for (const glm::vec2 corner : {glm::vec2(0.02f, 0.02f), glm::vec2(0.98f, 0.02f), glm::vec2(0.02f, 0.98f), glm::vec2(0.98f, 0.98f)})
    EXPECT_FALSE(shows(corner));
}

TEST_P(GeneratePlant, SameSeedSameBytesAndAnotherSeedAnotherPlant) {
  const auto [expected, seed] = GetParam();
  const auto again = generate_plant(expected.species, seed), other = generate_plant(expected.species, seed + 1);
  ASSERT_TRUE(again && other);
  const std::vector<std::uint8_t> bytes = glb_of(plant_);
  EXPECT_EQ(bytes, glb_of(*again));
  EXPECT_NE(bytes, glb_of(*other));
}

INSTANTIATE_TEST_SUITE_P(Species, GeneratePlant, testing::Combine(testing::ValuesIn(kExpected), testing::Values(1u, 0xfedcba9876543210u)),
                         [](const auto& parameter) {
                           return std::string(std::get<0>(parameter.param).species) + "_" + std::to_string(std::get<1>(parameter.param));
                         });

TEST(GeneratePlantCounts, HoldForManySeeds) {
  for (const Expected& expected : kExpected)
    for (std::uint64_t seed = 100; seed < 108; ++seed) {
      const auto plant = test::must(generate_plant(expected.species, seed));
      ASSERT_EQ(plant.leaves.size(), expected.leaf_count) << expected.species << " seed " << seed;
      ASSERT_LE(plant.wood.triangle_materials.size(), expected.max_wood_triangles) << expected.species << " seed " << seed;
    }
}

TEST(GeneratePlantErrors, UnknownSpeciesIsNamedAndTheKnownOnesListed) {
  test::expect_error(generate_plant("oak", 1), Status::invalid_argument, {"oak", "corylus", "willow", "juniper"});
}

}  // namespace coppice::bake::generate_plant_test
