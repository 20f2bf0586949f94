#include "odd_plants.h"

#include <algorithm>
#include <set>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "bake.h"
#include "gltf_builder.h"
#include "import_gltf.h"
#include "inspect.h"
#include "mentions.h"
#include "process.h"
#include "results.h"
#include "unpack.h"

namespace coppice::bake::odd_plants_test {

/// Counts triangles with the same corners once.
std::size_t different_triangles(const Mesh& mesh) {
  std::set<std::multiset<std::tuple<float, float, float>>> different;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    std::multiset<std::tuple<float, float, float>> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec3& corner = mesh.positions[mesh.indices[i + k]];
      corners.emplace(corner.x, corner.y, corner.z);
    }
    different.insert(std::move(corners));
  }
  return different.size();
}

class OddPlants : public testing::TestWithParam<test::OddPlant> {};

TEST_P(OddPlants, LeavesAreCountedAndNothingIsLost) {
  const test::OddPlant& plant = GetParam();
  const auto imported = coppice::test::must(import_gltf_bytes(test::encode(plant), plant.name + ".glb", {}));
  EXPECT_EQ(imported.leaves.size(), plant.leaf_count);
  EXPECT_EQ(imported.foliage.triangle_materials.size() + imported.wood.triangle_materials.size(), different_triangles(plant.soup.mesh));
  EXPECT_EQ(imported.warnings.size(), plant.leaf_count == 0 ? 1u : 0u) << testing::PrintToString(imported.warnings);
  for (const std::string& warning : imported.warnings) EXPECT_TRUE(coppice::test::mentions(warning, {"--leaf-material"}));
}

TEST_P(OddPlants, Bakes) {
  const test::OddPlant& plant = GetParam();
  const coppice::test::TemporaryFolder folder;
  BakeOptions options;
  options.collapse.resolution_px = 64;
  options.view_count = 6;
  BakeReport report;
  const auto bytes = coppice::test::must(bake(
      coppice::test::write_file(folder.path() / (plant.name + ".glb"), test::encode(plant)), options, [](const char*, double) {}, report));
  EXPECT_EQ(report.source_leaves, plant.leaf_count);
  const auto verified = verify(bytes);
  EXPECT_TRUE(verified) << verified.error().message();
  const auto baked = coppice::test::must(unpack(bytes));
  EXPECT_EQ(baked.tree.leaf_count(), std::max(plant.leaf_count, 1u));
}

INSTANTIATE_TEST_SUITE_P(All, OddPlants, testing::ValuesIn(test::odd_plants()), [](const auto& each) { return each.param.name; });

}  // namespace coppice::bake::odd_plants_test
