// Files that hold more than one plant, or a plant in another unit: what is drawn is the plant.

#include <algorithm>

#include "looks_case.h"
#include "tree_parts.h"

namespace coppice::test::packs {

struct Materials {
  int bark = 0, leaves = 0;
};

Materials add_materials(GltfBuilder& builder) {
  return {add_surface(builder, {.name = "bark", .image = painted_png(64, 64, furrowed_bark)}),
          add_surface(builder, {.name = "leaves", .image = painted_png(64, 64, oval_leaf), .alpha_cutoff = 0.5f})};
}

Shape scaled(Shape shape, float by) {
  for (glm::vec3& position : shape.positions) position *= by;
  return shape;
}

GltfBuilder oak(float scale = 1) {
  GltfBuilder builder;
  const auto [bark, leaves] = add_materials(builder);
  add_shape(builder, scaled(bare_tree(), scale), bark, "trunk");
  add_shape(builder, scaled(crown_of_cards(300), scale), leaves, "crown");
  return builder;
}

/// A tree seen from afar, on one card.
Rgba far_tree(float u, float v) {
  const float x = 2.0f * u - 1.0f, y = 2.0f * v - 1.0f;
  const bool is_crown = x * x + (y + 0.3f) * (y + 0.3f) < 0.4f, is_trunk = std::abs(x) < 0.06f && y > 0.0f;
  return is_crown ? Rgba{80, 120, 45, 255} : is_trunk ? Rgba{110, 85, 60, 255} : Rgba{0, 0, 0, 0};
}

/// Each card larger about its middle.
Shape enlarged(Shape cards, float by) {
  for (std::size_t i = 0; i < cards.positions.size(); i += 4) {
    glm::vec3 middle(0);
    for (std::size_t k = 0; k < 4; ++k) middle += 0.25f * cards.positions[i + k];
    for (std::size_t k = 0; k < 4; ++k) cards.positions[i + k] = middle + by * (cards.positions[i + k] - middle);
  }
  return cards;
}

/// One mesh and one node of two.
void join(GltfBuilder& builder, int first, int second) {
  nlohmann::json& nodes = builder.json["nodes"];
  nlohmann::json& meshes = builder.json["meshes"];
  const auto mesh_of = [&](int node) { return nodes[static_cast<std::size_t>(node)]["mesh"].get<std::size_t>(); };
  for (const nlohmann::json& primitive : meshes[mesh_of(second)]["primitives"]) meshes[mesh_of(first)]["primitives"].push_back(primitive);
  nlohmann::json& roots = builder.json["scenes"][0]["nodes"];
  roots.erase(std::ranges::find(roots, nlohmann::json(second)));
}

/// A tree at three levels of detail and as a billboard, all in one place, each a node whose name says which it is. is_pile: all of it is
/// one mesh, as if it were one tree.
GltfBuilder oak_pack(bool is_pile) {
  GltfBuilder builder;
  const auto [bark_material, leaf_material] = add_materials(builder);
  const auto add_level = [&, bark = bark_material, leaves = leaf_material](const std::string& name, std::uint32_t leaf_count, float size) {
    const int level = add_shape(builder, bare_tree(), bark, name);
    join(builder, level, add_shape(builder, enlarged(crown_of_cards(leaf_count), size), leaves));
    return level;
  };
  const int finest = add_level("oak_LOD0", 300, 1.0f), middle = add_level("oak_LOD1", 150, 1.4f),
            coarsest = add_level("oak_LOD2", 60, 2.2f);
  const int far = add_surface(builder, {.name = "oak_far", .image = painted_png(128, 128, far_tree), .alpha_cutoff = 0.5f});
  Shape card;
  add_card(card, {-2, 0, 0}, {4, 0, 0}, {0, 4, 0});
  const int billboard = add_shape(builder, card, far, "oak_billboard");
  if (is_pile)
    for (const int node : {middle, coarsest, billboard}) join(builder, finest, node);
  return builder;
}

INSTANTIATE_TEST_SUITE_P(Packs, LooksTest,
                         testing::Values(LooksCase{.name = "lod_pack",
                                                   .plant = [] { return oak_pack(false); },
                                                   .reference = [] { return oak(); },
                                                   .defect = [] { return oak_pack(true); }},
                                         LooksCase{.name = "centimetres",
                                                   .plant = [] { return oak(100); },
                                                   .reference = [] { return oak(); },
                                                   .defect = [] { return oak(); },
                                                   .bake = {.import = {.metres_per_unit = 0.01}}}),
                         looks_name);

}  // namespace coppice::test::packs
