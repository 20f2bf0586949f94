#include "gltf_write.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include <stb_image_write.h>
#include <tiny_gltf.h>
#include <glm/geometric.hpp>
#include <glm/gtc/type_precision.hpp>

#include "atomic_file.h"
#include "bounds.h"
#include "check.h"
#include "gltf_accessor.h"
#include "gltf_document.h"
#include "tree.h"

namespace coppice::bake {
namespace {

// A .glb is one JSON chunk and one binary chunk. Attribute arrays go to the binary chunk once per mesh and are shared by its primitives,
// one for each material in use; images follow as PNG files.

/// Appends `bytes` to the binary chunk, four-byte aligned as accessors need; returns the buffer view's index.
int add_view(tinygltf::Model& model, const void* bytes, std::size_t byte_count, int target) {
  std::vector<unsigned char>& data = model.buffers.front().data;
  data.resize((data.size() + 3) / 4 * 4);
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = byte_count;
  view.target = target;
  const auto* first = static_cast<const unsigned char*>(bytes);
  data.insert(data.end(), first, first + byte_count);
  model.bufferViews.push_back(std::move(view));
  return static_cast<int>(model.bufferViews.size() - 1);
}

/// Adds an accessor of values as they lie in memory; returns its index.
template <class Value>
int add_values(tinygltf::Model& model, const std::vector<Value>& values, int type, int component_type,
               int target = TINYGLTF_TARGET_ARRAY_BUFFER) {
  tinygltf::Accessor accessor;
  accessor.bufferView = add_view(model, values.data(), values.size() * sizeof(Value), target);
  accessor.componentType = component_type;
  accessor.type = type;
  accessor.count = values.size();
  model.accessors.push_back(std::move(accessor));
  return static_cast<int>(model.accessors.size() - 1);
}

int add_positions(tinygltf::Model& model, const std::vector<glm::vec3>& positions) {
  const auto [low, high] = box_of(positions);
  const int index = add_values(model, positions, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT);
  model.accessors.back().minValues = {low.x, low.y, low.z};
  model.accessors.back().maxValues = {high.x, high.y, high.z};
  return index;
}

int add_indices(tinygltf::Model& model, const std::vector<std::uint32_t>& indices, std::size_t vertex_count) {
  constexpr int kTarget = TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER;
  // 0xffff itself may not be an index: it restarts primitives.
  if (vertex_count > 0xffff) return add_values(model, indices, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, kTarget);
  const std::vector<std::uint16_t> narrow(indices.begin(), indices.end());
  return add_values(model, narrow, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, kTarget);
}

bool is_translucent(const Mesh& mesh, std::size_t triangle) {
  return !mesh.vertex_opacities.empty() && mesh.vertex_opacities[mesh.indices[3 * triangle]] < kOpaque;
}

/// Adds COLOR_0: white with the opacity as alpha.
int add_opacities(tinygltf::Model& model, const std::vector<std::uint8_t>& opacities) {
  std::vector<glm::u8vec4> colors;
  for (const std::uint8_t opacity : opacities)
    colors.emplace_back(255, 255, 255, static_cast<std::uint8_t>((255u * opacity + kOpaque / 2) / kOpaque));
  const int index = add_values(model, colors, TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE);
  model.accessors.back().normalized = true;
  return index;
}

/// blended  [material] index of its blended copy in the file; kNone if there is none
void add_mesh(tinygltf::Model& model, const GltfPart& part, const std::vector<std::uint32_t>& blended) {
  const Mesh& mesh = *part.mesh;
  std::vector<std::vector<std::uint32_t>> by_material(model.materials.size());
  for (std::size_t triangle = 0; triangle < mesh.triangle_materials.size(); ++triangle) {
    const std::uint32_t material = mesh.triangle_materials[triangle];
    auto& indices = by_material[is_translucent(mesh, triangle) ? blended[material] : material];
    indices.insert(indices.end(), &mesh.indices[3 * triangle], &mesh.indices[3 * triangle] + 3);
  }

  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.attributes["POSITION"] = add_positions(model, mesh.positions);
  primitive.attributes["NORMAL"] = add_values(model, mesh.normals, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT);
  primitive.attributes["TEXCOORD_0"] = add_values(model, mesh.uvs, TINYGLTF_TYPE_VEC2, TINYGLTF_COMPONENT_TYPE_FLOAT);
  const bool any_translucent = std::ranges::any_of(mesh.vertex_opacities, [](std::uint8_t opacity) { return opacity < kOpaque; });
  if (any_translucent) primitive.attributes["COLOR_0"] = add_opacities(model, mesh.vertex_opacities);
  if (!mesh.vertex_alongs.empty())
    primitive.attributes["_SPREAD"] = add_values(model, mesh.vertex_alongs, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_FLOAT);

  tinygltf::Mesh gltf_mesh;
  gltf_mesh.name = part.name;
  for (std::size_t material = 0; material < by_material.size(); ++material) {
    if (by_material[material].empty()) continue;
    primitive.indices = add_indices(model, by_material[material], mesh.positions.size());
    primitive.material = static_cast<int>(material);
    gltf_mesh.primitives.push_back(primitive);
  }
  model.meshes.push_back(std::move(gltf_mesh));

  tinygltf::Node node;
  node.name = part.name;
  node.mesh = static_cast<int>(model.meshes.size() - 1);
  model.nodes.push_back(std::move(node));
  model.scenes.front().nodes.push_back(static_cast<int>(model.nodes.size() - 1));
}

void add_material(tinygltf::Model& model, const Material& material) {
  tinygltf::Material out;
  out.name = material.name;
  out.doubleSided = material.double_sided;
  out.alphaMode = material.alpha_cutoff > 0.0f ? "MASK" : "OPAQUE";
  if (material.alpha_cutoff > 0.0f) out.alphaCutoff = static_cast<double>(material.alpha_cutoff);
  auto& pbr = out.pbrMetallicRoughness;
  const glm::vec4& color = material.base_color;
  pbr.baseColorFactor = {color.r, color.g, color.b, color.a};
  pbr.metallicFactor = 0.0;
  pbr.roughnessFactor = static_cast<double>(material.roughness);
  if (material.image != kNone) pbr.baseColorTexture.index = static_cast<int>(material.image);
  if (material.normal_map != kNone) out.normalTexture.index = static_cast<int>(material.normal_map);
  model.materials.push_back(std::move(out));
}

/// Appends a blended copy of each material that a translucent leaf has. returns  [material] the copy's index; kNone without one
std::vector<std::uint32_t> add_blended_materials(tinygltf::Model& model, const std::vector<GltfPart>& parts) {
  std::vector<std::uint32_t> blended(model.materials.size(), kNone);
  for (const GltfPart& part : parts)
    for (std::size_t triangle = 0; triangle < part.mesh->triangle_materials.size(); ++triangle) {
      std::uint32_t& copy = blended[part.mesh->triangle_materials[triangle]];
      if (copy != kNone || !is_translucent(*part.mesh, triangle)) continue;
      copy = static_cast<std::uint32_t>(model.materials.size());
      tinygltf::Material material = model.materials[part.mesh->triangle_materials[triangle]];
      material.alphaMode = "BLEND";
      material.alphaCutoff = 0.5;  // glTF's default
      model.materials.push_back(std::move(material));
    }
  return blended;
}

Result<void> add_image(tinygltf::Model& model, const Image& image) {
  COPPICE_TRY(png, encode_png(image.width, image.height, 4, image.rgba));
  tinygltf::Image out;
  out.mimeType = "image/png";
  out.bufferView = add_view(model, png.data(), png.size(), 0);
  model.images.push_back(std::move(out));
  tinygltf::Texture texture;
  texture.source = static_cast<int>(model.images.size() - 1);
  model.textures.push_back(std::move(texture));
  return {};
}

Result<void> check_mesh(const GltfPart& part, std::size_t material_count) {
  const Mesh& mesh = *part.mesh;
  const std::size_t vertex_count = mesh.positions.size();
  COPPICE_ASSERT(mesh.normals.size() == vertex_count && mesh.uvs.size() == vertex_count);
  COPPICE_ASSERT(mesh.vertex_opacities.empty() || mesh.vertex_opacities.size() == vertex_count);
  COPPICE_ASSERT(mesh.vertex_alongs.empty() || mesh.vertex_alongs.size() == vertex_count);
  COPPICE_ASSERT(mesh.indices.size() == 3 * mesh.triangle_materials.size());
  COPPICE_ASSERT(std::ranges::all_of(mesh.indices, [&](std::uint32_t index) { return index < vertex_count; }));
  COPPICE_ASSERT(std::ranges::all_of(mesh.triangle_materials, [&](std::uint32_t index) { return index < material_count; }));
  if (!std::ranges::all_of(mesh.positions, is_finite<3, float>))
    return Error{Status::invalid_argument, "position is not finite in mesh", Error::kNoOffset, part.name};
  return {};
}

Result<std::vector<std::uint8_t>> serialise(const tinygltf::Model& model) {
  tinygltf::TinyGLTF writer;
  std::ostringstream stream;
  if (!writer.WriteGltfSceneToStream(&model, stream, false, true)) return Error{Status::internal, "glTF cannot be serialised"};
  // A stream that gets no memory stops without throwing.
  if (!stream.good()) return Error{Status::out_of_memory, "glTF"};
  const std::string text = std::move(stream).str();
  return std::vector<std::uint8_t>(text.begin(), text.end());
}

}  // namespace

Result<std::vector<std::uint8_t>> encode_glb(const std::vector<GltfPart>& parts, const std::vector<Material>& materials,
                                             const std::vector<Image>& images) {
  for (const Material& material : materials) COPPICE_ASSERT(material.image == kNone || material.image < images.size());
  for (const Image& image : images)
    COPPICE_ASSERT(image.width > 0 && image.height > 0 && image.rgba.size() == std::size_t{4} * image.width * image.height);
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "coppice";
  model.buffers.resize(1);
  model.scenes.resize(1);
  model.scenes.front().name = "plant";  // tinygltf writes a scene without name and nodes as null, which is not glTF
  model.defaultScene = 0;
  for (const Material& material : materials) add_material(model, material);
  for (const GltfPart& part : parts) COPPICE_CHECK(check_mesh(part, materials.size()));
  const std::vector<std::uint32_t> blended = add_blended_materials(model, parts);
  for (const GltfPart& part : parts)
    if (!part.mesh->indices.empty()) add_mesh(model, part, blended);
  for (const Image& image : images) COPPICE_CHECK(add_image(model, image));
  // Leaves a mebibyte for the JSON chunk, whose size follows from the number of parts and materials, not of triangles.
  if (model.buffers.front().data.size() > kMaxGltfBytes - (1u << 20)) return Error{Status::invalid_argument, "a .glb holds at most 4 GiB"};
  if (model.buffers.front().data.empty()) model.buffers.clear();
  return serialise(model);
}

Result<void> write_glb(const std::filesystem::path& path, const std::vector<GltfPart>& parts, const std::vector<Material>& materials,
                       const std::vector<Image>& images) {
  COPPICE_TRY(bytes, encode_glb(parts, materials, images));
  return write_file_atomically(path, bytes);
}

Result<std::vector<std::uint8_t>> encode_png(std::uint32_t width, std::uint32_t height, std::uint32_t channels,
                                             std::span<const std::uint8_t> pixels) {
  std::vector<std::uint8_t> png;
  const auto append = [](void* user, void* data, int byte_count) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    auto& out = *static_cast<std::vector<std::uint8_t>*>(user);
    out.insert(out.end(), bytes, bytes + byte_count);
  };
  const int columns = static_cast<int>(width), rows = static_cast<int>(height), components = static_cast<int>(channels);
  if (stbi_write_png_to_func(append, &png, columns, rows, components, pixels.data(), components * columns) == 0)
    return Error{Status::internal, "image cannot be encoded as PNG"};
  return png;
}

Mesh foliage_mesh(const Foliage& foliage) {
  Mesh mesh;
  const bool any_normals = std::ranges::any_of(foliage.normals, [](std::uint16_t normals) { return normals != kFlatNormals; });
  for (std::size_t leaf = 0; leaf < foliage.quads.size(); ++leaf) {
    const Quad& quad = foliage.quads[leaf];
    const Card& card = foliage.card_table[foliage.cards[leaf]];
    // The diagonals' cross product is the mean normal of a bent quad. A quad collapsed to a line has none and gets up.
    const glm::vec3 across = glm::cross(quad[2] - quad[0], quad[3] - quad[1]);
    const float length = glm::length(across);
    const glm::vec3 own = length > 0.0f ? across / length : glm::vec3(0.0f, 1.0f, 0.0f);
    const std::uint16_t bits = any_normals ? foliage.normals[leaf] : kFlatNormals;
    const auto& [axis, along, is_sided] = unpack_normals(bits, {own.x, own.y, own.z});
    glm::vec3 normal(axis[0], axis[1], axis[2]);
    if (!is_sided && glm::dot(normal, own) < 0.0f) normal = -normal;
    const auto first = static_cast<std::uint32_t>(4 * leaf);
    mesh.positions.insert(mesh.positions.end(), quad.begin(), quad.end());
    mesh.normals.insert(mesh.normals.end(), 4, normal);
    mesh.uvs.insert(mesh.uvs.end(), card.uv.begin(), card.uv.end());
    mesh.indices.insert(mesh.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
    mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, card.material);
    if (!foliage.opacities.empty()) mesh.vertex_opacities.insert(mesh.vertex_opacities.end(), 4, foliage.opacities[leaf]);
    if (any_normals) mesh.vertex_alongs.insert(mesh.vertex_alongs.end(), 4, is_sided ? -along : along);
  }
  return mesh;
}

}  // namespace coppice::bake
