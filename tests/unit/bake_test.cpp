// The whole baker: generated and third-party plants in, a verified file out.

#include "bake.h"

#include <filesystem>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "alpha_mask.h"
#include "collapse_geometric.h"
#include "collapse_information.h"
#include "coppice/format.h"
#include "generate_plant.h"
#include "gltf_write.h"
#include "inspect.h"
#include "leaf_cards.h"
#include "naive_collapse.h"
#include "plants_folder.h"
#include "process.h"
#include "results.h"
#include "test_foliage.h"
#include "tree_order.h"
#include "unpack.h"

namespace coppice::bake::bake_test {

/// A small image keeps the test short; determinism does not depend on it.
BakeOptions quick_options(std::uint32_t thread_count) {
  BakeOptions options;
  options.collapse.resolution_px = 64;
  options.thread_count = thread_count;
  return options;
}

class BakeCorylus : public testing::Test {
 protected:
  void SetUp() override {
    const auto plant = test::must(generate_plant("corylus", 1));
    const auto written = write_glb(glb_, {{"leaves", &plant.foliage}, {"wood", &plant.wood}}, plant.materials, plant.images);
    ASSERT_TRUE(written) << written.error().message();
  }

  /// The plant's file; report_ describes it. Throws std::runtime_error where it cannot be baked.
  std::vector<std::uint8_t> baked(
      const BakeOptions& options, const StageProgress& progress = [](const char*, double) {}) {
    report_ = {};
    return test::must(bake(glb_, options, progress, report_));
  }

  test::TemporaryFolder folder_;
  std::filesystem::path glb_ = folder_.path() / "corylus.glb";
  BakeReport report_;
};

TEST_F(BakeCorylus, SameBytesForAnyNumberOfThreads) {
  std::vector<std::vector<std::uint8_t>> files;
  for (const std::uint32_t threads : {1u, 2u, 8u}) files.push_back(baked(quick_options(threads)));
  EXPECT_EQ(files[0], files[1]);
  EXPECT_EQ(files[0], files[2]);
}

TEST_F(BakeCorylus, FileHoldsThePlantAndTheReportDescribesIt) {
  const auto bytes = baked(quick_options(2));
  const auto verified = verify(bytes);
  ASSERT_TRUE(verified) << verified.error().message();
  const auto plant = test::must(unpack(bytes));
  EXPECT_EQ(plant.tree.leaf_count(), 386u);
  EXPECT_FALSE(plant.wood.lods.empty());

  EXPECT_EQ(report_.source_leaves, 386u);
  EXPECT_EQ(report_.sizes.file_bytes, bytes.size());
  EXPECT_GT(report_.sizes.foliage_bytes, 0u);
  EXPECT_LT(report_.sizes.foliage_bytes, bytes.size());
  EXPECT_GE(report_.evaluations, 385u);
  ASSERT_EQ(report_.level_information.size(), 7u);
  EXPECT_EQ(report_.level_information[0].leaf_count, 308u) << "floor(0.8 N), as the paper's Table II has it";
  EXPECT_GT(report_.source_information.bits, 0.0);
}

TEST_F(BakeCorylus, AllWoodIsAPlantToo) {
  BakeOptions options = quick_options(2);
  options.import.wood_material = ".";
  const auto bytes = baked(options);
  EXPECT_EQ(report_.source_leaves, 0u);
  const auto verified = verify(bytes);
  ASSERT_TRUE(verified) << verified.error().message();
  const auto plant = test::must(unpack(bytes));
  ASSERT_FALSE(plant.wood.lods.empty());
  EXPECT_EQ(plant.wood.lods[0].triangle_materials.size(), 12352u + 10358u);
  // One leaf that nobody sees stands in for them.
  ASSERT_EQ(plant.tree.vertices.size(), 4u);
  for (const glm::vec3& vertex : plant.tree.vertices) EXPECT_EQ(vertex, plant.tree.vertices[0]);
  for (const float error_px : plant.errors.error_px) EXPECT_EQ(error_px, 0.0f);
  EXPECT_EQ(test::must(inspect(bytes)).leaf_count, 0u);
}

TEST_F(BakeCorylus, InformationOfTheSourceEqualsABruteForceRecount) {
  BakeOptions options;
  options.metric = Metric::mi;
  for (const bool background : {true, false}) {
    options.collapse.count_background = background;
    baked(options);
    auto plant = test::must(import_gltf(glb_, {}));
    const auto foliage = test::must(card_foliage(plant));
    const test::NaiveScene scene{foliage, *alpha_masks(plant.materials, plant.images), *viewpoints(20), options.collapse};
    const test::NaiveAreas areas = test::render_areas(scene, test::source_plant(scene));
    EXPECT_NEAR(report_.source_information.bits, test::information_by_definition(scene, areas), 1e-9) << "background " << background;
  }
}

/// `count` squares of `side_m`, as far apart as a box of 4 m allows.
Foliage squares(std::uint32_t count, float side_m) {
  std::vector<Quad> quads;
  for (std::uint32_t i = 0; i < count; ++i)
    quads.push_back(test::rectangle({i % 5, i / 5 % 5, i / 25 % 5}, {side_m, 0, 0}, {0, side_m, 0}));
  return test::plain_foliage(std::move(quads));
}

TEST(BoundedResolution, IsLessOnlyWhereLeavesOverlapDeeply) {
  EXPECT_EQ(metric_resolution_px(Metric::default_metric, squares(5000, 0.2f), 256), 256u);
  EXPECT_EQ(metric_resolution_px(Metric::default_metric, squares(300, 0.5f), 256), 256u);
  const std::uint32_t deep = metric_resolution_px(Metric::default_metric, squares(300, 3.0f), 256);
  EXPECT_LT(deep, 200u);
  EXPECT_GT(deep, 96u);
  EXPECT_EQ(metric_resolution_px(Metric::default_metric, squares(300, 3.0f), 512) / 2, deep);
  EXPECT_EQ(metric_resolution_px(Metric::default_metric, squares(30000, 4.0f), 256), 96u) << "not less than 3/8";
  EXPECT_EQ(metric_resolution_px(Metric::default_metric, squares(1, 0.0f), 256), 256u);
  // It is the default metric's alone.
  EXPECT_EQ(metric_resolution_px(Metric::mi, squares(300, 3.0f), 256), 256u);
  EXPECT_EQ(metric_resolution_px(Metric::geometric, squares(300, 3.0f), 256), 256u);
}

TEST(BoundedResolution, LeavesRealPlantsAlone) {
  for (const char* name : {"scopia_bonsai.glb", "eztree_oak_medium.glb", "eztree_oak_large_x16.glb", "scopia_bush.glb", "coffee.glb"}) {
    COPPICE_PLANT_OR_SKIP(path, name);
    auto plant = test::must(import_gltf(path, {}));
    const auto foliage = test::must(card_foliage(plant));
    EXPECT_EQ(metric_resolution_px(Metric::default_metric, foliage, 256), 256u) << name;
  }
}

TEST_F(BakeCorylus, MetricsOrderDifferentlyAndTheFileNamesThem) {
  std::vector<BakedPlant> plants;
  for (const Metric metric : {Metric::default_metric, Metric::mi, Metric::geometric}) {
    BakeOptions options = quick_options(2);
    options.metric = metric;
    plants.push_back(test::must(unpack(baked(options))));
  }
  EXPECT_EQ(plants[0].metric, std::uint32_t{COPPICE_METRIC_IMAGE});
  EXPECT_EQ(plants[1].metric, std::uint32_t{COPPICE_METRIC_MI});
  EXPECT_EQ(plants[2].metric, std::uint32_t{COPPICE_METRIC_GEOMETRIC});
  EXPECT_NE(plants[0].tree.split_parent, plants[1].tree.split_parent);
  EXPECT_NE(plants[1].tree.split_parent, plants[2].tree.split_parent);
}

TEST_F(BakeCorylus, AReplayedSequenceHasTheInformationOfTheCollapseThatFoundIt) {
  auto plant = test::must(import_gltf(glb_, {}));
  const auto foliage = test::must(card_foliage(plant));
  const std::vector<Viewpoint> views = *viewpoints(20);
  CollapseOptions options = quick_options(0).collapse;
  for (const bool background : {true, false}) {
    options.count_background = background;
    const auto found = test::must(collapse_by_mutual_information({foliage, plant.materials, plant.images}, views, options, {}));
    const auto replayed = test::must(replay({foliage, plant.materials, plant.images}, views, options, found.sequence));
    EXPECT_EQ(replayed.source.bits, found.source.bits);
    ASSERT_EQ(replayed.levels.size(), found.levels.size());
    for (std::size_t i = 0; i < found.levels.size(); ++i) {
      EXPECT_EQ(replayed.levels[i].leaf_count, found.levels[i].leaf_count);
      EXPECT_EQ(replayed.levels[i].bits, found.levels[i].bits);
    }
  }
}

TEST_F(BakeCorylus, ProgressNeverFallsWithinAStage) {
  std::string stage;
  double last = 0.0;
  int calls = 0;
  baked(quick_options(2), [&](const char* name, double fraction) {
    if (stage != name) stage = name, last = 0.0;
    EXPECT_GE(fraction, last) << name;
    EXPECT_LE(fraction, 1.0) << name;
    last = fraction;
    ++calls;
  });
  EXPECT_GT(calls, 20);
}

class BakeRealPlant : public testing::TestWithParam<std::pair<std::string, std::uint32_t>> {};

TEST_P(BakeRealPlant, BakesAndVerifies) {
  const auto& [name, leaf_count] = GetParam();
  COPPICE_PLANT_OR_SKIP(path, name + ".glb");
  BakeReport report;
  const auto bytes = test::must(bake(
      path, quick_options(0), [](const char*, double) {}, report));
  EXPECT_EQ(report.source_leaves, leaf_count);
  const auto verified = verify(bytes);
  EXPECT_TRUE(verified) << verified.error().message();
}

INSTANTIATE_TEST_SUITE_P(Plants, BakeRealPlant, testing::Values(std::pair("scopia_poplar", 5100), std::pair("eztree_oak_medium", 5320)),
                         [](const auto& plant) { return plant.param.first; });

}  // namespace coppice::bake::bake_test
