#pragma once

// Item buffers: what each viewpoint sees, with all leaves behind the front one (the paper's section on visibility).

#include <cstdint>
#include <span>
#include <vector>

#include "alpha_mask.h"
#include "plant.h"
#include "raster.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

/// A leaf at a pixel, ordered by (depth, id): the smallest is in front, ties go to the smaller id.
using LeafFragment = std::uint64_t;
[[nodiscard]] inline LeafFragment make_fragment(std::uint32_t depth, std::uint32_t leaf) {
  return (std::uint64_t{depth} << 32) | leaf;
}
[[nodiscard]] inline std::uint32_t fragment_depth(LeafFragment fragment) {
  return static_cast<std::uint32_t>(fragment >> 32);
}
[[nodiscard]] inline std::uint32_t fragment_leaf(LeafFragment fragment) {
  return static_cast<std::uint32_t>(fragment);
}

/// Per view and pixel, every leaf that covers the pixel's centre, nearest first. See raster.h for projection and coverage.
struct ItemBuffers {
  std::uint32_t view_count = 0;
  std::uint32_t leaf_count = 0;
  std::uint32_t resolution_px = 0;            ///< views are square
  std::vector<std::uint64_t> fragment_begin;  ///< [view_count * resolution_px^2 + 1], view by view, rows top to bottom
  std::vector<LeafFragment> fragments;        ///< ascending within a pixel; pixel i has [fragment_begin[i], fragment_begin[i + 1])

  [[nodiscard]] std::uint32_t pixels_per_view() const { return resolution_px * resolution_px; }
  [[nodiscard]] std::span<const LeafFragment> at(std::uint32_t view, std::uint32_t pixel) const {
    const std::size_t i = std::size_t{view} * pixels_per_view() + pixel;
    return std::span(fragments).subspan(fragment_begin[i], fragment_begin[i + 1] - fragment_begin[i]);
  }
};

/// Calls visit(QuadFragment) for each pixel in which the quad shows an unmasked texel.
/// mask  may have no holes
template <class Visit>
void rasterise_leaf(const ProjectedQuad& quad, const Card& card, const AlphaMask& mask, std::int32_t resolution_px, Visit&& visit) {
  if (mask.hole.empty()) {
    rasterise_quad(
        quad, resolution_px, [](const auto&, auto, auto, auto) { return true; }, visit);
  } else {
    rasterise_quad(
        quad, resolution_px,
        [&](const RasterTriangle& triangle, std::uint32_t index, std::int32_t x, std::int32_t y) {
          return !mask.is_hole(card_uv(triangle, index, card, x, y));
        },
        visit);
  }
}

/// Checks the arguments of render_item_buffers. errors  those of render_item_buffers
Result<void> check_shown(const ShownFoliage& shown, const std::vector<Viewpoint>& views, std::uint32_t resolution_px);

/// Renders every leaf into every view, over bounding_sphere(shown.foliage). Parallel over views; the result does not depend on it.
/// errors  invalid_argument: no leaves, no views, resolution not in 1 .. kMaxResolutionPx, an index into cards, materials or images that
///         is out of range, a vertex that is not finite
Result<ItemBuffers> render_item_buffers(const ShownFoliage& shown, const std::vector<Viewpoint>& views, std::uint32_t resolution_px);

}  // namespace coppice::bake
