// The appearance of materials in the evaluation: see evaluation_render.h.

#include <cmath>
#include <string>

#include <glm/geometric.hpp>

#include "evaluation_render.h"

namespace coppice::bake {
namespace {

double linear_from_srgb(std::uint8_t value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

double luminance(const glm::dvec3& linear) {
  return glm::dot(linear, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// Sums over texels that are no holes.
struct AlbedoSums {
  std::uint32_t width = 0, height = 0;
  std::vector<double> sums;
  std::vector<std::uint32_t> counts;
};

AlbedoMip mean_albedo(const AlbedoSums& level) {
  AlbedoMip mip{level.width, std::vector<float>(level.sums.size(), 0.0f)};
  for (std::size_t i = 0; i < level.sums.size(); ++i)
    if (level.counts[i] > 0) mip.albedo[i] = static_cast<float>(level.sums[i] / level.counts[i]);
  return mip;
}

AlbedoSums halved(const AlbedoSums& level) {
  AlbedoSums half{(level.width + 1) / 2, (level.height + 1) / 2, {}, {}};
  half.sums.resize(std::size_t{half.width} * half.height);
  half.counts.resize(half.sums.size());
  for (std::size_t y = 0; y < level.height; ++y)
    for (std::size_t x = 0; x < level.width; ++x) {
      const std::size_t to = y / 2 * half.width + x / 2, from = y * level.width + x;
      half.sums[to] += level.sums[from];
      half.counts[to] += level.counts[from];
    }
  return half;
}

std::vector<AlbedoMip> albedo_mips(AlbedoSums level) {
  std::vector<AlbedoMip> mips{mean_albedo(level)};
  while (level.width > 1 || level.height > 1) {
    level = halved(level);
    mips.push_back(mean_albedo(level));
  }
  return mips;
}

Result<SurfaceLook> look_of(const Material& material, const std::vector<Image>& images, SurfaceColour colour) {
  SurfaceLook look;
  const glm::dvec3 factor(material.base_color);
  look.albedo = luminance(factor);
  const bool masked = material.alpha_cutoff > 0.0f;
  if (material.image == kNone) {
    look.all_holes = masked && material.base_color.a < material.alpha_cutoff;
    return look;
  }
  if (material.image >= images.size())
    return Error{Status::invalid_argument, "a material's image is out of range", Error::kNoOffset, material.name};
  const Image& image = images[material.image];
  const std::size_t texel_count = std::size_t{image.width} * image.height;
  if (texel_count == 0 || image.rgba.size() != 4 * texel_count)
    return Error{Status::invalid_argument, "an image's size and data disagree", Error::kNoOffset, material.name};

  if (masked) look.holes.resize(texel_count);
  look.width = image.width;
  look.height = image.height;
  AlbedoSums texels{image.width, image.height, {}, {}};
  if (colour == SurfaceColour::textured) {
    texels.sums.resize(texel_count);
    texels.counts.resize(texel_count);
  }
  glm::dvec3 sum(0.0);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < texel_count; ++i) {
    const std::uint8_t* rgba = image.rgba.data() + 4 * i;
    const bool hole = masked && material.base_color.a * static_cast<float>(rgba[3]) / 255.0f < material.alpha_cutoff;
    if (masked) look.holes[i] = hole ? 1 : 0;
    if (hole) continue;
    const glm::dvec3 linear(linear_from_srgb(rgba[0]), linear_from_srgb(rgba[1]), linear_from_srgb(rgba[2]));
    sum += linear;
    ++seen;
    if (texels.sums.empty()) continue;
    texels.sums[i] = luminance(factor * linear);
    texels.counts[i] = 1;
  }
  if (seen > 0) look.albedo = luminance(factor * sum / static_cast<double>(seen));
  if (!texels.sums.empty()) look.mips = albedo_mips(std::move(texels));
  return look;
}

}  // namespace

Result<std::vector<SurfaceLook>> surface_looks(const std::vector<Material>& materials, const std::vector<Image>& images,
                                               SurfaceColour colour) {
  std::vector<SurfaceLook> looks;
  for (const Material& material : materials) {
    COPPICE_TRY(look, look_of(material, images, colour));
    looks.push_back(std::move(look));
  }
  return looks;
}

}  // namespace coppice::bake
