// Shadow maps: what a view of the sun holds, and what it darkens, on both paths.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "path_fixture.h"
#include "shadow_map.h"

namespace coppice::test::shadow_test {

constexpr float kRadius_m = 12.0f;

/// Three plants: one stands between the sun and the second, 8 m off; the third stands beside them, in the open.
constexpr std::array<glm::vec3, 3> kPlaces{{{6.4f, 4.8f, 0.0f}, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -6.0f}}};
constexpr std::array<float, 3> kSun{0.8f, 0.6f, 0.0f};

/// From a side that the sun is on, so that what it does not reach is seen to be dark.
Shot view_of(const glm::vec3& place) {
  Shot view = make_view({.eye_m = place + glm::vec3(3.0f, -1.0f, 4.0f), .target_m = place, .width_px = 128});
  std::ranges::copy(kSun, view.light.sun_direction);
  view.error_px = 0.5f;
  return view;
}

/// Sum of what is not white.
double light_of(const Picture& picture) {
  double light = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
    if (picture.rgba[i] < 250 || picture.rgba[i + 1] < 250 || picture.rgba[i + 2] < 250)
      light += picture.rgba[i] + picture.rgba[i + 1] + picture.rgba[i + 2];
  return light;
}

class ShadowTest : public PathTest<ContextWithMapTest> {
 protected:
  void SetUp() override {
    PathTest::SetUp();
    create_map_view();
  }

  void place(const glm::vec3& at) { add(plant_, placement_at(at)); }

  [[nodiscard]] Shot sun_view(const Shot& camera) const { return sun_of(camera, {.radius_m = kRadius_m}); }

  /// The light of a plant seen with the shadow map over that seen without.
  double share_of_light(const glm::vec3& place) {
    Shot camera = view_of(place);
    settle(camera);
    const double open = light_of(frame(camera));
    return light_of(frame_with_map(camera, {.radius_m = kRadius_m})) / open;
  }
};

TEST_P(ShadowTest, APlantShadesWhatStandsBehindItAndNothingElse) {
  for (const glm::vec3& at : kPlaces) place(at);
  EXPECT_EQ(share_of_light(kPlaces[0]), 1.0) << "the plant that casts the shadow";
  EXPECT_LT(share_of_light(kPlaces[1]), 0.8) << "the plant behind it";
  EXPECT_EQ(share_of_light(kPlaces[2]), 1.0) << "the plant in the open";
}

TEST_P(ShadowTest, TheFirstMapThatHoldsAPlaceDecidesWhereverItIsInTheList) {
  for (const glm::vec3& at : kPlaces) place(at);
  const Shot camera = view_of(kPlaces[1]);
  settle(camera);
  const Picture open = frame(camera), shaded = frame_with_map(camera, {.radius_m = kRadius_m});
  EXPECT_NE(shaded.rgba, open.rgba);
  for (std::uint32_t others = 1; others < COPPICE_MAX_SHADOW_MAPS; ++others)
    EXPECT_EQ(frame_with_map(camera, {.radius_m = kRadius_m}, others).rgba, shaded.rgba) << others;
}

TEST_P(ShadowTest, TheMapHoldsThePlantWhereItStands) {
  place(kPlaces[0]);
  const Shot camera = view_of(kPlaces[0]);
  settle(camera);
  const Shot sun = sun_view(camera);
  frame(camera, [&](VkCommandBuffer cmd) { record_map(cmd, sun); }, {&sun, 1});
  const std::vector<float> depth = read_floats(gpu(), map_, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  // It stands on the ray to the sun from the map's middle, and it is about 3 m wide; the map is 24 m wide.
  std::uint32_t inside = 0, outside = 0, off_depth = 0;
  const glm::mat4 projection = glm::make_mat4(sun.clip_from_view);
  for (std::uint32_t y = 0; y < kMapPx; ++y)
    for (std::uint32_t x = 0; x < kMapPx; ++x) {
      const float value = depth[y * kMapPx + x];
      if (value == 0.0f) continue;
      const float from_middle_m = 2.0f * kRadius_m / kMapPx * std::hypot(static_cast<float>(x) - 127.5f, static_cast<float>(y) - 127.5f);
      ++(from_middle_m < 2.0f ? inside : outside);
      const float from_eye_m = (projection[3][2] - value) / projection[2][2];
      off_depth += std::abs(from_eye_m - (4.0f * kRadius_m - 8.0f)) > 2.0f;
    }
  EXPECT_GT(inside, 200u);
  EXPECT_EQ(outside, 0u);
  EXPECT_EQ(off_depth, 0u);
}

TEST_P(ShadowTest, TheEdgeOfAShadowIsAsSoftAsATexelIsWide) {
  place(kPlaces[1]);
  Shot camera = view_of(kPlaces[1]);
  settle(camera);
  // A map whose texels are as wide as the plant, all of one half before the plant: as it moves over the plant, light only grows.
  const coppice_shadow_map middle = map_of(sun_of(camera, {.radius_m = 200.0f}));
  for (const int axis : {0, 1}) {
    const VkClearAttachment near{VK_IMAGE_ASPECT_DEPTH_BIT, 0, {.depthStencil = {1.0f, 0}}};
    const VkClearRect half{{{}, {axis == 0 ? kMapPx / 2 : kMapPx, axis == 1 ? kMapPx / 2 : kMapPx}}, 0, 1};
    std::vector<double> light;
    for (int step = -16; step <= 16; ++step) {
      coppice_shadow_map map = middle;
      map.clip_from_world[12 + axis] += step / 8.0 * 2.0 / kMapPx;
      camera.light.shadow_maps = &map;
      camera.light.shadow_map_count = 1;
      const auto record = [&](VkCommandBuffer cmd) { record_map(cmd, [&] { vkCmdClearAttachments(cmd, 1, &near, 1, &half); }); };
      light.push_back(light_of(frame(camera, record)));
    }
    EXPECT_LT(light.front(), 0.8 * light.back()) << "along axis " << axis;
    EXPECT_TRUE(std::ranges::is_sorted(light)) << "along axis " << axis << ": " << testing::PrintToString(light);
  }
}

TEST_P(ShadowTest, AShadowViewHasStatisticsOfItsOwn) {
  for (const glm::vec3& at : kPlaces) place(at);
  const Shot camera = view_of(kPlaces[1]);
  settle(camera);
  frame(camera);
  const coppice_view_stats plain = view_stats();
  const Shot sun = sun_view(camera);
  for (int i = 0; i < 3; ++i) frame(camera, [&](VkCommandBuffer cmd) { record_map(cmd, sun); }, {&sun, 1});
  EXPECT_GT(view_stats(map_view_).drawn_leaf_count, 0u);
  EXPECT_NE(view_stats(map_view_).drawn_leaf_count, plain.drawn_leaf_count);
  EXPECT_EQ(view_stats().drawn_leaf_count, plain.drawn_leaf_count);
  EXPECT_EQ(view_stats().visible_instance_count, plain.visible_instance_count);
}

TEST_P(ShadowTest, AMapBeforeItChangesNothingInThePicture) {
  // Drawn as modelled to the camera and as quads to the sun: what the one view counts is not the other's.
  plant_ = open_random({.leaf_count = 300, .seed = 6, .leaf_mesh_count = 2});
  place(kPlaces[1]);
  Shot camera = view_of(kPlaces[1]);
  camera.error_px = 0.1f;
  settle(camera);
  const Picture plain = frame(camera);
  const Shot sun = sun_view(camera);
  EXPECT_EQ(frame(camera, [&](VkCommandBuffer cmd) { record_map(cmd, sun); }, {&sun, 1}).rgba, plain.rgba);
  EXPECT_GT(light_of(plain), 0.0);
  frame(camera);
  EXPECT_EQ(view_stats().leaf_mesh_instance_count, GetParam().compute_raster == VK_TRUE ? 0u : 1u)
      << "the rasteriser takes leaves this small";
}

// A descriptor set that is written while a command buffer holds it makes that invalid.
TEST_P(ShadowTest, AFrameOnItsWayKeepsItsImages) {
  for (const glm::vec3& at : kPlaces) place(at);
  Shot camera = view_of(kPlaces[1]);
  settle(camera);
  const Picture expected = frame_with_map(camera, {.radius_m = kRadius_m});
  const Shot sun = sun_view(camera);
  const coppice_shadow_map map = map_of(sun);
  camera.light.shadow_maps = &map;
  camera.light.shadow_map_count = 1;
  const std::array shots{sun, camera};
  const auto before = [&](VkCommandBuffer cmd) {
    record_upload(cmd);
    record_map(cmd, sun);
    record_cull(cmd, camera);
  };
  Picture next;
  begin(shots);
  const Picture picture = draw_on_white(gpu(), camera, before, [&](VkCommandBuffer cmd) {
    record_draw(cmd, camera);
    frames_behind_ = 1;  // the next frame is recorded before this one is submitted
    begin(shots);
    next = draw_on_white(gpu(), camera, before, [&](VkCommandBuffer of_next) { record_draw(of_next, camera); });
    frames_behind_ = 0;
  });
  EXPECT_EQ(picture.rgba, expected.rgba);
  EXPECT_EQ(next.rgba, expected.rgba);
}

INSTANTIATE_TEST_SUITE_P(Paths, ShadowTest, testing::Values(kHardwarePath, kComputePath, kTwoPassPath), path_name);

}  // namespace coppice::test::shadow_test
