#include "find_leaves.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "triangle_soup.h"

namespace coppice::bake::find_leaves_test {

/// Grows a soup out of shapes. Every shape has vertices of its own.
struct SoupBuilder {
  TriangleSoup soup;
  std::uint32_t material = 0, instance = 0;

  std::uint32_t vertex(const glm::vec3& position) {
    soup.mesh.positions.push_back(position);
    soup.mesh.normals.emplace_back(0.0f, 1.0f, 0.0f);
    soup.mesh.uvs.emplace_back(0.0f);
    soup.vertex_instances.push_back(instance);
    return static_cast<std::uint32_t>(soup.mesh.positions.size() - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    soup.mesh.indices.insert(soup.mesh.indices.end(), {a, b, c});
    soup.mesh.triangle_materials.push_back(material);
  }
  void card(const std::array<glm::vec3, 4>& corners) {
    const std::uint32_t a = vertex(corners[0]), b = vertex(corners[1]), c = vertex(corners[2]), d = vertex(corners[3]);
    triangle(a, b, c);
    triangle(a, c, d);
  }
};

/// Where leaf i of a crown is: a stalk on a helix of 1 m radius and 4 m height, and the way the leaf grows. No two touch.
struct Place {
  glm::vec3 stalk, along, across;
  [[nodiscard]] glm::vec3 normal() const { return glm::cross(along, across); }
};

Place place(std::uint32_t i) {
  const float angle = 2.4f * static_cast<float>(i), tilt = 0.3f + 0.1f * static_cast<float>(i % 7);
  const glm::vec3 out(std::cos(angle), 0.0f, std::sin(angle)), side(-out.z, 0.0f, out.x);
  return {out + glm::vec3(0.0f, 4.0f * std::fmod(static_cast<float>(i) * 0.618f, 1.0f), 0.0f),
          std::cos(tilt) * out + std::sin(tilt) * glm::vec3(0.0f, 1.0f, 0.0f), side};
}

glm::vec3 at(const Place& where, float along_m, float across_m) {
  return where.stalk + along_m * where.along + across_m * where.across;
}

/// A bent leaf of four triangles in two halves along its midrib; halves share vertices, or have a seam between them.
void add_leaf(SoupBuilder& builder, const Place& where, bool seam = false, float size_m = 0.1f) {
  const glm::vec3 sag(0.0f, -0.1f * size_m, 0.0f);
  const glm::vec3 stalk = where.stalk, tip = at(where, size_m, 0.0f) + sag;
  const glm::vec3 left = at(where, 0.5f * size_m, 0.25f * size_m), right = at(where, 0.5f * size_m, -0.25f * size_m);
  const glm::vec3 middle = at(where, 0.5f * size_m, 0.0f) + 0.5f * sag;
  std::uint32_t s = builder.vertex(stalk), m = builder.vertex(middle), t = builder.vertex(tip);
  const std::uint32_t l = builder.vertex(left);
  builder.triangle(s, m, l);
  builder.triangle(m, t, l);
  if (seam) s = builder.vertex(stalk), m = builder.vertex(middle), t = builder.vertex(tip);
  const std::uint32_t r = builder.vertex(right);
  builder.triangle(s, r, m);
  builder.triangle(m, r, t);
}

/// An open tube of six sides.
void add_tube(SoupBuilder& builder, const glm::vec3& from, const glm::vec3& to, float radius_m) {
  const glm::vec3 axis = glm::normalize(to - from);
  const glm::vec3 x = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0)));
  const glm::vec3 y = glm::cross(axis, x);
  std::vector<std::uint32_t> ring;
  for (int i = 0; i < 6; ++i) {
    const float angle = static_cast<float>(i) * static_cast<float>(std::numbers::pi) / 3.0f;
    const glm::vec3 out = radius_m * (std::cos(angle) * x + std::sin(angle) * y);
    ring.push_back(builder.vertex(from + out));
    ring.push_back(builder.vertex(to + out));
  }
  for (std::size_t i = 0; i < 12; i += 2) {
    builder.triangle(ring[i], ring[(i + 2) % 12], ring[i + 1]);
    builder.triangle(ring[i + 1], ring[(i + 2) % 12], ring[(i + 3) % 12]);
  }
}

/// A blade of two rows of quads that goes up, over and down again in half a circle.
void add_blade(SoupBuilder& builder, const Place& where, float radius_m) {
  constexpr int kSegments = 8;
  const glm::vec3 up(0.0f, 1.0f, 0.0f), out = glm::normalize(where.along * glm::vec3(1.0f, 0.0f, 1.0f));
  std::array<std::uint32_t, 3> before{};
  for (int i = 0; i <= kSegments; ++i) {
    const float angle = static_cast<float>(std::numbers::pi) * static_cast<float>(i) / kSegments;
    const glm::vec3 middle = where.stalk + radius_m * ((1.0f - std::cos(angle)) * out + std::sin(angle) * up);
    std::array<std::uint32_t, 3> now{};
    for (std::size_t k = 0; k < 3; ++k) now[k] = builder.vertex(middle + 0.05f * radius_m * (static_cast<float>(k) - 1.0f) * where.across);
    for (std::size_t k = 0; k < 2 && i > 0; ++k) {
      builder.triangle(before[k], before[k + 1], now[k + 1]);
      builder.triangle(before[k], now[k + 1], now[k]);
    }
    before = now;
  }
}

void add_trunk(SoupBuilder& builder) {
  add_tube(builder, {0.0f, -1.0f, 0.0f}, {0.0f, 4.0f, 0.0f}, 0.15f);
}

/// A trunk of material 0; what follows is of material 1.
SoupBuilder with_trunk() {
  SoupBuilder builder;
  add_trunk(builder);
  builder.material = 1;
  return builder;
}

/// Materials of these names, grey and opaque.
std::vector<Material> materials_of(const std::vector<std::string>& names) {
  std::vector<Material> materials;
  for (const std::string& name : names) {
    Material material;
    material.name = name;
    material.base_color = glm::vec4(0.5f, 0.5f, 0.5f, 1.0f);
    materials.push_back(material);
  }
  return materials;
}

FoundParts find(const SoupBuilder& builder, const std::vector<std::string>& names) {
  const std::vector<Material> materials = materials_of(names);
  return find_leaves(builder.soup, materials, {}, std::vector<std::vector<MaterialRule>>(materials.size()));
}

/// Every leaf has so many triangles.
void expect_leaves(const FoundParts& found, std::size_t count, std::uint32_t triangle_count) {
  EXPECT_EQ(found.leaves.size(), count);
  for (const LeafRange& leaf : found.leaves) ASSERT_EQ(leaf.triangle_count, triangle_count);
}

TEST(FindLeaves, UnnamedMaterialsByShapeAndRepetition) {
  SoupBuilder builder = with_trunk();
  for (std::uint32_t i = 0; i < 300; ++i) add_leaf(builder, place(i));
  const FoundParts found = find(builder, {"", ""});
  expect_leaves(found, 300, 4);
  EXPECT_EQ(found.wood.triangle_materials, std::vector<std::uint32_t>(12, 0));
}

TEST(FindLeaves, OneMaterialForEverything) {
  SoupBuilder builder;
  add_trunk(builder);
  for (std::uint32_t i = 0; i < 300; ++i) {
    add_leaf(builder, place(i));
    if (i % 10 == 0) add_tube(builder, {0.0f, place(i).stalk.y, 0.0f}, place(i).stalk - 0.01f * place(i).along, 0.01f);
  }
  const FoundParts found = find(builder, {"Material.001"});
  expect_leaves(found, 300, 4);
  EXPECT_EQ(found.wood.triangle_materials.size(), 12u * 31u);
}

TEST(FindLeaves, TextureSeamsDoNotSplitALeaf) {
  for (const std::uint32_t every : {1u, 5u}) {
    SoupBuilder builder;
    for (std::uint32_t i = 0; i < 100; ++i) add_leaf(builder, place(i), i % every == 0);
    expect_leaves(find(builder, {"leaves"}), 100, 4);
  }
}

TEST(FindLeaves, WithoutIndicesToo) {
  SoupBuilder indexed, loose;
  for (std::uint32_t i = 0; i < 100; ++i) add_leaf(indexed, place(i));
  for (std::size_t i = 0; i < indexed.soup.mesh.indices.size(); i += 3) {
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) corners[k] = loose.vertex(indexed.soup.mesh.positions[indexed.soup.mesh.indices[i + k]]);
    loose.triangle(corners[0], corners[1], corners[2]);
  }
  expect_leaves(find(loose, {"leaves"}), 100, 4);
}

/// Three leaves fan out of one point.
void add_whorl(SoupBuilder& builder, std::uint32_t i) {
  const Place where = place(i);
  for (int k = -1; k <= 1; ++k) {
    const float turn = 0.9f * static_cast<float>(k);
    const glm::vec3 normal = where.normal();
    const glm::vec3 along = std::cos(turn) * where.along + std::sin(turn) * where.across;
    add_leaf(builder, {where.stalk, along, glm::cross(normal, along)});
  }
}

/// Vertices at one place become one, as exporters do that merge by distance.
TriangleSoup merged_by_distance(TriangleSoup soup) {
  for (std::uint32_t& index : soup.mesh.indices)
    for (std::uint32_t i = 0; i < index; ++i)
      if (glm::distance(soup.mesh.positions[i], soup.mesh.positions[index]) < 1e-6f) index = i;
  return soup;
}

TEST(FindLeaves, LeavesThatTouchInAPointOrShareAVertexStayApart) {
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 60; ++i) add_whorl(builder, i);
  expect_leaves(find(builder, {"leaves"}), 180, 4);
  builder.soup = merged_by_distance(std::move(builder.soup));
  expect_leaves(find(builder, {"leaves"}), 180, 4);
}

TEST(FindLeaves, CardsThatShareAnEdgeHereAndThereStayApart) {
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Place where = place(i);
    const std::array<glm::vec3, 4> corners{at(where, 0.0f, -0.02f), at(where, 0.1f, -0.02f), at(where, 0.1f, 0.02f),
                                           at(where, 0.0f, 0.02f)};
    builder.card(corners);
    const glm::vec3 normal = where.normal();
    if (i % 5 == 0) builder.card({corners[3], corners[2], corners[2] + 0.04f * normal, corners[3] + 0.04f * normal});
  }
  expect_leaves(find(builder, {"leaves"}), 120, 2);
}

TEST(FindLeaves, ALeafModelledOncePerSideIsOne) {
  for (const bool shared_vertices : {true, false}) {
    SoupBuilder builder;
    for (std::uint32_t i = 0; i < 100; ++i) {
      add_leaf(builder, place(i));
      // Back sides, in the opposite winding; some leaves have none.
      if (i % 4 == 0) continue;
      const auto& indices = builder.soup.mesh.indices;
      for (std::size_t first = indices.size() - 12, k = 0; k < 12; k += 3) {
        std::array<std::uint32_t, 3> corners{indices[first + k], indices[first + k + 2], indices[first + k + 1]};
        if (!shared_vertices)
          for (std::uint32_t& corner : corners) corner = builder.vertex(glm::vec3(builder.soup.mesh.positions[corner]));
        builder.triangle(corners[0], corners[1], corners[2]);
      }
    }
    const FoundParts found = find(builder, {"leaves"});
    EXPECT_EQ(found.leaves.size(), 100u) << shared_vertices;
    EXPECT_EQ(found.foliage.triangle_materials.size(), 4u * 100u + 4u * 75u) << shared_vertices;
  }
}

TEST(FindLeaves, AClosedLensIsOneLeaf) {
  SoupBuilder builder = with_trunk();
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Place where = place(i);
    const glm::vec3 normal = where.normal();
    const std::array<glm::vec3, 4> rim{where.stalk, at(where, 0.05f, 0.02f), at(where, 0.1f, 0.0f), at(where, 0.05f, -0.02f)};
    for (const float side : {0.003f, -0.003f}) {
      // Each side has its own vertices, as where normals differ.
      const std::uint32_t top = builder.vertex(at(where, 0.05f, 0.0f) + side * normal);
      std::vector<std::uint32_t> corners;
      corners.reserve(rim.size());
      for (const glm::vec3& point : rim) corners.push_back(builder.vertex(point));
      for (std::size_t k = 0; k < 4; ++k) builder.triangle(top, corners[k], corners[(k + 1) % 4]);
    }
  }
  expect_leaves(find(builder, {"", ""}), 100, 8);
}

TEST(FindLeaves, TwigsThatShareTheLeavesMaterialAreWood) {
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 300; ++i) {
    add_leaf(builder, place(i));
    if (i % 3 == 0) add_tube(builder, place(i).stalk * glm::vec3(0.2f, 1.0f, 0.2f), 0.99f * place(i).stalk, 0.01f);
  }
  const FoundParts found = find(builder, {"Leaves"});
  expect_leaves(found, 300, 4);
  EXPECT_EQ(found.wood.triangle_materials.size(), 12u * 100u);
}

TEST(FindLeaves, FlatRachisesThatShareTheLeavesMaterialAreWood) {
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 20; ++i) {
    const Place where = place(37 * i);
    // A strip of ten quads, 1 m long; ten leaflets at either side of it, which do not touch.
    std::array<std::uint32_t, 2> last{builder.vertex(at(where, 0.0f, -0.005f)), builder.vertex(at(where, 0.0f, 0.005f))};
    for (int k = 1; k <= 10; ++k) {
      const float along_m = 0.1f * static_cast<float>(k);
      const std::array<std::uint32_t, 2> next{builder.vertex(at(where, along_m, -0.005f)), builder.vertex(at(where, along_m, 0.005f))};
      builder.triangle(last[0], next[0], last[1]);
      builder.triangle(next[0], next[1], last[1]);
      last = next;
      for (const float side : {-1.0f, 1.0f})
        add_leaf(builder, {at(where, along_m - 0.05f, 0.01f * side), side * where.across, where.along}, false, 0.15f);
    }
  }
  const FoundParts found = find(builder, {"Leaves"});
  expect_leaves(found, 400, 4);
  EXPECT_EQ(found.wood.triangle_materials.size(), 400u);
}

/// A ball of welded leaves: every vertex displaced, all of one surface.
void add_shell(SoupBuilder& builder, const glm::vec3& center, float radius_m) {
  constexpr std::uint32_t kRings = 24, kSides = 40;
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t i = 0; i <= kRings; ++i)
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const double tilt = std::numbers::pi * i / kRings, turn = 2.0 * std::numbers::pi * k / kSides;
      const double rough = radius_m * (1.0 + 0.15 * std::sin(11.0 * turn) * std::sin(7.0 * tilt));
      vertices.push_back(builder.vertex(
          center + glm::vec3(rough * std::sin(tilt) * std::cos(turn), rough * std::cos(tilt), rough * std::sin(tilt) * std::sin(turn))));
    }
  for (std::uint32_t i = 0; i < kRings; ++i)
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const std::uint32_t a = vertices[i * kSides + k], b = vertices[i * kSides + (k + 1) % kSides];
      const std::uint32_t c = vertices[(i + 1) * kSides + k], d = vertices[(i + 1) * kSides + (k + 1) % kSides];
      builder.triangle(a, b, c);
      builder.triangle(b, d, c);
    }
}

TEST(FindLeaves, AWeldedShellIsWoodAndSaysSo) {
  SoupBuilder builder = with_trunk();
  add_shell(builder, {0.0f, 4.0f, 0.0f}, 1.5f);
  const FoundParts found = find(builder, {"Trunk", "Leaves"});
  EXPECT_TRUE(found.leaves.empty());
  ASSERT_EQ(found.classes.size(), 2u);
  EXPECT_FALSE(found.classes[0].is_shell);
  EXPECT_TRUE(found.classes[1].is_shell) << found.classes[1].reason;
  EXPECT_EQ(found.wood.triangle_materials.size(), builder.soup.mesh.triangle_materials.size());
}

TEST(FindLeaves, NamesDecideWhereShapesDoNot) {
  // One leaf as large as the plant; a flat piece of bark beside it.
  SoupBuilder builder;
  builder.card({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}});
  builder.material = 1;
  builder.card({{{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}});
  const FoundParts found = find(builder, {"Blatt", "Rinde"});
  expect_leaves(found, 1, 2);
  EXPECT_EQ(found.wood.triangle_materials, (std::vector<std::uint32_t>{1, 1}));
}

TEST(FindLeaves, AWholeTreeThatIsNamedAfterItsTrunkHasLeaves) {
  SoupBuilder leaflets, fronds;
  add_trunk(leaflets);
  for (std::uint32_t i = 0; i < 300; ++i) add_leaf(leaflets, place(i));
  add_trunk(fronds);
  for (std::uint32_t i = 0; i < 12; ++i) add_blade(fronds, place(i), 1.0f);
  for (const auto& [builder, count, triangles] : {std::tuple(&leaflets, 300u, 4u), std::tuple(&fronds, 12u, 32u)}) {
    const FoundParts found = find(*builder, {"palm_trunk"});
    expect_leaves(found, count, triangles);
    EXPECT_EQ(found.wood.triangle_materials.size(), 12u);
    EXPECT_TRUE(found.has_crown);
    ASSERT_EQ(found.classes.size(), 2u);
    for (const PieceClass& each : found.classes) EXPECT_EQ(each.against_name, each.part == PlantPart::leaf);
  }
}

TEST(FindLeaves, FlatWoodStaysWoodByItsName) {
  // Flakes of a bark are a small part of the trunk; planks are closed.
  SoupBuilder flakes, planks;
  add_trunk(flakes);
  for (std::uint32_t i = 0; i < 40; ++i) add_leaf(flakes, place(i));
  for (std::uint32_t i = 0; i < 12; ++i) {
    const Place where = place(i);
    std::array<std::uint32_t, 8> corner{};
    for (std::uint32_t k = 0; k < 8; ++k)
      corner[k] = planks.vertex(at(where, (k & 1u) != 0 ? 0.8f : 0.0f, (k & 2u) != 0 ? 0.1f : 0.0f) +
                                ((k & 4u) != 0 ? 0.02f : 0.0f) * where.normal());
    constexpr std::array<std::array<std::size_t, 4>, 6> kSides{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& [a, b, c, d] : kSides) {
      planks.triangle(corner[a], corner[b], corner[c]);
      planks.triangle(corner[a], corner[c], corner[d]);
    }
  }
  EXPECT_TRUE(find(flakes, {"Bark"}).leaves.empty());
  EXPECT_TRUE(find(planks, {"Wood"}).leaves.empty());
}

TEST(FindLeaves, TwigsOfStripsBesideNeedlesStayWoodByTheirName) {
  SoupBuilder builder = with_trunk();
  for (std::uint32_t i = 0; i < 60; ++i) add_blade(builder, place(i), 0.5f);
  builder.material = 2;
  for (std::uint32_t i = 0; i < 400; ++i) add_leaf(builder, place(i), false, 0.05f);
  expect_leaves(find(builder, {"bark", "bark_twigs", "needles"}), 400, 4);
}

TEST(FindLeaves, MarksAndSplintersBesideACrownThatIsWoodAreNoLeaves) {
  for (const std::uint32_t count : {5u, 40u, 150u}) {
    SoupBuilder builder;
    add_trunk(builder);
    add_shell(builder, {0.0f, 6.0f, 0.0f}, 2.5f);
    builder.material = 1;
    for (std::uint32_t i = 0; i < count; ++i) add_leaf(builder, place(i), false, 0.06f);
    const FoundParts marks = find(builder, {"", "marks"});
    EXPECT_TRUE(marks.leaves.empty());
    EXPECT_FALSE(marks.has_crown);
    const FoundParts named = find(builder, {"", "leaves"});
    expect_leaves(named, count, 4);
    EXPECT_FALSE(named.has_crown) << "so that somebody is told";
  }
}

TEST(FindLeaves, GroundBelowDoesNotMakeTheLeavesFew) {
  SoupBuilder builder = with_trunk();
  for (std::uint32_t i = 0; i < 40; ++i) add_leaf(builder, place(i));
  builder.material = 2;
  builder.card({{{-20, -1, -20}, {20, -1, -20}, {20, -1, 20}, {-20, -1, 20}}});
  const FoundParts found = find(builder, {"", "", ""});
  expect_leaves(found, 40, 4);
  EXPECT_TRUE(found.has_crown);
}

TEST(FindLeaves, BladeAndMidribOfTwoMaterialsAreOneLeaf) {
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 50; ++i) {
    add_leaf(builder, place(i), true);
    auto& materials = builder.soup.mesh.triangle_materials;
    materials[materials.size() - 1] = materials[materials.size() - 2] = 1;
  }
  expect_leaves(find(builder, {"leaf_left", "leaf_right"}), 50, 4);
}

TEST(FindLeaves, CopiesOfOneMeshThatTouchStayApart) {
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 40; ++i) {
    builder.instance = i;
    const auto x = static_cast<float>(i);
    builder.card({{{x, 0, 0}, {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}}});
  }
  expect_leaves(find(builder, {"leaves"}), 40, 2);
}

TEST(FindLeaves, CrossedCardsThatShareTheirMiddleFallApart) {
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 10; ++i) {
    const Place where = place(i);
    const glm::vec3 normal = where.normal();
    const std::uint32_t a = builder.vertex(where.stalk), b = builder.vertex(at(where, 0.5f, 0.0f));
    for (const glm::vec3& side : {where.across, -where.across, normal, -normal}) {
      const std::uint32_t c = builder.vertex(at(where, 0.5f, 0.0f) + 0.2f * side), d = builder.vertex(where.stalk + 0.2f * side);
      builder.triangle(a, b, c);
      builder.triangle(a, c, d);
    }
  }
  expect_leaves(find(builder, {""}), 40, 2);
}

TEST(FindLeaves, HolesAndColourSpeakForLeaves) {
  // Ten tubes of leaf size, which could be needles or twigs.
  SoupBuilder builder = with_trunk();
  for (std::uint32_t i = 0; i < 10; ++i) add_tube(builder, place(i).stalk, at(place(i), 0.3f, 0.0f), 0.02f);
  for (std::size_t i = 0; i < builder.soup.mesh.uvs.size(); ++i)
    builder.soup.mesh.uvs[i] = {static_cast<float>(i % 2), static_cast<float>(i / 2 % 2)};
  std::vector<Material> materials = materials_of({"a", "b"});
  const std::vector<std::vector<MaterialRule>> no_rules(2);
  EXPECT_TRUE(find_leaves(builder.soup, materials, {}, no_rules).leaves.empty()) << "grey and opaque";
  materials[1].image = 0;
  materials[1].alpha_cutoff = 0.5f;
  const Image needles{2, 2, {20, 120, 10, 255, 20, 120, 10, 255, 0, 0, 0, 0, 20, 120, 10, 255}};
  expect_leaves(find_leaves(builder.soup, materials, {needles}, no_rules), 10, 12);
}

TEST(FindLeaves, AFoldedLeafIsNoTube) {
  // Folded by a right angle along the midrib, as coffee and magnolia leaves are.
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Place where = place(i);
    const glm::vec3 normal = where.normal();
    const std::uint32_t stalk = builder.vertex(where.stalk), tip = builder.vertex(at(where, 0.1f, 0.0f));
    const std::uint32_t left = builder.vertex(at(where, 0.05f, 0.03f) + 0.03f * normal);
    const std::uint32_t right = builder.vertex(at(where, 0.05f, -0.03f) + 0.03f * normal);
    builder.triangle(stalk, tip, left);
    builder.triangle(stalk, right, tip);
  }
  expect_leaves(find(builder, {""}), 100, 2);
}

TEST(FindLeaves, BladesThatHangOverAreLeaves) {
  SoupBuilder builder = with_trunk();
  for (std::uint32_t i = 0; i < 60; ++i) add_blade(builder, place(i), 0.15f);
  const FoundParts found = find(builder, {"Material.001", "Material.002"});
  expect_leaves(found, 60, 32);
  EXPECT_EQ(found.wood.triangle_materials.size(), 12u);
}

TEST(FindLeaves, LongBladesAmongMoreFlatLeavesAreLeaves) {
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 400; ++i) add_leaf(builder, place(i));
  for (std::uint32_t i = 400; i < 440; ++i) add_blade(builder, place(i), 0.1f);
  EXPECT_EQ(find(builder, {"Material"}).leaves.size(), 440u);
}

TEST(FindLeaves, RulesDecideBeforeEvidence) {
  SoupBuilder builder = with_trunk();
  for (std::uint32_t i = 0; i < 20; ++i) add_leaf(builder, place(i));
  for (std::uint32_t i = 20; i < 30; ++i) add_tube(builder, place(i).stalk, at(place(i), 0.1f, 0.0f), 0.01f);
  const std::vector<Material> materials = materials_of({"bark", "leaves"});
  const std::vector<MaterialRule> leaf{{.part = PlantPart::leaf, .source = "a"}};
  const std::vector<MaterialRule> small_dropped{{.part = PlantPart::dropped, .max_triangles = 4, .source = "b"},
                                                {.part = PlantPart::leaf, .source = "c"}};
  const FoundParts swapped = find_leaves(builder.soup, materials, {}, {leaf, {{.part = PlantPart::wood, .source = "w"}}});
  expect_leaves(swapped, 1, 12);
  EXPECT_EQ(swapped.wood.triangle_materials.size(), 20u * 4u + 10u * 12u);
  const FoundParts sorted = find_leaves(builder.soup, materials, {}, {{}, small_dropped});
  expect_leaves(sorted, 10, 12);
  EXPECT_EQ(sorted.wood.triangle_materials.size(), 12u);
  EXPECT_EQ(sorted.dropped_leaf_count, 0u) << "dropped on request is not degenerate";
}

TEST(FindLeaves, WhatHasNoAreaIsDroppedFromFoliageAndKeptInWood) {
  SoupBuilder builder;
  for (std::uint32_t i = 0; i < 20; ++i) add_leaf(builder, place(i));
  const auto add_line = [&](float x) { builder.triangle(builder.vertex({x, 0, 0}), builder.vertex({x, 1, 0}), builder.vertex({x, 2, 0})); };
  add_line(3.0f);
  const std::uint32_t point = builder.vertex({4, 0, 0});
  builder.triangle(point, point, point);
  builder.material = 1;
  add_trunk(builder);
  add_line(5.0f);
  const FoundParts found = find(builder, {"leaves", "bark"});
  expect_leaves(found, 20, 4);
  EXPECT_EQ(found.dropped_leaf_count, 2u);
  EXPECT_EQ(found.wood.triangle_materials.size(), 13u);
}

TEST(FindLeaves, NothingGivesNothing) {
  const FoundParts found = find_leaves({}, {}, {}, {});
  EXPECT_TRUE(found.leaves.empty() && found.wood.indices.empty() && found.classes.empty());
}

}  // namespace coppice::bake::find_leaves_test
