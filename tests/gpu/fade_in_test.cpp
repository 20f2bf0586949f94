// Instances that fade in, and instances that change their slots, through coppice.h on both render paths.

#include <unistd.h>

#include <filesystem>
#include <vector>

#include "context_fixture.h"

namespace coppice::test::fade_in_test {

constexpr std::uint32_t kSidePx = 128, kFrames = 8;

Shot front_view() {
  Shot view = make_view({.eye_m = {0.0f, 0.3f, 5.0f}, .width_px = kSidePx});
  view.error_px = 0.5f;
  return view;
}

struct Path {
  VkBool32 compute_raster;
  std::uint32_t leaf_mesh_count;
};

class FadeInTest : public ContextTest, public testing::WithParamInterface<Path> {
 protected:
  void SetUp() override {
    ContextTest::SetUp();
    ContextDesc with = desc();
    with.compute_raster = GetParam().compute_raster;
    create(with);
  }

  /// All of it is resident, at a place that the camera does not see.
  coppice_plant open_resident() {
    const coppice_plant plant =
        open_random({.leaf_count = 3000, .seed = 5, .leaf_mesh_count = GetParam().leaf_mesh_count, .looks = Looks::noise});
    const coppice_instance hidden = add(plant, placement_at({0.0f, 0.0f, 0.0f}));
    settle(front_view());
    remove({&hidden, 1});
    frame(front_view());
    return plant;
  }

  void fade_in(std::span<const coppice_instance> instances) {
    EXPECT_EQ(coppice_instances_fade_in(context_, instances.data(), static_cast<std::uint32_t>(instances.size()), kFrames), COPPICE_OK)
        << log_;
  }
};

INSTANTIATE_TEST_SUITE_P(Paths, FadeInTest, testing::Values(Path{VK_FALSE, 0}, Path{VK_TRUE, 0}, Path{VK_FALSE, 2}, Path{VK_TRUE, 2}));

TEST_P(FadeInTest, APlantGrowsUpFrameByFrame) {
  const coppice_plant plant = open_resident();
  // What each frame is to look like: the same instance at that share of its size.
  const coppice_instance instance = add(plant, placement_at({0.0f, -1.0f, 0.0f}));
  std::vector<Picture> expected;
  for (std::uint32_t i = 1; i <= kFrames; ++i) {
    move(instance, placement_at({0.0f, -1.0f, 0.0f}, static_cast<float>(i) / kFrames));
    expected.push_back(frame(front_view()));
  }
  EXPECT_LT(3 * drawn_pixels(expected[0]), drawn_pixels(expected.back()));

  fade_in({&instance, 1});
  for (std::uint32_t i = 1; i <= kFrames; ++i) {
    EXPECT_EQ(frame(front_view()).rgba, expected[i - 1].rgba) << i;
    EXPECT_EQ(is_settled(view_), i == kFrames) << i;
  }
  for (int i = 0; i < 3; ++i) EXPECT_EQ(frame(front_view()).rgba, expected.back().rgba) << "it stays";
}

TEST_P(FadeInTest, AMoveDoesNotEndIt) {
  const coppice_plant plant = open_resident();
  const coppice_instance instance = add(plant, placement_at({0.0f, -1.0f, 0.0f}));
  fade_in({&instance, 1});
  frame(front_view());
  move(instance, placement_at({0.5f, -1.0f, 0.0f}));
  const std::size_t early_px = drawn_pixels(frame(front_view()));
  for (std::uint32_t i = 0; i < kFrames; ++i) frame(front_view());
  EXPECT_LT(2 * early_px, drawn_pixels(frame(front_view())));
}

/// Which leaves are drawn, their dither and their cuts go with an instance when it changes its slot.
TEST_P(FadeInTest, SortingChangesNoPicture) {
  const coppice_plant plant = open_resident();
  std::vector<coppice_placement> placements;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const std::uint32_t shuffled = i * 1117 % 3000;
    placements.push_back(
        placement_at({2.0f * static_cast<float>(shuffled % 50) - 50.0f, -1.0f, -4.0f * static_cast<float>(shuffled / 50)}));
    placements.back().leaf_share = 0.5f;
  }
  add(plant, placements);
  const Picture first = frame(front_view());
  EXPECT_GT(drawn_pixels(first), 1000u);
  for (int i = 0; i < 40; ++i) EXPECT_EQ(frame(front_view()).rgba, first.rgba) << i;
}

}  // namespace coppice::test::fade_in_test
