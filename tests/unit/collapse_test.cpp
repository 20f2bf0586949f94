#include "collapse_information.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "alpha_mask.h"
#include "bounds.h"
#include "live_visibility.h"
#include "naive_collapse.h"
#include "quad_merge.h"
#include "results.h"
#include "test_foliage.h"
#include "tree_order.h"

namespace coppice::bake::collapse_test {

using test::NaiveAreas;
using test::NaivePlant;
using test::NaiveScene;

/// Opaque leaves seen from the dodecahedron.
NaiveScene scene_of(Foliage foliage, bool count_background, std::uint32_t resolution_px = 48) {
  NaiveScene scene;
  scene.source = std::move(foliage);
  scene.views = *viewpoints(20);
  scene.options.resolution_px = resolution_px;
  scene.options.count_background = count_background;
  scene.masks = *alpha_masks(test::plain_materials(), {});
  return scene;
}

Result<CollapseResult> collapsed(const NaiveScene& scene, const AreaSource& source = {}) {
  return collapse_by_mutual_information({scene.source, test::plain_materials(), {}}, scene.views, scene.options, {}, source);
}

CollapseResult collapse(const NaiveScene& scene) {
  return test::must(collapsed(scene));
}

std::string text(const Merge& merge) {
  std::string line = std::to_string(merge.first) + " + " + std::to_string(merge.second) + " corners";
  for (const std::uint8_t corner : merge.corners) line += " " + std::to_string(corner);
  return line;
}

void expect_same_sequence(const CollapseSequence& actual, const CollapseSequence& expected) {
  ASSERT_EQ(actual.merges.size(), expected.merges.size());
  for (std::size_t i = 0; i < expected.merges.size(); ++i) ASSERT_EQ(text(actual.merges[i]), text(expected.merges[i])) << "merge " << i;
  EXPECT_EQ(actual.evaluations, expected.evaluations);
}

class Collapse : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Background, Collapse, testing::Values(true, false),
                         [](const auto& instance) { return instance.param ? "counted" : "not_counted"; });

TEST_P(Collapse, SequenceIsThatOfTheNaiveImplementation) {
  const std::pair<const char*, Foliage> plants[] = {
      {"random quads, seed 1", test::random_quads(60, 1)},
      {"random quads, seed 2", test::random_quads(75, 2)},
      {"crown, seed 3", test::ball_crown(90, 3)},
      {"crown, seed 4", test::ball_crown(120, 4)},
      {"duplicated leaves", test::duplicated_leaves(60, 5)},
      {"identical leaves", test::plain_foliage(std::vector<Quad>(12, test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0.2f})))}};
  for (const auto& [name, foliage] : plants) {
    SCOPED_TRACE(name);
    const NaiveScene scene = scene_of(foliage, GetParam());
    expect_same_sequence(collapse(scene).sequence, test::naive_collapse(scene));
  }
}

TEST_P(Collapse, SequenceIsThatOfTheNaiveImplementationForOtherOptions) {
  for (const std::uint32_t candidate_count : {1u, 3u, 40u}) {
    SCOPED_TRACE(candidate_count);
    NaiveScene scene = scene_of(test::ball_crown(60, candidate_count), GetParam(), 33);
    scene.options.candidate_count = candidate_count;
    scene.views = *viewpoints(7);
    expect_same_sequence(collapse(scene).sequence, test::naive_collapse(scene));
  }
}

/// The masked leaves of a plant with two materials, one with holes: merged leaves keep the larger child's card.
TEST_P(Collapse, MaskedLeavesCollapseAsInTheNaiveImplementation) {
  NaiveScene scene = scene_of(test::ball_crown(60, 11), GetParam());
  scene.source.card_table.push_back(scene.source.card_table[0]);
  scene.source.card_table[1].material = 1;
  for (std::uint32_t i = 0; i < 60; i += 2) scene.source.cards[i] = 1;
  Image image{4, 4, std::vector<std::uint8_t>(64, 255)};
  for (const std::size_t texel : {0u, 3u, 5u, 12u}) image.rgba[texel * 4 + 3] = 10;
  std::vector<Material> materials(2);
  materials[1].image = 0;
  materials[1].alpha_cutoff = 0.5f;
  scene.masks = *alpha_masks(materials, {image});
  const auto result = test::must(collapse_by_mutual_information({scene.source, materials, {image}}, scene.views, scene.options, {}));
  expect_same_sequence(result.sequence, test::naive_collapse(scene));
}

/// Item buffers of whatever leaves are asked for: what a device would measure that rounds as they do.
Result<void> areas_of_item_buffers(const NaiveScene& scene, const AreaRequest& request, std::span<std::uint32_t> areas_px) {
  Foliage foliage = scene.source;
  foliage.quads.assign(request.quads.begin(), request.quads.end());
  foliage.cards.assign(request.cards.begin(), request.cards.end());
  NaivePlant plant;
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf) plant[leaf] = {foliage.quads[leaf], foliage.cards[leaf]};
  const NaiveAreas areas = test::render_areas(scene, plant);
  const std::size_t view_count = scene.views.size();
  for (std::size_t v = 0; v < view_count; ++v) {
    for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf) {
      std::uint32_t& area = areas_px[leaf * view_count + v];
      const std::uint32_t now = areas.leaves.at(leaf)[v];
      const Projection projection = make_projection(scene.views[v], bounding_sphere(scene.source), scene.options.resolution_px);
      const PixelBox box = pixel_box(project(projection, foliage.quads[leaf]), projection.resolution_px);
      // What no change touches must be what it was: no caller may say less than changes.
      const bool asked = request.changed.empty() || box.meets(request.changed[v]);
      EXPECT_TRUE(asked || area == now);
      area = now;
    }
    areas_px[foliage.leaf_count() * view_count + v] = areas.background[v];
  }
  return {};
}

TEST_P(Collapse, MeasuredAreasGiveTheSameSequence) {
  for (const Foliage& foliage : {test::random_quads(40, 31), test::ball_crown(50, 32)}) {
    const NaiveScene scene = scene_of(foliage, GetParam(), 40);
    const CollapseResult expected = collapse(scene);
    AreaSource source;
    source.measure = [&](const AreaRequest& request, std::span<std::uint32_t> areas) {
      return areas_of_item_buffers(scene, request, areas);
    };
    for (const bool every_step : {true, false}) {
      source.every_step = every_step;
      const auto result = test::must(collapsed(scene, source));
      expect_same_sequence(result.sequence, expected.sequence);
      EXPECT_EQ(result.source.bits, expected.source.bits);
      for (std::size_t level = 0; level < expected.levels.size(); ++level)
        EXPECT_EQ(result.levels[level].bits, expected.levels[level].bits) << level;
    }
  }
}

/// Leaves count for what was measured: here as if half of them were not seen at all, and all of the others twice.
TEST_P(Collapse, InitialAreasAreThoseThatWereMeasured) {
  const NaiveScene scene = scene_of(test::ball_crown(40, 33), GetParam(), 40);
  AreaSource source;
  std::vector<std::uint32_t> measured;
  source.measure = [&](const AreaRequest& request, std::span<std::uint32_t> areas) -> Result<void> {
    COPPICE_CHECK(areas_of_item_buffers(scene, request, areas));
    for (std::size_t i = 0; i < 40 * scene.views.size(); ++i) areas[i] *= i < 20 * scene.views.size() ? 0u : 2u;
    measured.assign(areas.begin(), areas.end());
    return {};
  };
  const auto result = test::must(collapsed(scene, source));
  NaiveAreas areas;
  for (std::uint32_t leaf = 0; leaf <= 40; ++leaf) {
    const auto first = measured.begin() + static_cast<std::ptrdiff_t>(leaf * scene.views.size());
    (leaf < 40 ? areas.leaves[leaf] : areas.background).assign(first, first + static_cast<std::ptrdiff_t>(scene.views.size()));
  }
  EXPECT_EQ(result.source.bits, to_bits(test::information_of(scene, areas).sum));
  EXPECT_EQ(result.sequence.merges.size(), 39u);
}

/// A device that fails at the n-th question ends the collapse with its error.
TEST_P(Collapse, AFailureToMeasureIsPassedOn) {
  const NaiveScene scene = scene_of(test::ball_crown(20, 34), GetParam(), 24);
  for (const bool every_step : {true, false})
    for (const int fails_at : every_step ? std::vector{0, 1, 30} : std::vector{0}) {
      int asked = 0;
      AreaSource source{{}, every_step};
      source.measure = [&](const AreaRequest& request, std::span<std::uint32_t> areas) -> Result<void> {
        if (asked++ >= fails_at) return Error{Status::device_lost, "lost"};
        return areas_of_item_buffers(scene, request, areas);
      };
      test::expect_error(collapsed(scene, source), Status::device_lost);
      EXPECT_EQ(asked, fails_at + 1) << "it is not asked again";
    }
}

/// After every collapse, every leaf in every view, as integers.
TEST_P(Collapse, IncrementalAreasEqualAFullRender) {
  for (const Foliage& foliage : {test::random_quads(60, 21), test::ball_crown(60, 22), test::duplicated_leaves(60, 23)}) {
    const NaiveScene scene = scene_of(foliage, GetParam(), 64);
    const CollapseSequence sequence = collapse(scene).sequence;
    auto live = LiveVisibility::create({foliage, test::plain_materials(), {}}, scene.views, scene.options.resolution_px);
    ASSERT_TRUE(live);
    NaivePlant plant = test::source_plant(scene);
    LiveVisibility::Scratch scratch;
    OwnedPixels owned;
    AreaChanges changes;
    for (std::size_t i = 0; i <= sequence.merges.size(); ++i) {
      const NaiveAreas expected = test::render_areas(scene, plant);
      for (std::uint32_t id = 0; id < live->id_count(); ++id) {
        const auto found = expected.leaves.find(id);
        const std::vector<std::uint32_t> row =
            found == expected.leaves.end() ? std::vector<std::uint32_t>(scene.views.size(), 0) : found->second;
        ASSERT_TRUE(std::ranges::equal(live->areas(id), row)) << "leaf " << id << " after " << i << " collapses";
      }
      ASSERT_TRUE(std::ranges::equal(live->areas(live->background()), expected.background)) << i;
      if (i == sequence.merges.size()) break;
      const std::uint32_t result = foliage.leaf_count() + static_cast<std::uint32_t>(i);
      plant = test::merged_plant(plant, sequence.merges[i], result);
      const LeafMerge merge{sequence.merges[i].first, sequence.merges[i].second, result, {plant.at(result).quad, plant.at(result).card}};
      live->owned_pixels(merge.first, owned);
      live->changes_of(merge, owned, scratch, changes);
      live->apply(merge, changes);
    }
  }
}

TEST_P(Collapse, InformationOfSourceAndLevelsEqualsARecount) {
  for (const Foliage& foliage : {test::ball_crown(120, 31), test::random_quads(85, 32)}) {
    const NaiveScene scene = scene_of(foliage, GetParam(), 64);
    const CollapseResult result = collapse(scene);
    const std::uint32_t leaf_count = foliage.leaf_count();
    ASSERT_EQ(result.levels.size(), 7u);
    NaivePlant plant = test::source_plant(scene);
    const auto recount = [&](const FoliageInformation& information) {
      ASSERT_EQ(information.leaf_count, plant.size());
      const NaiveAreas areas = test::render_areas(scene, plant);
      EXPECT_EQ(information.bits, to_bits(test::information_of(scene, areas).sum));
      EXPECT_NEAR(information.bits, test::information_by_definition(scene, areas), 1e-10);
      EXPECT_GT(information.bits, 0.0);
    };
    recount(result.source);
    std::size_t level = 0;
    for (std::uint32_t i = 0; i < leaf_count - 1; ++i) {
      plant = test::merged_plant(plant, result.sequence.merges[i], leaf_count + i);
      for (; level < 7 && result.levels[level].leaf_count == plant.size(); ++level) recount(result.levels[level]);
    }
    EXPECT_EQ(level, 7u);
  }
}

TEST_P(Collapse, ThreadsDoNotChangeTheSequence) {
  const NaiveScene scene = scene_of(test::ball_crown(400, 41), GetParam(), 64);
  std::vector<CollapseResult> results;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(collapse(scene));
  }
  for (const CollapseResult& result : results) {
    expect_same_sequence(result.sequence, results[0].sequence);
    EXPECT_EQ(result.source.bits, results[0].source.bits);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(result.levels[i].bits, results[0].levels[i].bits);
  }
}

TEST_P(Collapse, OneAndTwoLeaves) {
  const Quad low = test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), high = test::rectangle({0, 0, 3}, {1, 0, 0}, {0, 1, 0});
  const CollapseResult one = collapse(scene_of(test::plain_foliage({low}), GetParam()));
  EXPECT_TRUE(one.sequence.merges.empty());
  EXPECT_EQ(one.sequence.evaluations, 0u);
  for (const FoliageInformation& level : one.levels) EXPECT_EQ(level.bits, one.source.bits);
  const CollapseResult two = collapse(scene_of(test::plain_foliage({low, high}), GetParam()));
  ASSERT_EQ(two.sequence.merges.size(), 1u);
  EXPECT_EQ(two.sequence.evaluations, 1u);
  // The eight are a box of 1 x 1 x 3. Of its four longest diagonals, sqrt(11), the first is 0-6. To these two, vertices 2 and 4 have the
  // largest sum, 3 + sqrt(2) against 1 + sqrt(10): v3 = 2. Then 4: 3 + sqrt(2) + sqrt(11) against 1 + 2 sqrt(10) of 5 and 7.
  EXPECT_EQ(text(two.sequence.merges[0]), "0 + 1 corners 0 2 6 4");
}

/// An invisible leaf has 0 bits and goes first; nothing is drawn for it.
TEST_P(Collapse, ALeafCollapsedToAPointGoesFirst) {
  Foliage foliage = test::ball_crown(30, 51);
  foliage.quads[17] = Quad{foliage.quads[17][0], foliage.quads[17][0], foliage.quads[17][0], foliage.quads[17][0]};
  const NaiveScene scene = scene_of(foliage, GetParam());
  const CollapseResult result = collapse(scene);
  expect_same_sequence(result.sequence, test::naive_collapse(scene));
  EXPECT_TRUE(result.sequence.merges[0].first == 17 || result.sequence.merges[0].second == 17) << text(result.sequence.merges[0]);
  const NaiveScene points = scene_of(test::plain_foliage(std::vector<Quad>(5, Quad{})), GetParam());
  EXPECT_EQ(collapse(points).sequence.merges.size(), 4u);
  EXPECT_EQ(collapse(points).source.bits, 0.0);
}

TEST(CollapseOptions, OutOfRangeIsRejected) {
  const Foliage foliage = test::ball_crown(4, 1);
  const auto collapsed_with = [](const Foliage& leaves, const CollapseOptions& options) {
    return collapse_by_mutual_information({leaves, test::plain_materials(), {}}, *viewpoints(3), options, {});
  };
  EXPECT_TRUE(collapsed_with(foliage, {16, true, 1}));
  for (const CollapseOptions& options :
       {CollapseOptions{0, true, 8}, CollapseOptions{2049, true, 8}, CollapseOptions{16, true, 0}, CollapseOptions{16, true, 4097}})
    test::expect_error(collapsed_with(foliage, options), Status::invalid_argument);
  test::expect_error(collapsed_with(Foliage{}, {16, true, 8}), Status::invalid_argument);
}

TEST(CollapseProgress, NeverFallsAndEndsAtOne) {
  std::vector<double> fractions;
  const auto result = collapse_by_mutual_information({test::ball_crown(200, 1), test::plain_materials(), {}}, *viewpoints(4), {32, true, 4},
                                                     [&](double fraction) { fractions.push_back(fraction); });
  ASSERT_TRUE(result);
  EXPECT_GE(fractions.size(), 100u);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
  EXPECT_GE(fractions.front(), 0.0);
}

TEST(CollapseLevels, AreThePapersTableII) {
  EXPECT_EQ(level_leaf_counts(386), (std::vector<std::uint32_t>{308, 231, 154, 77, 38, 19, 9}));
  EXPECT_EQ(level_leaf_counts(4456), (std::vector<std::uint32_t>{3564, 2673, 1782, 891, 445, 222, 111}));
  EXPECT_EQ(level_leaf_counts(13162), (std::vector<std::uint32_t>{10529, 7897, 5264, 2632, 1316, 658, 329}));
  EXPECT_EQ(level_leaf_counts(1), (std::vector<std::uint32_t>(7, 1)));
}

}  // namespace coppice::bake::collapse_test
