#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>

#include "plant.h"
#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

/// Longer side of the images a plant keeps: a leaf or bark is never seen larger than this from where a game camera stands.
inline constexpr std::uint32_t kMaxImageSide_px = 512;

/// Material `index` of a model from load_gltf; the glTF default material for kNone. `image` is the model's image index.
/// alphaMode BLEND becomes MASK at 0.5, with a warning: leaves are drawn unsorted.
Material convert_material(const tinygltf::Model& model, std::uint32_t index, std::vector<std::string>& warnings);

/// How the base colour of a material lies on its surface: texel at offset + linear * uv of the set TEXCOORD_n.
struct BaseColorUvs {
  std::uint32_t set = 0;
  bool is_transformed = false;  ///< by KHR_texture_transform; otherwise the uvs are as they are
  glm::dmat2 linear{1.0};
  glm::dvec2 offset{0.0};
};
BaseColorUvs base_color_uvs(const tinygltf::Model& model, std::uint32_t index);

/// Decodes the images that the materials use and renumbers them. An image in a form that is not read is left out, with a warning.
/// errors  io: the image's file is missing; bad_file: the image is damaged. A leaf without its mask would bake as a rectangle
Result<std::vector<Image>> take_images(const tinygltf::Model& model, std::vector<Material>& materials, std::vector<std::string>& warnings);

}  // namespace coppice::bake
