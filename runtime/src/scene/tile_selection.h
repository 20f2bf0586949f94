#pragma once

// Which tiles of a scene the views of a frame want. Pure functions of the scene's front. They go by sizes and not by where a view looks, so
// that what wind moves into a view is there.

#include <cstddef>
#include <cstdint>
#include <span>

#include "scene_reader.h"
#include "vectors.h"

namespace coppice {

/// A camera as tiles see it: it may look anywhere, so that turning the head loads nothing.
struct SceneEye {
  vec3 position_m{};
  float focal_px = 1.0f;  ///< half the image height times |clip_from_view[1][1]|
  float near_m = 0.1f;    ///< nearer counts as this near
  // Of a parallel view, whose sizes do not depend on distance: what is aside of its picture counts as smaller, the farther the smaller.
  bool parallel = false;
  vec3 toward_viewer{0, 0, 1};   ///< unit, against its rays
  float half_diagonal_m = 0.0f;  ///< of the picture
};

/// A tile, and the projected diameter of its largest plant if that stood at the tile's point nearest to the eye that sees it largest.
struct TileSize {
  std::uint32_t tile = 0;
  float size_px = 0.0f;
  bool kept = false;    ///< in: it is there, or on its way
  bool wanted = false;  ///< out of fit_tiles
};

/// Instances are kept in blocks of this many.
inline constexpr std::uint32_t kTileBlockInstances = 64;

inline std::uint32_t tile_blocks(const SceneTile& tile) {
  return (tile.entry.instance_count + kTileBlockInstances - 1) / kTileBlockInstances;
}

/// 0 without eyes
float tile_size_px(const SceneTile& tile, std::span<const SceneEye> eyes);

/// Every tile of at least floor_px to any of the eyes, in the file's order. Costs what is near enough, not what the scene has.
/// scratch, out  [tile count], any value. returns  how many are in `out`
std::size_t gather_tiles(const SceneFile& scene, std::span<const SceneEye> eyes, float floor_px, std::span<std::uint32_t> scratch,
                         std::span<TileSize> out);

/// Marks the largest tiles as wanted: all of least_px and more, if their blocks are no more than block_count; else those above a threshold
/// that rises in steps of a sixteenth of an octave, and of the step in which they stop to fit as many as still do, kept ones first.
/// tiles    from gather_tiles with floor_px <= least_px
/// scratch  [tiles], any value
/// returns  the threshold: the start of the last step that is wanted, in whole or in part
float fit_tiles(const SceneFile& scene, std::span<TileSize> tiles, float least_px, std::uint32_t block_count,
                std::span<std::uint32_t> scratch);

}  // namespace coppice
