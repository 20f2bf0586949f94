#include "vertex_colors.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <vector>

#include "mentions.h"
#include "node_names.h"
#include "triangle_soup.h"

namespace coppice::bake::vertex_colors_test {

/// Forty leaves of four vertices, at heights of 0 to 4 m; along is 0 at the stalk, 1 at the tip; random is one number a leaf.
struct LeafPoint {
  float height_m = 0.0f, along = 0.0f, random = 0.0f;
};
std::vector<ColoredVertex> leaves(const std::function<glm::vec3(const LeafPoint&)>& color) {
  std::minstd_rand random(7);
  std::vector<ColoredVertex> vertices;
  for (std::uint32_t leaf = 0; leaf < 40; ++leaf) {
    const float phase = static_cast<float>(random() % 1000) / 999.0f;
    const float stalk_m = 4.0f * static_cast<float>(random() % 1000) / 999.0f;
    for (int k = 0; k < 4; ++k) {
      const float along = k == 1 || k == 2 ? 1.0f : 0.0f;
      const glm::vec3 position(phase, stalk_m + 0.1f * along, 0.1f * static_cast<float>(k));
      vertices.push_back({position, color({position.y, along, phase}), leaf});
    }
  }
  return vertices;
}

TEST(WindWeights, AreToldByHowTheirChannelsVary) {
  using Point = LeafPoint;
  EXPECT_TRUE(looks_like_wind(leaves([](const Point& p) { return glm::vec3(p.along, p.random, p.height_m / 4.0f); }))) << "one of each";
  EXPECT_TRUE(looks_like_wind(leaves([](const Point& p) { return glm::vec3(p.along, 0.0f, 0.0f); }))) << "stalk to tip";
  EXPECT_TRUE(looks_like_wind(leaves([](const Point& p) { return glm::vec3(0.0f, p.height_m / 5.0f, 1.0f); }))) << "by height";
  EXPECT_TRUE(looks_like_wind(leaves([](const Point& p) { return glm::vec3(p.random, 0.0f, 0.0f); }))) << "a phase a leaf";
  EXPECT_TRUE(looks_like_wind(leaves([](const Point& p) { return glm::vec3(p.along); }))) << "grey from black to white in each leaf";
}

TEST(WindWeights, ColoursAreNone) {
  using Point = LeafPoint;
  const glm::vec3 green(0.1f, 0.4f, 0.05f), pale(0.6f, 0.8f, 0.3f), brown(0.3f, 0.18f, 0.08f), red(0.6f, 0.1f, 0.05f);
  const auto mix = [](const glm::vec3& a, const glm::vec3& b, float t) { return a + t * (b - a); };
  EXPECT_FALSE(looks_like_wind(leaves([&](const Point&) { return green; }))) << "one colour";
  EXPECT_FALSE(looks_like_wind(leaves([&](const Point& p) { return mix(green, pale, p.along); }))) << "pale tips";
  EXPECT_FALSE(looks_like_wind(leaves([&](const Point& p) { return mix(glm::vec3(0.0f), pale, p.height_m / 4.1f); }))) << "dark below";
  EXPECT_FALSE(looks_like_wind(leaves([&](const Point& p) { return mix(brown, green, p.height_m / 4.1f); }))) << "brown below";
  EXPECT_FALSE(looks_like_wind(leaves([&](const Point& p) { return mix(green, red, p.random); }))) << "autumn";
  EXPECT_FALSE(looks_like_wind(leaves([&](const Point& p) { return (0.7f + 0.3f * p.random) * green; }))) << "lighter and darker";
  EXPECT_FALSE(looks_like_wind(leaves([](const Point& p) { return glm::vec3(0.3f + 0.7f * p.along); }))) << "light in the crown";
  EXPECT_FALSE(looks_like_wind(leaves([](const Point& p) { return glm::vec3(p.random); }))) << "grey a leaf";
  EXPECT_FALSE(looks_like_wind({}));
}

TEST(WindWeights, AreNamed) {
  for (const char* name : {"wind", "tree_wind", "WindLeaves", "leaf.Sway", "grass bend 2", "leafFlutter"})
    EXPECT_TRUE(names_wind(name)) << name;
  for (const char* name : {"", "window", "Windswept", "unwind", "bender", "leaves", "bark"}) EXPECT_FALSE(names_wind(name)) << name;
}

/// A green leaf of 1 m^2 and a brown one of 3, of one material.
TriangleSoup two_leaves() {
  TriangleSoup soup;
  for (const float size : {1.0f, 3.0f}) {
    const auto first = static_cast<std::uint32_t>(soup.mesh.positions.size());
    for (const glm::vec2& corner : {glm::vec2(0.0f), glm::vec2(2.0f, 0.0f), glm::vec2(0.0f, size)}) {
      soup.mesh.positions.emplace_back(corner, size);
      soup.mesh.normals.emplace_back(0.0f, 0.0f, 1.0f);
      soup.mesh.uvs.emplace_back(0.0f);
      soup.vertex_instances.push_back(0);
      soup.vertex_colors.push_back(size == 1.0f ? glm::vec4(0.2f, 0.8f, 0.0f, 1.0f) : glm::vec4(0.6f, 0.4f, 0.0f, 1.0f));
    }
    for (const std::uint32_t k : {0u, 1u, 2u}) soup.mesh.indices.push_back(first + k);
    soup.mesh.triangle_materials.push_back(0);
  }
  return soup;
}

TEST(VertexColours, BecomeTheMaterialsMeanAndWhatEachTriangleIsOfIt) {
  TriangleSoup soup = two_leaves();
  std::vector<Material> materials{{.name = "leaf"}};
  std::vector<std::string> warnings;
  apply_vertex_colors(soup, materials, warnings);
  EXPECT_NEAR(materials[0].base_color.r, 0.5f, 1e-6f);
  EXPECT_NEAR(materials[0].base_color.g, 0.5f, 1e-6f);
  EXPECT_EQ(materials[0].base_color.b, 0.0f);
  ASSERT_EQ(soup.mesh.triangle_tints.size(), 2u);
  EXPECT_NEAR(soup.mesh.triangle_tints[0].r, 0.4f, 1e-6f);
  EXPECT_NEAR(soup.mesh.triangle_tints[1].g, 0.8f, 1e-6f);
  EXPECT_EQ(soup.mesh.triangle_tints[1].b, 1.0f) << "of nothing, nothing is a share";
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(test::mentions(warnings[0], {"'leaf'"}));
}

TEST(VertexColours, OfAMeshCalledAfterWindAreNoColours) {
  TriangleSoup soup = two_leaves();
  soup.wind_materials = {0};
  std::vector<Material> materials{{.name = "leaf"}};
  std::vector<std::string> warnings;
  apply_vertex_colors(soup, materials, warnings);
  EXPECT_EQ(materials[0].base_color, glm::vec4(1.0f));
  for (const glm::vec3& tint : soup.mesh.triangle_tints) EXPECT_EQ(tint, glm::vec3(1.0f));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(test::mentions(warnings[0], {"'leaf'"}));
}

}  // namespace coppice::bake::vertex_colors_test
