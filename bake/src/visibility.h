#pragma once

// What each viewpoint sees: item buffers, with all the leaves behind the front one kept (the paper's section on visibility).

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

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

/// The texel of a row or column that a texture coordinate falls on: nearest, wrapping (repeat). size  > 0
[[nodiscard]] inline std::uint32_t wrapped_texel(double coordinate, std::uint32_t size) {
  constexpr double kExact = 4503599627370496.0;  // 2^52: from there on every double is whole
  const bool is_whole = coordinate >= kExact || coordinate <= -kExact;
  const double wrapped = is_whole ? 0.0 : coordinate - static_cast<double>(detail::floor_to_int<std::int64_t>(coordinate));
  return std::min(static_cast<std::uint32_t>(wrapped * size), size - 1);
}

/// The holes of one material's image, nearest texel, wrapping (repeat). No image or alpha_cutoff 0: no holes.
struct AlphaMask {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> hole;  ///< [width * height] rows top to bottom, 1 where base_color.a * texel alpha < alpha_cutoff
  [[nodiscard]] bool is_hole(const glm::dvec2& uv) const {
    return !hole.empty() && hole[std::size_t{wrapped_texel(uv.y, height)} * width + wrapped_texel(uv.x, width)] != 0;
  }
};

/// One mask per material.
/// errors  invalid_argument: a material names an image that is not there, or whose rgba has the wrong size
Result<std::vector<AlphaMask>> alpha_masks(const std::vector<Material>& materials, const std::vector<Image>& images);

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

/// Renders every leaf into every view, over bounding_sphere(foliage). Parallel over views; the result does not depend on it.
/// errors  invalid_argument: no leaves, no views, resolution not in 1 .. kMaxResolutionPx, an index into cards, materials or images that
///         is out of range, a vertex that is not finite
Result<ItemBuffers> render_item_buffers(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                                        const std::vector<Viewpoint>& views, std::uint32_t resolution_px);

/// Pixels in which each leaf is in front. returns [view_count * leaf_count], row per view, px.
std::vector<std::uint32_t> leaf_areas_px(const ItemBuffers& buffers);

/// Pixels that no leaf covers. returns [view_count], px.
std::vector<std::uint32_t> background_areas_px(const ItemBuffers& buffers);

}  // namespace coppice::bake
