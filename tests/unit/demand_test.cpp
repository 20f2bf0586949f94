#include "demand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

#include "chunk_value.h"
#include "eye_motion.h"
#include "hook_array.h"
#include "results.h"

namespace coppice::demand_test {

using test::hook_array;

/// 90 degrees high, twice as wide as high, looking down -z from `eye`, near plane 0.5 m.
coppice_camera view_from(std::array<float, 3> eye, float depth_scale, float depth_offset) {
  coppice_camera view{};
  view.layer_mask = COPPICE_ALL_LAYERS;
  view.width_px = 1440;
  view.height_px = 720;
  view.error_px = 2.0f;
  for (std::size_t i = 0; i < 4; ++i) view.view_from_world[5 * i] = 1.0f;
  for (std::size_t i = 0; i < 3; ++i) view.view_from_world[12 + i] = -eye[i];
  view.clip_from_view[0] = 0.5f;
  view.clip_from_view[5] = -1.0f;
  view.clip_from_view[10] = depth_scale;
  view.clip_from_view[11] = -1.0f;
  view.clip_from_view[14] = depth_offset;
  return view;
}
coppice_camera reversed_infinite_view(std::array<float, 3> eye) {
  return view_from(eye, 0.0f, 0.5f);
}

/// Instances in blocks, as the instance table keeps them.
struct Blocks {
  std::vector<InstanceSphere> slots;
  std::vector<InstanceBounds> bounds;

  explicit Blocks(std::vector<InstanceSphere> instances) : slots(std::move(instances)) {
    for (std::size_t first = 0; first < slots.size(); first += kInstanceBlockSlots)
      bounds.push_back(instance_bounds(std::span(slots).subspan(first, std::min<std::size_t>(kInstanceBlockSlots, slots.size() - first))));
  }
  operator InstanceBlocks() const { return {slots, bounds}; }
};

TEST(DemandView, ReadsEyeFocalLengthAndNearPlane) {
  const auto view = test::must(demand_view(reversed_infinite_view({1, 2, 3})));
  EXPECT_EQ(view.eye_m, (dvec3{1, 2, 3}));
  EXPECT_FLOAT_EQ(view.focal_px, 360.0f);
  EXPECT_FLOAT_EQ(view.near_m, 0.5f);
  EXPECT_FALSE(view.full);
}

TEST(DemandView, FindsTheNearPlaneWhicheverWayDepthRuns) {
  const float near_m = 0.5f, far_m = 100.0f;
  const auto forward = demand_view(view_from({}, far_m / (near_m - far_m), near_m * far_m / (near_m - far_m)));
  const auto reversed = demand_view(view_from({}, near_m / (far_m - near_m), near_m * far_m / (far_m - near_m)));
  for (const auto& view : {forward, reversed}) EXPECT_NEAR(test::must(view).near_m, near_m, 1e-4f);
}

TEST(DemandView, FollowsARotatedCamera) {
  coppice_camera turned = reversed_infinite_view({});
  // Looks down +x from (4, 0, 0): right is +z, up is +y.
  const float columns[16] = {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 4, 1};
  std::ranges::copy(columns, turned.view_from_world);
  const auto view = test::must(demand_view(turned));
  EXPECT_EQ(view.eye_m, (dvec3{4, 0, 0}));
  const Blocks instances({{{14, 0, 0}, 1.0f, 0}, {{-6, 0, 0}, 1.0f, 1}});
  std::vector<PlantDemand> demands(2);
  measure_demand(instances, view, demands);
  EXPECT_FLOAT_EQ(demands[0].max_size_px, 72.0f) << "ahead";
  EXPECT_FLOAT_EQ(demands[1].max_size_px, 36.0f) << "behind: half";
}

TEST(DemandView, AParallelViewShowsAllDistancesAlike) {
  coppice_camera wide = reversed_infinite_view({0, 0, 5});
  const float depth_per_m = 0.01f;
  wide.clip_from_view[5] = -0.25f;
  wide.clip_from_view[10] = depth_per_m;
  wide.clip_from_view[11] = 0.0f;
  wide.clip_from_view[14] = wide.clip_from_view[15] = 1.0f;
  const auto view = test::must(demand_view(wide));
  EXPECT_TRUE(view.parallel);
  EXPECT_FLOAT_EQ(view.focal_px, 0.125f * static_cast<float>(wide.height_px));
  EXPECT_EQ(size_distance_m(view, {0, 0, -90}), size_distance_m(view, {0, 0, 0}));
  EXPECT_EQ(view.toward_viewer, (vec3{0, 0, 1}));
  EXPECT_FLOAT_EQ(view.eyes[0].key_row.z * -10.0f + view.eyes[0].key_row.w, 0.9f) << "10 m of the 100 m to the far plane";
  EXPECT_NEAR(view.eyes[0].planes[4].w, 0.0f, 1e-5f) << "the near plane goes through the eye";
}

TEST(DemandView, RefusesWhatIsNoView) {
  const auto status_of = [](const std::function<void(coppice_camera&)>& change) {
    coppice_camera view = reversed_infinite_view({});
    change(view);
    return demand_view(view).error().status;
  };
  EXPECT_EQ(status_of([](coppice_camera& view) { view.clip_from_view[11] = 1.0f; }), Status::invalid_argument) << "backwards";
  EXPECT_EQ(status_of([](coppice_camera& view) { view.view_from_world[12] = NAN; }), Status::invalid_argument);
  EXPECT_EQ(status_of([](coppice_camera& view) { view.error_px = 0.0f; }), Status::invalid_argument);
  EXPECT_EQ(status_of([](coppice_camera& view) { view.height_px = 0; }), Status::invalid_argument);
}

TEST(Demand, SortsInstancesBySize) {
  const auto view = test::must(demand_view(reversed_infinite_view({})));
  const Blocks instances({
      {{0, 0, -10}, 1.0f, 0},   // 72 px
      {{0, 0, -11}, 1.0f, 0},   // 65 px: the same bin, 64 to 90 px
      {{0, 0, -100}, 1.0f, 0},  // 7.2 px
      {},                       // a hole
      {{0, 0, -1e6f}, 1.0f, 1},
      {{0, 0, 0}, 1e6f, 1},
  });
  std::vector<PlantDemand> demands(3);
  demands[2].max_size_px = 1.0f;  // from the frame before
  measure_demand(instances, view, demands);
  EXPECT_FLOAT_EQ(demands[0].max_size_px, 72.0f);
  EXPECT_FLOAT_EQ(demands[0].instances[12], 2.0f);
  EXPECT_FLOAT_EQ(demands[0].instances[5], 1.0f);
  EXPECT_FLOAT_EQ(std::accumulate(demands[0].instances.begin(), demands[0].instances.end(), 0.0f), 3.0f);
  EXPECT_FLOAT_EQ(demands[1].instances.front(), 1.0f);
  EXPECT_FLOAT_EQ(demands[1].instances.back(), 1.0f);
  EXPECT_FLOAT_EQ(demands[2].max_size_px, 0.0f);
}

TEST(EyeMotion, FollowsASteadyCameraAndNoOther) {
  EyeMotion motion;
  EXPECT_EQ(follow_eye(motion, {100, 0, 0}, 10.0f), vec3{}) << "one frame is no motion";
  EXPECT_EQ(follow_eye(motion, {101, 0, 0}, 10.0f), vec3{}) << "nor are two: the first may have been a jump";
  EXPECT_EQ(follow_eye(motion, {102, 0, 0}, 10.0f), (vec3{10, 0, 0}));
  EXPECT_EQ(follow_eye(motion, {103, 0.125f, 0}, 8.0f), (vec3{8, 1, 0})) << "a gentle curve";
  EXPECT_EQ(follow_eye(motion, {500, 0, 0}, 10.0f), vec3{}) << "a jump";
  EXPECT_EQ(follow_eye(motion, {500, 0, 1}, 10.0f), vec3{});
  EXPECT_EQ(follow_eye(motion, {500, 0, 1}, 10.0f), vec3{}) << "a stop";
  EXPECT_EQ(follow_eye(motion, {500, 0, 1}, 10.0f), vec3{}) << "and rest";
}

TEST(EyeMotion, WhatWillComeIntoViewIsWanted) {
  const auto view = test::must(demand_view(reversed_infinite_view({})));
  const Blocks instances({{{0, 0, -110}, 1.0f, 0}, {{-5, 0, -8}, 1.0f, 1}});
  std::vector<PlantDemand> now(2), ahead(2), expected(2);
  measure_demand(instances, view, now);
  measure_demand(instances, moved_view(view, {10, 0, -10}), ahead);
  measure_demand(instances, *demand_view(reversed_infinite_view({10, 0, -10})), expected);
  for (std::size_t plant = 0; plant < 2; ++plant) {
    EXPECT_FLOAT_EQ(ahead[plant].max_size_px, expected[plant].max_size_px);
    EXPECT_EQ(ahead[plant].instances, expected[plant].instances);
  }
  merge_demands(now, ahead);
  EXPECT_FLOAT_EQ(now[0].max_size_px, expected[0].max_size_px) << "nearer then";
  EXPECT_GT(now[1].max_size_px, expected[1].max_size_px) << "nearer now";
}

TEST(EyeMotion, OfALargeSceneAPartIsMeasuredInEachFrame) {
  constexpr std::size_t kBlocks = 2 * kAheadBlocks + 1;  // three parts
  std::vector<InstanceSphere> instances(kBlocks * kInstanceBlockSlots, {{0, 0, 0}, 0.0f, InstanceSphere::kNoPlant});
  for (std::size_t i = 0; i < kBlocks; ++i)
    instances[i * kInstanceBlockSlots] = {{static_cast<float>(i % 64) - 32, 0, -static_cast<float>(i / 64)}, 0.5f, i % 2 ? 1u : 0u};
  const Blocks blocks(instances);
  const auto measured_at = [&](float z) {
    std::vector<PlantDemand> demands(2);
    measure_demand(blocks, *demand_view(reversed_infinite_view({0, 0, z})), demands);
    return demands;
  };
  DemandAhead ahead;
  Ledger ledger;
  ASSERT_TRUE(make_room(ahead, default_allocator(), ledger, 2));
  EXPECT_EQ(ledger.reserved(), ahead.measured.bytes() + ahead.finished.bytes());
  const auto add_ahead = [&](float z) {
    std::vector<PlantDemand> demands = measured_at(z);
    add_demand_ahead(ahead, blocks, *demand_view(reversed_infinite_view({0, 0, z})), 20.0f, demands);
    return demands;
  };
  const auto expect_same = [](const std::vector<PlantDemand>& demands, const std::vector<PlantDemand>& expected, int frame) {
    for (std::size_t plant = 0; plant < 2; ++plant) {
      EXPECT_FLOAT_EQ(demands[plant].max_size_px, expected[plant].max_size_px) << frame;
      for (std::size_t bin = 0; bin < kSizeBinCount; ++bin)
        EXPECT_NEAR(demands[plant].instances[bin], expected[plant].instances[bin], 1.0f) << frame;
    }
  };
  float z = 100.0f;
  const auto with_ahead = [&](float from_z) {
    std::vector<PlantDemand> expected = measured_at(z);
    merge_demands(expected, measured_at(from_z - 23.0f));
    return expected;
  };
  // Two frames say where the eye goes, three measure: then there is what an eye of the third sees, 20 frames and the parts' on.
  for (int frame = 1; frame <= 9; ++frame) {
    z -= 1.0f;
    expect_same(add_ahead(z), frame < 5 ? measured_at(z) : with_ahead(frame < 8 ? 97.0f : 94.0f), frame);
  }
  // A frame of half another's length more: the measurement goes on, and ends with frame 11.
  z -= 1.5f;
  expect_same(add_ahead(z), with_ahead(94.0f), 10);
  z -= 1.0f;
  expect_same(add_ahead(z), with_ahead(91.0f), 11);
  for (int frame = 12; frame <= 15; ++frame) {
    const std::vector<PlantDemand> demands = add_ahead(z);
    if (frame == 15) expect_same(demands, measured_at(z), frame);  // who stands still has demand for what is in view
  }
}

TEST(Demand, CountsWhatIsOutsideForLess) {
  const auto view = test::must(demand_view(reversed_infinite_view({})));
  const auto weight = [&](const dvec3& center) {
    const Blocks instances({{center, 1.0f, 0}});
    std::vector<PlantDemand> demands(1);
    measure_demand(instances, view, demands);
    return std::accumulate(demands[0].instances.begin(), demands[0].instances.end(), 0.0f);
  };
  EXPECT_FLOAT_EQ(weight({0, 0, -10}), 1.0f);
  EXPECT_FLOAT_EQ(weight({20.5f, 0, -10}), 1.0f) << "its edge is in view";
  EXPECT_FLOAT_EQ(weight({22.5f, 0, -10}), kOutsideWeight);
  EXPECT_FLOAT_EQ(weight({0, 11, -10}), 1.0f);
  EXPECT_FLOAT_EQ(weight({0, 12, -10}), kOutsideWeight);
  EXPECT_FLOAT_EQ(weight({0, -12, -10}), kOutsideWeight);
  EXPECT_FLOAT_EQ(weight({0, 0, 10}), kOutsideWeight);
  EXPECT_FLOAT_EQ(weight({0, 0, 1.1f}), kOutsideWeight) << "behind the eye, though all sides reach it";
}

/// What wind may move into view counts as in view, alone and in a block.
TEST(Demand, WindBringsPlantsIntoView) {
  LodView view = *demand_view(reversed_infinite_view({}));
  view.looks_around = false;
  const auto size_px = [&](float y) {
    std::vector<InstanceSphere> slots(kInstanceBlockSlots, {{0, y, -100}, 1.0f, 0});
    float largest_px = 0;
    for (const std::size_t count : {std::size_t{1}, slots.size()}) {
      std::vector<PlantDemand> demands(1);
      measure_demand(Blocks({slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(count)}), view, demands);
      EXPECT_TRUE(largest_px == 0 || demands[0].max_size_px > 0) << "the block does as the plant does";
      largest_px = std::max(largest_px, demands[0].max_size_px);
    }
    return largest_px;
  };
  // The upper plane is at 45 degrees: a sphere of 1 m ends at a height of 100 m and root of 2 of them.
  const float edge_m = 100.0f + std::sqrt(2.0f);
  EXPECT_GT(size_px(edge_m - 0.01f), 0.0f);
  EXPECT_EQ(size_px(edge_m + 0.04f), 0.0f);
  view.reach_share = 0.05f;  // in a gale
  EXPECT_GT(size_px(edge_m + 0.04f), 0.0f);
  EXPECT_EQ(size_px(edge_m + 0.1f), 0.0f);
}

/// A square of plants of two species and different sizes, block after block; every seventh slot is a hole.
std::vector<InstanceSphere> plantation(int side, float step_m, std::uint32_t plants_in_a_block) {
  std::vector<InstanceSphere> instances;
  for (int i = 0; i < side * side; ++i) {
    const int block = i / static_cast<int>(kInstanceBlockSlots), place = i % static_cast<int>(kInstanceBlockSlots);
    const int x = block % (side / 8) * 8 + place % 8, z = block / (side / 8) * 4 + place / 8;
    const float radius_m = 1.0f + 0.2f * static_cast<float>(i % 5);
    const auto plant = plants_in_a_block == 2 ? static_cast<std::uint32_t>(i % 2) : static_cast<std::uint32_t>(block % 2);
    instances.push_back({{step_m * static_cast<float>(x), 0.0f, step_m * static_cast<float>(z)}, radius_m, plant});
    if (i % 7 == 3) instances.back() = {};
  }
  return instances;
}

/// Every instance as a block of its own: nothing is taken together.
std::vector<PlantDemand> demand_one_by_one(const std::vector<InstanceSphere>& instances, const LodView& view) {
  std::vector<PlantDemand> sums(2), demands(2);
  for (const InstanceSphere& instance : instances) {
    measure_demand(Blocks({instance}), view, demands);
    for (std::size_t plant = 0; plant < sums.size(); ++plant) {
      sums[plant].max_size_px = std::max(sums[plant].max_size_px, demands[plant].max_size_px);
      for (std::size_t bin = 0; bin < kSizeBinCount; ++bin) sums[plant].instances[bin] += demands[plant].instances[bin];
    }
  }
  return sums;
}

TEST(Demand, OfBlocksIsThatOfTheirInstancesGiveOrTakeABin) {
  for (const std::uint32_t plants_in_a_block : {1u, 2u}) {
    const std::vector<InstanceSphere> instances = plantation(96, 4.0f, plants_in_a_block);
    for (const std::array<float, 3> eye : {std::array<float, 3>{190, 2, 190}, {190, 2, 500}, {190, 300, 2000}, {190, 2, -50}}) {
      const auto view = test::must(demand_view(reversed_infinite_view(eye)));
      std::vector<PlantDemand> demands(2);
      measure_demand(Blocks(instances), view, demands);
      const std::vector<PlantDemand> exact = demand_one_by_one(instances, view);
      for (std::size_t plant = 0; plant < 2; ++plant) {
        SCOPED_TRACE(testing::Message() << plants_in_a_block << " plants a block, eye at " << eye[2] << ", plant " << plant);
        EXPECT_GE(demands[plant].max_size_px, exact[plant].max_size_px) << "never taken for smaller";
        EXPECT_LE(demands[plant].max_size_px, 1.2f * exact[plant].max_size_px);
        float sum = 0.0f, exact_sum = 0.0f, moved = 0.0f;
        for (std::size_t bin = 0; bin < kSizeBinCount; ++bin) {
          sum += demands[plant].instances[bin];
          exact_sum += exact[plant].instances[bin];
          moved += std::abs(sum - exact_sum);  // earth mover's: instances times bins
        }
        EXPECT_NEAR(sum, exact_sum, 1e-3f * exact_sum) << "none is lost";
        EXPECT_LE(moved, exact_sum) << "a bin each at most";
      }
    }
  }
}

TEST(InstanceBounds, HoldEveryInstanceAndSkipHoles) {
  const std::vector<InstanceSphere> slots = {{{0, 0, 0}, 1.0f, 3}, {}, {{10, 0, 0}, 3.0f, 3}};
  const InstanceBounds bounds = instance_bounds(slots);
  EXPECT_EQ(bounds.instance_count, 2u);
  EXPECT_EQ(bounds.plant, 3u);
  EXPECT_FLOAT_EQ(bounds.max_instance_radius_m, 3.0f);
  EXPECT_FLOAT_EQ(bounds.mean_demand_radius_m, 2.0f);
  EXPECT_DOUBLE_EQ(bounds.center_m[0], 6.0) << "half way from -1 to 13";
  EXPECT_FLOAT_EQ(bounds.radius_m, 7.0f);
  EXPECT_EQ(instance_bounds(std::vector<InstanceSphere>{{{0, 0, 0}, 1.0f, 3}, {{0, 0, 0}, 1.0f, 4}}).plant, InstanceBounds::kMixedPlants);
  EXPECT_LT(instance_bounds(std::vector<InstanceSphere>(5)).radius_m, 0.0f);
}

TEST(InstanceBounds, KnowLayersThatAllHaveAndThatSomeHave) {
  const auto in_layers = [](std::uint32_t mask) { return InstanceSphere{.radius_m = 1.0f, .plant = 3, .layer_mask = mask}; };
  const InstanceBounds bounds = instance_bounds(std::vector{in_layers(0b0111), InstanceSphere{}, in_layers(0b1101)});
  EXPECT_EQ(bounds.all_layers, 0b0101u);
  EXPECT_EQ(bounds.any_layer, 0b1111u);
}

/// One level table and two wood LoDs of 1600 and 100 triangles: errors size / 80 and size / 20.
struct Plant {
  HookArray<std::uint32_t> words;
  ValuedPlant valued;
  PlantFile file;

  Plant() {
    file.plant.leaf_count = 1;
    file.error_leaf_counts = hook_array<std::uint32_t>({1});
    file.error_sizes_px = hook_array<float>({10.0f, 100.0f});
    file.error_px = hook_array<float>({0.0f, 0.0f});
    file.plant.wood_lod_count = 2;
    file.wood_error_px = hook_array<float>({0.125f, 1.25f, 0.5f, 5.0f});
    words = *pack_lod_table(file, default_allocator());
    valued = {lod_table(file, words), 1, 1};
  }
};

TEST(ChunkValue, OfWoodIsTheVisibleErrorItRemovesPerByte) {
  const Plant plant;
  const LodView view{.error_px = 2.0f};
  PlantDemand demand;
  demand.max_size_px = 200.0f;
  demand.instances[15] = 3.0f;  // 181 to 256 px, here at most 200
  const DemandedDetail demanded = demanded_detail(plant.valued, demand, view);
  EXPECT_EQ(demanded.finest_wood, 0u);
  // Errors 10 and 2.5 px, both above the threshold.
  EXPECT_NEAR(wood_value(plant.valued, demanded, demand, view, 0, 1000), 3.0f * 7.5f / 1000.0f, 1e-5f);
  demand.max_size_px = 15.0f;
  EXPECT_EQ(demanded_detail(plant.valued, demand, view).finest_wood, 1u) << "1.3 px is good enough";
  EXPECT_EQ(wood_value(plant.valued, demanded_detail(plant.valued, demand, view), demand, view, 0, 1000), 0.0f);
}

TEST(ChunkValue, NothingInViewWantsNothing) {
  const Plant plant;
  const DemandedDetail demanded = demanded_detail(plant.valued, {}, {});
  EXPECT_EQ(demanded.page_count, 0u);
  EXPECT_EQ(demanded.finest_wood, 2u);
  EXPECT_EQ(demanded.max_texture_bytes, 0u);
  EXPECT_EQ(texture_value(demanded, {}, 100), 0.0f);
}

}  // namespace coppice::demand_test
