#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>

#include "gltf_cost.h"
#include "gltf_references.h"
#include "plant.h"
#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

/// Maximum side of the images that a plant keeps: no game camera sees a leaf or bark larger than this.
inline constexpr std::uint32_t kMaxImageSide_px = 512;

/// Converts material `index` of a model from load_gltf; for kNone, glTF's default material. `image` and `normal_map` are the model's image
/// indices. A normal map is left out, with a warning, if its texture coordinates differ from the base colour's. alphaMode BLEND becomes
/// MASK at 0.5, with a warning: leaves are drawn unsorted.
Material convert_material(const tinygltf::Model& model, std::uint32_t index, std::vector<std::string>& warnings);

/// Maps a surface's texture coordinates to the images of its material: texel at offset + linear * uv of the set TEXCOORD_n.
struct TextureUvs {
  std::uint32_t set = 0;
  bool is_transformed = false;  ///< KHR_texture_transform changes the uvs
  glm::dmat2 linear{1.0};
  glm::dvec2 offset{0.0};

  bool operator==(const TextureUvs&) const = default;
};
/// Reads the mapping of the base colour; without a base colour, of the normal map.
TextureUvs texture_uvs(const tinygltf::Model& model, std::uint32_t index);

/// The folder of a glTF, where the files of its images are.
struct ImageFolder {
  std::filesystem::path path;
  OutsideFiles outside = OutsideFiles::refused;
  std::uint64_t max_triangles = kMaxSourceTriangles;  ///< whose memory all images together may take (gltf_cost.h)
  ReadObserver on_read = {};                          ///< may be empty
};

/// Decodes the images that the materials use and renumbers them. A normal map becomes unit vectors, with its material's scale applied; one
/// that cannot be read is left out, with a warning. Warns also of opaque materials whose images have holes that no material uses.
/// sources  [materials.size()] the materials' indices in the model
/// errors  of base colours, since a leaf without its mask would bake as a rectangle: io: the image's file is missing; bad_file: the image
///         is damaged or ends early; unsupported: another form, a file over 1 GiB, more pixels than the limit; invalid_argument: see
///         resolve_reference
Result<std::vector<Image>> take_images(const tinygltf::Model& model, std::span<const std::uint32_t> sources,
                                       std::vector<Material>& materials, const ImageFolder& folder, std::vector<std::string>& warnings);

}  // namespace coppice::bake
