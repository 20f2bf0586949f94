#include "unpack.h"

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "block_texture.h"
#include "decoded_pages.h"
#include "layout.h"
#include "normal_map.h"
#include "quantised_tree.h"
#include "reader.h"
#include "wood_codec.h"

namespace coppice::bake {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// Adds which chunk it is and where. The codecs know only their chunk's bytes.
Error in_chunk(Error error, const coppice_file_chunk& chunk) {
  if (error.status == Status::invalid_argument) error.status = Status::bad_file;
  error.offset = chunk.offset + (error.offset == Error::kNoOffset ? 0 : error.offset);
  error.detail =
      std::string(chunk_kind_name(chunk.kind)) + " " + std::to_string(chunk.index) + (error.detail.empty() ? "" : ", " + error.detail);
  return error;
}

/// A chunk's bytes, after checking their checksum. read_front has checked that they are in the file.
Result<Bytes> chunk_bytes(const coppice_file_chunk& chunk, Bytes file) {
  const Bytes bytes = file.subspan(static_cast<std::size_t>(chunk.offset), static_cast<std::size_t>(chunk.bytes));
  COPPICE_CHECK(check_chunk(chunk, bytes));
  return bytes;
}

const coppice_file_chunk& chunk_of(const PlantFile& file, coppice_chunk_kind kind, std::uint32_t index) {
  return *find_chunk(file, kind, index);  // read_front has checked that the table holds every chunk PLANT names
}

QuantisationBox quantisation_box(const coppice_file_plant& plant) {
  return {glm::make_vec3(plant.leaf_box_min), glm::make_vec3(plant.leaf_box_max), quantised_max(plant)};
}

Tree root_tree(const PlantFile& file, const QuantisationBox& box, const QuantisedQuad& root) {
  Tree tree;
  for (const QuantisedPoint& corner : root) tree.vertices.push_back(dequantise(box, corner));
  tree.nodes.push_back({{0, 1, 2, 3}, file.plant.root_card});
  tree.node_split.push_back(kNone);
  return tree;
}

/// errors  bad_file: the parent has been split before
Result<void> apply_split(Tree& tree, const QuantisationBox& box, const Split& split) {
  const auto split_index = static_cast<std::uint32_t>(tree.split_parent.size());
  if (tree.node_split[split.parent] != kNone)
    return Error{Status::bad_file, "page parent", Error::kNoOffset,
                 "split " + std::to_string(split_index) + " replaces node " + std::to_string(split.parent) + ", which is gone"};
  tree.node_split[split.parent] = split_index;
  tree.split_parent.push_back(split.parent);
  std::array<std::uint32_t, 8> corners;
  corners.fill(kNone);
  for (std::size_t corner = 0; corner < 4; ++corner) corners[split.parent_slots[corner]] = tree.nodes[split.parent].vertices[corner];
  std::size_t next = 0;
  for (std::uint32_t& corner : corners) {
    if (corner != kNone) continue;
    corner = static_cast<std::uint32_t>(tree.vertices.size());
    tree.vertices.push_back(dequantise(box, split.new_vertices[next++]));
  }
  for (std::size_t child = 0; child < 2; ++child) {
    tree.nodes.push_back(
        {{corners[4 * child], corners[4 * child + 1], corners[4 * child + 2], corners[4 * child + 3]}, split.cards[child]});
    tree.node_split.push_back(kNone);
  }
  return {};
}

Result<Tree> read_tree(const PlantFile& file, Bytes bytes) {
  const QuantisationBox box = quantisation_box(file.plant);
  const PageNode root = root_node(file.plant);
  Tree tree = root_tree(file, box, root.corners);
  DecodedPages pages(root, file.plant.leaf_count, file.plant.card_count, box.steps);
  for (std::uint32_t page = 0; page < file.plant.page_count; ++page) {
    const coppice_file_chunk& chunk = chunk_of(file, COPPICE_CHUNK_PAGE, page);
    COPPICE_TRY(content, chunk_bytes(chunk, bytes));
    const auto splits = pages.add(content);
    if (!splits) return in_chunk(splits.error(), chunk);
    for (const Split& split : *splits)
      if (auto applied = apply_split(tree, box, split); !applied) return in_chunk(applied.error(), chunk);
  }
  const std::vector<PageNode> nodes = pages.nodes();
  for (std::size_t node = 0; node < nodes.size(); ++node) {
    tree.nodes[node].opacity = nodes[node].opacity;
    tree.nodes[node].normals = nodes[node].normals;
  }
  std::uint32_t next_source = 0;
  for (std::uint32_t split : tree.node_split) tree.node_source.push_back(split == kNone ? next_source++ : kNone);
  return tree;
}

Result<WoodMesh> read_mesh(const coppice_file_chunk& chunk, Bytes bytes, const WoodShape& shape) {
  COPPICE_TRY(content, chunk_bytes(chunk, bytes));
  auto decoded = decode_wood(content, shape);
  if (!decoded) return in_chunk(decoded.error(), chunk);
  return *std::move(decoded);
}

Result<Mesh> plain_mesh(const WoodMesh& decoded, const coppice_file_chunk& chunk) {
  Mesh mesh;
  for (const WoodVertex& vertex : decoded.vertices) {
    mesh.positions.emplace_back(vertex.position[0], vertex.position[1], vertex.position[2]);
    mesh.normals.emplace_back(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
    mesh.uvs.emplace_back(vertex.uv[0], vertex.uv[1]);
  }
  mesh.indices = to_vector(decoded.indices);
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::uint32_t material = decoded.vertices[mesh.indices[i]].material;
    for (std::size_t corner = 1; corner < 3; ++corner)
      if (decoded.vertices[mesh.indices[i + corner]].material != material)
        return in_chunk({Status::bad_file, "wood material", Error::kNoOffset, "a triangle has two"}, chunk);
    mesh.triangle_materials.push_back(material);
  }
  return mesh;
}

Result<LeafMeshPart> read_leaf_mesh(const PlantFile& file, Bytes bytes, std::uint32_t index) {
  const coppice_file_chunk& chunk = chunk_of(file, COPPICE_CHUNK_LEAF_MESH, index);
  const auto [vertices, triangles] = file.leaf_meshes[index];
  COPPICE_TRY(decoded, read_mesh(chunk, bytes, {vertices, triangles, file.materials, true}));
  LeafMeshPart part;
  COPPICE_CHECK(move_into(part.mesh, plain_mesh(decoded, chunk)));
  const QuantisationBox box = quantisation_box(file.plant);
  for (const WoodVertex& vertex : decoded.vertices) part.stalks.push_back(dequantise(box, vertex.stalk));
  return part;
}

Result<Image> read_image(const PlantFile& file, Bytes bytes, std::uint32_t index) {
  const coppice_file_chunk& chunk = chunk_of(file, COPPICE_CHUNK_TEXTURE, index);
  COPPICE_TRY(content, chunk_bytes(chunk, bytes));
  COPPICE_CHECK(check_texture(file, index, content));
  COPPICE_TRY(layout, texture_layout(file.textures[index]));
  const MipLevel& level = layout.levels().front();
  Image image{level.width, level.height, std::vector<std::uint8_t>(std::size_t{level.width} * level.height * 4)};
  decode_texture_level(layout.format, level, content.subspan(static_cast<std::size_t>(level.offset), static_cast<std::size_t>(level.bytes)),
                       image.rgba);
  return image;
}

void copy_tables(const PlantFile& file, BakedPlant& plant) {
  for (const coppice_file_material& source : file.materials) {
    Material material;
    material.name = "material" + std::to_string(plant.materials.size());
    material.base_color = glm::make_vec4(source.base_color);
    const std::uint32_t texture = material_texture(source), normal_map = material_normal_map(source);
    material.image = texture == COPPICE_NO_TEXTURE ? kNone : texture;
    material.normal_map = normal_map == COPPICE_NO_TEXTURE ? kNone : normal_map;
    material.alpha_cutoff = source.alpha_cutoff;
    material.roughness = source.roughness;
    material.double_sided = (source.flags & COPPICE_MATERIAL_DOUBLE_SIDED) != 0;
    material.sided_normals = (source.flags & COPPICE_MATERIAL_SIDED_NORMALS) != 0;
    plant.materials.push_back(std::move(material));
  }
  for (const coppice_file_card& source : file.cards) {
    Card card{source.material, {}};
    for (std::size_t corner = 0; corner < 4; ++corner) card.uv[corner] = glm::make_vec2(source.uv[corner]);
    plant.card_table.push_back(card);
  }
  plant.errors = {to_vector(file.error_leaf_counts), to_vector(file.error_sizes_px), to_vector(file.error_px)};
}

/// Checks that every vertex is inside the sphere, but for quantisation and rounding: culling trusts the sphere.
Result<void> check_sphere(const PlantFile& file, const BakedPlant& plant) {
  // Doubles, so that squares of finite numbers stay finite.
  const glm::dvec3 extent = glm::make_vec3(file.plant.leaf_box_max) - glm::make_vec3(file.plant.leaf_box_min);
  const glm::dvec3 center = plant.sphere.center;
  // Tolerates half a step of 14 bits on each axis of the leaf box or the wood's, which are inside the sphere: under 1e-4 of either.
  const double radius = plant.sphere.radius;
  const double max_length = radius + 1e-4 * std::max({extent.x, extent.y, extent.z, 2.0 * radius});
  const auto outside = [&](const glm::vec3& point) {
    const glm::dvec3 offset = glm::dvec3(point) - center;
    return !(glm::dot(offset, offset) <= max_length * max_length);
  };
  bool holds = std::ranges::none_of(plant.tree.vertices, outside);
  for (const Mesh& lod : plant.wood.lods) holds = holds && std::ranges::none_of(lod.positions, outside);
  for (const LeafMeshPart& part : plant.leaf_meshes.parts) holds = holds && std::ranges::none_of(part.mesh.positions, outside);
  if (!holds)
    return Error{Status::bad_file, "plant sphere",
                 chunk_of(file, COPPICE_CHUNK_PLANT, 0).offset + offsetof(coppice_file_plant, sphere_center), "does not hold every vertex"};
  return {};
}

}  // namespace

Result<Mesh> unpack_wood(const PlantFile& file, Bytes bytes, std::uint32_t lod) {
  const coppice_file_chunk& chunk = chunk_of(file, COPPICE_CHUNK_WOOD, lod);
  COPPICE_TRY(decoded, read_mesh(chunk, bytes, {file.plant.wood_vertex_counts[lod], file.plant.wood_triangle_counts[lod], file.materials}));
  return plain_mesh(decoded, chunk);
}

Result<BakedPlant> unpack(Bytes bytes) {
  COPPICE_TRY(file, read_front(bytes, bytes.size()));
  BakedPlant plant;
  plant.name = file.plant.name;
  plant.metric = file.plant.metric;
  plant.sphere = {glm::make_vec3(file.plant.sphere_center), file.plant.sphere_radius};
  plant.wind = {file.wind, to_vector(file.wind_nodes)};
  copy_tables(file, plant);
  COPPICE_CHECK(move_into(plant.tree, read_tree(file, bytes)));
  for (std::uint32_t lod = 0; lod < file.plant.wood_lod_count; ++lod)
    COPPICE_CHECK(move_into(plant.wood.lods.emplace_back(), unpack_wood(file, bytes, lod)));
  plant.wood.error_px = to_vector(file.wood_error_px);
  for (std::uint32_t texture = 0; texture < file.plant.texture_count; ++texture)
    COPPICE_CHECK(move_into(plant.images.emplace_back(), read_image(file, bytes, texture)));
  for (std::uint32_t mesh = 0; mesh < file.plant.leaf_mesh_count; ++mesh)
    COPPICE_CHECK(move_into(plant.leaf_meshes.parts.emplace_back(), read_leaf_mesh(file, bytes, mesh)));
  plant.leaf_meshes.error_px = to_vector(file.leaf_mesh_error_px);
  for (const Material& material : plant.materials)
    if (material.normal_map != kNone && !plant.images[material.normal_map].is_normal_map)
      plant.images[material.normal_map] = normal_map_from_stored(plant.images[material.normal_map]);
  COPPICE_CHECK(check_sphere(file, plant));
  return plant;
}

}  // namespace coppice::bake
