// How the normals of merged leaves are added up, rounded, and lit: against sums over the leaves themselves.

#include "normal_sum.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "leaf_normals.h"
#include "leaf_shade.h"
#include "tree.h"

namespace coppice::bake::normal_sum_test {

glm::dvec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return glm::normalize(glm::dvec3(x, y, z));
}

ShadingNormals rounded(const NormalSum& sum) {
  return unpack_normals(node_normals(sum), {0.0f, 0.0f, 0.0f});
}

glm::dvec3 axis_of(const ShadingNormals& normals) {
  return {normals.axis[0], normals.axis[1], normals.axis[2]};
}

TEST(NormalSum, RoundsAnAxisToHalfAStepOfTheOctahedron) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 normal = random_direction(random);
    const ShadingNormals normals = rounded(normal_sum(normal, 0.3));
    EXPECT_GT(std::abs(glm::dot(axis_of(normals), normal)), 0.995) << "within 6 degrees";
    EXPECT_EQ(normals.along, 1.0f);
    EXPECT_FALSE(normals.is_sided);
    const ShadingNormals sided = rounded(normal_sum(normal, 0.3, true));
    EXPECT_GT(glm::dot(axis_of(sided), normal), 0.995);
    EXPECT_TRUE(sided.is_sided);
  }
}

TEST(NormalSum, RoundsTheAxisOfRoundNodesToFewerSteps) {
  std::mt19937 random(4);
  for (const double along : {0.0, 0.2, 0.55, 0.75, 0.95}) {
    const double least = along > 0.8 ? 0.995 : along < 0.1 || along > 0.7 ? 0.98 : 0.915;  // 6, 12 and 24 degrees
    for (int i = 0; i < 500; ++i) {
      const glm::dvec3 axis = random_direction(random), side = glm::normalize(glm::cross(axis, random_direction(random)));
      const NormalSum sum =
          normal_sum(axis, along) + normal_sum(side, 0.5 * (1.0 - along)) + normal_sum(glm::cross(axis, side), 0.5 * (1.0 - along));
      EXPECT_TRUE(are_normals(node_normals(sum)));
      EXPECT_GT(std::abs(glm::dot(axis_of(rounded(sum)), axis)), least) << along;
    }
  }
}

TEST(NormalSum, TakesTheUsualAxisWhereItIsNear) {
  const glm::dvec3 axis = glm::normalize(glm::dvec3(0.2, 0.4, 1.0)), near = glm::normalize(glm::dvec3(0.32, 0.4, 1.0)),
                   far = glm::normalize(glm::dvec3(0.42, 0.4, 1.0));
  const auto folded_along = [](const glm::dvec3& fold) {
    const glm::dvec3 side = glm::normalize(glm::cross(fold, glm::dvec3(0, 1, 0)));
    return normal_sum(side, 1.0) + normal_sum(glm::cross(fold, side), 1.0);
  };
  const std::uint16_t bits = node_normals(folded_along(axis));
  EXPECT_EQ(node_normals(folded_along(near), axis), bits);
  EXPECT_EQ(node_normals(folded_along(near), -axis), bits) << "either way";
  EXPECT_NE(node_normals(folded_along(near)), bits) << "without, it is another";
  EXPECT_EQ(node_normals(folded_along(far), axis), node_normals(folded_along(far)));
}

TEST(NormalSum, StraightUpIsExact) {
  for (int along = 0; along <= 15; ++along) {
    if (along == 5) continue;  // all directions are alike
    const ShadingNormals normals = rounded(normal_sum({0, 1, 0}, 1.0, true, along / 15.0));
    EXPECT_EQ(normals.axis[1], 1.0f) << along;
  }
}

TEST(NormalSum, TellsTwigsFromTuftsFromCrowns) {
  std::mt19937 random(2);
  NormalSum twig, tuft, crown;
  const glm::dvec3 axis = glm::normalize(glm::dvec3(0.3, 0.5, -0.8));
  for (int i = 0; i < 4000; ++i) {
    const glm::dvec3 any = random_direction(random);
    twig += normal_sum(glm::normalize(any - glm::dot(any, axis) * axis), 1.0);
    tuft += normal_sum(glm::normalize(axis + 0.4 * any), 1.0);
    crown += normal_sum(any, 1.0);
  }
  EXPECT_NEAR(rounded(twig).along, 0.0, 0.04);
  EXPECT_GT(std::abs(glm::dot(axis_of(rounded(twig)), axis)), 0.99);
  EXPECT_GT(rounded(tuft).along, 0.8);
  EXPECT_GT(std::abs(glm::dot(axis_of(rounded(tuft)), axis)), 0.99);
  EXPECT_NEAR(rounded(crown).along, 1.0 / 3.0, 0.04);
}

TEST(NormalSum, LeavesOfBothSidesHaveNoFront) {
  const glm::dvec3 up(0, 1, 0);
  EXPECT_EQ(side_of(node_normals(normal_sum(up, 1.0, true) + normal_sum(-up, 0.9, true))), NormalSide::either);
  EXPECT_EQ(side_of(node_normals(normal_sum(up, 1.0, true) + normal_sum(-up, 0.1, true))), NormalSide::along);
  EXPECT_EQ(side_of(node_normals(normal_sum(-up, 1.0, true) + normal_sum(up, 0.1, false))), NormalSide::against);
  EXPECT_EQ(node_normals(NormalSum{}), kFlatNormals) << "nothing without area";
}

TEST(NormalSum, OrderOfMergesDoesNotMatter) {
  const Quad one{glm::vec3(0), glm::vec3(1, 0, 0), glm::vec3(1, 1, 0.5f), glm::vec3(0, 1, 0)};
  const Quad other{glm::vec3(0), glm::vec3(0, 1, 0), glm::vec3(0, 1, 1), glm::vec3(0.2f, 0, 1)};
  EXPECT_EQ(node_normals(quad_normal_sum(one) + quad_normal_sum(other)), node_normals(quad_normal_sum(other) + quad_normal_sum(one)));
}

// The light of leaves whose second moment is known, summed leaf by leaf: by the area that the eye sees of each.
TEST(LeafLight, IsAboutTheMeanOverTheLeaves) {
  std::mt19937 random(3);
  double squares = 0.0, bias = 0.0;
  int count = 0;
  for (const double spread : {0.0, 0.5, 1.0, 100.0})
    for (int trial = 0; trial < 40; ++trial) {
      const glm::dvec3 axis = random_direction(random), light = random_direction(random), eye = random_direction(random);
      NormalSum sum;
      double weights = 0.0, visible = 0.0, hidden = 0.0;
      for (int i = 0; i < 600; ++i) {
        const glm::dvec3 normal = glm::normalize(axis + spread * random_direction(random) * 0.999);
        sum += normal_sum(normal, 1.0);
        const double seen = glm::dot(normal, eye), cosine = glm::dot(normal, light) * (seen < 0.0 ? -1.0 : 1.0);
        weights += std::abs(seen);
        visible += std::abs(seen) * std::max(cosine, 0.0);
        hidden += std::abs(seen) * std::max(-cosine, 0.0);
      }
      const glm::vec2 shown = leaf_light(rounded(sum), glm::vec3(light), glm::vec3(eye));
      const double error = static_cast<double>(shown.x) - visible / weights, through = static_cast<double>(shown.y) - hidden / weights;
      squares += error * error + through * through;
      bias += error + through;
      count += 2;
      EXPECT_GE(shown.x, -1e-6f);
      EXPECT_GE(shown.y, -1e-6f);
    }
  EXPECT_LT(std::sqrt(squares / count), 0.04);
  EXPECT_LT(std::abs(bias / count), 0.01);
}

TEST(LeafLight, OfAFlatLeafIsLambertsCosine) {
  const ShadingNormals flat{{0.0f, 0.6f, 0.8f}, 1.0f, false}, sided{{0.0f, 0.6f, 0.8f}, 1.0f, true};
  const glm::vec3 light(0.0f, 1.0f, 0.0f);
  for (const glm::vec3& eye : {glm::vec3(0, 0, 1), glm::vec3(1, 0, 0.01f), glm::vec3(0, 1, 0)}) {
    EXPECT_NEAR(leaf_light(flat, light, glm::normalize(eye)).x, 0.6f, 1e-3f);
    EXPECT_NEAR(leaf_light(flat, light, glm::normalize(eye)).y, 0.0f, 1e-3f);
    EXPECT_NEAR(leaf_light(flat, light, -glm::normalize(eye)).x, 0.0f, 1e-3f);
    EXPECT_NEAR(leaf_light(flat, light, -glm::normalize(eye)).y, 0.6f, 1e-3f);
    EXPECT_NEAR(leaf_light(sided, light, -glm::normalize(eye)).x, 0.6f, 1e-3f) << "the front is lit, whoever looks";
  }
}

/// Upright blades.
Plant grass(const glm::vec3& normal) {
  Plant plant;
  plant.materials.push_back({.name = "grass"});
  for (std::uint32_t leaf = 0; leaf < 4; ++leaf) {
    const float x = static_cast<float>(leaf);
    for (const glm::vec3& corner : {glm::vec3(x, 0, 0), glm::vec3(x + 0.1f, 0, 0), glm::vec3(x, 1, 0.1f)}) {
      plant.foliage.positions.push_back(corner);
      plant.foliage.normals.push_back(normal);
      plant.foliage.indices.push_back(static_cast<std::uint32_t>(plant.foliage.indices.size()));
    }
    plant.foliage.triangle_materials.push_back(0);
    plant.leaves.push_back({leaf, 1});
  }
  return plant;
}

Foliage lit_foliage(const Plant& plant) {
  Foliage foliage;
  foliage.quads.resize(plant.leaves.size());
  add_leaf_normals(plant, foliage);
  return foliage;
}

TEST(LeafNormals, AnArtistsNormalsAreKeptWithTheirSide) {
  Plant plant = grass({0, 1, 0});
  find_sided_normals(plant);
  EXPECT_TRUE(plant.materials[0].sided_normals);
  EXPECT_EQ(plant.warnings.size(), 1u);
  for (const std::uint16_t bits : lit_foliage(plant).normals) {
    EXPECT_EQ(side_of(bits), NormalSide::along);
    EXPECT_EQ(along_step_of(bits), kAlongSteps);
    EXPECT_NEAR(unpack_normals(bits, {}).axis[1], 1.0f, 0.01f);
  }
}

TEST(LeafNormals, ThoseOfAnExporterAreNobodysChoice) {
  // A leaf folded at a right angle whose halves share the vertices of its rib, with the mean of both there, as files without a choice have.
  Plant plant;
  plant.materials.push_back({.name = "folded"});
  plant.foliage.positions = {{0, 0, 0}, {0, 1, 0}, {-1, 0.5f, 1}, {1, 0.5f, 1}};
  plant.foliage.indices = {0, 2, 1, 0, 1, 3};
  plant.foliage.normals = {{0, 0, 1}, {0, 0, 1}, glm::normalize(glm::vec3(1, 0, 1)), glm::normalize(glm::vec3(-1, 0, 1))};
  plant.foliage.triangle_materials = {0, 0};
  plant.leaves.push_back({0, 2});
  find_sided_normals(plant);
  EXPECT_FALSE(plant.materials[0].sided_normals);
  for (glm::vec3& normal : plant.foliage.normals) normal = {0, 1, 0};
  find_sided_normals(plant);
  EXPECT_TRUE(plant.materials[0].sided_normals);
}

TEST(LeafNormals, ACutThatWasExportedKeepsItsNodesNormals) {
  Plant plant = grass({0, 0.6f, 0.8f});
  plant.foliage.vertex_alongs.assign(plant.foliage.positions.size(), 0.4f);
  find_sided_normals(plant);
  EXPECT_FALSE(plant.materials[0].sided_normals) << "its normals are axes";
  for (const std::uint16_t bits : lit_foliage(plant).normals) {
    EXPECT_EQ(along_step_of(bits), 6u);
    EXPECT_EQ(side_of(bits), NormalSide::either);
  }
  plant.foliage.vertex_alongs.assign(plant.foliage.positions.size(), -1.0f);
  find_sided_normals(plant);
  EXPECT_TRUE(plant.materials[0].sided_normals);
}

TEST(LeafNormals, OwnNormalsCostNothing) {
  Plant plant = grass({0, -0.1f, 1});
  find_sided_normals(plant);
  EXPECT_FALSE(plant.materials[0].sided_normals);
  EXPECT_TRUE(plant.warnings.empty());
  const Foliage foliage = lit_foliage(plant);
  EXPECT_EQ(foliage.normals, std::vector<std::uint16_t>(4, kFlatNormals));
  EXPECT_NEAR(rounded(foliage.normal_sums[0]).along, 1.0f, 0.0f);
}

TEST(LeafNormals, AFoldedLeafHasItsWayFromStalkToTipAsAxis) {
  Plant plant;
  plant.materials.push_back({.name = "folded"});
  const glm::vec3 stalk(0), tip(0, 1, 0), left(-0.1f, 0.5f, 0.1f), right(0.1f, 0.5f, 0.1f);
  plant.foliage.positions = {stalk, right, tip, stalk, tip, left};
  plant.foliage.normals.assign(6, glm::vec3(0, 0, 1));
  plant.foliage.indices = {0, 1, 2, 3, 4, 5};
  plant.foliage.triangle_materials = {0, 0};
  plant.leaves.push_back({0, 2});
  const auto normals_with = [&](float lean) {
    Foliage foliage;
    foliage.quads = {{glm::vec3(-0.1f, 0, 0), glm::vec3(-0.1f, 1, lean), glm::vec3(0.1f, 1, lean), glm::vec3(0.1f, 0, 0)}};
    add_leaf_normals(plant, foliage);
    return foliage.normals[0];
  };
  EXPECT_EQ(normals_with(0.0f), pack_normals(17, 17, 0, NormalSide::either));
  EXPECT_EQ(normals_with(0.1f), pack_normals(19, 14, 0, NormalSide::either)) << "6 degrees off";
  EXPECT_EQ(normals_with(0.2f), pack_normals(17, 17, 0, NormalSide::either)) << "11 degrees off";
}

TEST(LeafNormals, TurnToTheCrownOnRequest) {
  Plant plant = grass({0, 0, 1});
  turn_normals_to_crown(plant, 0.0f);
  EXPECT_EQ(plant.foliage.normals[0], glm::vec3(0, 0, 1));
  EXPECT_FALSE(plant.materials[0].sided_normals);
  turn_normals_to_crown(plant, 1.0f);
  EXPECT_TRUE(plant.materials[0].sided_normals);
  EXPECT_LT(plant.foliage.normals[0].x, 0.0f) << "the first blade stands on the left";
  EXPECT_GT(plant.foliage.normals[9].x, 0.0f);
}

}  // namespace coppice::bake::normal_sum_test
