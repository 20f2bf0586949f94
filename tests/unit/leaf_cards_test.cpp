#include "leaf_cards.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>

#include "leaf_meshes.h"
#include "leaf_quads.h"
#include "polygons.h"
#include "results.h"
#include "texture_regions.h"

namespace coppice::bake::leaf_cards_test {

using test::kite;
using test::LeafMesh;

/// A hexagon of the same length, with a tip that is blunt.
LeafMesh blunt() {
  return {{{0.0f, 0.0f, 0.0f}, {0.2f, -0.4f, 0.0f}, {1.9f, -0.4f, 0.0f}, {2.0f, 0.0f, 0.0f}, {1.9f, 0.4f, 0.0f}, {0.2f, 0.4f, 0.0f}},
          {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5}};
}

LeafMesh square() {
  return {{{0.0f, -0.5f, 0.0f}, {1.0f, -0.5f, 0.0f}, {1.0f, 0.5f, 0.0f}, {0.0f, 0.5f, 0.0f}}, {0, 1, 2, 0, 2, 3}};
}

LeafMesh moved(LeafMesh mesh, const glm::mat4& matrix) {
  for (glm::vec3& position : mesh.positions) position = glm::vec3(matrix * glm::vec4(position, 1.0f));
  return mesh;
}

/// Leaves of material 0, green and without an image, and a twig of material 1 left of the origin.
Plant plant_of(const std::vector<LeafMesh>& leaves) {
  Plant plant = test::plant_of_meshes(leaves);
  plant.materials[0].base_color = {0.1f, 0.4f, 0.1f, 1.0f};
  return plant;
}

Foliage carded(Plant& plant) {
  return test::must(card_foliage(plant));
}

/// Share of a card's texels that are no hole.
double coverage(const Plant& plant, const Card& card) {
  const Material& material = plant.materials.at(card.material);
  const Image& image = plant.images.at(material.image);
  const auto texel = [&](float uv, std::uint32_t size) { return static_cast<std::uint32_t>(uv * static_cast<float>(size)); };
  std::uint32_t solid = 0, all = 0;
  for (std::uint32_t y = texel(card.uv[3].y, image.height); y <= texel(card.uv[0].y, image.height); ++y)
    for (std::uint32_t x = texel(card.uv[0].x, image.width); x <= texel(card.uv[1].x, image.width); ++x, ++all)
      if (static_cast<float>(image.rgba[4 * (std::size_t{y} * image.width + x) + 3]) / 255.0f >= material.alpha_cutoff) ++solid;
  return static_cast<double>(solid) / all;
}

double area_m2(const Quad& quad) {
  return static_cast<double>(glm::length(glm::cross(quad[1] - quad[0], quad[3] - quad[0])));
}

// The picture shows the quad in rows and columns: the leaf is the quad's lower left half (below the line from corner 3 to corner 1).
TEST(DrawLeaf, PutsTheStalkLeftAndCornerThreeOnTop) {
  const Plant plant = plant_of({{{{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}}, {0, 1, 2}}});
  const Quad unit{glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(1, 1, 0), glm::vec3(0, 1, 0)};
  const CardImage image = draw_leaf(plant, plant.leaves[0], unit, 4, 4);
  ASSERT_EQ(image.texels.size(), 16u);
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t column = 0; column < 4; ++column) {
      const glm::vec4& texel = image.texels[4 * row + column];
      const float expected = column < row ? 1.0f : column > row ? 0.0f : 0.5f;
      // On the diagonal half of the 16 samples, and those whose centres lie on it.
      EXPECT_NEAR(texel.a, expected, column == row ? 0.13f : 0.0f) << row << ' ' << column;
      EXPECT_NEAR(texel.y, 0.4f * texel.a, 1e-6f) << "colour times alpha";
    }
}

TEST(DrawLeaf, ShowsTheTopmostTexelThatIsNoHole) {
  // Two squares, the upper one textured with a hole on its left half; below it, black.
  LeafMesh both = square();
  for (const glm::vec3& position : square().positions) both.positions.push_back(position + glm::vec3(0.0f, 0.0f, 0.1f));
  both.indices.insert(both.indices.end(), {4, 5, 6, 4, 6, 7});
  both.uvs.assign(8, glm::vec2(0.0f));
  for (std::size_t i = 4; i < 8; ++i) both.uvs[i] = {both.positions[i].x, 0.5f};
  Plant plant = plant_of({both});
  plant.materials[0].base_color = glm::vec4(0.0f, 0.0f, 0.0f, 1.0f);
  plant.materials.push_back({.base_color = glm::vec4(1.0f), .image = 0, .alpha_cutoff = 0.5f});
  plant.images.push_back({2, 1, {255, 255, 255, 0, 255, 255, 255, 255}});
  plant.foliage.triangle_materials = {0, 0, 2, 2};
  const Quad quad{square().positions[0], square().positions[1], square().positions[2], square().positions[3]};
  const CardImage image = draw_leaf(plant, plant.leaves[0], quad, 2, 2);
  for (const std::size_t left : {0u, 2u}) EXPECT_EQ(image.texels[left], glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
  for (const std::size_t right : {1u, 3u}) EXPECT_EQ(image.texels[right], glm::vec4(1.0f));
}

TEST(LeafCards, CoverTheLeafsArea) {
  Plant plant = plant_of({kite()});
  const Foliage foliage = carded(plant);
  ASSERT_EQ(foliage.leaf_count(), 1u);
  const Card& card = foliage.card_table.at(foliage.cards[0]);
  EXPECT_NEAR(area_m2(foliage.quads[0]) * coverage(plant, card), 0.8, 0.02);
  EXPECT_GT(plant.materials[card.material].alpha_cutoff, 0.0f);
  EXPECT_EQ(plant.materials[card.material].base_color, plant.materials[0].base_color) << "what is seen until the image is there";
}

/// Stalk at the origin, folded along x: each half leans by the slope, whose tip lies at x = 2.
LeafMesh folded(float slope) {
  return {{{0.0f, 0.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {1.0f, 0.5f, 0.5f * slope}, {1.0f, -0.5f, 0.5f * slope}}, {0, 1, 2, 0, 3, 1}};
}

double fullness_of(const LeafMesh& leaf) {
  const Plant plant = plant_of({leaf});
  return fullness(plant, plant.leaves[0], {glm::vec3(0, -0.5f, 0), glm::vec3(2, -0.5f, 0), glm::vec3(2, 0.5f, 0), glm::vec3(0, 0.5f, 0)});
}

TEST(Fullness, OfAFlatLeafIsOne) {
  EXPECT_EQ(fullness_of(kite()), 1.0);
  EXPECT_EQ(fullness_of(folded(0.0f)), 1.0);
}

// Sides that lean by 45 degrees have sqrt(2) of the flat area; where one hides the other, less of it shows.
TEST(Fullness, OfAFoldedLeafIsThatOfItsSides) {
  const double fold = fullness_of(folded(1.0f));
  EXPECT_GT(fold, 1.1);
  EXPECT_LT(fold, std::sqrt(2.0));
  EXPECT_LT(fullness_of(folded(0.5f)), fold);
}

// Equation (1) sees a frond that rises and droops from its side.
TEST(LeafCards, ShowAnArchedFrondFromAbove) {
  LeafMesh frond;
  constexpr std::uint32_t kSegments = 8;
  for (std::uint32_t i = 0; i <= kSegments; ++i) {
    const float angle = 1.2f - 2.4f * static_cast<float>(i) / kSegments;
    for (const float across : {-0.15f, 0.15f}) frond.positions.emplace_back(0.932f - std::sin(angle), across, std::cos(angle) - 0.362f);
    if (i > 0)
      for (const std::uint32_t corner : {0u, 2u, 1u, 1u, 2u, 3u}) frond.indices.push_back(2 * (i - 1) + corner);
  }
  Plant plant = plant_of({frond});
  const Quad quad = carded(plant).quads[0];
  const glm::vec3 normal = glm::normalize(glm::cross(quad[1] - quad[0], quad[3] - quad[0]));
  EXPECT_GT(std::abs(normal.z), 0.9f);
  EXPECT_GT(area_m2(quad), 0.9 * 0.3 * 1.86) << "as wide as the frond, and about as long as its chord";
}

// A quad shows nothing from the side, a folded leaf does: the quad is as much larger as makes up for it on the whole.
TEST(LeafCards, QuadOfABentLeafIsLarger) {
  Plant flat = plant_of({blunt()});
  LeafMesh bent_blunt = blunt();
  for (glm::vec3& position : bent_blunt.positions) position.z = std::abs(position.y);
  Plant bent = plant_of({bent_blunt});
  const double larger = area_m2(carded(bent).quads[0]) / area_m2(carded(flat).quads[0]);
  EXPECT_GT(larger, 1.1);
  EXPECT_LT(larger, 1.5);
}

// However a leaf is turned, scaled and stretched, in its own rectangle it is the same leaf.
TEST(LeafCards, CongruentLeavesShareOnePictureOthersDoNot) {
  std::vector<LeafMesh> leaves;
  for (int i = 0; i < 12; ++i) {
    glm::mat4 place = glm::translate(glm::mat4(1.0f), glm::vec3(3.0f * static_cast<float>(i), 0.0f, 0.0f));
    place = glm::rotate(place, 0.1f * static_cast<float>(i), glm::vec3(1.0f, 0.0f, 0.0f));
    place = glm::scale(place, glm::vec3(1.0f + 0.1f * static_cast<float>(i), 1.0f, 1.0f));
    leaves.push_back(moved(i % 3 == 0 ? blunt() : kite(), place));
  }
  // Each leaf has its own bit of wood at its stalk.
  Plant plant = plant_of(leaves);
  plant.wood = {};
  for (int i = 0; i < 12; ++i) {
    const glm::vec3 stalk(3.0f * static_cast<float>(i) - 0.01f, 0.0f, 0.0f);
    test::add_polygon(plant.wood, std::array{stalk, stalk + glm::vec3(-0.01f, 0, 0), stalk + glm::vec3(-0.01f, 0.001f, 0)}, {}, 1);
  }
  const Foliage foliage = carded(plant);
  EXPECT_EQ(foliage.card_table.size(), 2u);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(foliage.cards[i], foliage.cards[i % 3 == 0 ? 0 : 1]) << i;
}

TEST(LeafCards, QuadHoldsALeafThatReachesBehindItsStalk) {
  // A heart: its lobes lie behind the stalk, towards the wood but to the sides of it.
  Plant plant = plant_of(
      {{{{0.0f, 0.0f, 0.0f}, {-0.4f, -0.6f, 0.0f}, {0.5f, -0.8f, 0.0f}, {2.0f, 0.0f, 0.0f}, {0.5f, 0.8f, 0.0f}, {-0.4f, 0.6f, 0.0f}},
        {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5}}});
  plant.wood.positions = {{-0.01f, 0.0f, 0.0f}, {-0.01f, 0.001f, 0.0f}, {-0.01f, 0.0f, 0.001f}};
  const Foliage foliage = carded(plant);
  const auto [low, high] = std::ranges::minmax(foliage.quads[0], {}, &glm::vec3::x);
  EXPECT_NEAR(low.x, -0.4f, 1e-5f);
  EXPECT_NEAR(high.x, 2.0f, 1e-5f);
}

TEST(LeafCards, QuadIsCroppedToWhatTheTextureShows) {
  // A 2 x 1 sheet with a stalk and a tip, whose texture is solid in x from 0.5 to 1 only.
  LeafMesh sheet{
      {{-0.2f, 0.0f, 0.0f}, {0.0f, -0.5f, 0.0f}, {2.0f, -0.5f, 0.0f}, {2.2f, 0.0f, 0.0f}, {2.0f, 0.5f, 0.0f}, {0.0f, 0.5f, 0.0f}},
      {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5}};
  for (const glm::vec3& position : sheet.positions) sheet.uvs.emplace_back(position.x / 2.0f, position.y + 0.5f);
  Plant plant = plant_of({sheet});
  plant.materials[0].image = 0;
  plant.materials[0].alpha_cutoff = 0.5f;
  plant.images.push_back({4, 1, {9, 9, 9, 0, 9, 9, 9, 255, 9, 9, 9, 0, 9, 9, 9, 0}});
  const Foliage foliage = carded(plant);
  EXPECT_NEAR(area_m2(foliage.quads[0]), 0.5, 0.05);
  EXPECT_GT(coverage(plant, foliage.card_table.at(foliage.cards[0])), 0.95);
}

TEST(LeafCards, LeafThatIsAQuadKeepsItsTexture) {
  Plant plant = plant_of({square(), moved(square(), glm::translate(glm::mat4(1.0f), glm::vec3(3.0f, 0.0f, 0.0f)))});
  const Foliage plain = *fit_leaf_quads(plant);
  const Foliage foliage = carded(plant);
  EXPECT_EQ(plant.materials.size(), 2u);
  EXPECT_TRUE(plant.images.empty());
  EXPECT_EQ(foliage.quads, plain.quads);
  EXPECT_EQ(foliage.card_table.at(0).uv, plain.card_table.at(0).uv);
}

// However different the leaves, there are no more images than the atlas holds, and every leaf has one.
TEST(LeafCards, ManyShapesShareTheAtlas) {
  std::vector<LeafMesh> leaves;
  for (int i = 0; i < 60; ++i) {
    LeafMesh leaf = kite();
    leaf.positions[1].x = 0.2f + 0.03f * static_cast<float>(i);
    leaf.positions[3].x = 1.9f - 0.03f * static_cast<float>(i);
    leaves.push_back(moved(leaf, glm::translate(glm::mat4(1.0f), glm::vec3(0.0f, 2.0f * static_cast<float>(i), 0.0f))));
  }
  Plant plant = plant_of(leaves);
  const Foliage foliage = carded(plant);
  ASSERT_EQ(plant.materials.size(), 3u);
  EXPECT_GT(foliage.card_table.size(), 2u);
  EXPECT_LE(foliage.card_table.size(), kMaxCardImages);
  EXPECT_LE(plant.images.at(0).width, 512u);
  std::set<std::uint32_t> used(foliage.cards.begin(), foliage.cards.end());
  EXPECT_EQ(used.size(), foliage.card_table.size());
  for (const Card& card : foliage.card_table) {
    EXPECT_EQ(card.material, 2u);
    for (const glm::vec2& uv : card.uv) EXPECT_TRUE(uv.x > 0.0f && uv.x < 1.0f && uv.y > 0.0f && uv.y < 1.0f);
  }
}

TEST(DropUnusedMaterials, KeepsWhatCardsAndWoodUse) {
  BakedPlant plant;
  plant.materials.resize(4);
  for (std::uint32_t m = 0; m < 4; ++m) plant.materials[m] = {.name = std::to_string(m), .image = m == 3 ? 1 : m};
  plant.images = {{1, 1, {0, 0, 0, 0}}, {1, 1, {1, 1, 1, 1}}, {1, 1, {2, 2, 2, 2}}};
  plant.card_table = {{3, {}}};
  plant.wood.lods.resize(1);
  plant.wood.lods[0].triangle_materials = {2, 2};
  drop_unused_materials(plant);
  ASSERT_EQ(plant.materials.size(), 2u);
  EXPECT_EQ(plant.materials[0].name, "2");
  EXPECT_EQ(plant.materials[1].name, "3");
  ASSERT_EQ(plant.images.size(), 2u);
  EXPECT_EQ(plant.images[plant.materials[0].image].rgba[0], 2);
  EXPECT_EQ(plant.images[plant.materials[1].image].rgba[0], 1);
  EXPECT_EQ(plant.card_table[0].material, 1u);
  EXPECT_EQ(plant.wood.lods[0].triangle_materials, (std::vector<std::uint32_t>{0, 0}));
}

}  // namespace coppice::bake::leaf_cards_test
