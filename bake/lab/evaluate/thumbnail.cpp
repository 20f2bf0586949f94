#include "thumbnail.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "gltf_write.h"
#include "measures.h"
#include "parallel_for.h"

namespace coppice::bake {
namespace {

/// Rays on each side of a pixel.
constexpr std::uint32_t kSupersampling = 2;
/// Weight of each linear channel in luminance, as in the renderer.
constexpr std::array<float, 3> kLuminanceShares = {0.2126f, 0.7152f, 0.0722f};

/// Looks whose luminance is one channel of the colour: the renderer then draws that channel.
Result<std::vector<SurfaceLook>> channel_looks(std::vector<Material> materials, const std::vector<Image>& images, SurfaceColour colour,
                                               int channel) {
  for (Material& material : materials) {
    const float value = material.base_color[channel] / kLuminanceShares[static_cast<std::size_t>(channel)];
    const float alpha = material.base_color.a;
    material.base_color = {0.0f, 0.0f, 0.0f, alpha};
    material.base_color[channel] = value;
  }
  return surface_looks(materials, images, colour);
}

glm::dvec3 side_direction() {
  constexpr double kHeight = 0.15;  // a little from above
  const auto directions = evaluation_directions(kEvaluationCameraCount);
  return *std::ranges::min_element(directions, {}, [](const glm::dvec3& direction) { return std::abs(direction.y - kHeight); });
}

}  // namespace

Result<ThumbnailView> thumbnail_view(const Mesh& source, const std::vector<Material>& materials, const std::vector<Image>& images,
                                     SurfaceColour colour) {
  ThumbnailView view;
  view.camera = evaluation_camera(side_direction(), evaluation_sphere(source));
  for (int channel = 0; channel < 3; ++channel) {
    COPPICE_TRY(looks, channel_looks(materials, images, colour, channel));
    view.looks[static_cast<std::size_t>(channel)] = std::move(looks);
  }
  return view;
}

Result<std::vector<std::uint8_t>> render_thumbnail_png(const Level& level, const ThumbnailView& view) {
  std::vector<std::uint8_t> rgb(std::size_t{3} * kThumbnailSizePx * kThumbnailSizePx);
  parallel_for(view.looks.size(), [&](std::size_t channel) {
    const std::uint32_t rendered_px = kSupersampling * kThumbnailSizePx;
    const EvaluationImage image = render_evaluation(level, view.looks[channel], view.camera, rendered_px);
    const std::vector<float> values = box_filtered(image.luminance, rendered_px, kSupersampling);
    for (std::size_t pixel = 0; pixel < values.size(); ++pixel)
      rgb[3 * pixel + channel] = static_cast<std::uint8_t>(std::lround(std::clamp(values[pixel], 0.0f, kEvaluationWhite)));
  });
  return encode_png(kThumbnailSizePx, kThumbnailSizePx, 3, rgb);
}

}  // namespace coppice::bake
