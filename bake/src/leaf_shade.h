#pragma once

// How bright a leaf is on screen, where the baker compares pictures.

#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"
#include "visibility.h"

namespace coppice::bake {

inline constexpr float kWhiteLuminance = 255.0f;

/// Mean linear luminance of the texels that are no holes; of the base colour without an image.
float mean_texel_luminance(const Material& material, const std::vector<Image>& images, const AlphaMask& mask);

/// Lambert, 0..255 as a display would show it. cosine  of the angle to the light, at least 0
float lambert_luminance(float albedo, float cosine);

/// Two-sided Lambert, 0..255 as a display would show it. to_light  unit
float shaded_luminance(const Quad& quad, float albedo, const glm::vec3& to_light);

}  // namespace coppice::bake
