#pragma once

// Chooses the tiles of a scene for the views of a frame. Pure functions of the scene's front. They use sizes and not directions, so that
// plants that wind moves into a view are loaded.

#include <cstddef>
#include <cstdint>
#include <span>

#include "scene_reader.h"
#include "vectors.h"

namespace coppice {

/// A camera for the choice of tiles. It may look anywhere, so turning the head loads nothing.
struct SceneEye {
  vec3 position_m{};
  float focal_px = 1.0f;  ///< half the image height times |clip_from_view[1][1]|
  float near_m = 0.1f;    ///< smaller distances count as this
  // For a parallel view, whose sizes do not depend on distance: plants beside its picture count as smaller, in proportion to their distance
  // from it.
  bool parallel = false;
  vec3 toward_viewer{0, 0, 1};   ///< unit, against the view's rays
  float half_diagonal_m = 0.0f;  ///< half the diagonal of the picture
};

/// A tile, and the projected diameter of its largest plant, as if that stood at the tile's nearest point to the eye that sees it largest.
struct TileSize {
  std::uint32_t tile = 0;
  float size_px = 0.0f;
  bool kept = false;    ///< in: it is resident or being loaded
  bool wanted = false;  ///< out of fit_tiles: it is in demand
};

/// Instances are kept in blocks of this many.
inline constexpr std::uint32_t kTileBlockInstances = 64;

inline std::uint32_t tile_blocks(const SceneTile& tile) {
  return (tile.entry.instance_count + kTileBlockInstances - 1) / kTileBlockInstances;
}

/// Returns 0 without eyes.
float tile_size_px(const SceneTile& tile, std::span<const SceneEye> eyes);

/// Gathers every tile of at least floor_px for any eye, in the file's order. The cost depends on the number of near tiles, not on the
/// scene's size.
/// scratch, out  [tile count], any value. returns  the number of tiles in `out`
std::size_t gather_tiles(const SceneFile& scene, std::span<const SceneEye> eyes, float floor_px, std::span<std::uint32_t> scratch,
                         std::span<TileSize> out);

/// Marks the largest tiles as wanted. If all tiles of at least min_px have at most block_count blocks together, it marks those. Otherwise
/// it marks tiles above a threshold that rises in steps of a sixteenth of an octave, and as many tiles of the next lower step as still fit,
/// kept ones first.
/// tiles    from gather_tiles with floor_px <= min_px
/// scratch  [tiles], any value
/// returns  the threshold: the start of the last step that is wanted, entirely or in part
float fit_tiles(const SceneFile& scene, std::span<TileSize> tiles, float min_px, std::uint32_t block_count,
                std::span<std::uint32_t> scratch);

}  // namespace coppice
