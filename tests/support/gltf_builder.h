#pragma once

// glTF files made in memory, byte by byte: right ones with any feature the importer must read, and wrong ones, by changing `json`.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include "text_files.h"

namespace coppice::test {

enum Component : int { kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126 };

/// Grows one buffer and the JSON that describes it.
class GltfBuilder {
 public:
  GltfBuilder();

  nlohmann::json json;
  std::vector<std::uint8_t> bin;
  /// Length of a second buffer that holds nothing and says so (EXT_meshopt_compression); 0 for none.
  std::size_t fallback_bytes = 0;

  /// Appends bytes, aligned to four; returns the buffer view.
  int add_view(std::span<const std::uint8_t> bytes, int stride = 0);
  template <class T>
  int add_view(const std::vector<T>& values, int stride = 0) {
    return add_view({reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)}, stride);
  }
  int add_accessor(int view, int component, const std::string& type, std::size_t count, bool normalized = false, std::size_t offset = 0);
  int add_positions(const std::vector<glm::vec3>& values) { return add_accessor(add_view(values), kFloat, "VEC3", values.size()); }
  int add_uvs(const std::vector<glm::vec2>& values) { return add_accessor(add_view(values), kFloat, "VEC2", values.size()); }
  template <class T>
  int add_indices(const std::vector<T>& values) {
    const int component = sizeof(T) == 1 ? kUnsignedByte : sizeof(T) == 2 ? kUnsignedShort : kUnsignedInt;
    return add_accessor(add_view(values), component, "SCALAR", values.size());
  }
  /// Returns the material.
  int add_material(const std::string& name);
  /// A mesh of one primitive; the attributes are {"POSITION": ..., ...}. Returns the mesh.
  int add_mesh(const nlohmann::json& attributes, std::optional<int> indices, std::optional<int> material, int mode = 4);
  /// A node of the default scene; `members` adds a transform or children. Returns the node.
  int add_node(int mesh, const nlohmann::json& members = nlohmann::json::object());
  nlohmann::json& node(int index) { return json["nodes"][static_cast<std::size_t>(index)]; }
  /// The first primitive of a mesh.
  nlohmann::json& primitive(std::size_t mesh = 0) { return json["meshes"][mesh]["primitives"][0]; }
  /// An image in a buffer view, a texture of it, and that as the material's base colour.
  void set_texture(int material, std::span<const std::uint8_t> encoded_image);

  [[nodiscard]] std::vector<std::uint8_t> glb() const;
  /// With the buffer as a data URI.
  [[nodiscard]] std::vector<std::uint8_t> gltf() const;
  /// With the buffer under this URI.
  [[nodiscard]] std::vector<std::uint8_t> gltf_beside(const std::string& bin_uri) const;

 private:
  [[nodiscard]] nlohmann::json with_buffer(const std::optional<std::string>& uri) const;
};

std::string base64(std::span<const std::uint8_t> bytes);
/// A PNG of [height * width] RGBA texels, rows top to bottom.
std::vector<std::uint8_t> encode_png(const std::vector<std::uint8_t>& rgba, int width, int height);
/// A PNG of one colour.
std::vector<std::uint8_t> png(int width, int height, std::array<std::uint8_t, 4> rgba);
/// A PNG two pixels high whose columns alternate between two colours.
std::vector<std::uint8_t> striped_png(int width, std::array<std::uint8_t, 4> even, std::array<std::uint8_t, 4> odd);

/// One unit square of a leaf in the plane z = 0 (material "leaves", node 0) and one triangle of wood (material "bark", node 1): the
/// smallest plant there is. Accessor 0 holds the leaf's positions, 1 its indices.
GltfBuilder small_plant();

}  // namespace coppice::test
