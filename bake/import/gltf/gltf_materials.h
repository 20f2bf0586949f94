#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>

#include "gltf_references.h"
#include "plant.h"
#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

/// Longer side of the images a plant keeps: a leaf or bark is never seen larger than this from where a game camera stands.
inline constexpr std::uint32_t kMaxImageSide_px = 512;

/// Material `index` of a model from load_gltf; the glTF default material for kNone. `image` and `normal_map` are the model's image
/// indices. A normal map that lies otherwise on the surface than the base colour is left out, with a warning.
/// alphaMode BLEND becomes MASK at 0.5, with a warning: leaves are drawn unsorted.
Material convert_material(const tinygltf::Model& model, std::uint32_t index, std::vector<std::string>& warnings);

/// How the images of a material lie on its surface: texel at offset + linear * uv of the set TEXCOORD_n.
struct TextureUvs {
  std::uint32_t set = 0;
  bool is_transformed = false;  ///< by KHR_texture_transform; otherwise the uvs are as they are
  glm::dmat2 linear{1.0};
  glm::dvec2 offset{0.0};

  bool operator==(const TextureUvs&) const = default;
};
/// Those of the base colour, or without one of the normal map.
TextureUvs texture_uvs(const tinygltf::Model& model, std::uint32_t index);

/// Where the files of images are.
struct ImageFolder {
  std::filesystem::path path;
  OutsideFiles outside = OutsideFiles::refused;
};

/// Decodes the images that the materials use and renumbers them. An image in a form that is not read is left out, with a warning. A normal
/// map is made of unit vectors, its material's scale applied.
/// errors  io: the image's file is missing; bad_file: the image is damaged or ends early (a leaf without its mask would bake as a
///         rectangle); unsupported: a file over 1 GiB; invalid_argument: see resolve_reference
/// sources  [materials.size()] their indices in the model
Result<std::vector<Image>> take_images(const tinygltf::Model& model, std::span<const std::uint32_t> sources,
                                       std::vector<Material>& materials, const ImageFolder& folder, std::vector<std::string>& warnings);

}  // namespace coppice::bake
