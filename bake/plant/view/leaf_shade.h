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

/// Cosine of the angle between a quad's normal, on either side, and a light. to_light  unit
float two_sided_cosine(const Quad& quad, const glm::vec3& to_light);

}  // namespace coppice::bake
