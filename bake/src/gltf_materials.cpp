#include "gltf_materials.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <tiny_gltf.h>

#include "image_decode.h"

namespace coppice::bake {
namespace {

// What stands in for BLEND: half covered is covered.
constexpr float kBlendCutoff = 0.5f;

float clamped(double value, float fallback) {
  if (!std::isfinite(value)) return fallback;
  return static_cast<float>(std::clamp(value, 0.0, 1.0));
}

float alpha_cutoff(const tinygltf::Material& source, std::vector<std::string>& warnings) {
  if (source.alphaMode == "MASK") return clamped(source.alphaCutoff, kBlendCutoff);
  if (source.alphaMode != "BLEND") return 0.0f;
  warnings.push_back("material '" + source.name.substr(0, 64) + "' blends; it is drawn with an alpha mask at 0.5 instead");
  return kBlendCutoff;
}

/// With an image the mask compares base_color.a * texel with the cutoff: the factor goes into the cutoff, so that whoever reads the texel
/// alone sees the same holes.
void fold_alpha(Material& material, std::vector<std::string>& warnings) {
  if (material.image == kNone || material.alpha_cutoff == 0.0f) return;
  if (material.base_color.a < material.alpha_cutoff)
    warnings.push_back("material '" + material.name.substr(0, 64) + "' is wholly transparent: its base colour's alpha is below the cutoff");
  material.alpha_cutoff = material.base_color.a > 0.0f ? std::min(1.0f, material.alpha_cutoff / material.base_color.a) : 1.0f;
  material.base_color.a = 1.0f;
}

/// The model's image behind a texture, kNone when there is none.
std::uint32_t image_of(const tinygltf::Model& model, int texture) {
  if (texture < 0) return kNone;
  const int source = model.textures.at(static_cast<std::size_t>(texture)).source;
  return source < 0 ? kNone : static_cast<std::uint32_t>(source);
}

void warn_of_texture_transform(const tinygltf::Material& source, std::vector<std::string>& warnings) {
  if (source.pbrMetallicRoughness.baseColorTexture.extensions.count("KHR_texture_transform") == 0) return;
  warnings.push_back("material '" + source.name.substr(0, 64) + "': KHR_texture_transform is ignored");
}

}  // namespace

Material convert_material(const tinygltf::Model& model, std::uint32_t index, std::vector<std::string>& warnings) {
  Material material;
  if (index == kNone) {
    material.name = "default";
    material.double_sided = false;
    return material;
  }
  const tinygltf::Material& source = model.materials.at(index);
  const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
  material.name = source.name;
  for (int c = 0; c < 4 && pbr.baseColorFactor.size() == 4; ++c)
    material.base_color[c] = clamped(pbr.baseColorFactor[static_cast<std::size_t>(c)], 1.0f);
  material.image = image_of(model, pbr.baseColorTexture.index);
  material.alpha_cutoff = alpha_cutoff(source, warnings);
  fold_alpha(material, warnings);
  material.roughness = clamped(pbr.roughnessFactor, 1.0f);
  material.double_sided = source.doubleSided;
  warn_of_texture_transform(source, warnings);
  return material;
}

std::uint32_t base_color_uv_set(const tinygltf::Model& model, std::uint32_t index) {
  if (index == kNone) return 0;
  return static_cast<std::uint32_t>(std::max(model.materials.at(index).pbrMetallicRoughness.baseColorTexture.texCoord, 0));
}

std::vector<Image> take_images(const tinygltf::Model& model, std::vector<Material>& materials, std::vector<std::string>& warnings) {
  std::vector<Image> images;
  std::map<std::uint32_t, std::uint32_t> taken;  // model image -> index in `images`, kNone if undecodable
  for (Material& material : materials) {
    if (material.image == kNone) continue;
    const auto [found, is_new] = taken.try_emplace(material.image, kNone);
    if (is_new) {
      const tinygltf::Image& source = model.images.at(material.image);
      Result<Image> image = decode_image(source.image, kMaxImageSide_px);
      if (image) {
        found->second = static_cast<std::uint32_t>(images.size());
        images.push_back(*std::move(image));
      } else {
        const std::string name = source.uri.empty() ? source.name : source.uri;
        warnings.push_back("images[" + std::to_string(material.image) + "] '" + name.substr(0, 64) + "' left out: " + image.error().what);
      }
    }
    material.image = found->second;
  }
  return images;
}

}  // namespace coppice::bake
