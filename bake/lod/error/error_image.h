#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"
#include "visibility.h"

namespace coppice::bake {

// What the measured errors of a plant have in common: its cuts' (error_table.h), its wood's and its leaf meshes' (mesh_error.h).

inline constexpr std::uint32_t kErrorViewCount = 6;
inline constexpr std::uint32_t kErrorImagePx = 512;
/// Projected diameters of the bounding sphere, px.
inline constexpr std::array<std::uint32_t, 7> kErrorSizesPx = {8, 16, 32, 64, 128, 256, 512};

/// Luminance 0..255, or another channel, [kErrorImagePx * kErrorImagePx], rows top to bottom.
using LuminanceImage = std::vector<float>;
/// Mean squared difference at each of kErrorSizesPx.
using SquaredErrors = std::array<double, kErrorSizesPx.size()>;

/// The six viewpoints errors are measured from: spread over the sphere, and turned so that no set of viewpoints() holds one of them.
std::vector<Viewpoint> error_viewpoints();
/// The sphere from those, filling the image.
std::vector<Projection> error_projections(const Sphere& sphere);
/// To the light of those pictures, unit.
const glm::vec3& error_light();

/// What a pixel that shows the plant counts as: of what is bright, half of what it is brighter, so that the background is whiter than a
/// white flower, which would be missed by no error otherwise. luminance  0..255
float plant_luminance(float luminance);

/// The image box-filtered down to 8 x 8.
LuminanceImage coarse_image(LuminanceImage image);

/// Both images box-filtered down to each size.
SquaredErrors squared_errors(const LuminanceImage& source, const LuminanceImage& other);

/// size_px * rmse / 255 over all views, px: see ARCHITECTURE.md, "Error table". size  index into kErrorSizesPx
float error_px_of(const std::array<SquaredErrors, kErrorViewCount>& errors, std::size_t size);

}  // namespace coppice::bake
