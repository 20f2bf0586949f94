#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "visibility.h"

namespace coppice::bake {

/// Pixels in which each leaf is in front. returns [view_count * leaf_count], row per view, px.
inline std::vector<std::uint32_t> leaf_areas_px(const ItemBuffers& buffers) {
  std::vector<std::uint32_t> areas(std::size_t{buffers.view_count} * buffers.leaf_count);
  for (std::uint32_t view = 0; view < buffers.view_count; ++view) {
    for (std::uint32_t pixel = 0; pixel < buffers.pixels_per_view(); ++pixel) {
      const std::span<const LeafFragment> fragments = buffers.at(view, pixel);
      if (!fragments.empty()) ++areas[std::size_t{view} * buffers.leaf_count + fragment_leaf(fragments.front())];
    }
  }
  return areas;
}

/// Pixels that no leaf covers. returns [view_count], px.
inline std::vector<std::uint32_t> background_areas_px(const ItemBuffers& buffers) {
  std::vector<std::uint32_t> areas(buffers.view_count);
  for (std::uint32_t view = 0; view < buffers.view_count; ++view)
    for (std::uint32_t pixel = 0; pixel < buffers.pixels_per_view(); ++pixel) areas[view] += buffers.at(view, pixel).empty() ? 1u : 0u;
  return areas;
}

}  // namespace coppice::bake
