#pragma once

// How bright a leaf is on screen, wherever the baker compares images.

#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "alpha_mask.h"
#include "plant.h"

namespace coppice::bake {

inline constexpr float kWhiteLuminance = 255.0f;

float luminance(const glm::vec3& linear);

/// The mean linear colour of each material's texels that are no holes; its base colour without an image. It reads whole images: call it
/// once for all cards.
std::vector<glm::vec3> mean_texel_colors(const std::vector<Material>& materials, const std::vector<Image>& images,
                                         const std::vector<AlphaMask>& masks);

/// The luminance of one material's mean colour.
float mean_texel_luminance(const Material& material, const std::vector<Image>& images, const AlphaMask& mask);

/// Red minus luminance and blue minus luminance at a leaf's mean shade, 0..255 as a display would show it. albedo  linear
glm::vec2 chroma(const glm::vec3& albedo, float cosine = 0.5f);

/// Lambert's luminance, 0..255 as a display would show it. cosine  of the angle to the light, at least 0
float lambert_luminance(float albedo, float cosine);

/// The share of the sun on a leaf's back that shines through it: the renderer's (shaders/light/shading.glsl).
inline constexpr float kTranslucency = 0.45f;

/// Unit, the mean for a bent quad; 0 for a quad without area.
glm::dvec3 quad_normal(const Quad& quad);

/// A node's normals for shading. bits  core/tree.h
ShadingNormals shading_normals(std::uint16_t bits, const Quad& quad);

/// Light on the visible side and on the other: coppice_leaf_light of coppice_surface.glsl, the same text. Directions  unit, towards the
/// light and the viewer
glm::vec2 leaf_light(const ShadingNormals& normals, const glm::vec3& to_light, const glm::vec3& to_viewer);

/// The mean cosine of the light that leaves show: leaf_light's sides, the other one times `translucency`. 0..1
float leaf_cosine(const ShadingNormals& normals, const glm::vec3& to_light, const glm::vec3& to_viewer, float translucency);

}  // namespace coppice::bake
