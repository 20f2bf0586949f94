#include "select.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "hook_array.h"
#include "random_tree.h"

namespace coppice::select_test {

using test::hook_array;

/// Levels 1, N / 10, N; sizes 8, 32 px; errors proportional to size. Wood of four LoDs.
struct Table {
  PlantFile file;
  HookArray<std::uint32_t> words;
  lod::CoppiceTable table{};

  explicit Table(std::uint32_t leaf_count = 100) {
    file.plant.leaf_count = leaf_count;
    file.error_leaf_counts = hook_array<std::uint32_t>({1, leaf_count / 10, leaf_count});
    file.error_sizes_px = hook_array<float>({8.0f, 32.0f});
    file.error_px = hook_array<float>({4.0f, 16.0f, 2.0f, 8.0f, 0.5f, 2.0f});
    file.plant.wood_lod_count = 4;
    file.wood_error_px = hook_array<float>({0.0f, 0.0f, 0.1f, 0.4f, 0.2f, 0.8f, 0.4f, 1.6f});
    pack();
  }
  void pack() {
    words = *pack_lod_table(file, default_allocator());
    table = lod_table(file, words);
  }
  [[nodiscard]] float leaves(float size_px, float threshold_px) const {
    return lod::coppice_leaf_count(table, column(size_px), threshold_px);
  }
  [[nodiscard]] lod::CoppiceColumn column(float size_px) const { return lod::coppice_column(table, size_px); }
};

TEST(LeafCount, IsLinearInLogLeafCountAndLogSizeAndStaysWithinTheTree) {
  const Table t;
  struct Case {
    float size_px, threshold_px, leaves;
  };
  const Case cases[] = {
      // levels and sizes of the table
      {8.0f, 4.0f, 1.0f},
      {8.0f, 2.0f, 10.0f},
      {32.0f, 8.0f, 10.0f},
      {32.0f, 2.0f, 100.0f},
      // Error 1 is two thirds of the way from 2 to 0.5: 10^(1 + 2/3). Error 3 is half way from 4 to 2: 10^0.5.
      {8.0f, 1.0f, 46.4159f},
      {8.0f, 3.0f, 3.16228f},
      // 16 px is half way from 8 to 32 in log size: errors 10, 5, 1.25.
      {16.0f, 5.0f, 10.0f},
      {16.0f, 7.5f, 3.16228f},
      // below the first size as there; at twice the last size errors are 32, 16, 4
      {1.0f, 3.0f, 3.16228f},
      {0.0f, 3.0f, 3.16228f},
      {64.0f, 16.0f, 10.0f},
      {64.0f, 24.0f, 3.16228f},
      {1e6f, 2.0f, 100.0f},
      {8.0f, 1e6f, 1.0f},
      {8.0f, 1e-6f, 100.0f},
  };
  for (const auto& [size_px, threshold_px, leaves] : cases)
    EXPECT_NEAR(t.leaves(size_px, threshold_px), leaves, 1e-5f * leaves + 6e-5f) << size_px << " px at " << threshold_px;
}

TEST(LeafCount, GrowsWithSizeAndFallsWithThreshold) {
  const bake::BakedPlant plant = test::random_plant({.leaf_count = 700, .seed = 3});
  PlantFile file;
  file.plant.leaf_count = 700;
  file.error_leaf_counts = hook_array(plant.errors.leaf_counts);
  file.error_sizes_px = hook_array(plant.errors.sizes_px);
  file.error_px = hook_array(plant.errors.error_px);
  const HookArray<std::uint32_t> words = *pack_lod_table(file, default_allocator());
  const lod::CoppiceTable table = lod_table(file, words);
  for (float threshold = 0.25f; threshold < 20.0f; threshold *= 1.3f) {
    float last = 0.0f;
    for (float size = 1.0f; size < 3000.0f; size *= 1.07f) {
      const float leaves = lod::coppice_leaf_count(table, lod::coppice_column(table, size), threshold);
      EXPECT_GE(leaves, 1.0f);
      EXPECT_LE(leaves, 700.0f);
      EXPECT_GE(leaves, last * 0.99999f) << size << " px at " << threshold;
      EXPECT_LE(lod::coppice_leaf_count(table, lod::coppice_column(table, size), threshold * 1.2f), leaves * 1.00001f);
      last = leaves;
    }
  }
}

TEST(LeafCount, KeepsTheThresholdItWasGiven) {
  const Table t;
  for (float threshold : {0.6f, 1.0f, 1.7f, 3.1f})
    for (float size : {8.0f, 11.0f, 20.0f}) {
      const float leaves = t.leaves(size, threshold);
      if (leaves >= 100.0f || leaves <= 1.0f) continue;
      EXPECT_NEAR(error_px_at(t.table, leaves, size), threshold, 1e-3f);
    }
  EXPECT_FLOAT_EQ(error_px_at(t.table, 10.0f, 8.0f), 2.0f);
  EXPECT_FLOAT_EQ(error_px_at(t.table, 1000.0f, 8.0f), 0.5f);
}

/// The same with leaf meshes: quads err by 1 px at 8 px and 2 px at 32 px.
struct TableWithMeshes : Table {
  TableWithMeshes() {
    file.leaf_mesh_error_px = hook_array<float>({1.0f, 2.0f});
    pack();
    plant = {.table = table, .resident_leaf_count = 100, .resident_wood_mask = 0b1111, .leaf_meshes_resident = true};
  }
  /// At a threshold of 4 px.
  [[nodiscard]] InstanceLod lod_at(float size_px) const {
    return select_lod({.center_m = {0.0f, 0.0f, 1000.0f / size_px}, .radius_m = 1.0f, .plant = 0}, 0, plant, view);
  }

  LodPlant plant;
  LodView view{.focal_px = 500.0f, .error_px = 4.0f};
};

TEST(LeafCount, DiscreteLevelsAreQuartersAndNeverTooFew) {
  EXPECT_EQ(lod::coppice_discrete_leaf_count(1000.0f, 1000), 1000.0f);
  EXPECT_EQ(lod::coppice_discrete_leaf_count(250.5f, 1000), 1000.0f);
  EXPECT_EQ(lod::coppice_discrete_leaf_count(250.0f, 1000), 250.0f);
  EXPECT_EQ(lod::coppice_discrete_leaf_count(60.0f, 1000), 63.0f);
  EXPECT_EQ(lod::coppice_discrete_leaf_count(1.0f, 1'000'000), 245.0f) << "the seventh is the coarsest";
  EXPECT_EQ(lod::coppice_discrete_leaf_count(1.0f, 1), 1.0f);
}

TEST(LeafMeshes, ErrorIsTheTablesAndGrowsWithTheSizeBeyondIt) {
  const TableWithMeshes t;
  EXPECT_FLOAT_EQ(lod::coppice_leaf_mesh_error_px(t.table, t.column(4.0f)), 1.0f);
  EXPECT_FLOAT_EQ(lod::coppice_leaf_mesh_error_px(t.table, t.column(8.0f)), 1.0f);
  EXPECT_NEAR(lod::coppice_leaf_mesh_error_px(t.table, t.column(16.0f)), 1.5f, 1e-5f);
  EXPECT_FLOAT_EQ(lod::coppice_leaf_mesh_error_px(t.table, t.column(32.0f)), 2.0f);
  EXPECT_FLOAT_EQ(lod::coppice_leaf_mesh_error_px(t.table, t.column(96.0f)), 6.0f);
  EXPECT_FLOAT_EQ(lod::coppice_leaf_mesh_error_px(Table().table, Table().column(96.0f)), 0.0f) << "without leaf meshes";
  EXPECT_FLOAT_EQ(lod::coppice_table_error_px(t.table, lod::coppice_wood_row(t.table, 3), 1), 1.6f) << "behind them in the table";
}

TEST(LeafMeshes, AreDrawnWhereQuadsErrByMoreThanTheThreshold) {
  TableWithMeshes t;
  const float share = lod::coppice_instance_threshold_px(1.0f, 0);  // quads err by 4 px at a size of 64 px
  EXPECT_TRUE(t.lod_at(64.0f * share * 1.001f).leaf_meshes);
  EXPECT_FALSE(t.lod_at(64.0f * share * 0.999f).leaf_meshes);
  t.plant.leaf_meshes_resident = false;
  EXPECT_FALSE(t.lod_at(1000.0f).leaf_meshes) << "quads until they are there";
  EXPECT_EQ(t.lod_at(1000.0f).leaf_count, 100.0f);
  t.plant.leaf_meshes_resident = t.view.full = true;
  EXPECT_TRUE(t.lod_at(1.0f).leaf_meshes) << "in full detail always";
}

TEST(LeafMeshes, TheCutBecomesAllQuadsWhereMeshesTakeOver) {
  TableWithMeshes t;
  // All leaves have no error against themselves, as baked tables say.
  t.file.error_px = hook_array<float>({4.0f, 16.0f, 2.0f, 8.0f, 0.0f, 0.0f});
  t.pack();
  t.plant.table = t.table;
  const float threshold_px = lod::coppice_instance_threshold_px(4.0f, 0);
  float last = 0.0f;
  for (float size_px = 8.0f; size_px < 64.0f * threshold_px / 4.0f; size_px *= 1.01f) {
    const InstanceLod lod = t.lod_at(size_px);
    ASSERT_FALSE(lod.leaf_meshes);
    EXPECT_GE(lod.leaf_count, last * 0.99999f) << "detail grows with the size";
    last = lod.leaf_count;
    const float of_cut = error_px_at(t.table, lod.leaf_count, size_px),
                of_quads = lod::coppice_leaf_mesh_error_px(t.table, t.column(size_px));
    EXPECT_LE(std::hypot(of_cut, of_quads), threshold_px * 1.001f) << size_px << " px";
  }
  EXPECT_GT(last, 90.0f);
  t.plant.leaf_meshes_resident = false;
  EXPECT_LT(t.lod_at(32.0f * threshold_px / 2.0f).leaf_count, 90.0f) << "nothing takes over: the cut as the table has it";
}

TEST(ProjectedSize, IsTheDiameterAtItsDistance) {
  EXPECT_FLOAT_EQ(lod::coppice_projected_size_px(10.0f, 1.0f, 0.1f, 500.0f), 100.0f);
  EXPECT_FLOAT_EQ(lod::coppice_projected_size_px(0.0f, 1.0f, 0.5f, 500.0f), 2000.0f);
  EXPECT_EQ(lod::coppice_projected_size_px(1.0f, 3e38f, 0.1f, 500.0f), lod::kCoppiceMaxSizePx) << "overflows";
  EXPECT_EQ(lod::coppice_projected_size_px(INFINITY, 3e38f, 0.1f, 500.0f), lod::kCoppiceMaxSizePx) << "infinity by infinity";
}

TEST(WholeLeafCount, RoundsUpButNotByRounding) {
  EXPECT_EQ(lod::coppice_whole_leaf_count(0.0f), 1u);
  EXPECT_EQ(lod::coppice_whole_leaf_count(NAN), 1u);
  EXPECT_EQ(lod::coppice_whole_leaf_count(INFINITY), 1u << 31);
  EXPECT_EQ(lod::coppice_whole_leaf_count(1.0f), 1u);
  EXPECT_EQ(lod::coppice_whole_leaf_count(1.01f), 2u);
  EXPECT_EQ(lod::coppice_whole_leaf_count(100.00001f), 100u);
  EXPECT_EQ(lod::coppice_whole_leaf_count(100.5f), 101u);
}

TEST(InstanceThreshold, SpreadsAFewPercentRoundTheGlobalOne) {
  float sum = 0.0f;
  std::set<float> seen;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const float threshold = lod::coppice_instance_threshold_px(2.0f, i);
    EXPECT_GE(threshold, 2.0f * (1.0f - lod::kCoppiceThresholdSpread));
    EXPECT_LE(threshold, 2.0f * (1.0f + lod::kCoppiceThresholdSpread));
    sum += threshold;
    seen.insert(threshold);
  }
  EXPECT_NEAR(sum / 1000.0f, 2.0f, 0.01f);
  EXPECT_GT(seen.size(), 990u);
}

TEST(DrawnLeafCount, KeepsSomeLeavesOfSmallPlantsAndIsTheTablesElsewhere) {
  const Table t;
  EXPECT_FLOAT_EQ(t.leaves(8.0f, 4.0f), 1.0f);
  EXPECT_FLOAT_EQ(lod::coppice_drawn_leaf_count(t.table, t.column(8.0f), 4.0f), 4.0f);
  EXPECT_FLOAT_EQ(lod::coppice_drawn_leaf_count(t.table, t.column(0.1f), 4.0f), 1.0f);
  EXPECT_FLOAT_EQ(lod::coppice_drawn_leaf_count(t.table, t.column(1000.0f), 1000.0f), 2.0f);
  for (const float size_px : {8.0f, 32.0f, 200.0f})
    EXPECT_FLOAT_EQ(lod::coppice_drawn_leaf_count(t.table, t.column(size_px), 0.8f),
                    std::max(t.leaves(size_px, 0.8f), std::min(2.5f * size_px, 32.0f)));
  EXPECT_LE(lod::coppice_drawn_leaf_count(t.table, t.column(1e6f), 1e6f), 100.0f);
  EXPECT_FLOAT_EQ(lod::coppice_drawn_leaf_count(t.table, t.column(8.0f), 0.0f), 100.0f);
  const Table few(20);
  EXPECT_FLOAT_EQ(lod::coppice_drawn_leaf_count(few.table, few.column(1000.0f), 10.0f), 20.0f) << "no more than it has";
}

TEST(WoodLod, IsTheCoarsestWithinTheThreshold) {
  const Table t;
  // At 80 px, two and a half times the table's last size: 0, 1, 2, 4. At 16 px, half way between its sizes: 0.25.
  EXPECT_NEAR(lod::coppice_wood_error_px(t.table, 1, t.column(80.0f)), 1.0f, 1e-5f);
  EXPECT_NEAR(lod::coppice_wood_error_px(t.table, 1, t.column(16.0f)), 0.25f, 1e-5f);
  const float share = lod::kCoppiceWoodThresholdShare;
  EXPECT_EQ(lod::coppice_wood_lod(t.table, t.column(80.0f), 4.01f / share), 3u);
  EXPECT_EQ(lod::coppice_wood_lod(t.table, t.column(80.0f), 2.01f / share), 2u);
  EXPECT_EQ(lod::coppice_wood_lod(t.table, t.column(80.0f), 1.99f / share), 1u);
  EXPECT_EQ(lod::coppice_wood_lod(t.table, t.column(80.0f), 0.1f), 0u);
}

TEST(WoodLod, FallsBackToCoarserThenFiner) {
  EXPECT_EQ(lod::coppice_resident_wood_lod(0b1111, 1, 4), 1u);
  EXPECT_EQ(lod::coppice_resident_wood_lod(0b1001, 1, 4), 3u);
  EXPECT_EQ(lod::coppice_resident_wood_lod(0b0011, 2, 4), 1u);
  EXPECT_EQ(lod::coppice_resident_wood_lod(0b0001, 3, 4), 0u);
  EXPECT_EQ(lod::coppice_resident_wood_lod(0, 0, 4), 4u);
}

std::vector<std::uint32_t> cut(std::span<const std::uint32_t> node_split, std::uint32_t leaf_count) {
  std::vector<std::uint32_t> nodes(leaf_count + 1);
  nodes.resize(select_cut(node_split, leaf_count, nodes));
  return nodes;
}

TEST(SelectCut, OfFourLeaves) {
  // Split 0: node 0 -> 1 2; split 1: node 2 -> 3 4; split 2: node 1 -> 5 6.
  constexpr std::uint32_t kLast = lod::kCoppiceNoSplit;
  const std::vector<std::uint32_t> node_split = {0, 2, 1, kLast, kLast, kLast, kLast};
  EXPECT_EQ(cut(node_split, 1), (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(cut(node_split, 2), (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(cut(node_split, 3), (std::vector<std::uint32_t>{1, 3, 4}));
  EXPECT_EQ(cut(node_split, 4), (std::vector<std::uint32_t>{3, 4, 5, 6}));
}

TEST(SelectCut, AnyCutCoversEverySourceLeafOnce) {
  const bake::Tree tree = test::random_tree(test::random_foliage(60, 7), 7);
  std::vector<std::vector<std::uint32_t>> sources(tree.nodes.size());
  for (std::size_t node = tree.nodes.size(); node-- > 0;) {
    if (tree.node_split[node] == bake::kNone) {
      sources[node] = {tree.node_source[node]};
      continue;
    }
    for (std::uint32_t child : {2 * tree.node_split[node] + 1, 2 * tree.node_split[node] + 2})
      sources[node].insert(sources[node].end(), sources[child].begin(), sources[child].end());
  }
  for (std::uint32_t m = 1; m <= 60; ++m) {
    const std::vector<std::uint32_t> nodes = cut(tree.node_split, m);
    ASSERT_EQ(nodes.size(), m);
    std::vector<int> covered(60);
    for (std::uint32_t node : nodes)
      for (std::uint32_t source : sources[node]) ++covered[source];
    EXPECT_EQ(std::ranges::count(covered, 1), 60) << "cut of " << m;
  }
}

TEST(SelectLods, ClampsToWhatIsResidentAndSkipsHoles) {
  const Table t;
  const std::vector<LodPlant> plants = {{t.table, 100, 0b1111}, {t.table, 20, 0b1000}};
  const std::vector<InstanceSphere> instances = {{{0, 0, -1}, 1.0f, 0}, {{0, 0, -1}, 1.0f, 1}, {}, {{0, 0, -1000}, 1.0f, 0}};
  LodView view{.eye_m = {0, 0, 0}, .focal_px = 500.0f, .error_px = 2.0f};
  std::vector<InstanceLod> lods(instances.size());
  select_lods(instances, plants, view, lods);
  EXPECT_FLOAT_EQ(lods[0].leaf_count, 100.0f);
  EXPECT_EQ(lods[0].wood_lod, 0u);
  EXPECT_FLOAT_EQ(lods[1].leaf_count, 20.0f);
  EXPECT_EQ(lods[1].wood_lod, 3u);
  EXPECT_EQ(lods[2].leaf_count, 0.0f);
  EXPECT_LT(lods[3].leaf_count, 20.0f);
  EXPECT_EQ(lods[3].wood_lod, 3u);
  view.full = true;
  select_lods(instances, plants, view, lods);
  EXPECT_FLOAT_EQ(lods[3].leaf_count, 100.0f);
  EXPECT_EQ(lods[3].wood_lod, 0u);
  EXPECT_FLOAT_EQ(lods[1].leaf_count, 20.0f);
}

TEST(SelectLods, AgreesWithTheFunctionsItIsMadeOf) {
  const Table t;
  const std::vector<LodPlant> plants = {{t.table, 100, 0b1111}};
  const LodView view{.eye_m = {1, 2, 3}, .focal_px = 600.0f, .error_px = 1.5f};
  for (std::uint32_t i = 0; i < 50; ++i) {
    const InstanceSphere instance{{1, 2, 3.0f + 20.0f + 9.0f * static_cast<float>(i)}, 1.5f, 0};
    const float size_px = 2.0f * 1.5f * 600.0f / (20.0f + 9.0f * static_cast<float>(i));
    const float threshold_px = lod::coppice_instance_threshold_px(1.5f, i);
    EXPECT_NEAR(select_lod(instance, i, plants[0], view).leaf_count,
                lod::coppice_drawn_leaf_count(t.table, t.column(size_px), threshold_px), 1e-2f);
  }
}

}  // namespace coppice::select_test
