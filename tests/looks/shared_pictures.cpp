// Plants whose leaves, bark and ornaments have one picture or one material between them, and pictures in forms that are not read.

#include <random>

#include "looks_case.h"
#include "test_foliage.h"
#include "tree_parts.h"

namespace coppice::test::shared_pictures {

constexpr UvBox kLeafBox{{0.02f, 0.05f}, {0.42f, 0.95f}}, kBarkBox{{0.56f, 0.02f}, {0.76f, 0.98f}}, kPotBox{{0.85f, 0.4f}, {0.95f, 0.5f}};

/// With three texels of 256 more on every side: what is shown of the picture does not end on a texel's edge.
bool is_in(const UvBox& box, float u, float v) {
  constexpr float kMargin = 3.0f / 256.0f;
  return u >= box.low.x - kMargin && u < box.high.x + kMargin && v >= box.low.y - kMargin && v < box.high.y + kMargin;
}

/// Where the texel is in the box, 0..1.
glm::vec2 place_in(const UvBox& box, float u, float v) {
  return (glm::vec2(u, v) - box.low) / (box.high - box.low);
}

/// A leaf, bark, a golden square, and paper between them.
Rgba shared_picture(float u, float v, const Rgba& paper) {
  if (is_in(kLeafBox, u, v)) {
    const glm::vec2 at = place_in(kLeafBox, u, v);
    const Rgba leaf = oval_leaf(at.x, at.y);
    return leaf[3] == 0 ? Rgba{paper[0], paper[1], paper[2], 0} : leaf;
  }
  if (is_in(kBarkBox, u, v)) {
    const glm::vec2 at = place_in(kBarkBox, u, v);
    return furrowed_bark(at.x, at.y);
  }
  if (is_in(kPotBox, u, v)) return {230, 180, 30, 255};
  return paper;
}

Shape trunk(const UvBox& uvs) {
  Shape wood;
  add_tube(wood, {.from = {0, 0, 0}, .to = {0, 3, 0}, .from_radius_m = 0.2f, .to_radius_m = 0.08f, .sides = 9, .uvs = uvs});
  return wood;
}

/// Round the foot of the trunk.
Shape pot(const UvBox& uvs) {
  Shape shape;
  add_tube(shape, {.from = {0, 0, 0}, .to = {0, 0.7f, 0}, .from_radius_m = 0.4f, .to_radius_m = 0.6f, .uvs = uvs});
  return shape;
}

Shape crown(const UvBox& uvs) {
  Shape cards = crown_of_cards(300);
  for (glm::vec2& uv : cards.uvs) uv = uvs.low + uv * (uvs.high - uvs.low);
  return cards;
}

/// tint  1, or about what the mean of the whole picture makes of it
GltfBuilder tree_of_one_picture(const Rgba& paper, const glm::vec4& tint) {
  GltfBuilder builder;
  const auto paint = [&](float u, float v) { return shared_picture(u, v, paper); };
  const int all = add_surface(builder, {.name = "leaves", .base_color = tint, .image = painted_png(256, 256, paint), .alpha_cutoff = 0.5f});
  nlohmann::json& materials = builder.json["materials"];
  nlohmann::json bark = materials[static_cast<std::size_t>(all)];
  bark["name"] = "bark";
  const int same = static_cast<int>(materials.size());
  materials.push_back(std::move(bark));
  add_shape(builder, crown(kLeafBox), all, "crown");
  add_shape(builder, trunk(kBarkBox), same, "trunk");
  add_shape(builder, pot(kPotBox), same, "pot");
  return builder;
}

/// As add_shape, with COLOR_0: by vertex, linear.
void add_colored_shape(GltfBuilder& builder, const Shape& shape, int material, const std::vector<glm::vec3>& colors) {
  const int node = add_shape(builder, shape, material);
  const auto mesh = builder.json["nodes"][static_cast<std::size_t>(node)]["mesh"].get<std::size_t>();
  builder.json["meshes"][mesh]["primitives"][0]["attributes"]["COLOR_0"] = builder.add_positions(colors);
}

enum class Colors { by_part, mean, wind, none };

/// A tree that has no picture but colours of vertices: or weights for the wind there, which must not be seen.
GltfBuilder tree_of_vertex_colors(Colors colors) {
  GltfBuilder builder;
  const bool has_colors = colors == Colors::by_part;
  const int leaves = add_surface(builder, {.name = "leaves", .base_color = has_colors ? glm::vec4(1) : glm::vec4(0.09f, 0.22f, 0.03f, 1)});
  const int wood = add_surface(builder, {.name = "bark", .base_color = has_colors ? glm::vec4(1) : glm::vec4(0.16f, 0.09f, 0.05f, 1)});
  const Shape cards = crown({}), stem = trunk({}), red_pot = pot({});
  std::mt19937 random(9);
  const auto repeated = [](std::size_t count, const glm::vec3& color) { return std::vector<glm::vec3>(count, color); };
  std::vector<glm::vec3> of_leaves;
  for (std::size_t i = 0; i < cards.positions.size(); i += 4) {
    const float phase = uniform(random, 0, 1);
    const bool is_autumn = cards.positions[i].y > 2.9f;
    for (std::size_t k = 0; k < 4; ++k) {
      if (colors == Colors::wind) of_leaves.emplace_back(phase, k < 2 ? 0.0f : 1.0f, cards.positions[i + k].y / 4.0f);
      if (colors == Colors::by_part) of_leaves.push_back(is_autumn ? glm::vec3(0.6f, 0.25f, 0.02f) : glm::vec3(0.09f, 0.22f, 0.03f));
      if (colors == Colors::mean) of_leaves.emplace_back(0.45f, 0.5f, 0.45f);
    }
  }
  const glm::vec3 brown = has_colors ? glm::vec3(0.16f, 0.09f, 0.05f) : glm::vec3(1),
                  red = has_colors ? glm::vec3(0.7f, 0.02f, 0.02f) : glm::vec3(1);
  if (colors == Colors::none) {
    add_shape(builder, cards, leaves);
    add_shape(builder, stem, wood);
    add_shape(builder, red_pot, wood);
    return builder;
  }
  add_colored_shape(builder, cards, leaves, of_leaves);
  add_colored_shape(builder, stem, wood, repeated(stem.positions.size(), brown));
  add_colored_shape(builder, red_pot, wood, repeated(red_pot.positions.size(), red));
  return builder;
}

enum class Textures { none, png, png_and_ktx2 };  ///< KTX2 is not read

GltfBuilder tree_of(Textures textures) {
  GltfBuilder builder;
  const int leaves = add_surface(builder, {.name = "leaves", .image = painted_png(64, 64, oval_leaf), .alpha_cutoff = 0.5f});
  const int bark = add_surface(builder, {.name = "bark", .image = painted_png(64, 64, furrowed_bark)});
  add_shape(builder, crown({}), leaves, "crown");
  add_shape(builder, bare_tree(), bark, "trunk");
  if (textures == Textures::none)
    for (nlohmann::json& material : builder.json["materials"]) material["pbrMetallicRoughness"].erase("baseColorTexture");
  if (textures != Textures::png_and_ktx2) return builder;
  const std::vector<std::uint8_t> ktx{0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
  builder.json["images"].push_back({{"bufferView", builder.add_view(ktx)}, {"mimeType", "image/ktx2"}});
  for (nlohmann::json& texture : builder.json["textures"])
    texture["extensions"]["KHR_texture_basisu"]["source"] = builder.json["images"].size() - 1;
  return builder;
}

constexpr Rgba kWhite{255, 255, 255, 255}, kMagenta{255, 0, 255, 255};

INSTANTIATE_TEST_SUITE_P(SharedPictures, LooksTest,
                         testing::Values(LooksCase{.name = "one_picture_on_white_paper",
                                                   .plant = [] { return tree_of_one_picture(kWhite, glm::vec4(1)); },
                                                   .defect = [] { return tree_of_one_picture(kWhite, glm::vec4(1.0f, 0.7f, 0.8f, 1)); }},
                                         LooksCase{.name = "one_picture_on_magenta",
                                                   .plant = [] { return tree_of_one_picture(kMagenta, glm::vec4(1)); },
                                                   .defect = [] { return tree_of_one_picture(kMagenta, glm::vec4(1.0f, 0.6f, 1.0f, 1)); }},
                                         LooksCase{.name = "vertex_colours",
                                                   .plant = [] { return tree_of_vertex_colors(Colors::by_part); },
                                                   .defect = [] { return tree_of_vertex_colors(Colors::mean); }},
                                         LooksCase{.name = "wind_weights",
                                                   .plant = [] { return tree_of_vertex_colors(Colors::wind); },
                                                   .reference = [] { return tree_of_vertex_colors(Colors::none); },
                                                   .defect = [] { return tree_of_vertex_colors(Colors::mean); }},
                                         LooksCase{.name = "ktx2_beside_png",
                                                   .plant = [] { return tree_of(Textures::png_and_ktx2); },
                                                   .reference = [] { return tree_of(Textures::png); },
                                                   .defect = [] { return tree_of(Textures::none); }}),
                         looks_name);

}  // namespace coppice::test::shared_pictures
