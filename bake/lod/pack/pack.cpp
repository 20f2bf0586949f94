#include "pack.h"

#include <algorithm>

#include "bounds.h"
#include "card_look.h"
#include "card_shown.h"
#include "mesh_error.h"
#include "page_encode.h"
#include "quantised_tree.h"
#include "reader.h"
#include "utf8.h"
#include "wood_encode.h"
#include "wood_lods.h"
#include "writer.h"

namespace coppice::bake {
namespace {

void store(float (&target)[3], const glm::vec3& value) {
  for (int axis = 0; axis < 3; ++axis) target[axis] = value[axis];
}

/// Stores the whole UTF-8 sequences of `name` that leave room for a zero. Bytes that belong to none become '?'.
void store_name(char (&target)[64], const std::string& name) {
  const std::vector<std::uint8_t> text(name.begin(), name.end());
  std::size_t length = 0;
  for (std::size_t at = 0; at < text.size() && text[at] != 0;) {
    const std::size_t sequence = utf8_sequence_length(std::span(text).subspan(at));
    const std::size_t taken = std::max<std::size_t>(sequence, 1);
    if (length + taken >= sizeof target) break;
    for (std::size_t i = 0; i < taken; ++i) target[length++] = sequence == 0 ? '?' : name[at + i];
    at += taken;
  }
}

/// [material] Whether only leaf meshes show it.
std::vector<bool> leaf_mesh_materials(const BakedPlant& plant) {
  std::vector<bool> of_meshes(plant.materials.size(), false);
  const auto mark = [&](std::uint32_t material, bool value) {
    if (material < of_meshes.size()) of_meshes[material] = value;  // an invalid index is refused later
  };
  for (const LeafMeshPart& part : plant.leaf_meshes.parts)
    for (const std::uint32_t material : part.mesh.triangle_materials) mark(material, true);
  for (const Card& card : plant.card_table) mark(card.material, false);
  for (const Mesh& lod : plant.wood.lods)
    for (const std::uint32_t material : lod.triangle_materials) mark(material, false);
  return of_meshes;
}

coppice_file_material file_material(const Material& material, bool leaf_mesh_only) {
  coppice_file_material result{};
  for (int channel = 0; channel < 4; ++channel) result.base_color[channel] = std::clamp(material.base_color[channel], 0.0f, 1.0f);
  result.alpha_cutoff = std::clamp(material.alpha_cutoff, 0.0f, 1.0f);
  result.roughness = std::clamp(material.roughness, 0.0f, 1.0f);
  set_material_textures(result, material.image == kNone ? COPPICE_NO_TEXTURE : material.image,
                        material.normal_map == kNone ? COPPICE_NO_TEXTURE : material.normal_map);
  result.flags = material.double_sided ? COPPICE_MATERIAL_DOUBLE_SIDED : 0u;
  if (leaf_mesh_only) result.flags |= COPPICE_MATERIAL_LEAF_MESH_ONLY;
  if (material.sided_normals) result.flags |= COPPICE_MATERIAL_SIDED_NORMALS;
  return result;
}

coppice_file_card file_card(const Card& card, const ShownShares& shown, const FileContents& contents) {
  coppice_file_card result{};
  result.material = card.material;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    result.uv[corner][0] = card.uv[corner].x;
    result.uv[corner][1] = card.uv[corner].y;
  }
  set_card_look(contents.materials[card.material], contents.textures, shown, result);
  return result;
}

/// The cutoff of the first alpha-tested material that shows the image; 0 if there is none.
float cutoff_of_image(const BakedPlant& plant, std::size_t image) {
  for (const Material& material : plant.materials)
    if (material.image == image && material.alpha_cutoff > 0.0f) return material.alpha_cutoff;
  return 0.0f;
}

Result<void> add_pages(const QuantisedTree& tree, FileContents& contents) {
  for (std::size_t first = 0; first < tree.splits.size(); first += COPPICE_PAGE_SPLITS) {
    const std::size_t count = std::min<std::size_t>(COPPICE_PAGE_SPLITS, tree.splits.size() - first);
    const PageSource source{std::span(tree.splits).subspan(first, count), static_cast<std::uint32_t>(first), tree.nodes,
                            tree.box.max - tree.box.min, tree.box.steps};
    COPPICE_CHECK(move_into(contents.pages.emplace_back(), encode_page(source)));
  }
  return {};
}

void set_wood(std::size_t lod, EncodedWood wood, FileContents& contents) {
  contents.plant.wood_vertex_counts[lod] = wood.vertex_count;
  contents.plant.wood_triangle_counts[lod] = wood.triangle_count;
  contents.wood.resize(std::max(contents.wood.size(), lod + 1));
  contents.wood[lod] = std::move(wood.bytes);
}

/// Bytes of the first read without the coarsest wood.
std::uint64_t first_read_without_wood(const FileContents& contents, std::size_t texture_count) {
  const std::size_t chunk_count = 7 + contents.pages.size() + COPPICE_MAX_WOOD_LODS + texture_count + contents.leaf_meshes.size();
  const std::size_t error_count = contents.error_leaf_counts.size() + contents.error_sizes_px.size() + contents.error_px.size() +
                                  contents.leaf_mesh_error_px.size() + COPPICE_MAX_WOOD_LODS * contents.error_sizes_px.size();
  return sizeof(coppice_file_header) + chunk_count * sizeof(coppice_file_chunk) + sizeof(coppice_file_plant) +
         contents.materials.size() * sizeof(coppice_file_material) + contents.cards.size() * sizeof(coppice_file_card) +
         sizeof(coppice_file_wind) + contents.wind_nodes.size() * sizeof(coppice_file_wind_node) +
         contents.leaf_mesh_counts.size() * sizeof(coppice_file_leaf_mesh) + error_count * sizeof(float) +
         textures_chunk(contents.textures, contents.materials).size() + (contents.pages.empty() ? 0 : contents.pages.front().size());
}

/// Adds a coarser LoD if the wood does not fit into the rest of the first read, unless wood cannot get that small. Returns the LoD; without
/// triangles: none was needed.
Result<Mesh> fit_coarsest_wood(const BakedPlant& plant, Mesh coarsest, FileContents& contents) {
  Mesh fitted;
  const std::uint64_t others = first_read_without_wood(contents, plant.images.size());
  const std::size_t last = std::min<std::size_t>(contents.wood.size(), COPPICE_MAX_WOOD_LODS - 1);
  while (others + contents.wood.back().size() > COPPICE_FIRST_READ_BYTES) {
    Mesh halved = halve_wood(coarsest);
    if (halved.indices.size() >= coarsest.indices.size()) break;
    COPPICE_TRY(wood, encode_wood(halved, static_cast<std::uint32_t>(plant.materials.size())));
    if (wood.bytes.empty()) break;
    set_wood(last, std::move(wood), contents);
    coarsest = fitted = std::move(halved);
  }
  return fitted;
}

Result<void> add_wood(const BakedPlant& plant, FileContents& contents) {
  std::vector<const Mesh*> lods;
  for (const Mesh& lod : plant.wood.lods) {
    COPPICE_TRY(wood, encode_wood(lod, static_cast<std::uint32_t>(plant.materials.size())));
    if (wood.bytes.empty()) continue;
    if (contents.wood.size() == COPPICE_MAX_WOOD_LODS) return Error{Status::invalid_argument, "pack: over COPPICE_MAX_WOOD_LODS"};
    set_wood(contents.wood.size(), std::move(wood), contents);
    lods.push_back(&lod);
  }
  if (lods.empty()) return {};
  COPPICE_TRY(fitted, fit_coarsest_wood(plant, *lods.back(), contents));
  if (!fitted.indices.empty()) {
    lods.resize(contents.wood.size() - 1);
    lods.push_back(&fitted);
  }
  if (plant.wood.error_px.size() == lods.size() * plant.errors.sizes_px.size() && fitted.indices.empty()) {
    contents.wood_error_px = plant.wood.error_px;
    return {};
  }
  return move_into(contents.wood_error_px, measure_wood_error(plant, lods));
}

/// Bits that keep positions within the steps of the leaf quads on every axis: Draco divides the longest side into equal steps.
int position_bits(const Mesh& mesh, const QuantisationBox& box) {
  const glm::vec3 extent = box_of(mesh.positions).extent(), step_m = (box.max - box.min) / static_cast<float>(box.steps);
  const float longest_m = std::max({extent.x, extent.y, extent.z});
  int bits = 14;
  constexpr int kMaxBits = 18;  // a flat plant has no steps across
  for (int axis = 0; axis < 3; ++axis)
    while (bits < kMaxBits && longest_m > step_m[axis] * static_cast<float>((1 << bits) - 1)) ++bits;
  return bits;
}

Result<void> add_leaf_meshes(const BakedPlant& plant, const QuantisationBox& box, FileContents& contents) {
  for (const LeafMeshPart& part : plant.leaf_meshes.parts) {
    std::vector<QuantisedPoint> stalks;
    for (const glm::vec3& stalk : part.stalks) stalks.push_back(quantise(box, stalk));
    if (part.mesh.positions.empty()) continue;
    COPPICE_TRY(coded,
                encode_leaf_mesh(part.mesh, stalks, static_cast<std::uint32_t>(plant.materials.size()), position_bits(part.mesh, box)));
    if (coded.bytes.empty()) continue;
    contents.leaf_mesh_counts.push_back({coded.vertex_count, coded.triangle_count});
    contents.leaf_meshes.push_back(std::move(coded.bytes));
  }
  if (!contents.leaf_meshes.empty()) contents.leaf_mesh_error_px = plant.leaf_meshes.error_px;
  return {};
}

/// Whether positions are fine: where quads are the finest level, viewers see single texels, and half a step of 14 bits is several texels.
bool has_fine_positions(const BakedPlant& plant) {
  return plant.leaf_meshes.parts.empty() && std::ranges::any_of(plant.card_table, [&](const Card& card) {
           return card.material < plant.materials.size() && plant.materials[card.material].image != kNone;
         });
}

void fill_plant(const BakedPlant& plant, const QuantisedTree& tree, coppice_file_plant& target) {
  target.leaf_count = plant.tree.leaf_count();
  store(target.leaf_box_min, tree.box.min);
  store(target.leaf_box_max, tree.box.max);
  store(target.sphere_center, plant.sphere.center);
  target.sphere_radius = plant.sphere.radius;
  for (std::size_t corner = 0; corner < 4; ++corner) std::ranges::copy(tree.nodes[0].corners[corner], target.root_quad[corner]);
  target.root_card = tree.nodes[0].card;
  target.root_opacity = tree.nodes[0].opacity;
  target.root_normals = tree.nodes[0].normals;
  target.metric = plant.metric;
  target.fine_positions = tree.box.steps == COPPICE_FINE_QUANTISED_MAX ? 1 : 0;
  store_name(target.name, plant.name);
}

std::uint64_t total_bytes(const std::vector<std::vector<std::uint8_t>>& chunks) {
  std::uint64_t sum = 0;
  for (const auto& chunk : chunks) sum += chunk.size();
  return sum;
}

}  // namespace

Result<std::vector<std::uint8_t>> pack(const BakedPlant& plant, PackSizes& sizes, TextureCoding textures) {
  COPPICE_TRY(tree, quantise_tree(plant.tree, has_fine_positions(plant) ? COPPICE_FINE_QUANTISED_MAX : COPPICE_QUANTISED_MAX));
  FileContents contents;
  fill_plant(plant, tree, contents.plant);
  const std::vector<bool> of_meshes = leaf_mesh_materials(plant);
  for (std::uint32_t m = 0; m < plant.materials.size(); ++m) contents.materials.push_back(file_material(plant.materials[m], of_meshes[m]));
  for (std::size_t i = 0; i < plant.images.size(); ++i)
    COPPICE_CHECK(move_into(contents.textures.emplace_back(), encode_texture(plant.images[i], cutoff_of_image(plant, i), textures)));
  for (const Card& card : plant.card_table)
    if (card.material >= contents.materials.size()) return Error{Status::invalid_argument, "pack: a card's material is not there"};
  for (const Tree::Node& node : plant.tree.nodes)
    if (node.card >= plant.card_table.size()) return Error{Status::invalid_argument, "pack: a node's card is not in the table"};
  COPPICE_TRY(shown, shown_shares(plant));
  for (std::size_t i = 0; i < plant.card_table.size(); ++i) contents.cards.push_back(file_card(plant.card_table[i], shown[i], contents));
  contents.error_leaf_counts = plant.errors.leaf_counts;
  contents.error_sizes_px = plant.errors.sizes_px;
  contents.error_px = plant.errors.error_px;
  contents.wind = plant.wind.head;
  contents.wind_nodes = plant.wind.nodes;
  COPPICE_CHECK(add_pages(tree, contents));
  COPPICE_CHECK(add_leaf_meshes(plant, tree.box, contents));
  COPPICE_CHECK(add_wood(plant, contents));  // comes last: it gets what the others leave of the first read
  COPPICE_TRY(file, write_file(contents));
  sizes = {file.size(), total_bytes(contents.pages), total_bytes(contents.leaf_meshes)};
  return file;
}

}  // namespace coppice::bake
