#pragma once

// Compressed forms of what a GltfBuilder holds, coded by the libraries themselves.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "gltf_builder.h"

namespace coppice::test {

/// A mesh for Draco. Ids in the stream: positions 0, uvs 1, colours 2.
struct DracoMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec2> uvs;                       ///< may be empty
  std::vector<std::array<std::uint8_t, 4>> colors;  ///< may be empty
  std::vector<std::array<std::uint32_t, 3>> triangles;
  bool edgebreaker = true;  ///< otherwise sequential, which keeps the order of vertices and triangles
  int position_bits = 0;    ///< 0: not quantised
};

std::vector<std::uint8_t> encode_draco(const DracoMesh& mesh);

/// Gives the primitive KHR_draco_mesh_compression over `coded`; its accessors for `ids` must exist. Returns the extension object.
nlohmann::json& add_draco(GltfBuilder& builder, nlohmann::json& primitive, const std::vector<std::uint8_t>& coded,
                          const nlohmann::json& ids);

/// What a buffer view of a GltfBuilder becomes.
struct MeshoptCoding {
  std::string mode = "ATTRIBUTES";
  std::string filter = "NONE";
  int stride = 4;
  std::string extension = "EXT_meshopt_compression";
};

/// Codes `values` as they are: with a filter, what the filter is to decode. Index modes take 16- or 32-bit indices, by their stride.
std::vector<std::uint8_t> encode_meshopt(const std::vector<std::uint8_t>& values, const MeshoptCoding& coding);

/// Replaces a view's bytes by their coding; the plain bytes would be in a fallback buffer that has none.
/// Returns the extension object.
nlohmann::json& compress_view(GltfBuilder& builder, int view, const MeshoptCoding& coding);

/// A WebP of one colour, lossless.
std::vector<std::uint8_t> webp(int width, int height, std::array<std::uint8_t, 4> rgba);

}  // namespace coppice::test
