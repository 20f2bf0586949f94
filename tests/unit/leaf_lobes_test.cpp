#include <array>
#include <cstddef>
#include <ostream>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "find_leaves.h"
#include "leaf_quads.h"
#include "lobed_plants.h"
#include "results.h"

namespace coppice::bake {

namespace test {
void PrintTo(const LobedPlant& plant, std::ostream* out) {
  *out << plant.name;
}
}  // namespace test

namespace leaf_lobes_test {

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

TEST(LeafLobes, AQuadStandsForAllLobes) {
  const test::LobedPlant of{.name = "", .sides = test::LobeSides::both, .twigs = test::TwigForm::strips, .twigs_bear = true};
  const test::GrownPlant grown = test::grow(of);
  FoundParts found = find_leaves(grown.soup, grown.materials, {}, std::vector<std::vector<MaterialRule>>(grown.materials.size()));
  for (const LeafRange& leaf : found.leaves) ASSERT_EQ(leaf.triangle_count, 18u);
  EXPECT_EQ(found.wood.triangle_materials.size(), 150u * 40u + 16u);
  Plant plant;
  plant.materials = grown.materials;
  plant.foliage = std::move(found.foliage);
  plant.leaves = std::move(found.leaves);
  plant.wood = std::move(found.wood);
  const auto fitted = coppice::test::must(fit_leaves(plant));
  ASSERT_EQ(fitted.size(), 900u);
  for (std::size_t i = 0; i < fitted.size(); ++i) {
    const Quad& quad = fitted[i].quad;
    double leaf_m2 = 0.0;
    for (std::size_t t = plant.leaves[i].first_triangle; t < plant.leaves[i].first_triangle + 18; ++t) {
      std::array<glm::dvec3, 3> at;
      for (std::size_t k = 0; k < 3; ++k) at[k] = plant.foliage.positions[plant.foliage.indices[3 * t + k]];
      leaf_m2 += 0.25 * glm::length(glm::cross(at[1] - at[0], at[2] - at[0]));  // half of it is the back
    }
    const double quad_m2 = static_cast<double>(glm::distance(quad[0], quad[1]) * glm::distance(quad[1], quad[2]));
    // A rectangle about a leaf of three lobes, not about one of them, which alone have twice their area at most.
    ASSERT_GT(quad_m2, 2.0 * leaf_m2) << i;
    ASSERT_LT(quad_m2, 6.0 * leaf_m2) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(LeafLobes, LobedPlantTest, testing::ValuesIn(test::lobed_plants()),
                         [](const testing::TestParamInfo<test::LobedPlant>& plant) { return plant.param.name; });

}  // namespace leaf_lobes_test
}  // namespace coppice::bake
