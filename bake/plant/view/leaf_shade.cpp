#include "leaf_shade.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "srgb.h"

namespace coppice::bake {
namespace shading {
using glm::vec2, glm::vec3, glm::dot, glm::sqrt, glm::max, glm::clamp;
#include "coppice/coppice_surface.glsl"
}  // namespace shading
namespace {

glm::vec3 mean_texel_color(const Material& material, const std::vector<Image>& images, const AlphaMask& mask) {
  if (material.image == kNone) return glm::vec3(material.base_color);
  const Image& image = images[material.image];
  glm::dvec3 sum(0.0);
  double weights = 0.0;
  for (std::size_t texel = 0; texel * 4 < image.rgba.size(); ++texel) {
    if (!mask.hole.empty() && mask.hole[texel] != 0) continue;
    const double weight = image.shown.empty() ? 1.0 : static_cast<double>(image.shown[texel]);
    sum += weight * glm::dvec3(linear_color(&image.rgba[4 * texel]) * glm::vec3(material.base_color));
    weights += weight;
  }
  return weights > 0.0 ? glm::vec3(sum / weights) : glm::vec3(0.0f);
}

}  // namespace

float luminance(const glm::vec3& linear) {
  return glm::dot(linear, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

float mean_texel_luminance(const Material& material, const std::vector<Image>& images, const AlphaMask& mask) {
  return luminance(mean_texel_color(material, images, mask));
}

std::vector<glm::vec3> mean_texel_colors(const std::vector<Material>& materials, const std::vector<Image>& images,
                                         const std::vector<AlphaMask>& masks) {
  std::vector<glm::vec3> colors;
  for (std::size_t m = 0; m < materials.size(); ++m) colors.push_back(mean_texel_color(materials[m], images, masks[m]));
  return colors;
}

glm::vec2 chroma(const glm::vec3& albedo, float cosine) {
  const float gray = lambert_luminance(luminance(albedo), cosine);
  return {lambert_luminance(albedo.r, cosine) - gray, lambert_luminance(albedo.b, cosine) - gray};
}

glm::dvec3 quad_normal(const Quad& quad) {
  const glm::dvec3 across = glm::cross(glm::dvec3(quad[2]) - glm::dvec3(quad[0]), glm::dvec3(quad[3]) - glm::dvec3(quad[1]));
  const double length = glm::length(across);
  return length > 0.0 ? across / length : glm::dvec3(0.0);
}

ShadingNormals shading_normals(std::uint16_t bits, const Quad& quad) {
  const glm::vec3 own(quad_normal(quad));
  return unpack_normals(bits, {own.x, own.y, own.z});
}

glm::vec2 leaf_light(const ShadingNormals& normals, const glm::vec3& to_light, const glm::vec3& to_viewer) {
  const auto& [x, y, z] = normals.axis;
  return shading::coppice_leaf_light({x, y, z}, normals.along, to_light, to_viewer, normals.is_sided ? 1.0f : 0.0f);
}

float leaf_cosine(const ShadingNormals& normals, const glm::vec3& to_light, const glm::vec3& to_viewer, float translucency) {
  const glm::vec2 light = leaf_light(normals, to_light, to_viewer);
  return light.x + translucency * light.y;
}

float lambert_luminance(float albedo, float cosine) {
  return kWhiteLuminance * srgb_from_linear(std::clamp(albedo * (0.35f + 0.65f * cosine), 0.0f, 1.0f));
}

}  // namespace coppice::bake
