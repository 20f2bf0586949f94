// The trees of a scene through coppice.h: found, felled, replaced and restored, while their tiles come and go.

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string_view>
#include <tuple>

#include "coppice/vulkan.h"
#include "golden.h"
#include "mentions.h"
#include "scene_context.h"

namespace coppice::test::scene_trees_test {

constexpr double kEverywhere = std::numeric_limits<double>::infinity();

auto key_of(const coppice_scene_tree& tree) {
  return std::tuple(tree.scene, tree.tile, tree.number);
}

class SceneTreesTest : public SceneContextTest {
 protected:
  /// Trees in the square box about a place on the ground; missing: tiles
  std::vector<coppice_scene_tree> trees_near(double x, double z, double reach_m, std::uint32_t* missing = nullptr) {
    const double low[3] = {x - reach_m, -1000.0, z - reach_m}, high[3] = {x + reach_m, 1000.0, z + reach_m};
    std::uint32_t count = 0, again = 0;
    EXPECT_EQ(coppice_scene_query(context_, scene_, low, high, nullptr, 0, &count, missing), COPPICE_OK) << log_;
    std::vector<coppice_scene_tree> trees(count);
    EXPECT_EQ(coppice_scene_query(context_, scene_, low, high, trees.data(), count, &again, nullptr), COPPICE_OK) << log_;
    EXPECT_EQ(again, count);
    return trees;
  }

  coppice_tree_info tree_info(const coppice_scene_tree& tree) {
    auto info = defaults(coppice_tree_info_init);
    EXPECT_EQ(coppice_scene_get_tree(context_, &tree, &info), COPPICE_OK) << log_;
    return info;
  }

  /// From above onto some trees about (0, 0, -19), every leaf, so that slots make no difference.
  static Shot near_view() { return make_view({.eye_m = {0, 5, -17}, .target_m = {0, 0, -19}, .width_px = 128, .lod = COPPICE_LOD_FULL}); }
  static Shot far_view() { return view_from(0, 2, 50000); }

  /// What is drawn once all of the view is there, against a picture of it.
  double changed_share(const Shot& view, const Picture& picture, std::uint32_t channel_delta = 8) {
    settle(view);
    return compare_pictures(ContextTest::frame(view), picture, channel_delta).differing_share;
  }

  /// All of the scene goes.
  void go_away() {
    EXPECT_EQ(settle(far_view()).scene_tiles_resident, 0u);
    frame(far_view());
  }
};

TEST_F(SceneTreesTest, AFelledTreeIsGoneWhenItsTileComesBackAndStandsOnceRestored) {
  create(16384, true);
  open_scene();
  const Shot view = near_view();
  const coppice_stats before = settle(view);
  const Picture whole = ContextTest::frame(view);

  // Whoever looks at a tree picks it.
  auto ray = defaults(coppice_ray_init);
  const double from[3] = {0, 5, -17};
  std::ranges::copy(from, ray.origin);
  ray.direction[1] = -5.0f / std::hypot(5.0f, 2.0f);
  ray.direction[2] = -2.0f / std::hypot(5.0f, 2.0f);
  ray.boxes = COPPICE_TRUE;
  auto hit = defaults(coppice_hit_init);
  ASSERT_EQ(coppice_pick(context_, &ray, &hit), COPPICE_OK) << log_;
  ASSERT_EQ(hit.kind, COPPICE_HIT_BOX);
  EXPECT_EQ(hit.instance, 0u);
  EXPECT_EQ(hit.tree.scene, scene_);
  const coppice_scene_tree felled = hit.tree;
  const coppice_tree_info standing = tree_info(felled);
  EXPECT_EQ(standing.state, COPPICE_TREE_AS_IN_FILE);
  EXPECT_EQ(standing.plant, hit.plant);
  EXPECT_NEAR(standing.placement.position[2], hit.position[2], 3.0);

  ASSERT_EQ(coppice_scene_hide(context_, &felled, 1), COPPICE_OK) << log_;
  settle(view);
  const Picture without = ContextTest::frame(view);
  EXPECT_GT(compare_pictures(without, whole, 40).differing_share, 0.005) << "it is not drawn";
  auto behind = defaults(coppice_hit_init);
  ASSERT_EQ(coppice_pick(context_, &ray, &behind), COPPICE_OK) << log_;
  EXPECT_NE(key_of(behind.tree), key_of(felled)) << "nor picked";
  EXPECT_EQ(tree_info(felled).state, COPPICE_TREE_HIDDEN);
  EXPECT_EQ(tree_info(felled).placement.layer_mask, COPPICE_ALL_LAYERS) << "its placement is good for one of the engine's own";
  EXPECT_EQ(tree_info(felled).plant, standing.plant);

  go_away();
  EXPECT_EQ(tree_info(felled).resident, COPPICE_FALSE);
  EXPECT_EQ(tree_info(felled).state, COPPICE_TREE_HIDDEN);
  EXPECT_EQ(settle(view).instance_count, before.instance_count) << "a hidden one still has its place";
  EXPECT_LT(changed_share(view, without), 0.002) << "and is still felled";

  ASSERT_EQ(coppice_scene_restore(context_, &felled, 1), COPPICE_OK) << log_;
  EXPECT_LT(changed_share(view, whole), 0.002);
  go_away();
  EXPECT_LT(changed_share(view, whole), 0.002);
  EXPECT_EQ(log_, "");
}

TEST_F(SceneTreesTest, AnotherPlantStandsInPlaceOfATreeAndComesAndGoesWithIt) {
  create(16384, true);
  open_scene();
  const Shot view = near_view();
  settle(view);
  const Picture whole = ContextTest::frame(view);
  const std::vector<coppice_scene_tree> trees = trees_near(0, -19, 10);
  ASSERT_GE(trees.size(), 3u);
  write_plant(folder_ / "own.coppice", {.leaf_count = 900, .seed = 9});
  const coppice_plant own = open(folder_ / "own.coppice");
  std::vector<coppice_placement> placements(trees.size());
  for (std::size_t i = 0; i < trees.size(); ++i) {
    placements[i] = tree_info(trees[i]).placement;
    placements[i].position[1] += 0.5;
    placements[i].scale = 0.5f;
    placements[i].tint[0] = 2.0f;
    placements[i].user_data = 5;
  }
  ASSERT_EQ(
      coppice_scene_replace(context_, trees.data(), own, placements.data(), sizeof placements[0], static_cast<std::uint32_t>(trees.size())),
      COPPICE_OK)
      << log_;
  settle(view);
  const Picture replaced = ContextTest::frame(view);
  EXPECT_GT(compare_pictures(replaced, whole, 40).differing_share, 0.02);
  EXPECT_EQ(tree_info(trees[0]).plant, own);
  EXPECT_EQ(tree_info(trees[0]).state, COPPICE_TREE_REPLACED);
  EXPECT_EQ(tree_info(trees[0]).placement.user_data, 5u);
  go_away();
  EXPECT_LT(changed_share(view, replaced), 0.002) << "they come back as they were";

  // Its own plant, bare: autumn.
  for (coppice_placement& placement : placements) placement.leaf_share = 0.0f;
  ASSERT_EQ(coppice_scene_replace(context_, &trees[0], 0, placements.data(), sizeof placements[0], 1), COPPICE_OK) << log_;
  EXPECT_NE(tree_info(trees[0]).plant, own);
  EXPECT_EQ(tree_info(trees[0]).placement.leaf_share, 0.0f);

  // A plant that is closed takes what it stood for along; the trees can still be had back.
  ASSERT_EQ(coppice_plant_close(context_, own), COPPICE_OK);
  settle(view);
  EXPECT_EQ(tree_info(trees[1]).plant, 0u);
  go_away();
  settle(view);
  ASSERT_EQ(coppice_scene_restore(context_, trees.data(), static_cast<std::uint32_t>(trees.size())), COPPICE_OK) << log_;
  EXPECT_LT(changed_share(view, whole), 0.002);
  EXPECT_EQ(log_, "");
}

TEST_F(SceneTreesTest, ABoxHasTheTreesThatStandInIt) {
  create(16384, false);
  open_scene();
  std::uint32_t missing = 0;
  EXPECT_TRUE(trees_near(0, 0, kEverywhere, &missing).empty());
  EXPECT_GT(missing, 0u) << "nothing has come yet";
  const coppice_stats there = settle(view_from(0, 2, 0));
  const std::vector<coppice_scene_tree> all = trees_near(0, 0, kEverywhere, &missing);
  EXPECT_EQ(all.size(), there.instance_count);
  EXPECT_EQ(missing, there.scene_tile_count - there.scene_tiles_resident);
  std::vector<coppice_scene_tree> sorted = all;
  std::ranges::sort(sorted, {}, key_of);
  EXPECT_EQ(std::ranges::adjacent_find(sorted, {}, key_of), sorted.end()) << "each once";
  for (const double reach_m : {0.1, 4.8, 30.0, 200.0}) {
    const auto inside = std::ranges::count_if(all, [&](const coppice_scene_tree& tree) {
      const coppice_placement at = tree_info(tree).placement;
      return std::abs(at.position[0] - 20.0) <= reach_m && std::abs(at.position[2] + 30.0) <= reach_m;
    });
    EXPECT_EQ(trees_near(20, -30, reach_m).size(), static_cast<std::size_t>(inside)) << reach_m;
  }
  EXPECT_EQ(trees_near(20, -30, 4.8, &missing).size(), 1u) << "a grid of 9.5 m";
  EXPECT_EQ(missing, 0u);
  // The file says where they are: none is moved, and each of 9.47 m from the next.
  const coppice_placement at = tree_info(trees_near(20, -30, 4.8)[0]).placement;
  EXPECT_NEAR(std::remainder(at.position[0] / (900.0 / 95.0), 1.0), 0.0, 0.01);

  // Where the scene is moved to, there they stand; what was changed moves along.
  const coppice_scene_tree hidden = trees_near(20, -30, 4.8)[0];
  ASSERT_EQ(coppice_scene_hide(context_, &hidden, 1), COPPICE_OK);
  auto moved = defaults(coppice_scene_placement_init);
  moved.position[0] = 7000.0;
  moved.rotation[1] = moved.rotation[3] = std::sqrt(0.5f);  // what lay towards -z lies towards -x
  ASSERT_EQ(coppice_scene_move(context_, scene_, &moved), COPPICE_OK);
  const std::vector<coppice_scene_tree> turned = trees_near(7000 - 30, -20, 4.8);
  ASSERT_EQ(turned.size(), 1u);
  EXPECT_EQ(key_of(turned[0]), key_of(hidden));
  EXPECT_EQ(tree_info(turned[0]).state, COPPICE_TREE_HIDDEN);
  const double origin[3] = {7000, 0, 0};
  ASSERT_EQ(coppice_set_origin(context_, origin), COPPICE_OK);
  EXPECT_EQ(trees_near(-30, -20, 4.8).size(), 1u);
  EXPECT_NEAR(tree_info(turned[0]).placement.position[0], -30.0, 5.0);
}

/// What was changed before its tile comes, and in many trees at once.
TEST_F(SceneTreesTest, TreesAreChangedWhileTheyAreNotThere) {
  create(16384, false);
  open_scene();
  auto info = defaults(coppice_scene_info_init);
  ASSERT_EQ(coppice_scene_get_info(context_, scene_, &info), COPPICE_OK);
  const coppice_stats before = settle(view_from(0, 2, 0));
  const std::uint32_t visible = view_stats().visible_instance_count;
  const std::vector<coppice_scene_tree> all = trees_near(0, 0, kEverywhere);
  go_away();
  // Every other one, the last first, some twice.
  std::vector<coppice_scene_tree> half;
  for (std::size_t i = 0; i < all.size(); i += 2) half.insert(half.begin(), all[i]);
  half.insert(half.end(), half.begin(), half.begin() + 50);
  ASSERT_EQ(coppice_scene_hide(context_, half.data(), static_cast<std::uint32_t>(half.size())), COPPICE_OK) << log_;
  settle(view_from(0, 2, 0));
  EXPECT_NEAR(view_stats().visible_instance_count, visible / 2, visible / 20);
  for (std::size_t i = 0; i < all.size(); i += 97)
    EXPECT_EQ(tree_info(all[i]).state, i % 2 == 0 ? COPPICE_TREE_HIDDEN : COPPICE_TREE_AS_IN_FILE);

  std::uint32_t count = 0;
  ASSERT_EQ(coppice_get_draws(context_, view_, nullptr, 0, sizeof(coppice_draw), &count), COPPICE_OK);
  std::vector<coppice_draw> draws(count);
  ASSERT_EQ(coppice_get_draws(context_, view_, draws.data(), count, sizeof(coppice_draw), &count), COPPICE_OK);
  ASSERT_GT(count, 0u);
  for (const coppice_draw& draw : draws) {
    EXPECT_EQ(draw.instance, 0u);
    ASSERT_EQ(draw.tree.scene, scene_);
    const coppice_tree_info of_tree = tree_info(draw.tree);
    EXPECT_EQ(of_tree.state, COPPICE_TREE_AS_IN_FILE) << "none that is hidden is drawn";
    EXPECT_EQ(of_tree.plant, draw.plant);
    EXPECT_EQ(of_tree.placement.position[0], draw.position[0]);
  }
  ASSERT_EQ(coppice_scene_restore(context_, all.data(), static_cast<std::uint32_t>(all.size())), COPPICE_OK) << log_;
  const coppice_stats after = settle(view_from(0, 2, 0));
  EXPECT_EQ(view_stats().visible_instance_count, visible);
  EXPECT_EQ(after.instance_count, before.instance_count);
  ASSERT_EQ(coppice_scene_close(context_, scene_), COPPICE_OK);
  frame(view_from(0, 2, 0));
  EXPECT_EQ(stats().instance_count, 0u);
}

/// A change to a tree that is still growing up, as near tiles do that come late.
TEST_F(SceneTreesTest, ATreeThatGrowsUpIsReplacedAtItsFullSize) {
  create(16384, false);
  open_scene();
  std::vector<coppice_scene_tree> trees;
  for (int i = 0; i < 100 && trees.empty(); ++i) {
    frame(view_from(0, 2, 0));
    trees = trees_near(0, -20, 20);
    usleep(2000);
  }
  ASSERT_FALSE(trees.empty());
  auto placement = defaults(coppice_placement_init);
  placement.scale = 2.0f;
  ASSERT_EQ(coppice_scene_replace(context_, trees.data(), 0, &placement, sizeof placement, 1), COPPICE_OK) << log_;
  for (int i = 0; i < 40; ++i) frame(view_from(0, 2, 0));
  settle(view_from(0, 2, 0));
  EXPECT_FLOAT_EQ(tree_info(trees[0]).placement.scale, 2.0f);
  ASSERT_EQ(coppice_scene_restore(context_, trees.data(), 1), COPPICE_OK) << log_;
  EXPECT_FLOAT_EQ(tree_info(trees[0]).placement.scale, tree_info(trees.back()).placement.scale);
}

TEST_F(SceneTreesTest, WhatIsNoTreeIsRefusedAndNothingChanges) {
  create(16384, false);
  open_scene();
  settle(view_from(0, 2, 0));
  const coppice_scene_tree good = trees_near(0, -20, 20).at(0);
  auto placement = defaults(coppice_placement_init);
  const auto expect_refused = [&](std::initializer_list<std::string_view> names, auto change) {
    std::array<coppice_scene_tree, 2> trees{good, good};
    change(trees[1]);
    for (const int call : {0, 1, 2}) {
      log_.clear();
      const std::array<coppice_placement, 2> placements{placement, placement};
      EXPECT_EQ(call == 0   ? coppice_scene_hide(context_, trees.data(), 2)
                : call == 1 ? coppice_scene_restore(context_, trees.data(), 2)
                            : coppice_scene_replace(context_, trees.data(), 0, placements.data(), sizeof placement, 2),
                COPPICE_ERROR_INVALID_ARGUMENT);
      EXPECT_TRUE(mentions(log_, names));
    }
    EXPECT_EQ(tree_info(good).state, COPPICE_TREE_AS_IN_FILE);
  };
  expect_refused({"trees[1].scene", "0"}, [](coppice_scene_tree& tree) { tree.scene = 0; });
  expect_refused({"trees[1].scene", "view"}, [this](coppice_scene_tree& tree) { tree.scene = view_; });
  expect_refused({"trees[1].tile", "1000000"}, [](coppice_scene_tree& tree) { tree.tile = 1000000; });
  expect_refused({"trees[1].number", "5000"}, [](coppice_scene_tree& tree) { tree.number = 5000; });
  EXPECT_EQ(coppice_scene_hide(context_, nullptr, 1), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(coppice_scene_hide(context_, nullptr, 0), COPPICE_OK);
  placement.scale = 0.0f;
  EXPECT_EQ(coppice_scene_replace(context_, &good, 0, &placement, sizeof placement, 1), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(mentions(log_, {"placements[0].scale"}));
  EXPECT_EQ(coppice_scene_replace(context_, &good, 17, &placement, sizeof placement, 1), COPPICE_ERROR_INVALID_ARGUMENT);
  const double low[3] = {0, 0, 0}, high[3] = {1, -1, 1};
  std::uint32_t count = 7;
  EXPECT_EQ(coppice_scene_query(context_, scene_, low, high, nullptr, 0, &count, nullptr), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(mentions(log_, {"box_min[1]", "box_max[1]"}));
  EXPECT_EQ(count, 0u);
  EXPECT_EQ(coppice_scene_query(context_, scene_, low, low, nullptr, 1, &count, nullptr), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(coppice_scene_query(context_, scene_, nullptr, high, nullptr, 0, &count, nullptr), COPPICE_ERROR_INVALID_ARGUMENT);
  coppice_tree_info info{};
  EXPECT_EQ(coppice_scene_get_tree(context_, &good, &info), COPPICE_ERROR_INVALID_ARGUMENT) << "struct_size";
  coppice_scene_close(context_, scene_);
  log_.clear();
  EXPECT_EQ(coppice_scene_hide(context_, &good, 1), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(mentions(log_, {"trees[0].scene"}));
}

}  // namespace coppice::test::scene_trees_test
