#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "find_leaves.h"
#include "lobed_plants.h"

namespace coppice::bake {

namespace test {
void PrintTo(const LobedPlant& plant, std::ostream* out) {
  *out << plant.name;
}
}  // namespace test

namespace {

class LobedPlantTest : public testing::TestWithParam<test::LobedPlant> {};

TEST_P(LobedPlantTest, HasItsLeaves) {
  const test::LobedPlant& plant = GetParam();
  const test::GrownPlant grown = test::grow(plant);
  const FoundParts found = find_leaves(grown.soup, grown.materials, {}, std::vector<std::vector<MaterialRule>>(grown.materials.size()));
  EXPECT_NEAR(static_cast<double>(found.leaves.size()), plant.true_leaf_count(), 0.01 * plant.true_leaf_count());
  if (HasFailure())
    for (const PieceClass& each : found.classes)
      if (each.part == PlantPart::leaf)
        ADD_FAILURE() << each.piece_count << " of " << each.triangle_count << " triangles, " << each.length_m << " m: " << each.reason;
}

INSTANTIATE_TEST_SUITE_P(LeafLobes, LobedPlantTest, testing::ValuesIn(test::lobed_plants()),
                         [](const testing::TestParamInfo<test::LobedPlant>& plant) { return plant.param.name; });

}  // namespace
}  // namespace coppice::bake
