// Trees whose bark and leaves have normal maps. Their materials name two images, of which the far picture wants the colour.

#include <cmath>

#include "looks_case.h"
#include "tree_parts.h"

namespace coppice::test::normal_maps {

Rgba white(float u, float v) {
  return {255, 255, 255, oval_leaf(u, v)[3]};
}

GltfBuilder tree(bool has_colors) {
  const auto furrows = [](float u, float v) {
    return normal_texel({0.5f * std::cos(25.0f * u + 3.0f * std::sin(6.2831853f * v)), 0.0f, 1.0f});
  };
  const auto midrib = [](float u, float) { return normal_texel({u < 0.5f ? -0.3f : 0.3f, 0.0f, 1.0f}); };
  GltfBuilder builder;
  const int bark = add_surface(builder, {.name = "bark",
                                         .image = has_colors ? painted_png(64, 64, furrowed_bark) : std::vector<std::uint8_t>(),
                                         .normal_map = painted_png(64, 64, furrows)});
  const int leaves = add_surface(builder, {.name = "leaves",
                                           .image = painted_png(64, 64, has_colors ? oval_leaf : white),
                                           .normal_map = painted_png(64, 64, midrib),
                                           .alpha_cutoff = 0.5f});
  add_shape(builder, bare_tree(), bark, "trunk");
  add_shape(builder, crown_of_cards(300), leaves, "crown");
  return builder;
}

INSTANTIATE_TEST_SUITE_P(NormalMaps, LooksTest,
                         testing::Values(LooksCase{.name = "normal_mapped_bark_and_leaves",
                                                   .plant = [] { return tree(true); },
                                                   .defect = [] { return tree(false); }}),
                         looks_name);

}  // namespace coppice::test::normal_maps
