#include "alpha_mask.h"

#include <string>

namespace coppice::bake {
namespace {

Error invalid(const char* what, std::uint32_t image) {
  return Error{Status::invalid_argument, what, Error::kNoOffset, std::to_string(image)};
}

}  // namespace

Result<std::vector<AlphaMask>> alpha_masks(const std::vector<Material>& materials, const std::vector<Image>& images) {
  std::vector<AlphaMask> masks(materials.size());
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const Material& material = materials[m];
    if (material.alpha_cutoff <= 0.0f || material.image == kNone) continue;
    if (material.image >= images.size()) return invalid("a material's image is out of range", material.image);
    const Image& image = images[material.image];
    const std::size_t texel_count = std::size_t{image.width} * image.height;
    if (texel_count == 0 || image.rgba.size() != texel_count * 4) return invalid("an image's size and data disagree", material.image);
    masks[m] = {image.width, image.height, std::vector<std::uint8_t>(texel_count)};
    for (std::size_t i = 0; i < texel_count; ++i)
      masks[m].hole[i] = material.base_color.a * static_cast<float>(image.rgba[i * 4 + 3]) / 255.0f < material.alpha_cutoff;
  }
  return masks;
}

}  // namespace coppice::bake
