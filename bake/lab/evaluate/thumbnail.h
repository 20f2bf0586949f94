#pragma once

// Draws pictures for a person who reads the report; no figure is computed from them. The renderer of the figures draws them from one of its
// cameras, in colour and smoothed.

#include <array>
#include <cstdint>
#include <vector>

#include "evaluation_render.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kThumbnailSizePx = 256;

/// Shared by all pictures of one plant.
struct ThumbnailView {
  EvaluationCamera camera;
  std::array<std::vector<SurfaceLook>, 3> looks;  ///< [red, green, blue] albedo is the colour's part in that channel
};

/// Selects the evaluation's camera that looks most nearly from the side.
/// source  its bounding sphere is framed
/// errors  those of surface_looks
Result<ThumbnailView> thumbnail_view(const Mesh& source, const std::vector<Material>& materials, const std::vector<Image>& images,
                                     SurfaceColour colour = SurfaceColour::mean);

/// A PNG file, RGB, kThumbnailSizePx square, white where nothing is visible.
/// errors  internal: the picture cannot be encoded
Result<std::vector<std::uint8_t>> render_thumbnail_png(const Level& level, const ThumbnailView& view);

}  // namespace coppice::bake
