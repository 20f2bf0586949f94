#include "gltf_builder.h"

#include <string_view>
#include <utility>

#include <stb_image_write.h>

namespace coppice::test {
namespace {

void append_u32(std::vector<std::uint8_t>& bytes, std::size_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

std::vector<std::uint8_t> to_bytes(const std::string& text) {
  return {text.begin(), text.end()};
}

void append_bytes(void* user, void* data, int size) {
  auto& file = *static_cast<std::vector<std::uint8_t>*>(user);
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  file.insert(file.end(), bytes, bytes + size);
}

int last_index(const nlohmann::json& array) {
  return static_cast<int>(array.size()) - 1;
}

}  // namespace

GltfBuilder::GltfBuilder() {
  json["asset"]["version"] = "2.0";
  json["scene"] = 0;
  json["scenes"] = {{{"nodes", nlohmann::json::array()}}};
}

int GltfBuilder::add_view(std::span<const std::uint8_t> bytes, int stride) {
  bin.resize((bin.size() + 3) / 4 * 4);
  nlohmann::json view{{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}};
  if (stride != 0) view["byteStride"] = stride;
  bin.insert(bin.end(), bytes.begin(), bytes.end());
  json["bufferViews"].push_back(view);
  return last_index(json["bufferViews"]);
}

int GltfBuilder::add_accessor(int view, int component, const std::string& type, std::size_t count, bool normalized, std::size_t offset) {
  nlohmann::json accessor{{"bufferView", view}, {"componentType", component}, {"type", type}, {"count", count}};
  if (normalized) accessor["normalized"] = true;
  if (offset != 0) accessor["byteOffset"] = offset;
  json["accessors"].push_back(accessor);
  return last_index(json["accessors"]);
}

int GltfBuilder::add_material(const std::string& name) {
  json["materials"].push_back({{"name", name}});
  return last_index(json["materials"]);
}

int GltfBuilder::add_mesh(const nlohmann::json& attributes, std::optional<int> indices, std::optional<int> material, int mode) {
  nlohmann::json primitive{{"attributes", attributes}};
  if (indices) primitive["indices"] = *indices;
  if (material) primitive["material"] = *material;
  if (mode != 4) primitive["mode"] = mode;
  json["meshes"].push_back({{"primitives", {primitive}}});
  return last_index(json["meshes"]);
}

int GltfBuilder::add_node(int mesh, const nlohmann::json& members) {
  nlohmann::json node = members;
  if (mesh >= 0) node["mesh"] = mesh;
  json["nodes"].push_back(node);
  json["scenes"][0]["nodes"].push_back(last_index(json["nodes"]));
  return last_index(json["nodes"]);
}

void GltfBuilder::set_texture(int material, std::span<const std::uint8_t> encoded_image) {
  json["images"].push_back({{"bufferView", add_view(encoded_image)}, {"mimeType", "image/png"}});
  json["textures"].push_back({{"source", last_index(json["images"])}});
  json["materials"][static_cast<std::size_t>(material)]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = last_index(json["textures"]);
}

nlohmann::json GltfBuilder::with_buffer(const std::optional<std::string>& uri) const {
  nlohmann::json document = json;
  if (document.contains("buffers")) return document;
  document["buffers"] = {{{"byteLength", bin.size()}}};
  if (uri) document["buffers"][0]["uri"] = *uri;
  if (fallback_bytes > 0)
    document["buffers"].push_back({{"byteLength", fallback_bytes}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  return document;
}

std::vector<std::uint8_t> GltfBuilder::glb() const {
  std::string text = with_buffer(std::nullopt).dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::size_t bin_bytes = (bin.size() + 3) / 4 * 4;
  std::vector<std::uint8_t> file = to_bytes("glTF");
  append_u32(file, 2);
  append_u32(file, 12 + 8 + text.size() + 8 + bin_bytes);
  append_u32(file, text.size());
  append_u32(file, 0x4e4f534a);
  file.insert(file.end(), text.begin(), text.end());
  append_u32(file, bin_bytes);
  append_u32(file, 0x004e4942);
  file.insert(file.end(), bin.begin(), bin.end());
  file.resize(file.size() + bin_bytes - bin.size());
  return file;
}

std::vector<std::uint8_t> GltfBuilder::gltf() const {
  return gltf_beside("data:application/octet-stream;base64," + base64(bin));
}

std::vector<std::uint8_t> GltfBuilder::gltf_beside(const std::string& bin_uri) const {
  return to_bytes(with_buffer(bin_uri).dump());
}

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::vector<std::uint8_t> encode_png(const std::vector<std::uint8_t>& rgba, int width, int height) {
  std::vector<std::uint8_t> file;
  stbi_write_png_to_func(append_bytes, &file, width, height, 4, rgba.data(), 4 * width);
  return file;
}

std::vector<std::uint8_t> striped_png(int width, std::array<std::uint8_t, 4> even, std::array<std::uint8_t, 4> odd) {
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < 2 * width; ++i) {
    const auto& rgba = i % width % 2 == 0 ? even : odd;
    pixels.insert(pixels.end(), rgba.begin(), rgba.end());
  }
  return encode_png(pixels, width, 2);
}

std::vector<std::uint8_t> png(int width, int height, std::array<std::uint8_t, 4> rgba) {
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < width * height; ++i) pixels.insert(pixels.end(), rgba.begin(), rgba.end());
  return encode_png(pixels, width, height);
}

GltfBuilder small_plant() {
  GltfBuilder builder;
  const int leaves = builder.add_material("leaves");
  const int bark = builder.add_material("bark");
  const int leaf_positions = builder.add_positions({{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}});
  const int leaf_indices = builder.add_indices(std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3});
  const int wood_positions = builder.add_positions({{0.0f, -1.0f, 0.0f}, {0.5f, -1.0f, 0.0f}, {0.0f, 0.0f, 0.0f}});
  builder.add_node(builder.add_mesh({{"POSITION", leaf_positions}}, leaf_indices, leaves));
  builder.add_node(builder.add_mesh({{"POSITION", wood_positions}}, std::nullopt, bark));
  return builder;
}

}  // namespace coppice::test
