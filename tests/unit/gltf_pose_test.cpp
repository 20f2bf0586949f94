// The rest pose of skins and morph targets, against positions computed by hand.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include "gltf_builder.h"
#include "imported.h"

namespace coppice::test::gltf_pose_test {

using nlohmann::json;

/// The same four joints and weights for each vertex of the leaf.
void add_joints(GltfBuilder& builder, const std::array<std::uint8_t, 4>& joints, const std::array<float, 4>& weights) {
  std::vector<std::uint8_t> all_joints;
  std::vector<float> all_weights;
  for (int vertex = 0; vertex < 4; ++vertex) {
    all_joints.insert(all_joints.end(), joints.begin(), joints.end());
    all_weights.insert(all_weights.end(), weights.begin(), weights.end());
  }
  builder.primitive()["attributes"]["JOINTS_0"] = builder.add_accessor(builder.add_view(all_joints), kUnsignedByte, "VEC4", 4);
  builder.primitive()["attributes"]["WEIGHTS_0"] = builder.add_accessor(builder.add_view(all_weights), kFloat, "VEC4", 4);
}

/// A skin of these nodes for the leaf's, whose own transform is to be ignored.
void add_skin(GltfBuilder& builder, const std::vector<int>& joints) {
  builder.json["skins"] = {{{"joints", joints}}};
  builder.json["nodes"][0]["skin"] = 0;
  builder.json["nodes"][0]["translation"] = {7, 8, 9};
}

/// As Blender writes it: the armature's scale is that of centimetres.
TEST(RestPose, ASkinnedMeshFollowsItsJointsAndNotItsNode) {
  GltfBuilder builder = small_plant();
  const int joint = builder.add_node(-1, {{"translation", {0, 100, 0}}});
  builder.json["scenes"][0]["nodes"].erase(2);
  builder.add_node(-1, {{"scale", {0.5, 0.5, 0.5}}, {"children", {joint}}});
  add_skin(builder, {joint});
  // Down by 98 before the joint puts it up by 100.
  builder.json["skins"][0]["inverseBindMatrices"] =
      builder.add_accessor(builder.add_view(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -98, 0, 1}), kFloat, "MAT4", 1);
  add_joints(builder, {0, 0, 0, 0}, {1, 0, 0, 0});
  const bake::Plant plant = imported(builder);
  ASSERT_EQ(plant.leaves.size(), 1u);
  expect_near(plant.foliage.positions.at(0), {0, 1, 0});
  expect_near(plant.foliage.positions.at(2), {0.5f, 1.5f, 0});
  expect_near(plant.foliage.normals.at(0), {0, 0, 1});
  expect_warning(plant, {"1", "skins"});
}

TEST(RestPose, WeightsAreSharesOfTheirSumAndNoneIsTheFirstJoint) {
  GltfBuilder builder = small_plant();
  const int left = builder.add_node(-1, {{"translation", {-1, 0, 0}}}), right = builder.add_node(-1, {{"translation", {3, 0, 0}}});
  add_skin(builder, {left, right});
  GltfBuilder unweighted = builder;
  add_joints(builder, {0, 1, 0, 0}, {0.25f, 0.25f, 0, 0});
  expect_near(imported(builder).foliage.positions.at(0), {1, 0, 0});
  add_joints(unweighted, {1, 0, 0, 0}, {0, 0, 0, 0});
  expect_near(imported(unweighted).foliage.positions.at(0), {3, 0, 0});
}

TEST(RestPose, WithoutJointsASkinSaysNothing) {
  GltfBuilder builder = small_plant();
  add_skin(builder, {1});
  builder.json["nodes"][0]["translation"] = {0.5, 0, 0};
  expect_near(imported(builder).foliage.positions.at(0), {0.5f, 0, 0});
}

TEST(RestPose, ABadSkinIsRefused) {
  GltfBuilder builder = small_plant();
  add_skin(builder, {1});
  add_joints(builder, {2, 0, 0, 0}, {1, 0, 0, 0});
  expect_error(import_built(builder), Status::bad_file, {"meshes[0].primitives[0]", "vertex 0"});
  builder.json["skins"][0]["joints"] = {5};
  expect_error(import_built(builder), Status::bad_file, {"skins[0].joints[0]", "5"});
  builder.json["skins"][0] = {{"joints", {1, 1}},
                              {"inverseBindMatrices", builder.add_accessor(builder.add_view(std::vector<float>(16)), kFloat, "MAT4", 1)}};
  expect_error(import_built(builder), Status::bad_file, {"skins[0].inverseBindMatrices"});
  builder.json["skins"][0] = {{"name", "empty"}};
  expect_error(import_built(builder), Status::bad_file, {"skins[0].joints"});
}

/// A target that lifts the leaf by 2 and turns its normals, and one that is not to be used.
GltfBuilder morphed() {
  GltfBuilder builder = small_plant();
  const int up = builder.add_positions(std::vector<glm::vec3>(4, {0, 2, 0}));
  const int aside = builder.add_positions(std::vector<glm::vec3>(4, {5, 0, 0}));
  builder.primitive()["targets"] = {{{"POSITION", up}}, {{"POSITION", aside}}};
  return builder;
}

TEST(RestPose, MorphWeightsAreTheNodesElseTheMeshs) {
  GltfBuilder builder = morphed();
  expect_near(imported(builder).foliage.positions.at(0), {0, 0, 0});
  builder.json["meshes"][0]["weights"] = {0.5, 0};
  const bake::Plant plant = imported(builder);
  expect_near(plant.foliage.positions.at(0), {0, 1, 0});
  expect_warning(plant, {"1", "morph weights"});
  builder.json["nodes"][0]["weights"] = {-0.25, 0};
  expect_near(imported(builder).foliage.positions.at(0), {0, -0.5f, 0});
}

TEST(RestPose, NodesMayShowOneMeshInSeveralWays) {
  GltfBuilder builder = morphed();
  builder.json["meshes"][0]["weights"] = {0.5, 0};
  builder.add_node(0, {{"translation", {2, 0, 0}}});
  builder.add_node(0, {{"translation", {4, 0, 0}}, {"weights", {0, 0}}});
  builder.add_node(0, {{"translation", {6, 0, 0}}, {"weights", {1, 0}}});
  const bake::Plant plant = imported(builder);
  ASSERT_EQ(plant.leaves.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::array<float, 4> lifted{1, 1, 0, 2};
    expect_near(plant.foliage.positions.at(4 * i), {2.0f * static_cast<float>(i), lifted.at(i), 0});
  }
}

TEST(RestPose, ABadMorphIsRefused) {
  GltfBuilder builder = morphed();
  builder.json["meshes"][0]["weights"] = {1, 0};
  builder.primitive()["targets"][0]["POSITION"] = builder.add_positions({{0, 0, 0}});
  expect_error(import_built(builder), Status::bad_file, {"meshes[0].primitives[0]", "POSITION", "1", "4"});
  builder.primitive()["targets"][0]["POSITION"] = 99;
  expect_error(import_built(builder), Status::bad_file, {"meshes[0].primitives[0].targets[0].POSITION", "99"});
  builder = morphed();
  builder.json["meshes"][0]["weights"] = {"much"};
  expect_error(import_built(builder), Status::bad_file, {"meshes[0].weights"});
  builder.json["meshes"][0]["weights"] = std::vector<double>(5000, 0.0);
  expect_error(import_built(builder), Status::unsupported, {"meshes[0].weights", "4096"});
}

TEST(RestPose, AFewBytesDoNotAskForMuchWork) {
  GltfBuilder builder = small_plant();
  const int positions = builder.add_accessor(builder.add_view(std::vector<glm::vec3>(1u << 16)), kFloat, "VEC3", 1u << 16);
  builder.primitive()["attributes"]["POSITION"] = positions;
  builder.primitive()["targets"] = json::array();
  builder.json["meshes"][0]["weights"] = json::array();
  for (int i = 0; i < 3000; ++i) {
    builder.primitive()["targets"].push_back({{"POSITION", positions}});
    builder.json["meshes"][0]["weights"].push_back(1);
  }
  for (const int mode : {4, 1}) {
    builder.primitive()["mode"] = mode;
    expect_error(import_built(builder), Status::unsupported, {"nodes[0]", "196673536", "--max-source-triangles"});
  }
}

TEST(RestPose, AnimationIsSaidToBeLost) {
  GltfBuilder builder = small_plant();
  builder.json["animations"] = {{{"channels", json::array()}, {"samplers", json::array()}}};
  expect_warning(imported(builder), {"animation"});
}

}  // namespace coppice::test::gltf_pose_test
