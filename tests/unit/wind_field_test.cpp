// The grid of a WIND chunk: what it says between nodes, and that its bounds hold.

#include "wind_field.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "still_wind.h"

namespace coppice::wind_field_test {

using Point = std::array<float, 3>;

/// A box of 2 m x 4 m x 2 m that stands on the ground.
coppice_file_wind box_head(std::uint32_t side) {
  coppice_file_wind head = kStillWind;
  head.height_m = 4.0f;
  head.lean_m = head.sway_m = 0.1f;
  head.box_min[0] = head.box_min[2] = -1.0f;
  head.box_max[1] = 4.0f;
  head.node_side = side;
  return head;
}

std::vector<coppice_file_wind_node> random_nodes(std::uint32_t side, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<coppice_file_wind_node> nodes(wind_node_count(side));
  for (coppice_file_wind_node& node : nodes) {
    node.lean = static_cast<std::uint8_t>(random() % 256);
    node.sway_cos = static_cast<std::int8_t>(static_cast<int>(random() % 255) - 127);
    node.sway_sin = static_cast<std::int8_t>(static_cast<int>(random() % 255) - 127);
  }
  return nodes;
}

WindSample sample(const WindField& field, const Point& at) {
  const float position[3] = {at[0], at[1], at[2]};
  return sample_wind(field, position);
}

TEST(WindField, NodesAreWhereTheFormatPutsThem) {
  const auto nodes = random_nodes(4, 1);
  const WindField field{box_head(4), nodes};
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    const float x = static_cast<float>(i % 4), y = static_cast<float>(i / 4 % 4), z = static_cast<float>(i / 16);
    const WindSample found = sample(field, {-1.0f + 2.0f * x / 3.0f, 4.0f * y / 3.0f, -1.0f + 2.0f * z / 3.0f});
    EXPECT_NEAR(found.lean, nodes[i].lean / 255.0f, 1e-5f) << i;
    EXPECT_NEAR(found.sway_cos, static_cast<float>(nodes[i].sway_cos) / 127.0f, 1e-5f) << i;
    EXPECT_NEAR(found.sway_sin, static_cast<float>(nodes[i].sway_sin) / 127.0f, 1e-5f) << i;
  }
}

TEST(WindField, BetweenNodesItIsTheirMeanAndOutsideTheEdges) {
  std::vector<coppice_file_wind_node> nodes(8);
  nodes[1].lean = 255;  // x 1, y 0, z 0
  const WindField field{box_head(2), nodes};
  EXPECT_FLOAT_EQ(sample(field, {0.0f, 0.0f, -1.0f}).lean, 0.5f);
  EXPECT_FLOAT_EQ(sample(field, {0.0f, 2.0f, 0.0f}).lean, 0.125f);
  EXPECT_FLOAT_EQ(sample(field, {9.0f, -7.0f, -3.0f}).lean, 1.0f);
  EXPECT_FLOAT_EQ(sample({box_head(0), {}}, {0.0f, 0.0f, 0.0f}).lean, 0.0f);
}

TEST(WindField, HeightSharesRunFromBaseToTop) {
  coppice_file_wind head = box_head(0);
  head.base_y_m = 1.0f;
  EXPECT_EQ(wind_height_share(head, 0.0f), 0.0f);
  EXPECT_EQ(wind_height_share(head, 3.0f), 0.5f);
  EXPECT_EQ(wind_height_share(head, 9.0f), 1.0f);
}

TEST(WindField, GrowthOfKnownFields) {
  coppice_file_wind head = box_head(2);
  std::vector<coppice_file_wind_node> nodes(8);
  for (std::size_t i = 1; i < 8; i += 2) nodes[i].lean = 255;  // along x, over 2 m
  EXPECT_NEAR(max_wind_growth({head, nodes}), 0.1 / 2.0, 1e-8);
  for (std::size_t i = 2; i < 8; ++i)
    if (i / 2 % 2 == 1) nodes[i].sway_cos = 127, nodes[i].sway_sin = -127;  // along y, over 4 m
  EXPECT_NEAR(max_wind_growth({head, nodes}), 0.1 / 2.0 + 0.1 * std::sqrt(2.0) / 4.0, 1e-8);
  head.bend_m = 0.6f;
  EXPECT_NEAR(max_wind_growth({head, nodes}), 0.1 / 2.0 + 0.1 * std::sqrt(2.0) / 4.0, 1e-8) << "bending does not count";
  EXPECT_NEAR(wind_fall_m(head), 2.0 / 3.0 * 0.6 * 0.6 / 4.0, 1e-7);
  EXPECT_NEAR(max_wind_move_m({head, nodes}), 0.6 + 0.06 + 0.1 + 0.1 * std::sqrt(2.0), 1e-7);
  head.node_side = 0;
  EXPECT_EQ(max_wind_growth({head, {}}), 0.0);
}

/// All that a renderer may make of lean and sway: the wind along x, a swing at `phase`, along x too.
std::array<double, 3> moved(const WindField& field, const Point& at, double phase) {
  const WindSample found = sample(field, at);
  const double sway = found.sway_cos * std::cos(phase) + found.sway_sin * std::sin(phase);
  return {at[0] + field.head.lean_m * found.lean + field.head.sway_m * sway, at[1], at[2]};
}

TEST(WindField, NoTwoPointsMoveApartFasterThanItsGrowth) {
  std::mt19937 random(7);
  const auto unit = [&] { return static_cast<float>(random() % 10001) / 10000.0f; };
  double max_share = 0.0;
  for (const std::uint32_t side : {2u, 4u, 8u}) {
    const auto nodes = random_nodes(side, side);
    const WindField field{box_head(side), nodes};
    const double growth = max_wind_growth(field);
    for (int i = 0; i < 20000; ++i) {
      // Now and then outside the box.
      const Point a{-1.2f + 2.4f * unit(), -0.5f + 5.0f * unit(), -1.2f + 2.4f * unit()};
      const Point b{a[0] + 0.02f * unit(), a[1] + 0.02f * unit() - 0.01f, a[2] + 0.02f * unit() - 0.01f};
      const double phase = 6.2831853 * unit();
      const auto at_a = moved(field, a, phase), at_b = moved(field, b, phase);
      const double apart = (at_b[0] - b[0]) - (at_a[0] - a[0]);
      const double distance = std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
      if (distance < 1e-3) continue;
      ASSERT_LE(std::abs(apart), growth * distance + 1e-6) << side;
      max_share = std::max(max_share, std::abs(apart) / (growth * distance));
    }
  }
  EXPECT_GT(max_share, 0.4) << "the bound says little";
}

TEST(WindField, ChecksTakeWhatKeepsTheLimitsAndNoMore) {
  coppice_file_wind head = box_head(2);
  const std::vector<coppice_file_wind_node> nodes(8);
  EXPECT_TRUE(check_wind_head(kStillWind, 0));
  EXPECT_TRUE(check_wind_field({kStillWind, {}}, 0.0, 0));
  head.bend_m = 1.59f;  // and 0.42 down
  EXPECT_TRUE(check_wind_head(head, 0));
  EXPECT_TRUE(check_wind_field({head, nodes}, 2.52, 0));
  EXPECT_FALSE(check_wind_field({head, nodes}, 2.5, 0)) << "moves further than 0.8 of the radius";
  head.bend_m = 1.61f;
  EXPECT_FALSE(check_wind_field({head, nodes}, 9.0, 0)) << "bends by more than 0.4 of the height";
  head.bend_m = 0.0f;
  auto leaning = nodes;
  leaning[1].lean = 255;  // over 2 m along x and z, and 4 m along y: a gradient of 0.75 / m
  EXPECT_TRUE(check_wind_field({head, leaning}, 9.0, 0));
  head.lean_m = 0.11f;
  EXPECT_FALSE(check_wind_field({head, leaning}, 9.0, 0)) << "grows by more than 0.08";

  coppice_file_wind low = box_head(2), flat = box_head(2);
  low.height_m = 1e-42f;
  EXPECT_FALSE(check_wind_head(low, 0)) << "its inverse is infinite";
  flat.box_min[1] = 0.0f;
  flat.box_max[1] = 1e-40f;
  EXPECT_FALSE(check_wind_head(flat, 0)) << "nodes too near to each other";
}

}  // namespace coppice::wind_field_test
