#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// A mesh, which becomes one node of the scene; it has one primitive per material in use.
struct GltfPart {
  std::string name;
  const Mesh* mesh = nullptr;  ///< not null; every index within its arrays (asserted)
};

/// Writes a binary glTF 2.0 file in memory. Material i of the file is materials[i], texture i shows images[i] as an embedded PNG; a
/// material is alpha masked if its cutoff is above 0. A mesh with leaves that are not opaque stores their opacity as the alpha of COLOR_0,
/// and those leaves get a blended copy of their material (alphaMode BLEND), after all others. A mesh with alongs stores them as the float
/// attribute _SPREAD, beside the axis in NORMAL. Empty meshes are left out. Same arguments, same bytes.
/// errors  invalid_argument: a position is not finite (the mesh is named), or more than 4 GiB
Result<std::vector<std::uint8_t>> encode_glb(const std::vector<GltfPart>& parts, const std::vector<Material>& materials,
                                             const std::vector<Image>& images);

/// Writes encode_glb to a .glb, atomically: either the whole file appears at `path` or the earlier file stays.
/// errors  those of encode_glb; io: names the path and the operating system's reason
Result<void> write_glb(const std::filesystem::path& path, const std::vector<GltfPart>& parts, const std::vector<Material>& materials,
                       const std::vector<Image>& images);

/// Writes an image of 8-bit channels, rows top to bottom, as a PNG file in memory. errors  internal
Result<std::vector<std::uint8_t>> encode_png(std::uint32_t width, std::uint32_t height, std::uint32_t channels,
                                             std::span<const std::uint8_t> pixels);

/// Makes a mesh of leaf quads: four vertices and two triangles a leaf, the card's uvs. Normals are the axes of the leaves' normals, on the
/// side of the quad's own, or on the front of leaves that have one; alongs are negative for those (Mesh::vertex_alongs). It has alongs only
/// if a leaf's normals are not its quad's own.
Mesh foliage_mesh(const Foliage& foliage);

}  // namespace coppice::bake
