// How wind moves a plant, as the baker finds it: the wood's skeleton, its bending, and the field in the end.

#include "wind.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "generate_plant.h"
#include "leaf_cards.h"
#include "results.h"
#include "seeded_random.h"
#include "union_find.h"
#include "wind_field.h"
#include "wood_bending.h"
#include "wood_capsules.h"
#include "wood_graph.h"
#include "wood_joints.h"
#include "wood_plants.h"
#include "wood_skeleton.h"

namespace coppice::bake::wind_test {

struct Tube {
  glm::vec3 foot{0.0f}, tip{0.0f, 1.0f, 0.0f};
  float foot_radius_m = 0.1f, tip_radius_m = 0.01f;
  std::uint32_t ring_count = 40;
};

void append_tube(const Tube& tube, Mesh& mesh) {
  constexpr std::uint32_t kSides = 10;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const glm::vec3 along = glm::normalize(tube.tip - tube.foot);
  const glm::vec3 side = glm::normalize(glm::cross(along, std::abs(along.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0)));
  for (std::uint32_t ring = 0; ring < tube.ring_count; ++ring)
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const float share = static_cast<float>(ring) / static_cast<float>(tube.ring_count - 1);
      const float turn = 2.0f * std::numbers::pi_v<float> * static_cast<float>(i) / kSides;
      const glm::vec3 outward = std::cos(turn) * side + std::sin(turn) * glm::cross(along, side);
      mesh.positions.push_back(glm::mix(tube.foot, tube.tip, share) + glm::mix(tube.foot_radius_m, tube.tip_radius_m, share) * outward);
      mesh.normals.push_back(outward);
      mesh.uvs.emplace_back(0.0f);
    }
  for (std::uint32_t ring = 0; ring + 1 < tube.ring_count; ++ring)
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const std::uint32_t a = first + ring * kSides + i, b = first + ring * kSides + (i + 1) % kSides;
      mesh.indices.insert(mesh.indices.end(), {a, b, b + kSides, a, b + kSides, a + kSides});
      mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, 0u);
    }
}

/// Wood and quads, each quad a leaf of two triangles.
struct TestPlant {
  Mesh wood, foliage;
  std::vector<LeafRange> leaves;
  std::vector<Quad> quads;

  void add_leaf(const glm::vec3& stalk, const glm::vec3& to_tip, float width_m) {
    const glm::vec3 side = 0.5f * width_m * glm::normalize(glm::cross(to_tip, glm::vec3(0.3f, 0.1f, 0.9f)));
    const Quad quad{stalk - side, stalk - side + to_tip, stalk + side + to_tip, stalk + side};
    const auto first = static_cast<std::uint32_t>(foliage.positions.size());
    foliage.positions.insert(foliage.positions.end(), quad.begin(), quad.end());
    foliage.indices.insert(foliage.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
    foliage.triangle_materials.insert(foliage.triangle_materials.end(), 2, 0u);
    leaves.push_back({2 * static_cast<std::uint32_t>(leaves.size()), 2});
    quads.push_back(quad);
  }
  [[nodiscard]] Sphere sphere() const {
    Foliage shown{quads, {}, {}, {}};
    if (quads.empty()) shown.quads.emplace_back().fill(wood.positions.front());
    return plant_sphere(shown, wood);
  }
  [[nodiscard]] Wind wind(const WindOptions& options = {}) const { return wind_of({wood, foliage, leaves, quads, sphere()}, options); }
};

/// Leaves along a line, in all directions, each 6 cm.
void add_leaves(const glm::vec3& from, const glm::vec3& to, int count, TestPlant& plant) {
  SeededRandom random(static_cast<std::uint64_t>(count));
  const auto part = [&] { return static_cast<float>(random.uniform()) - 0.5f; };
  for (int i = 0; i < count; ++i) {
    const glm::vec3 direction(part(), part(), part());
    plant.add_leaf(glm::mix(from, to, (static_cast<float>(i) + 0.5f) / static_cast<float>(count)),
                   0.06f * glm::normalize(direction + glm::vec3(0, 0.01f, 0)), 0.04f);
  }
}

/// A trunk of 6 m with one branch of 2 m at half its height, leaves on the outer half of the branch and at the top. trunk_m, branch_m:
/// radii at foot and tip
TestPlant branched_plant(int leaf_count = 1200, const glm::vec2& trunk_m = {0.05f, 0.01f}, const glm::vec2& branch_m = {0.02f, 0.004f}) {
  TestPlant plant;
  append_tube({{0, 0, 0}, {0, 6, 0}, trunk_m[0], trunk_m[1], 60}, plant.wood);
  append_tube({{0, 3, 0}, {2, 3.5f, 0}, branch_m[0], branch_m[1], 30}, plant.wood);
  add_leaves({1, 3.25f, 0}, {2, 3.5f, 0}, leaf_count / 2, plant);
  add_leaves({0, 4.5f, 0}, {0, 6, 0}, leaf_count / 2, plant);
  return plant;
}

WindSample sample(const Wind& wind, const glm::vec3& at) {
  const float position[3] = {at.x, at.y, at.z};
  return sample_wind({wind.head, wind.nodes}, position);
}

double lean_m(const Wind& wind, const glm::vec3& at) {
  return double{wind.head.lean_m} * sample(wind, at).lean;
}

double sway_m(const Wind& wind, const glm::vec3& at) {
  const WindSample found = sample(wind, at);
  return wind.head.sway_m * std::hypot(found.sway_cos, found.sway_sin);
}

void expect_within_limits(const Wind& wind, const Sphere& sphere, const std::string& what) {
  const auto head = check_wind_head(wind.head, 0);
  ASSERT_TRUE(head) << what << ": " << head.error().message();
  ASSERT_EQ(wind.nodes.size(), wind_node_count(wind.head.node_side)) << what;
  const auto field = check_wind_field({wind.head, wind.nodes}, sphere.radius, 0);
  ASSERT_TRUE(field) << what << ": " << field.error().message();
}

bool same(const Wind& a, const Wind& b) {
  return std::memcmp(&a.head, &b.head, sizeof a.head) == 0 && a.nodes.size() == b.nodes.size() &&
         std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof a.nodes[0]) == 0;
}

TEST(WoodSkeleton, ATubeIsAChainOfRings) {
  for (const std::uint32_t ring_count : {2u, 30u}) {
    Mesh wood;
    append_tube({{0, 0, 0}, {0, 4, 0}, 0.2f, 0.1f, ring_count}, wood);
    const std::vector<Ring> rings = wood_skeleton(wood, {0.0, 4.0, false}, 0.2);
    ASSERT_GE(rings.size(), 15u) << ring_count;
    for (std::size_t i = 0; i < rings.size(); ++i) {
      EXPECT_EQ(rings[i].parent, i == 0 ? kNone : static_cast<std::uint32_t>(i) - 1) << ring_count;
      EXPECT_NEAR(rings[i].radius_m, 0.2 - 0.1 * rings[i].center.y / 4.0, 0.03) << ring_count << ", ring " << i;
      EXPECT_LT(std::hypot(rings[i].center.x, rings[i].center.z), 0.08) << ring_count;
    }
    EXPECT_NEAR(rings.back().center.y, 4.0, 0.2);
  }
}

TEST(WoodSkeleton, LoosePiecesGrowOutOfTheNearest) {
  Mesh wood;
  append_tube({{0, 0, 0}, {0, 4, 0}, 0.1f, 0.05f, 2}, wood);
  append_tube({{0.12f, 3, 0}, {1.5f, 3.2f, 0}, 0.02f, 0.01f, 2}, wood);       // a branch, 2 cm off the trunk
  append_tube({{1.6f, 3.2f, 0}, {2.5f, 3.4f, 0}, 0.01f, 0.005f, 2}, wood);    // a twig beyond it
  append_tube({{1.5f, 3.15f, 0}, {1.5f, 0.0f, 0}, 0.003f, 0.002f, 2}, wood);  // hangs from the branch to the ground
  const std::vector<Ring> rings = wood_skeleton(wood, {0.0, 4.0, false}, 0.1);
  EXPECT_EQ(std::ranges::count(rings, kNone, &Ring::parent), 1) << "what hangs to the ground does not stand on it";
  const auto passes = [&](const glm::dvec3& from, const glm::dvec3& through) {
    const auto nearest = std::ranges::min_element(rings, {}, [&](const Ring& ring) { return glm::distance(ring.center, from); });
    double least_m = 1e9;
    for (auto at = static_cast<std::uint32_t>(nearest - rings.begin()); at != kNone; at = rings[at].parent)
      least_m = std::min(least_m, glm::distance(rings[at].center, through));
    return least_m < 0.15;
  };
  EXPECT_TRUE(passes({2.5, 3.4, 0}, {1.5, 3.2, 0})) << "the twig grows out of the branch";
  EXPECT_TRUE(passes({2.5, 3.4, 0}, {0, 3, 0})) << "which grows out of the trunk where it is near";
  EXPECT_TRUE(passes({1.5, 0.1, 0}, {1.5, 3.2, 0}));
}

TEST(WoodSkeleton, EachStemOfABushStandsOnTheGround) {
  Mesh wood;
  for (int stem = 0; stem < 5; ++stem)
    append_tube({{0.2f * static_cast<float>(stem), 0, 0}, {0.6f * static_cast<float>(stem), 2, 0}, 0.03f, 0.01f, 20}, wood);
  const std::vector<Ring> rings = wood_skeleton(wood, {0.0, 2.0, false}, 0.1);
  EXPECT_EQ(std::ranges::count(rings, kNone, &Ring::parent), 5);
}

/// Distance of a point from the nearest surface of the capsules, along which it should lie.
double off_m(const glm::dvec3& point, const std::vector<Capsule>& capsules) {
  double least_m = 1e9;
  for (const Capsule& capsule : capsules) {
    const glm::dvec3 along = capsule.to - capsule.from;
    const double at = std::clamp(glm::dot(point - capsule.from, along) / std::max(glm::dot(along, along), 1e-12), 0.0, 1.0);
    least_m = std::min(least_m, std::abs(glm::distance(point, capsule.from + at * along) - capsule.radius_m));
  }
  return least_m;
}

TEST(WoodCapsules, TheStemIsFirstAndFewFollowABentOne) {
  Mesh wood;
  append_tube({{0, 0, 0}, {0, 4, 0}, 0.2f, 0.18f, 30}, wood);
  append_tube({{0, 4, 0}, {2, 7, 0}, 0.18f, 0.15f, 30}, wood);
  append_tube({{0.1f, 3, 0}, {-2, 3.5f, 0}, 0.06f, 0.04f, 20}, wood);  // a bough
  append_tube({{-1, 3.3f, 0}, {-1, 4, 0}, 0.004f, 0.002f, 20}, wood);  // a twig
  const std::vector<Capsule> one = wood_capsules(wood, 1);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_LT(glm::length(one[0].from), 0.3);
  EXPECT_LT(glm::distance(one[0].to, glm::dvec3(2, 7, 0)), 0.3);
  const std::vector<Capsule> few = wood_capsules(wood, 8);
  EXPECT_GE(few.size(), 3u);
  EXPECT_LE(few.size(), 8u);
  for (const Capsule& capsule : few) EXPECT_GT(capsule.radius_m, 0.018) << "the twig has none";
  EXPECT_LT(off_m({0.2, 2, 0}, few), 0.08);
  EXPECT_LT(off_m({1 - 0.13, 5.5 + 0.09, 0}, few), 0.08);
  EXPECT_LT(off_m({-1.5, 3.38 + 0.05, 0}, few), 0.06);
  const std::vector<Capsule> again = wood_capsules(wood, 8);
  EXPECT_TRUE(std::ranges::equal(few, again, [](const Capsule& a, const Capsule& b) { return a.from == b.from && a.to == b.to; }));
  EXPECT_TRUE(wood_capsules({}, 8).empty());
}

TEST(WoodGraph, EverythingIsConnectedHoweverLoose) {
  Mesh wood;
  SeededRandom random(5);
  const auto place = [&] { return glm::vec3(random.uniform(), random.uniform(), random.uniform()); };
  for (std::uint32_t triangle = 0; triangle < 3000; ++triangle) {
    const glm::vec3 at = triangle % 3 == 0 ? glm::vec3(0.5f) + 1e-4f * place() : place();  // a third of them in one spot
    for (int corner = 0; corner < 3; ++corner) {
      wood.indices.push_back(static_cast<std::uint32_t>(wood.positions.size()));
      wood.positions.push_back(at + 0.001f * place());
    }
    wood.triangle_materials.push_back(0);
  }
  const WoodGraph graph = wood_graph(wood, 0.05);
  UnionFind parts(graph.points.size());
  for (std::uint32_t point = 0; point < graph.points.size(); ++point)
    for (const std::uint32_t to : graph.links_of(point)) parts.join(point, to);
  for (std::uint32_t point = 0; point < graph.points.size(); ++point) EXPECT_EQ(parts.find(point), 0u);
}

/// A mast of one thickness with a load at its top: F L^3 / (3 E I).
TEST(WoodBending, AMastBendsAsACantileverDoes) {
  constexpr double kLength_m = 5.0, kRadius_m = 0.05, kLoad_m2 = 0.3;
  std::vector<Ring> rings;
  for (std::uint32_t i = 0; i <= 200; ++i)
    rings.push_back({i == 0 ? kNone : i - 1, {0.0, kLength_m * i / 200.0, 0.0}, kRadius_m, i == 0 ? 0.0 : kLength_m / 200.0});
  std::vector<RingLoad> loads(rings.size());
  constexpr double kHuge_m2 = 1e9;  // so that what the mast itself catches is little
  loads.back() = {kLoad_m2, kLoad_m2 * rings.back().center};
  const WoodBend bend = bend_wood(rings, loads, {0.0, kLength_m, false}, kHuge_m2);
  const double force_n = kGalePressure_pa * kCrownDrag * kLoad_m2;
  const double inertia_m4 = std::numbers::pi / 4.0 * std::pow(kRadius_m, 4);
  const double at_top_m = force_n * std::pow(kLength_m, 3) / (3.0 * kWoodModulus_pa * inertia_m4);
  // A mast's own load, evenly spread: F L^3 / (8 E I).
  const double own_n = kGalePressure_pa * kCrownDrag * 2.0 * kRadius_m * kLength_m;
  const double own_m = own_n * std::pow(kLength_m, 3) / (8.0 * kWoodModulus_pa * inertia_m4);
  EXPECT_NEAR(bend.top_m, at_top_m + own_m, 0.03 * (at_top_m + own_m));
  EXPECT_EQ(bend.rings.front().offset_m, 0.0);
  for (const RingBend& ring : bend.rings) EXPECT_TRUE(ring.is_stem);
}

double area_m2(const Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto [a, b, c] = at_corners(mesh.positions, mesh.indices, i);
    sum += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return sum;
}

TEST(WoodJoints, LongPiecesAreDividedAndStayTogether) {
  coppice_file_wind wind = kStillWind;
  wind.height_m = 2.0f;
  Mesh plain, fine;
  append_tube({{0, 0, 0}, {0.3f, 2, 0}, 0.02f, 0.01f, 2}, plain);
  append_tube({{0, 0, 0}, {0.3f, 2, 0}, 0.02f, 0.01f, 20}, fine);
  Mesh divided = plain, stiff = plain;
  wind.bend_m = 0.06f;
  add_joints(wind, stiff);
  EXPECT_EQ(stiff.positions, plain.positions) << "it hardly bends";
  wind.bend_m = 0.6f;
  add_joints(wind, divided);
  EXPECT_NEAR(area_m2(divided), area_m2(plain), 1e-5);
  ASSERT_EQ(divided.triangle_materials.size(), divided.indices.size() / 3);
  ASSERT_TRUE(divided.normals.size() == divided.positions.size() && divided.uvs.size() == divided.positions.size());
  std::map<std::set<std::uint32_t>, int> sides;
  float longest_m = 0.0f;
  for (std::size_t i = 0; i < divided.indices.size(); ++i) {
    const std::uint32_t from = divided.indices[i], to = divided.indices[i % 3 == 2 ? i - 2 : i + 1];
    ++sides[{from, to}];
    longest_m = std::max(longest_m, std::abs(divided.positions[to].y - divided.positions[from].y));
  }
  EXPECT_LE(longest_m, 0.8f);
  for (const auto& [ends, count] : sides) {
    const float y = divided.positions[*ends.begin()].y;
    EXPECT_TRUE(count == 2 || y < 0.1f || y > 1.9f) << "no side ends at " << y;
  }
  Mesh as_it_was = fine;
  add_joints(wind, fine);
  EXPECT_EQ(fine.positions, as_it_was.positions);
}

TEST(Wind, TheStemBendsAndTheBranchLeansTowardsItsTip) {
  const TestPlant plant = branched_plant();
  const Wind wind = plant.wind();
  expect_within_limits(wind, plant.sphere(), "branched");
  EXPECT_EQ(wind.head.node_side, 8u);
  EXPECT_NEAR(wind.head.base_y_m, 0.0f, 0.05f);
  EXPECT_NEAR(wind.head.base_y_m + wind.head.height_m, 6.06f, 0.1f);
  EXPECT_GT(wind.head.bend_m, 0.01f) << "a slender stem bends";
  EXPECT_EQ(wind_height_share(wind.head, wind.head.base_y_m + wind.head.height_m), 1.0f);
  for (const glm::vec3 foot : {glm::vec3(0, 0, 0), glm::vec3(0.08f, 0, 0), glm::vec3(0, 0, -0.08f)})
    EXPECT_EQ(lean_m(wind, foot) + sway_m(wind, foot), 0.0);
  const double at_fork = lean_m(wind, {0.1f, 3, 0}), halfway = lean_m(wind, {1, 3.25f, 0}), at_tip = lean_m(wind, {2, 3.5f, 0});
  EXPECT_LT(at_fork, 0.5 * halfway);
  EXPECT_LT(halfway, 0.8 * at_tip);
  EXPECT_GT(sway_m(wind, {2, 3.5f, 0}), 2.0 * sway_m(wind, {0.1f, 3, 0}));
  EXPECT_LT(lean_m(wind, {0, 1.5f, 0}), 0.25 * at_tip) << "the stem does not lean beyond its bend";
  EXPECT_GT(at_tip, 0.005);
}

TEST(Wind, AStoutTreeMovesLessThanASlenderOne) {
  const auto grown = [](float radius_m) {
    return branched_plant(1200, {radius_m, 0.3f * radius_m}, {0.3f * radius_m, 0.05f * radius_m}).wind();
  };
  const Wind stout = grown(0.4f), slender = grown(0.03f);
  EXPECT_LT(stout.head.bend_m, 0.05f * slender.head.bend_m);
  EXPECT_LT(stout.head.lean_m, slender.head.lean_m);
  EXPECT_LT(stout.head.stem_period_s, slender.head.stem_period_s);
  EXPECT_GT(slender.head.bend_m, 0.04f) << "near its limit";
}

TEST(Wind, BranchesAreOutOfStepAndEachMovesAsOne) {
  TestPlant plant;
  append_tube({{0, 0, 0}, {0, 6, 0}, 0.06f, 0.01f, 60}, plant.wood);
  for (int branch = 0; branch < 8; ++branch) {
    const float turn = 0.785f * static_cast<float>(branch);
    const glm::vec3 foot(0, 3.0f + 0.3f * static_cast<float>(branch), 0),
        tip = foot + glm::vec3(2 * std::cos(turn), 0.2f, 2 * std::sin(turn));
    append_tube({foot, tip, 0.02f, 0.004f, 30}, plant.wood);
    add_leaves(glm::mix(foot, tip, 0.5f), tip, 200, plant);
  }
  const Wind wind = plant.wind();
  expect_within_limits(wind, plant.sphere(), "eight branches");
  std::vector<double> phases;
  for (int branch = 0; branch < 8; ++branch) {
    const float turn = 0.785f * static_cast<float>(branch);
    const WindSample found = sample(wind, {2 * std::cos(turn), 3.2f + 0.3f * static_cast<float>(branch), 2 * std::sin(turn)});
    phases.push_back(std::atan2(found.sway_sin, found.sway_cos));
  }
  EXPECT_GT(*std::ranges::max_element(phases) - *std::ranges::min_element(phases), 0.7);
}

TEST(Wind, ThreadsDoNotMatter) {
  const TestPlant plant = branched_plant(3000);
  std::vector<Wind> winds;
  for (const std::size_t threads : {1u, 2u, 5u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    winds.push_back(plant.wind());
  }
  EXPECT_TRUE(same(winds[0], winds[1]));
  EXPECT_TRUE(same(winds[0], winds[2]));
}

TEST(Wind, StiffnessDividesAndLimitsHoldBelowOne) {
  const TestPlant plant = branched_plant();
  const Wind plain = plant.wind(), stiff = plant.wind({true, 2.0f}), soft = plant.wind({true, 0.1f});
  for (const auto by_m : {&coppice_file_wind::bend_m, &coppice_file_wind::lean_m, &coppice_file_wind::sway_m})
    EXPECT_FLOAT_EQ(stiff.head.*by_m, 0.5f * plain.head.*by_m);
  expect_within_limits(soft, plant.sphere(), "soft");
  EXPECT_GE(soft.head.bend_m, plain.head.bend_m);
  TestPlant stout;
  append_tube({{0, 0, 0}, {0, 6, 0}, 0.5f, 0.3f, 60}, stout.wood);
  add_leaves({0, 4.5f, 0}, {0, 6, 0}, 600, stout);
  EXPECT_NEAR(stout.wind({true, 0.5f}).head.bend_m, 2.0f * stout.wind().head.bend_m, 0.02f * stout.wind().head.bend_m)
      << "far from a limit half as stiff is twice as far";
}

TEST(Wind, NoneMeansStill) {
  const Wind wind = branched_plant().wind({false, 1.0f});
  for (const float by_m : {wind.head.bend_m, wind.head.lean_m, wind.head.sway_m}) EXPECT_EQ(by_m, 0.0f);
  EXPECT_EQ(wind.head.node_side, 0u);
  EXPECT_TRUE(wind.nodes.empty());
  EXPECT_TRUE(check_wind_head(wind.head, 0));
}

TEST(Wind, TheGridTakesAtMostTwoBytesALeaf) {
  for (const auto& [leaves, side] :
       std::map<std::size_t, std::uint32_t>{{0, 0}, {15, 0}, {16, 2}, {127, 2}, {128, 4}, {1023, 4}, {1024, 8}, {100000, 8}}) {
    EXPECT_EQ(wind_node_side(leaves), side) << leaves;
    EXPECT_LE(sizeof(coppice_file_wind_node) * wind_node_count(side), 2 * leaves);
  }
}

TEST(Wind, WeightsSayWhatBends) {
  TestPlant plant = branched_plant();
  // The other way round than the wood would: what is at the top is flexible, the branch is stiff.
  for (const glm::vec3& at : plant.foliage.positions) plant.foliage.wind_weights.push_back(at.y > 4.2f ? 1.0f : 0.0f);
  for (const glm::vec3& at : plant.wood.positions) plant.wood.wind_weights.push_back(at.y > 4.2f ? 1.0f : 0.0f);
  const Wind wind = plant.wind();
  expect_within_limits(wind, plant.sphere(), "weights");
  EXPECT_GT(lean_m(wind, {0, 6, 0}), 4.0 * lean_m(wind, {2, 3.3f, 0}));
  const Wind told_by_wood = branched_plant().wind();
  EXPECT_LT(lean_m(told_by_wood, {0, 6, 0}), lean_m(told_by_wood, {2, 3.5f, 0}));
  // What has none is told by the wood.
  plant.foliage.wind_weights.assign(plant.foliage.positions.size(), -1.0f);
  plant.wood.wind_weights.assign(plant.wood.positions.size(), -1.0f);
  EXPECT_TRUE(same(plant.wind(), told_by_wood));
}

TEST(Wind, BladesWithoutWoodLeanWithTheirHeight) {
  TestPlant grass;
  SeededRandom random(3);
  for (int blade = 0; blade < 400; ++blade) {
    const glm::vec3 foot(static_cast<float>(random.uniform()), 0, static_cast<float>(random.uniform()));
    grass.add_leaf(foot, {0.02f, 0.4f + 0.2f * static_cast<float>(random.uniform()), 0.01f}, 0.02f);
  }
  const Wind wind = grass.wind();
  expect_within_limits(wind, grass.sphere(), "grass");
  EXPECT_GT(wind.head.bend_m, 0.0f);
  EXPECT_EQ(lean_m(wind, {0.5f, 0, 0.5f}), 0.0);
  EXPECT_GT(lean_m(wind, {0.5f, 0.5f, 0.5f}), 1.5 * lean_m(wind, {0.5f, 0.2f, 0.5f}));
  EXPECT_GT(lean_m(wind, {0.5f, 0.2f, 0.5f}), 0.0);
}

TEST(Wind, WhatHangsIsHeldAtItsTop) {
  TestPlant vine;
  append_tube({{0, 0, 0}, {0, -2, 0}, 0.01f, 0.003f, 40}, vine.wood);
  add_leaves({0, -0.3f, 0}, {0, -2, 0}, 300, vine);
  const Wind wind = vine.wind();
  expect_within_limits(wind, vine.sphere(), "vine");
  EXPECT_EQ(wind.head.bend_m, 0.0f);
  EXPECT_EQ(lean_m(wind, {0, 0, 0}), 0.0);
  EXPECT_GT(lean_m(wind, {0, -2, 0}), 0.0);
}

TEST(Wind, RootsBelowTheGroundAreStill) {
  TestPlant plant = branched_plant();
  append_tube({{0, 0, 0}, {0.5f, -0.6f, 0}, 0.05f, 0.01f, 10}, plant.wood);
  const Wind wind = plant.wind();
  EXPECT_EQ(wind.head.base_y_m, 0.0f);
  for (const glm::vec3 at : {glm::vec3(0, 0, 0), glm::vec3(0.25f, -0.3f, 0), glm::vec3(0.5f, -0.6f, 0)}) {
    EXPECT_EQ(lean_m(wind, at), 0.0);
    EXPECT_EQ(wind_height_share(wind.head, at.y), 0.0f);
  }
}

/// Anything bakes.
TEST(Wind, PlantsWithoutSenseKeepTheLimits) {
  SeededRandom random(11);
  const auto place = [&](float size_m) {
    return size_m * glm::vec3(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
  };
  for (const float size_m : {1e-5f, 1.0f, 1e6f})
    for (const int leaf_count : {0, 1, 20, 300, 2000}) {
      TestPlant noise;
      for (std::uint32_t triangle = 0; triangle < 40; ++triangle) {
        for (int corner = 0; corner < 3; ++corner) {
          noise.wood.indices.push_back(static_cast<std::uint32_t>(noise.wood.positions.size()));
          noise.wood.positions.push_back(corner == 2 && triangle % 2 == 0 ? noise.wood.positions.back() : place(size_m));  // a line
        }
        noise.wood.triangle_materials.push_back(0);
      }
      for (int leaf = 0; leaf < leaf_count; ++leaf) noise.add_leaf(place(size_m), place(0.2f * size_m), 0.02f * size_m);
      const std::string what = std::to_string(size_m) + " m, " + std::to_string(leaf_count) + " leaves";
      for (const float stiffness : {0.1f, 10.0f}) expect_within_limits(noise.wind({true, stiffness}), noise.sphere(), what);
      noise.wood = {};
      if (leaf_count > 0) expect_within_limits(noise.wind(), noise.sphere(), what + " without wood");
    }
  TestPlant flat;
  for (int leaf = 0; leaf < 200; ++leaf) flat.add_leaf(place(1.0f) * glm::vec3(1, 0, 1), {0.1f, 0, 0}, 0.05f);
  for (Quad& quad : flat.quads)
    for (glm::vec3& corner : quad) corner.y = 0.0f;
  for (glm::vec3& position : flat.foliage.positions) position.y = 0.0f;
  expect_within_limits(flat.wind(), flat.sphere(), "flat");
  TestPlant far;
  for (int leaf = 0; leaf < 200; ++leaf) far.add_leaf(glm::vec3(9e7f, -9e7f, 9e7f) + place(100.0f), {20.0f, 10.0f, 0}, 8.0f);
  append_tube({{9e7f, -9e7f, 9e7f}, {9e7f, -9e7f + 200.0f, 9e7f}, 10.0f, 8.0f, 5}, far.wood);
  expect_within_limits(far.wind(), far.sphere(), "far from its origin");
  TestPlant point;
  point.wood.positions.assign(3, glm::vec3(1.0f));
  point.wood.indices = {0, 1, 2};
  point.wood.triangle_materials = {0};
  expect_within_limits(point.wind(), point.sphere(), "a point");
}

class WindOfWood : public testing::TestWithParam<test::WoodPlant> {};

TEST_P(WindOfWood, KeepsTheLimits) {
  Plant plant = GetParam().grow();
  Foliage foliage;
  if (plant.leaves.empty())
    foliage.quads.emplace_back().fill(plant.wood.positions.front());
  else
    foliage = *card_foliage(plant);
  const Sphere sphere = plant_sphere(foliage, plant.wood);
  for (const float stiffness : {0.1f, 1.0f}) {
    const Wind wind = wind_of({plant.wood, plant.foliage, plant.leaves, foliage.quads, sphere}, {true, stiffness});
    expect_within_limits(wind, sphere, plant.name);
    EXPECT_GT(wind.head.bend_m + wind.head.lean_m, 0.0f);
  }
}

INSTANTIATE_TEST_SUITE_P(Plants, WindOfWood, testing::ValuesIn(test::wood_plants()),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(Wind, GrownPlantsKeepTheLimitsAndTwigsMoveMost) {
  for (const char* species : {"corylus", "willow"}) {
    auto plant = coppice::test::must(generate_plant(species, 1));
    const Foliage foliage = *card_foliage(plant);
    const Sphere sphere = plant_sphere(foliage, plant.wood);
    const Wind wind = wind_of({plant.wood, plant.foliage, plant.leaves, foliage.quads, sphere}, {});
    expect_within_limits(wind, sphere, species);
    EXPECT_GT(max_wind_move_m({wind.head, wind.nodes}), 0.015 * sphere.radius) << species << " visibly moves in a gale";
    double leaf_sum_m = 0.0;
    for (const Quad& quad : foliage.quads) leaf_sum_m += lean_m(wind, quad[1]);
    const double foot_m = lean_m(wind, {0.0f, wind.head.base_y_m + 0.1f * wind.head.height_m, 0.0f});
    EXPECT_GT(leaf_sum_m / foliage.leaf_count(), 2.0 * foot_m) << species;
  }
}

}  // namespace coppice::bake::wind_test
