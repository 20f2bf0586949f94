// Large worlds, and what instances may be asked for, on both paths.

#include <algorithm>
#include <array>

#include "golden.h"
#include "path_fixture.h"
#include "shadow_map.h"

namespace coppice::test::world_test {

using Offset = std::array<double, 3>;

coppice_placement placed(double x, double z, const Offset& offset = {}) {
  return placement_at({x + offset[0], offset[1], z + offset[2]});
}

/// The same view of a world that has been moved.
Shot moved(Shot view, const Offset& by) {
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t i = 0; i < 3; ++i) view.view_from_world[12 + row] -= view.view_from_world[4 * i + row] * by[i];
  return view;
}

/// Pixels that differ by more than roundings of colours do.
double differing_pixels(const Picture& expected, const Picture& actual) {
  return compare_pictures(expected, actual, 3).differing_share * static_cast<double>(expected.rgba.size()) / 4;
}
/// An edge may go through the middle of as many: which side they are on is a matter of rounding, and so of the compiler.
constexpr double kEdgePixels = 2.5;

class WorldTest : public PathTest<ContextWithMapTest> {
 protected:
  void SetUp() override {
    PathTest::SetUp();
    create_map_view();
  }

  std::vector<coppice_instance> add(const std::vector<coppice_placement>& placements) { return PathTest::add(plant_, placements); }
  void move(const std::vector<coppice_instance>& handles, const std::vector<coppice_placement>& placements) {
    ASSERT_EQ(coppice_instances_move(context_, handles.data(), placements.data(), sizeof(coppice_placement),
                                     static_cast<std::uint32_t>(handles.size())),
              COPPICE_OK)
        << log_;
  }
  static Shot view_from(float distance_m) { return make_view({.eye_m = {1.0f, 0.8f, distance_m}, .width_px = 192, .error_px = 1.0f}); }

  /// With the shadow map of what stands about `center`.
  Picture shadowed(Shot camera, const Offset& center) {
    settle(camera);
    return frame_with_map(camera, {.center = center});
  }
};

std::vector<coppice_placement> grove(const Offset& offset) {
  // The last shades the first; those at the back are small on screen.
  std::vector<coppice_placement> all{placed(0, 0, offset), placed(-2, -3, offset), placed(3, -20, offset), placed(-6, -40, offset)};
  all.push_back(placed(2.5, 3.0, offset));
  all.back().position[1] += 3.0;  // towards the sun
  return all;
}

TEST_P(WorldTest, TenThousandKilometresAwayThePictureIsTheSame) {
  constexpr Offset kFar{1e7 + 0.4, 812.3, -9.87654321e6};
  // Aside, as edges that go through the middle of pixels show roundings of any size.
  Shot view = moved(view_from(7.0f), {0.0137, 0.0, 0.0});
  view.light.fog_density = 0.02f;
  const std::vector<coppice_instance> here = add(grove({}));
  const Picture at_origin = shadowed(view, {});
  remove(here);
  add(grove(kFar));
  const Picture far = shadowed(moved(view, kFar), kFar);
  EXPECT_GT(count_pixels(at_origin, [](const std::uint8_t* pixel) { return std::min({pixel[0], pixel[1], pixel[2]}) < 250; }), 2000u);
  EXPECT_LT(differing_pixels(at_origin, far), kEdgePixels);
  EXPECT_GT(differing_pixels(at_origin, frame(moved(view, kFar))), 50.0) << "the shadows are seen";
}

TEST_P(WorldTest, AnOriginThatMovesChangesNothing) {
  constexpr Offset kBack{-50000.0, -20.0, 7000.0}, kFrom{50000.0, 20.0, -7000.0};
  Shot view = view_from(7.0f);
  view.light.fog_density = 0.02f;
  std::vector<coppice_instance> handles = add(grove({}));
  const Picture before = shadowed(view, {});
  const coppice_stats loaded = stats();
  ASSERT_EQ(coppice_set_origin(context_, kFrom.data()), COPPICE_OK) << log_;
  EXPECT_LT(differing_pixels(before, shadowed(moved(view, kBack), kBack)), kEdgePixels);
  move(handles, grove(kBack));
  EXPECT_LT(differing_pixels(before, shadowed(moved(view, kBack), kBack)), kEdgePixels) << "placements count from it too";
  EXPECT_EQ(stats().bytes_read, loaded.bytes_read);
  EXPECT_EQ(streamed().loaded, loaded.streamed[COPPICE_STREAMED_ALL].loaded);
  EXPECT_EQ(streamed().evicted, 0u);
}

TEST_P(WorldTest, LeavesFallOneAfterTheOther) {
  for (const float distance_m : {5.0f, 14.0f, 60.0f}) {
    Shot view = view_from(distance_m);
    std::vector<coppice_placement> placements{placed(0, 0)};
    const std::vector<coppice_instance> handles = add(placements);
    settle(view);
    std::size_t last = drawn_pixels(frame(view));
    const std::size_t all = last;
    EXPECT_GT(all, 20u) << distance_m;
    for (const float share : {0.9f, 0.7f, 0.5f, 0.3f, 0.15f, 0.05f, 0.0f}) {
      placements[0].leaf_share = share;
      move(handles, placements);
      const std::size_t now = drawn_pixels(frame(view));
      EXPECT_LE(now, last) << share << " of the leaves, " << distance_m << " m away";
      last = now;
    }
    frame(view);
    EXPECT_LT(static_cast<double>(last), 0.4 * static_cast<double>(all)) << "wood at most, " << distance_m << " m away";
    EXPECT_EQ(view_stats().drawn_leaf_count, 0u);
    remove(handles);
  }
}

TEST_P(WorldTest, LayersAreDrawnWhereMasksMeet) {
  std::vector<coppice_placement> placements{placed(-1.5, 0), placed(1.5, 0)};
  placements[0].layer_mask = 0b01;
  placements[1].layer_mask = 0b10;
  add(placements);
  Shot view = view_from(9.0f);
  const auto visible = [&](std::uint32_t mask) {
    view.layer_mask = mask;
    settle(view);
    frame(view);
    frame(view);
    return view_stats().visible_instance_count;
  };
  EXPECT_EQ(visible(COPPICE_ALL_LAYERS), 2u);
  EXPECT_EQ(visible(0b01), 1u);
  EXPECT_EQ(visible(0b10), 1u);
  EXPECT_EQ(visible(0b100), 0u);
}

TEST_P(WorldTest, ABiasIsAnotherThreshold) {
  std::vector<coppice_placement> placements{placed(0, 0)};
  Shot view = view_from(9.0f);
  view.error_px = 4.0f;
  const std::vector<coppice_instance> handles = add(placements);
  settle(view);
  const Picture coarse = frame(view);
  frame(view);
  const std::uint64_t leaves = view_stats().drawn_leaf_count;
  view.error_px = 1.0f;
  settle(view);
  EXPECT_GT(rmse(frame(view), coarse), 1.0);
  placements[0].lod_bias = 2.0f;
  move(handles, placements);
  settle(view);
  EXPECT_LT(rmse(frame(view), coarse), 0.5);
  frame(view);
  EXPECT_EQ(view_stats().drawn_leaf_count, leaves);
}

TEST_P(WorldTest, RecordsMayBeShorterAndLarger) {
  struct Larger {
    coppice_placement placement;
    double other[5];
  };
  std::vector<Larger> larger{{placed(-1.5, 0), {}}, {placed(1.5, 0), {}}};
  ASSERT_EQ(coppice_instances_add(context_, plant_, &larger[0].placement, sizeof(Larger), 2, nullptr), COPPICE_OK) << log_;
  const std::array<double, 3> position{0, 0, -4};
  ASSERT_EQ(
      coppice_instances_add(context_, plant_, reinterpret_cast<const coppice_placement*>(position.data()), sizeof position, 1, nullptr),
      COPPICE_OK)
      << log_;
  const Shot view = view_from(12.0f);
  settle(view);
  frame(view);
  frame(view);
  EXPECT_EQ(view_stats().visible_instance_count, 3u);
  EXPECT_EQ(coppice_instances_add(context_, plant_, &larger[0].placement, 8, 1, nullptr), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(log_.find("stride"), std::string::npos) << log_;
}

INSTANTIATE_TEST_SUITE_P(Paths, WorldTest, testing::Values(kHardwarePath, Path{"compute", VK_TRUE, VK_FALSE}), path_name);

}  // namespace coppice::test::world_test
