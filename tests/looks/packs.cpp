// Files that hold more than one plant, or a plant in another unit: what is drawn is the plant.

#include "looks_case.h"
#include "tree_parts.h"

namespace coppice::test {
namespace {

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

/// are_levels: the names say so, and only the first is the tree; without that all are, one in the other.
GltfBuilder oak_pack(bool are_levels) {
  GltfBuilder builder;
  const auto [bark, leaves] = add_materials(builder);
  const int billboard = add_surface(builder, {.name = "oak_far", .image = painted_png(128, 128, far_tree), .alpha_cutoff = 0.5f});
  Shape card;
  add_card(card, {-2, 0, 0}, {4, 0, 0}, {0, 4, 0});
  const auto name = [&](const char* level) { return are_levels ? std::string("oak_") + level : std::string(); };
  // A mesh of two primitives for each level, as exporters write them.
  const auto add_level = [&](const char* level, std::uint32_t leaf_count) {
    const std::size_t wood = builder.json["meshes"].size();
    add_shape(builder, bare_tree(), bark, name(level));
    add_shape(builder, crown_of_cards(leaf_count), leaves);
    nlohmann::json& meshes = builder.json["meshes"];
    meshes[wood]["primitives"].push_back(meshes[wood + 1]["primitives"][0]);
    builder.json["scenes"][0]["nodes"].erase(builder.json["scenes"][0]["nodes"].size() - 1);
  };
  add_level("LOD0", 300);
  add_level("LOD1", 150);
  add_level("LOD2", 60);
  add_shape(builder, card, billboard, name("billboard"));
  return builder;
}

INSTANTIATE_TEST_SUITE_P(Packs, LooksTest,
                         testing::Values(LooksCase{.name = "lod_pack",
                                                   .plant = [] { return oak_pack(true); },
                                                   .reference = [] { return oak(); },
                                                   .defect = [] { return oak_pack(false); }},
                                         LooksCase{.name = "centimetres",
                                                   .plant = [] { return oak(100); },
                                                   .reference = [] { return oak(); },
                                                   .defect = [] { return oak(); },
                                                   .bake = {.import = {.metres_per_unit = 0.01}}}),
                         looks_name);

}  // namespace
}  // namespace coppice::test
