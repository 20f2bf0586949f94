// Light in a crown: what the grid says of crowns whose optical depth is known.

#include "crown_light.h"

#include <cmath>

#include <gtest/gtest.h>

#include "coppice/format.h"

namespace coppice::gpu::crown_light_test {

constexpr std::uint32_t kLargest = COPPICE_QUANTISED_MAX;

/// Small square leaves of three directions in turn, side by side in a box of `size` m about the origin, in cells of a grid of `side`^3.
struct Cloud {
  std::vector<PageNode> nodes;
  std::vector<CardLook> looks{{.albedo = {}, .coverage = 1.0f, .mask = {}}};
  LeafBox box;
  float depth_per_m = 0;  ///< optical depth, with leaves of all directions
  std::uint32_t leaf_count = 0;

  /// keep: whether the cell at a place, 0..1 along each axis, has a leaf
  template <class Keep>
  Cloud(float size_m, std::uint32_t side, std::uint32_t leaf_side, Keep keep) {
    const float step = size_m / static_cast<float>(kLargest);
    box = {{-0.5f * size_m, -0.5f * size_m, -0.5f * size_m}, {step, step, step}, kLargest};
    std::vector<PageNode> leaves;
    for (std::uint32_t i = 0; i < side * side * side; ++i) {
      const std::array<std::uint32_t, 3> cell{i % side, i / side % side, i / side / side};
      std::array<float, 3> place{};
      for (std::size_t axis = 0; axis < 3; ++axis) place[axis] = (static_cast<float>(cell[axis]) + 0.5f) / static_cast<float>(side);
      if (!keep(place)) continue;
      PageNode leaf;
      const std::size_t u = i % 3, v = (i + 1) % 3;
      for (std::size_t corner = 0; corner < 4; ++corner) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          leaf.corners[corner][axis] = static_cast<std::uint16_t>(place[axis] * static_cast<float>(kLargest - leaf_side));
        if (corner == 1 || corner == 2) leaf.corners[corner][u] = static_cast<std::uint16_t>(leaf.corners[corner][u] + leaf_side);
        if (corner >= 2) leaf.corners[corner][v] = static_cast<std::uint16_t>(leaf.corners[corner][v] + leaf_side);
      }
      leaves.push_back(leaf);
    }
    // A chain of splits before them, so that exactly the leaves are the cut.
    leaf_count = static_cast<std::uint32_t>(leaves.size());
    nodes.resize(leaf_count - 1);
    for (std::uint32_t i = 0; i + 1 < leaf_count; ++i) nodes[i].split = i;
    nodes.insert(nodes.end(), leaves.begin(), leaves.end());
    const float leaf_m = step * static_cast<float>(leaf_side);
    const float spacing_m = size_m / static_cast<float>(side);
    depth_per_m = 0.5f * leaf_m * leaf_m / (spacing_m * spacing_m * spacing_m);
  }
  [[nodiscard]] CrownLight light() const { return measure_crown({nodes[0], std::span(nodes).subspan(1), looks, box}); }
};

float depth_towards(const CrownSample& sample, const std::array<float, 3>& unit) {
  return sample.depth + sample.slope[0] * unit[0] + sample.slope[1] * unit[1] + sample.slope[2] * unit[2];
}

TEST(CrownLight, DepthGrowsWithTheWayThroughAnEvenCrown) {
  const Cloud cloud(4.0f, 24, 560, [](const std::array<float, 3>&) { return true; });
  const CrownLight light = cloud.light();
  // From the middle of a cube of side 4 the way out is 2 along the axes and 2 sqrt(3) along the diagonals: 2.88 by their weights.
  const CrownSample middle = light.at({0, 0, 0});
  EXPECT_NEAR(middle.depth, 2.88f * cloud.depth_per_m, 0.1f * 2.88f * cloud.depth_per_m);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(middle.slope[axis], 0.0f, 0.05f * middle.depth);
  // Near the top it is short upwards and long downwards.
  const CrownSample top = light.at({0, 1.7f, 0});
  EXPECT_LT(depth_towards(top, {0, 1, 0}), 0.25f * depth_towards(top, {0, -1, 0}));
  EXPECT_NEAR(depth_towards(top, {0, -1, 0}), 3.7f * cloud.depth_per_m, 0.25f * 3.7f * cloud.depth_per_m);
  EXPECT_GT(top.sky, 1.5f * middle.sky);
  EXPECT_LT(middle.sky, 0.5f);
}

TEST(CrownLight, GapsInLeavesLetLightThrough) {
  Cloud cloud(4.0f, 24, 560, [](const std::array<float, 3>&) { return true; });
  const CrownSample opaque = cloud.light().at({0, 0, 0});
  for (PageNode& node : cloud.nodes) node.opacity = kOpaque / 2;
  const CrownSample half = cloud.light().at({0, 0, 0});
  EXPECT_NEAR(half.depth, 0.5f * opaque.depth, 0.02f * opaque.depth);
  EXPECT_GT(half.sky, 1.2f * opaque.sky);
}

TEST(CrownLight, TheSideWithoutLeavesIsOpen) {
  const Cloud cloud(4.0f, 24, 700, [](const std::array<float, 3>& place) { return place[0] < 0.5f; });
  const CrownSample edge = cloud.light().at({-0.2f, 0, 0});
  EXPECT_LT(depth_towards(edge, {1, 0, 0}), 0.3f * depth_towards(edge, {-1, 0, 0}));
  const CrownSample outside = cloud.light().at({1.9f, 0, 0});
  EXPECT_LT(std::max(depth_towards(outside, {1, 0, 0}), 0.0f), 0.1f * depth_towards(outside, {-1, 0, 0}));
}

TEST(CrownLight, HolesLetLightThrough) {
  Cloud cloud(2.0f, 16, 700, [](const std::array<float, 3>&) { return true; });
  const float whole = cloud.light().at({0, 0, 0}).depth;
  cloud.looks[0].coverage = 0.25f;
  EXPECT_NEAR(cloud.light().at({0, 0, 0}).depth, 0.25f * whole, 4e-3f * whole) << "within the steps of its words";
}

TEST(CrownLight, WithoutLeavesThereIsLight) {
  const CrownSample nowhere = CrownLight{}.at({1, 2, 3});
  EXPECT_EQ(nowhere.depth, 0.0f);
  EXPECT_EQ(nowhere.sky, 1.0f);
}

TEST(CrownLight, AWordHoldsASample) {
  const CrownSample sample{.depth = 1.7f, .slope = {-1.1f, 0.4f, 2.9f}, .sky = 0.37f}, stored = unpack_crown(pack_crown(sample));
  EXPECT_NEAR(stored.depth, sample.depth, 0.03f);
  for (std::uint32_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(stored.slope[axis], sample.slope[axis], 0.06f) << axis;
  EXPECT_NEAR(stored.sky, sample.sky, 0.008f);
  EXPECT_EQ(pack_crown(CrownSample{.depth = NAN, .slope = {}, .sky = NAN}), 0u) << "of a box that overflows";
  EXPECT_EQ(pack_crown(CrownSample{.depth = 1e9f, .slope = {1e9f, -1e9f, 0}, .sky = 2}) & 255u, 255u);
}

TEST(CrownLight, DirectionsComeBackFromTheOctahedron) {
  for (const float z : {-1.0f, -0.6f, 0.0f, 0.3f, 1.0f})
    for (int turn = 0; turn < 16; ++turn) {
      const float angle = 0.3927f * static_cast<float>(turn), across = std::sqrt(1.0f - z * z);
      const vec3 unit{across * std::cos(angle), across * std::sin(angle), z};
      EXPECT_LT(distance(unfold(octahedral(3.0f * unit)), unit), 1e-5f) << z << ' ' << turn;
    }
  EXPECT_EQ(unfold(octahedral({0, 0, 0})), (vec3{0, 0, 1})) << "of no direction some";
  EXPECT_EQ(packSnorm4x8(vec4(1.0f, -1.0f, 0.0f, 2.0f)), 0x7f00817fu);
  EXPECT_EQ(packSnorm2x16(vec2(-1.0f, 0.5f)), 0x40008001u);
}

}  // namespace coppice::gpu::crown_light_test
