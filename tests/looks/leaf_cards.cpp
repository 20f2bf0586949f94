// A tree of nothing unusual: what it fails at is wrong for all.

#include "looks_case.h"
#include "tree_parts.h"

namespace coppice::test::leaf_cards {

GltfBuilder tree(std::uint32_t leaf_count) {
  GltfBuilder builder;
  const int bark = add_surface(builder, {.name = "bark", .image = painted_png(64, 64, furrowed_bark)});
  const int leaves = add_surface(builder, {.name = "leaves", .image = painted_png(64, 64, oval_leaf), .alpha_cutoff = 0.5f});
  add_shape(builder, bare_tree(), bark, "trunk");
  add_shape(builder, crown_of_cards(leaf_count), leaves, "crown");
  return builder;
}

INSTANTIATE_TEST_SUITE_P(LeafCards, LooksTest,
                         testing::Values(LooksCase{
                             .name = "leaf_cards", .plant = [] { return tree(300); }, .defect = [] { return tree(200); }}),
                         looks_name);

}  // namespace coppice::test::leaf_cards
