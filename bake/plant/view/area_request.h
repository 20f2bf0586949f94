#pragma once

// What a collapse asks of a module that measures projected areas in another way than by item buffers.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>

#include "plant.h"
#include "raster.h"
#include "result.h"

namespace coppice::bake {

/// A rectangle of a view: columns [left, right), rows [top, bottom).
struct PixelBox {
  std::int32_t left = 0, top = 0, right = 0, bottom = 0;

  [[nodiscard]] bool empty() const { return right <= left || bottom <= top; }
  [[nodiscard]] bool meets(const PixelBox& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

/// A box of all pixels that a quad may cover, however a rasteriser rounds. It is empty for a quad beside the view.
[[nodiscard]] inline PixelBox pixel_box(const ProjectedQuad& quad, std::int32_t resolution_px) {
  constexpr std::int32_t kMarginPx = 1;
  const auto [left, right] = std::minmax({quad[0].x, quad[1].x, quad[2].x, quad[3].x});
  const auto [top, bottom] = std::minmax({quad[0].y, quad[1].y, quad[2].y, quad[3].y});
  const auto first = [&](std::int32_t subpixels) { return std::clamp(subpixels / kSubpixels - kMarginPx, 0, resolution_px); };
  const auto end = [&](std::int32_t subpixels) { return std::clamp(subpixels / kSubpixels + 1 + kMarginPx, 0, resolution_px); };
  return {first(left), first(top), end(right), end(bottom)};
}

/// The smallest box around two.
[[nodiscard]] inline PixelBox united(const PixelBox& a, const PixelBox& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right), std::max(a.bottom, b.bottom)};
}

struct AreaRequest {
  std::span<const Quad> quads;           ///< [leaf_count] all leaves that there are now
  std::span<const std::uint32_t> cards;  ///< [leaf_count] index into the foliage's card table
  std::span<const PixelBox> changed;  ///< [view_count] where a view differs from that in which `areas_px` was measured; empty: everywhere
};

/// Measures in how many pixels each leaf is seen. Called from one thread at a time.
/// areas_px  [(leaf_count + 1) * view_count] row per leaf, the background's last, px. Entries that no change can have touched stay.
using MeasureAreas = std::function<Result<void>(const AreaRequest& request, std::span<std::uint32_t> areas_px)>;

}  // namespace coppice::bake
