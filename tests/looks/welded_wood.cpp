// Trunk and boughs that are one surface. Simplifiers make a spike of the trunk, and the crown floats.

#include "looks_case.h"
#include "tree_parts.h"

namespace coppice::test::welded_wood {

/// The crown hides the boughs.
GltfBuilder forked_trunk(float foot_radius_m) {
  GltfBuilder builder;
  const int bark = add_surface(builder, {.name = "bark", .base_color = {0.35f, 0.25f, 0.15f, 1}});
  const int leaf = add_surface(builder, {.name = "leaves", .image = painted_png(64, 96, oval_leaf), .alpha_cutoff = 0.5f});
  Shape leaves = crown_of_cards(500);
  for (glm::vec3& position : leaves.positions) position.y += 1.2f;
  add_shape(builder, forked_tree(foot_radius_m), bark, "trunk");
  add_shape(builder, leaves, leaf, "leaves");
  return builder;
}

INSTANTIATE_TEST_SUITE_P(WeldedWood, LooksTest,
                         testing::Values(LooksCase{.name = "forked_trunk",
                                                   .plant = [] { return forked_trunk(0.16f); },
                                                   .defect = [] { return forked_trunk(0.01f); }}),
                         looks_name);

}  // namespace coppice::test::welded_wood
