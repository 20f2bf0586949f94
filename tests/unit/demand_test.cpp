#include "demand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "chunk_value.h"

namespace coppice {
namespace {

/// 90 degrees high, twice as wide as high, looking down -z from `eye`, near plane 0.5 m.
coppice_view view_from(std::array<float, 3> eye, float depth_scale, float depth_offset) {
  coppice_view view{};
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
coppice_view reversed_infinite_view(std::array<float, 3> eye) {
  return view_from(eye, 0.0f, 0.5f);
}

TEST(DemandView, ReadsEyeFocalLengthAndNearPlane) {
  const auto view = demand_view(reversed_infinite_view({1, 2, 3}));
  ASSERT_TRUE(view);
  EXPECT_EQ(view->lod.eye_m, (std::array<float, 3>{1, 2, 3}));
  EXPECT_FLOAT_EQ(view->lod.focal_px, 360.0f);
  EXPECT_FLOAT_EQ(view->lod.near_m, 0.5f);
  EXPECT_FALSE(view->lod.full);
}

TEST(DemandView, FindsTheNearPlaneWhicheverWayDepthRuns) {
  const float near_m = 0.5f, far_m = 100.0f;
  const auto forward = demand_view(view_from({}, far_m / (near_m - far_m), near_m * far_m / (near_m - far_m)));
  const auto reversed = demand_view(view_from({}, near_m / (far_m - near_m), near_m * far_m / (far_m - near_m)));
  ASSERT_TRUE(forward);
  ASSERT_TRUE(reversed);
  EXPECT_NEAR(forward->lod.near_m, near_m, 1e-4f);
  EXPECT_NEAR(reversed->lod.near_m, near_m, 1e-4f);
}

TEST(DemandView, FollowsARotatedCamera) {
  coppice_view turned = reversed_infinite_view({});
  // Looks down +x from (4, 0, 0): right is +z, up is +y.
  const float columns[16] = {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 4, 1};
  std::ranges::copy(columns, turned.view_from_world);
  const auto view = demand_view(turned);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->lod.eye_m, (std::array<float, 3>{4, 0, 0}));
  const std::vector<InstanceSphere> instances = {{{14, 0, 0}, 1.0f, 0}, {{-6, 0, 0}, 1.0f, 1}};
  std::vector<PlantDemand> demands(2);
  measure_demand(instances, *view, demands);
  EXPECT_FLOAT_EQ(demands[0].max_size_px, 72.0f) << "ahead";
  EXPECT_FLOAT_EQ(demands[1].max_size_px, 36.0f) << "behind: half";
}

TEST(DemandView, RefusesWhatIsNoPerspectiveView) {
  const auto refused = [](coppice_view view) {
    const auto result = demand_view(view);
    return !result && result.error().status == Status::invalid_argument;
  };
  coppice_view orthographic = reversed_infinite_view({});
  orthographic.clip_from_view[11] = 0.0f;
  orthographic.clip_from_view[15] = 1.0f;
  EXPECT_TRUE(refused(orthographic));
  coppice_view not_finite = reversed_infinite_view({});
  not_finite.view_from_world[12] = NAN;
  EXPECT_TRUE(refused(not_finite));
  coppice_view no_threshold = reversed_infinite_view({});
  no_threshold.error_px = 0.0f;
  EXPECT_TRUE(refused(no_threshold));
  coppice_view no_height = reversed_infinite_view({});
  no_height.height_px = 0;
  EXPECT_TRUE(refused(no_height));
}

TEST(Demand, SortsInstancesBySize) {
  const auto view = demand_view(reversed_infinite_view({}));
  ASSERT_TRUE(view);
  const std::vector<InstanceSphere> instances = {
      {{0, 0, -10}, 1.0f, 0},   // 72 px
      {{0, 0, -11}, 1.0f, 0},   // 65 px: the same bin, 64 to 90 px
      {{0, 0, -100}, 1.0f, 0},  // 7.2 px
      {},                       // a hole
      {{0, 0, -1e6f}, 1.0f, 1},
      {{0, 0, 0}, 1e6f, 1},
  };
  std::vector<PlantDemand> demands(3);
  demands[2].max_size_px = 1.0f;  // from the frame before
  measure_demand(instances, *view, demands);
  EXPECT_FLOAT_EQ(demands[0].max_size_px, 72.0f);
  EXPECT_FLOAT_EQ(demands[0].instances[12], 2.0f);
  EXPECT_FLOAT_EQ(demands[0].instances[5], 1.0f);
  EXPECT_FLOAT_EQ(std::accumulate(demands[0].instances.begin(), demands[0].instances.end(), 0.0f), 3.0f);
  EXPECT_FLOAT_EQ(demands[1].instances.front(), 1.0f);
  EXPECT_FLOAT_EQ(demands[1].instances.back(), 1.0f);
  EXPECT_FLOAT_EQ(demands[2].max_size_px, 0.0f);
}

TEST(Demand, CountsWhatIsOutsideForLess) {
  const auto view = demand_view(reversed_infinite_view({}));
  ASSERT_TRUE(view);
  const auto weight = [&](std::array<float, 3> center) {
    const std::vector<InstanceSphere> instances = {{center, 1.0f, 0}};
    std::vector<PlantDemand> demands(1);
    measure_demand(instances, *view, demands);
    return std::accumulate(demands[0].instances.begin(), demands[0].instances.end(), 0.0f);
  };
  EXPECT_FLOAT_EQ(weight({0, 0, -10}), 1.0f);
  EXPECT_FLOAT_EQ(weight({20.5f, 0, -10}), 1.0f) << "its edge is in view";
  EXPECT_FLOAT_EQ(weight({22.5f, 0, -10}), kOutsideWeight);
  EXPECT_FLOAT_EQ(weight({0, 11, -10}), 1.0f);
  EXPECT_FLOAT_EQ(weight({0, 12, -10}), kOutsideWeight);
  EXPECT_FLOAT_EQ(weight({0, -12, -10}), kOutsideWeight);
  EXPECT_FLOAT_EQ(weight({0, 0, 10}), kOutsideWeight);
}

/// One level table and two wood LoDs of 1600 and 100 triangles: errors size / 80 and size / 20.
struct Plant {
  std::vector<std::uint32_t> words;
  ValuedPlant valued;
  PlantFile file;

  Plant() {
    file.plant.leaf_count = 1;
    file.error_leaf_counts = {1};
    file.error_sizes_px = {100.0f};
    file.error_px = {0.0f};
    file.plant.wood_lod_count = 2;
    file.plant.wood_triangle_counts[0] = 1600;
    file.plant.wood_triangle_counts[1] = 100;
    words = pack_lod_table(file);
    valued = {lod_table(file, words), 1, 1};
  }
};

TEST(ChunkValue, OfWoodIsTheVisibleErrorItRemovesPerByte) {
  const Plant plant;
  const LodView view{.error_px = 2.0f};
  PlantDemand demand;
  demand.max_size_px = 200.0f;
  demand.instances[15] = 3.0f;  // 181 to 256 px, here at most 200
  const PlantWants wants = plant_wants(plant.valued, demand, view);
  EXPECT_EQ(wants.finest_wood, 0u);
  // Errors 10 and 2.5 px, both above the threshold.
  EXPECT_NEAR(wood_value(plant.valued, wants, demand, view, 0, 1000), 3.0f * 7.5f / 1000.0f, 1e-5f);
  demand.max_size_px = 30.0f;
  EXPECT_EQ(plant_wants(plant.valued, demand, view).finest_wood, 1u) << "1.5 px is good enough";
  EXPECT_EQ(wood_value(plant.valued, plant_wants(plant.valued, demand, view), demand, view, 0, 1000), 0.0f);
}

TEST(ChunkValue, NothingInViewWantsNothing) {
  const Plant plant;
  const PlantWants wants = plant_wants(plant.valued, {}, {});
  EXPECT_EQ(wants.page_count, 0u);
  EXPECT_EQ(wants.finest_wood, 2u);
  EXPECT_FALSE(wants.textures);
  EXPECT_EQ(texture_value(wants, {}, 100), 0.0f);
}

}  // namespace
}  // namespace coppice
