// A low-poly tree as packs have them: no leaves, and one image for all, of which each part shows a patch of one colour.

#include "looks_case.h"

namespace coppice::test::palette {

enum Patch { bark, needles, clay, snow };

/// Four patches side by side. Without them all of the tree has their mean, as it was drawn from afar once.
Rgba patch_colour(float u, bool has_patches) {
  if (!has_patches) return {150, 138, 118, 255};
  constexpr std::array<Rgba, 4> kColours{{{96, 62, 40, 255}, {58, 122, 52, 255}, {190, 100, 60, 255}, {236, 240, 244, 255}}};
  return kColours[static_cast<std::size_t>(4.0f * u)];
}

/// The middle of a patch.
UvBox within(Patch patch) {
  const float left = 0.25f * static_cast<float>(patch);
  return {{left + 0.1f, 0.4f}, {left + 0.15f, 0.6f}};
}

GltfBuilder spruce_in_a_pot(bool has_patches) {
  GltfBuilder builder;
  const auto paint = [&](float u, float) { return patch_colour(u, has_patches); };
  const int palette = add_surface(builder, {.name = "palette", .image = painted_png(64, 64, paint)});
  Shape tree;
  add_tube(tree, {.from = {0, 0, 0}, .to = {0, 0.6f, 0}, .from_radius_m = 0.5f, .to_radius_m = 0.7f, .sides = 8, .uvs = within(clay)});
  add_tube(tree, {.from = {0, 0.3f, 0}, .to = {0, 1.4f, 0}, .from_radius_m = 0.16f, .to_radius_m = 0.12f, .sides = 8, .uvs = within(bark)});
  for (int i = 0; i < 4; ++i) {
    const float foot_m = 1.1f + 0.7f * static_cast<float>(i), radius_m = 1.0f - 0.2f * static_cast<float>(i);
    add_tube(tree, {.from = {0, foot_m, 0},
                    .to = {0, foot_m + 1.1f, 0},
                    .from_radius_m = radius_m,
                    .to_radius_m = 0.02f,
                    .sides = 8,
                    .uvs = within(i < 3 ? needles : snow)});
  }
  add_shape(builder, tree, palette, "spruce");
  return builder;
}

INSTANTIATE_TEST_SUITE_P(Palette, LooksTest,
                         testing::Values(LooksCase{.name = "low_poly_spruce",
                                                   .plant = [] { return spruce_in_a_pot(true); },
                                                   .defect = [] { return spruce_in_a_pot(false); }}),
                         looks_name);

}  // namespace coppice::test::palette
