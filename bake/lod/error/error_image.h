#pragma once

#include "plant.h"
#include "visibility.h"

namespace coppice::bake {

// Shared by all measured errors of a plant: its cuts' (error_table.h), its wood's and its leaf meshes' (mesh_error.h).

inline constexpr std::uint32_t kErrorViewCount = 6;
inline constexpr std::uint32_t kErrorImagePx = 512;
/// Projected diameters of the bounding sphere, px.
inline constexpr std::array<std::uint32_t, 7> kErrorSizesPx = {8, 16, 32, 64, 128, 256, 512};

/// Luminance 0..255, or another channel, [kErrorImagePx * kErrorImagePx], rows top to bottom.
using LuminanceImage = std::vector<float>;
/// Mean squared difference at each of kErrorSizesPx.
using SquaredErrors = std::array<double, kErrorSizesPx.size()>;

/// The six viewpoints from which errors are measured: spread over the sphere, and turned so that no set of viewpoints() holds one of them.
std::vector<Viewpoint> error_viewpoints();
/// The sphere seen from each of these, filling the image.
std::vector<Projection> error_projections(const Sphere& sphere);
/// Direction to the light of those images, unit.
const glm::vec3& error_light();

/// The luminance that a pixel of the plant counts with: the part above half counts half. So the background is whiter than a white flower,
/// whose loss would otherwise be no error. luminance  0..255
float plant_luminance(float luminance);

/// The image box-filtered from from_px x from_px down to size_px x size_px, both powers of two.
LuminanceImage coarse_image(LuminanceImage image, std::uint32_t from_px, std::uint32_t size_px);

/// Mean squared differences of both images, box-filtered down to each size.
SquaredErrors squared_errors(const LuminanceImage& source, const LuminanceImage& other);

/// size_px * rmse / 255 over all views, px: see ARCHITECTURE.md, "Error table". size  index into kErrorSizesPx
float error_px_of(const std::array<SquaredErrors, kErrorViewCount>& errors, std::size_t size);

/// What each view of a plant covers, in any unit.
using ViewCoverage = std::array<double, kErrorViewCount>;
/// How much the views of another LoD gain or lose of their coverage, as a share of all; 0 if the source covers nothing.
double changed_coverage(const ViewCoverage& source, const ViewCoverage& other);

/// Converts the share of its coverage that a plant gains or loses to an error, px: squares hardly show it if the plant fills little of the
/// image. At a threshold of 2 px a 20th is right; of a plant below 16 px more, since it is less visible.
float coverage_error_px(double share, std::uint32_t size_px);

}  // namespace coppice::bake
