#pragma once

#include <cstdint>
#include <string>
#include <vector>

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

/// Which TEXCOORD_n set the base colour of that material uses.
std::uint32_t base_color_uv_set(const tinygltf::Model& model, std::uint32_t index);

/// Decodes the images that the materials use and renumbers them. An image that cannot be decoded is left out, with a warning.
std::vector<Image> take_images(const tinygltf::Model& model, std::vector<Material>& materials, std::vector<std::string>& warnings);

}  // namespace coppice::bake
