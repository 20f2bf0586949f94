// Needles and blades that a file holds as line primitives.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "gltf_builder.h"
#include "imported.h"

namespace coppice::bake::gltf_lines_test {

using nlohmann::json;
using test::GltfBuilder;
using test::imported;

enum Mode { kLines = 1, kLoop = 2, kStrip = 3 };

/// A triangle of bark, 1 m high, and lines of the material "needles".
GltfBuilder with_lines(int mode, const std::vector<glm::vec3>& positions, const std::optional<std::vector<std::uint16_t>>& indices = {}) {
  GltfBuilder builder = test::small_plant();
  builder.json["materials"][0]["name"] = "needles";
  std::optional<int> order;
  if (indices) order = builder.add_indices(*indices);
  builder.json["nodes"][0]["mesh"] = builder.add_mesh({{"POSITION", builder.add_positions(positions)}}, order, 0, mode);
  return builder;
}

/// Needles of 0.1 m along x at different heights; every fourth is half as long.
std::vector<glm::vec3> needles(int count) {
  std::vector<glm::vec3> ends;
  for (int i = 0; i < count; ++i) {
    const glm::vec3 from(0.2f, 0.05f * static_cast<float>(i), 0.0f);
    ends.push_back(from);
    ends.push_back(from + glm::vec3(i % 4 == 3 ? 0.05f : 0.1f, 0.0f, 0.0f));
  }
  return ends;
}

/// The distance between the two corners of a leaf that stand at its first one's end of the line.
float width_m(const Plant& plant, std::size_t leaf) {
  const std::size_t first = std::size_t{3} * plant.leaves.at(leaf).first_triangle;
  return glm::distance(test::corner(plant.foliage, first), test::corner(plant.foliage, first + 1));
}

TEST(GltfLines, EachNeedleIsAThinLeafOfOneWidth) {
  const Plant plant = imported(with_lines(kLines, needles(40)));
  ASSERT_EQ(plant.leaves.size(), 40u);
  EXPECT_EQ(plant.wood.triangle_materials.size(), 1u);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(plant.leaves[i].triangle_count, 2u);
    EXPECT_NEAR(width_m(plant, i), 0.005f, 1e-5f);
  }
  test::expect_warning(plant, {"40", "5"});
}

TEST(GltfLines, WidthsAreToldInMillimetresOfThePlant) {
  GltfBuilder builder = with_lines(kLines, needles(10));
  builder.json["nodes"][0]["scale"] = {2, 2, 2};
  builder.add_node(builder.json["nodes"][0]["mesh"]);
  test::expect_warning(imported(builder), {"20", "5", "10"});
}

TEST(GltfLines, NoneIsWiderThanAQuarterOfItsLength) {
  std::vector<glm::vec3> positions = needles(20);
  positions.insert(positions.end(), {{0.3f, 2.0f, 0.0f}, {0.304f, 2.0f, 0.0f}});
  const Plant plant = imported(with_lines(kLines, positions));
  ASSERT_EQ(plant.leaves.size(), 21u);
  EXPECT_NEAR(width_m(plant, 20), 0.001f, 1e-5f);
}

TEST(GltfLines, StripsLieAboutTheirLinesInAllDirections) {
  const Plant plant = imported(with_lines(kLines, needles(40)));
  float up_m = 0.0f, side_m = 0.0f;
  for (std::size_t i = 0; i < plant.leaves.size(); ++i) {
    const std::size_t first = std::size_t{3} * plant.leaves[i].first_triangle;
    const glm::vec3 across = test::corner(plant.foliage, first + 1) - test::corner(plant.foliage, first);
    EXPECT_NEAR(across.x, 0.0f, 1e-6f);
    up_m += std::abs(across.y);
    side_m += std::abs(across.z);
  }
  EXPECT_NEAR(up_m, side_m, 0.05f * side_m) << "a plant is as dense from above as from the side";
}

/// A blade of four segments that turns by 0.3 rad at each, and the way back to its root or somewhere else.
std::vector<glm::vec3> blade() {
  std::vector<glm::vec3> points{{0.3f, 0.0f, 0.0f}};
  for (int i = 0; i < 4; ++i) {
    const float angle = 0.3f * static_cast<float>(i);
    points.push_back(points.back() + 0.1f * glm::vec3(std::sin(angle), std::cos(angle), 0.0f));
  }
  return points;
}

TEST(GltfLines, AChainIsOneLeafHoweverItIsWritten) {
  const std::vector<glm::vec3> points = blade();
  std::vector<glm::vec3> separate;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) separate.insert(separate.end(), {points[i], points[i + 1]});
  const std::vector<std::uint16_t> backwards{4, 3, 1, 2, 3, 2, 0, 1};
  for (const GltfBuilder& builder : {with_lines(kStrip, points), with_lines(kLines, separate), with_lines(kLines, points, backwards)}) {
    const Plant plant = imported(builder);
    ASSERT_EQ(plant.leaves.size(), 1u);
    EXPECT_EQ(plant.leaves[0].triangle_count, 8u);
    float area_m2 = 0.0f;
    for (std::size_t t = 0; t < 24; t += 3) {
      const glm::vec3 a = test::corner(plant.foliage, t);
      area_m2 += 0.5f * glm::length(glm::cross(test::corner(plant.foliage, t + 1) - a, test::corner(plant.foliage, t + 2) - a));
    }
    EXPECT_NEAR(area_m2, 0.4f * 0.01f, 0.0002f);
  }
}

TEST(GltfLines, SharpCornersAndForksEndALine) {
  // Three sides of a square, and the fourth.
  const std::vector<glm::vec3> square{{1.0f, 0.0f, 0.0f}, {1.2f, 0.0f, 0.0f}, {1.2f, 0.2f, 0.0f}, {1.0f, 0.2f, 0.0f}};
  EXPECT_EQ(imported(with_lines(kStrip, square)).leaves.size(), 3u);
  EXPECT_EQ(imported(with_lines(kLoop, square)).leaves.size(), 4u);
  // Three needles out of one point, two of which lie in a line.
  const std::vector<glm::vec3> fan{{1.0f, 0.0f, 0.0f}, {1.2f, 0.0f, 0.0f}, {0.8f, 0.0f, 0.0f}, {1.0f, 0.2f, 0.0f}};
  EXPECT_EQ(imported(with_lines(kLines, fan, std::vector<std::uint16_t>{0, 1, 0, 2, 0, 3})).leaves.size(), 3u);
}

TEST(GltfLines, ARingIsOneLeaf) {
  std::vector<glm::vec3> ring;
  for (int i = 0; i < 12; ++i) {
    const float angle = 0.5236f * static_cast<float>(i);
    ring.emplace_back(std::cos(angle), 1.0f, std::sin(angle));
  }
  const Plant plant = imported(with_lines(kLoop, ring));
  ASSERT_EQ(plant.leaves.size(), 1u);
  EXPECT_EQ(plant.leaves[0].triangle_count, 24u);
}

TEST(GltfLines, TheyFollowSkinsAndMorphWeights) {
  GltfBuilder builder = with_lines(kLines, needles(40));
  json& mesh = builder.json["meshes"].back();
  mesh["weights"] = {0.5};
  mesh["primitives"][0]["targets"] = {{{"POSITION", builder.add_positions(std::vector<glm::vec3>(80, {0, 2, 0}))}}};
  const float morphed_y = test::corner(imported(builder).foliage, 0).y;
  EXPECT_NEAR(morphed_y, 1.0f, 0.01f);
  builder.json["skins"] = {{{"joints", {builder.add_node(-1, {{"scale", {2, 2, 2}}})}}}};
  builder.json["nodes"][0]["skin"] = 0;
  json& attributes = builder.json["meshes"].back()["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = builder.add_accessor(builder.add_view(std::vector<std::uint8_t>(320, 0)), test::kUnsignedByte, "VEC4", 80);
  attributes["WEIGHTS_0"] = builder.add_accessor(builder.add_view(std::vector<float>(320, 0.25f)), test::kFloat, "VEC4", 80);
  const Plant skinned = imported(builder);
  EXPECT_NEAR(test::corner(skinned.foliage, 0).y, 2.0f, 0.02f);
  EXPECT_NEAR(width_m(skinned, 0), 0.01f, 1e-5f);
}

TEST(GltfLines, ColoursOfTheEndsTint) {
  GltfBuilder builder = with_lines(kLines, needles(8));
  const int view = builder.add_view(std::vector<glm::vec4>(16, glm::vec4(0.5f, 0.25f, 0.125f, 1.0f)));
  json& attributes = builder.json["meshes"].back()["primitives"][0]["attributes"];
  attributes["COLOR_0"] = builder.add_accessor(view, test::kFloat, "VEC4", 16);
  const Plant plant = imported(builder);
  EXPECT_NEAR(plant.materials.at(plant.foliage.triangle_materials.at(0)).base_color.g, 0.25f, 1e-5f);
  attributes["COLOR_0"] = builder.add_accessor(view, test::kFloat, "VEC4", 15);
  test::expect_error(test::import_built(builder), Status::bad_file, {"meshes[2].primitives[0]", "COLOR_0"});
}

TEST(GltfLines, PointsAndLinesWithoutLengthAreLeftOutWithAWarning) {
  for (const int mode : {0, 1}) {
    const Plant plant = imported(with_lines(mode, std::vector<glm::vec3>(6, glm::vec3(1.0f))));
    EXPECT_TRUE(plant.leaves.empty());
    EXPECT_EQ(plant.wood.triangle_materials.size(), 1u);
    EXPECT_EQ(plant.warnings.size(), 2u) << "that, and that there are no leaves";
  }
}

TEST(GltfLines, WhatIsWrongIsNamed) {
  test::expect_error(test::import_built(with_lines(kLines, needles(2), std::vector<std::uint16_t>{0, 1, 2, 4})), Status::bad_file,
                     {"meshes[2].primitives[0]", "accessors[3] element 3"});
  std::vector<glm::vec3> broken = needles(2);
  broken[1].x = std::nanf("");
  test::expect_error(test::import_built(with_lines(kLines, broken)), Status::bad_file,
                     {"meshes[2].primitives[0]", "accessors[3] element 1"});
  // Primitives that share their ends ask for more than the file has.
  GltfBuilder builder = with_lines(kLines, needles(20000));
  const json primitive = builder.json["meshes"].back()["primitives"][0];
  for (int i = 0; i < 60; ++i) builder.json["meshes"].back()["primitives"].push_back(primitive);
  test::expect_error(test::import_built(builder, {.max_source_triangles = 1000000}), Status::unsupported,
                     {"meshes[2]", "--max-source-triangles"});
}

}  // namespace coppice::bake::gltf_lines_test
