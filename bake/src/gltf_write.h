#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// A glTF scene of one node per mesh; a mesh has one primitive per material it uses.
struct GltfPart {
  std::string name;
  const Mesh* mesh = nullptr;
};

/// Writes a .glb, atomically: either the whole file appears at `path` or the file that was there stays.
/// Same arguments, same bytes. Empty meshes are left out.
/// errors  io: names the path and the operating system's reason
Result<void> write_glb(const std::filesystem::path& path, const std::vector<GltfPart>& parts, const std::vector<Material>& materials,
                       const std::vector<Image>& images);

/// Leaf quads as a mesh: four vertices and two triangles a leaf, flat normals, the card's uvs.
Mesh foliage_mesh(const Foliage& foliage);

}  // namespace coppice::bake
