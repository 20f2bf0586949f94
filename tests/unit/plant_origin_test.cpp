// Where a plant's origin is: plants that stand elsewhere in their files, and plants that only reach away from their foot.
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "bounds.h"
#include "imported.h"
#include "pack_gltf.h"

namespace coppice::test::plant_origin_test {

using bake::ImportOptions;
using bake::Origin;
using bake::Plant;

bake::PointBox<glm::vec3> extent_of(const Plant& plant) {
  bake::PointBox<glm::vec3> extent;
  for (const bake::Mesh* mesh : {&plant.wood, &plant.foliage})
    for (const glm::vec3& position : mesh->positions) extent.add(position);
  return extent;
}

/// A tree 5 m high, at its foot.
Plant tree_at(const std::array<double, 3>& at, Origin origin = Origin::automatic) {
  Pack pack;
  pack.part("trunk", trunk_part(5));
  pack.part("leaves", crown_part(200, 5, 1));
  for (auto& node : pack.file.json["nodes"]) node["translation"] = at;
  ImportOptions options;
  options.origin = origin;
  return imported(pack.file, options);
}

TEST(PlantOrigin, IsTheFilesWhereThatIsInThePlantOrNear) {
  const Plant plain = tree_at({0, 0, 0});
  EXPECT_TRUE(plain.warnings.empty());
  for (const std::array<double, 3>& at : {std::array{0.25, 0.0, 0.5}, {1.5, 0.0, 0.0}, {0.0, 2.0, 0.0}, {0.0, -8.0, 0.0}}) {
    const Plant moved = tree_at(at);
    EXPECT_TRUE(moved.warnings.empty()) << at[0] << " " << at[1];
    for (std::size_t i = 0; i < plain.wood.positions.size(); ++i)
      expect_near(moved.wood.positions.at(i), plain.wood.positions[i] + glm::vec3(at[0], at[1], at[2]));
  }
}

TEST(PlantOrigin, IsTheFootWhereThePlantStandsElsewhere) {
  const Plant plain = tree_at({0, 0, 0});
  for (const std::array<double, 3>& at : {std::array{1000.0, 0.0, -2500.0}, {4.0, 0.0, 0.0}, {5e6, 300.0, 1e6}, {0.0, 40.0, 0.0}}) {
    const Plant moved = tree_at(at);
    ASSERT_EQ(moved.wood.positions.size(), plain.wood.positions.size());
    for (std::size_t i = 0; i < plain.wood.positions.size(); ++i) expect_near(moved.wood.positions[i], plain.wood.positions[i], 1e-4f);
    for (std::size_t i = 0; i < plain.foliage.positions.size(); ++i)
      expect_near(moved.foliage.positions.at(i), plain.foliage.positions[i], 1e-4f);
  }
  expect_warning(tree_at({1000, 0, -2500}), {"2691", "--origin keep"});
  expect_warning(tree_at({30000, 0, 40000}), {"49998"});
}

TEST(PlantOrigin, IsWhatTheCallerChooses) {
  const Plant kept = tree_at({1000, 0, -2500}, Origin::keep);
  expect_warning(kept, {"2691", "--origin foot"});
  EXPECT_NEAR(kept.wood.positions.at(0).z, -2500.0f, 1.0f);
  const auto centred = extent_of(tree_at({1000, 0, -2500}, Origin::center));
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(centred.low[axis], -centred.high[axis], 1e-4f);
  const Plant standing = tree_at({0.5, 1.0, 0}, Origin::foot);
  EXPECT_TRUE(standing.warnings.empty());
  EXPECT_NEAR(extent_of(standing).low.y, 0.0f, 1e-5f);
  expect_near(standing.wood.positions.at(0), tree_at({0, 0, 0}).wood.positions.at(0));
}

/// A pack's variants stand beside each other; each is a plant at its own foot.
TEST(PlantOrigin, IsTheFootOfEachVariant) {
  Pack pack;
  for (int i = 0; i < 3; ++i)
    pack.part("oak_" + std::to_string(i + 1), tree(100 + i, 5, static_cast<std::uint64_t>(i)), {8.0f * static_cast<float>(i), 0, 0});
  ImportOptions options;
  options.plant.variant = 3;
  const auto extent = extent_of(imported(pack.file, options));
  EXPECT_LT(extent.high.x, 2.0f);
  EXPECT_GT(extent.low.x, -2.0f);
}

}  // namespace coppice::test::plant_origin_test
