// Wood whose texture makes its outline: cards of twigs, and a whole bare tree on two crossed cards.

#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "looks_case.h"
#include "test_foliage.h"
#include "tree_parts.h"

namespace coppice::test::masked_wood {

/// A stem with four pairs of side shoots; holes are black, as exporters leave them. A quarter of the image.
Rgba twig(float u, float v, bool has_holes) {
  const float x = std::abs(2.0f * u - 1.0f), y = 1.0f - v;
  const float above_shoot = std::fmod(y + 1.0f - 0.5f * x, 0.25f);
  const bool is_twig = x < 0.08f || (above_shoot < 0.05f && y - 0.5f * x > 0.1f && x < 0.9f - 0.5f * y);
  if (!is_twig) return {0, 0, 0, static_cast<std::uint8_t>(has_holes ? 0 : 255)};
  return {124, 92, 70, 255};
}

struct Tree {
  bool has_holes = true;
  bool is_crossed_cards = false;  ///< instead of twigs on a trunk
};

/// With some leaves: a plant without any would be another test.
GltfBuilder tree(const Tree& wanted) {
  GltfBuilder builder;
  const auto paint = [&](float u, float v) { return twig(u, v, wanted.has_holes); };
  const int twigs =
      add_surface(builder, {.name = "bark_twigs", .image = painted_png(128, 128, paint), .alpha_cutoff = wanted.has_holes ? 0.5f : 0.0f});
  const int leaves = add_surface(builder, {.name = "leaves", .image = painted_png(64, 64, oval_leaf), .alpha_cutoff = 0.5f});
  Shape cards;
  if (wanted.is_crossed_cards) {
    add_card(cards, {-1.5f, 0, 0}, {3, 0, 0}, {0, 4, 0});
    add_card(cards, {0, 0, -1.5f}, {0, 0, 3}, {0, 4, 0});
  } else {
    const int bark = add_surface(builder, {.name = "bark", .image = painted_png(64, 64, furrowed_bark)});
    add_shape(builder, bare_tree(), bark, "trunk");
    std::mt19937 random(3);
    for (int i = 0; i < 60; ++i) {
      const float angle = 2.4f * static_cast<float>(i), height_m = uniform(random, 1.2f, 3.0f);
      const glm::vec3 up = glm::normalize(glm::vec3(std::cos(angle), uniform(random, 0.3f, 1.2f), std::sin(angle)));
      const glm::vec3 right = glm::normalize(glm::cross(up, glm::vec3(uniform(random, -1, 1), 0.3f, uniform(random, -1, 1))));
      add_card(cards, glm::vec3(0, height_m, 0) + 0.1f * up - 0.4f * right, 0.8f * right, 1.1f * up);
    }
  }
  add_shape(builder, cards, twigs, "twigs");
  add_shape(builder, leaves_up_a_stem(40, 2.0f, 3.2f), leaves, "crown");
  return builder;
}

INSTANTIATE_TEST_SUITE_P(MaskedWood, LooksTest,
                         testing::Values(LooksCase{.name = "twigs_on_cards",
                                                   .plant = [] { return tree({}); },
                                                   .defect = [] { return tree({.has_holes = false}); }},
                                         LooksCase{.name = "bare_tree_on_two_cards",
                                                   .plant = [] { return tree({.is_crossed_cards = true}); },
                                                   .defect = [] { return tree({.has_holes = false, .is_crossed_cards = true}); },
                                                   .from = {0.3f, 0.2f, 1.0f}}),
                         looks_name);

}  // namespace coppice::test::masked_wood
