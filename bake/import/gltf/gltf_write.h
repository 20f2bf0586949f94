#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// A glTF scene of one node per mesh; a mesh has one primitive per material it uses.
struct GltfPart {
  std::string name;
  const Mesh* mesh = nullptr;  ///< not null; every index within its arrays (asserted)
};

/// A binary glTF 2.0 file in memory. Material i of the file is materials[i], texture i shows images[i] as an embedded PNG; a material is
/// alpha masked when its cutoff is above 0. A mesh with leaves that are not opaque has their opacity as the alpha of COLOR_0, and those
/// leaves a copy of their material that is blended (alphaMode BLEND), after all others. Empty meshes are left out. A pure function: same
/// arguments, same bytes.
/// errors  invalid_argument: a position is not finite (the mesh is named), or more than 4 GiB
Result<std::vector<std::uint8_t>> encode_glb(const std::vector<GltfPart>& parts, const std::vector<Material>& materials,
                                             const std::vector<Image>& images);

/// encode_glb to a .glb, atomically: either the whole file appears at `path` or the file that was there stays.
/// errors  those of encode_glb; io: names the path and the operating system's reason
Result<void> write_glb(const std::filesystem::path& path, const std::vector<GltfPart>& parts, const std::vector<Material>& materials,
                       const std::vector<Image>& images);

/// Leaf quads as a mesh: four vertices and two triangles a leaf, flat normals, the card's uvs.
Mesh foliage_mesh(const Foliage& foliage);

}  // namespace coppice::bake
