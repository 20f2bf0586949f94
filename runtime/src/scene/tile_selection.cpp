#include "tile_selection.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace coppice {
namespace {

/// Distance of a point from an interval.
float gap(float at, float low, float high) {
  return std::max({low - at, at - high, 0.0f});
}

float size_px(float radius_m, float distance_m, const SceneEye& eye) {
  return 2.0f * radius_m * eye.focal_px / std::max(distance_m, eye.near_m);
}

/// The distance of a box from the eye that sizes use.
float distance_m(const vec3& low, const vec3& high, const SceneEye& eye) {
  if (!eye.parallel) return length(max(max(low - eye.position_m, eye.position_m - high), vec3(0.0f)));
  const vec3 off = 0.5f * (low + high) - eye.position_m;
  const float aside_m = length(off - dot(off, eye.toward_viewer) * eye.toward_viewer) - 0.5f * distance(low, high) - eye.half_diagonal_m;
  return 1.0f + std::max(aside_m, 0.0f) / eye.half_diagonal_m;
}

/// Maximum size in the tile and below it: its descendants stand in its square and have no larger plants.
float max_size_px(const SceneTile& tile, const SceneEye& eye) {
  // The square at any height.
  if (eye.parallel) return size_px(tile.entry.max_radius, 1.0f, eye);
  const float x = gap(eye.position_m.x, tile.square_min_m[0], tile.square_min_m[0] + tile.square_side_m);
  const float z = gap(eye.position_m.z, tile.square_min_m[1], tile.square_min_m[1] + tile.square_side_m);
  return size_px(tile.entry.max_radius, std::sqrt(x * x + z * z), eye);
}

// Sizes are binned by the upper bits of a float: exponent and four bits of the mantissa.
constexpr std::uint32_t kStepBits = 4, kMantissaBits = 23, kShift = kMantissaBits - kStepBits;
constexpr std::uint32_t kBinCount = 64u << kStepBits;  // 64 octaves
constexpr std::uint32_t kFirstBin = (127u - 32u) << kStepBits;

std::uint32_t bin_of(float px) {
  const std::uint32_t bin = std::bit_cast<std::uint32_t>(px) >> kShift;
  return std::clamp(bin, kFirstBin, kFirstBin + kBinCount - 1) - kFirstBin;
}
float bin_start_px(std::uint32_t bin) {
  return std::bit_cast<float>((bin + kFirstBin) << kShift);
}

}  // namespace

float tile_size_px(const SceneTile& tile, std::span<const SceneEye> eyes) {
  const vec3 low(tile.entry.box_min), high(tile.entry.box_max);
  float largest_px = 0.0f;
  for (const SceneEye& eye : eyes) largest_px = std::max(largest_px, size_px(tile.entry.max_radius, distance_m(low, high, eye), eye));
  return largest_px;
}

std::size_t gather_tiles(const SceneFile& scene, std::span<const SceneEye> eyes, float floor_px, std::span<std::uint32_t> scratch,
                         std::span<TileSize> out) {
  std::size_t found = 0, visit_count = 1;
  // Breadth first, as the tiles are: scratch holds tiles whose parents may have large enough children.
  scratch[0] = 0;
  for (std::size_t i = 0; i < visit_count; ++i) {
    const SceneTile& tile = scene.tiles[scratch[i]];
    if (std::ranges::none_of(eyes, [&](const SceneEye& eye) { return max_size_px(tile, eye) >= floor_px; })) continue;
    const float size = tile_size_px(tile, eyes);
    if (size >= floor_px) out[found++] = {.tile = scratch[i], .size_px = size};
    const auto child_count = static_cast<std::uint32_t>(std::popcount(tile.entry.child_mask));
    for (std::uint32_t child = 0; child < child_count; ++child) scratch[visit_count++] = tile.entry.first_child + child;
  }
  return found;
}

float fit_tiles(const SceneFile& scene, std::span<TileSize> tiles, float min_px, std::uint32_t block_count,
                std::span<std::uint32_t> scratch) {
  std::array<std::uint32_t, kBinCount> blocks{};
  for (const TileSize& tile : tiles)
    if (tile.size_px >= min_px) blocks[bin_of(tile.size_px)] += tile_blocks(scene.tiles[tile.tile]);
  std::uint32_t room = block_count;
  std::uint32_t bin = kBinCount;
  while (bin > 0 && blocks[bin - 1] <= room) room -= blocks[--bin];
  for (TileSize& tile : tiles) tile.wanted = tile.size_px >= min_px && bin_of(tile.size_px) >= bin;
  if (bin == 0) return min_px;
  // The step that fits in part. If the eye is in many tiles at once, they all have the same size.
  const std::uint32_t last = bin - 1;
  std::size_t partial_count = 0;
  for (std::uint32_t i = 0; i < tiles.size(); ++i)
    if (tiles[i].size_px >= min_px && bin_of(tiles[i].size_px) == last) scratch[partial_count++] = i;
  const std::span<std::uint32_t> partial = scratch.first(partial_count);
  std::ranges::sort(partial, [&](std::uint32_t i, std::uint32_t j) {
    const TileSize &a = tiles[i], &b = tiles[j];
    if (a.kept != b.kept) return a.kept;
    return a.size_px != b.size_px ? a.size_px > b.size_px : a.tile < b.tile;
  });
  for (const std::uint32_t i : partial) {
    const std::uint32_t needed = tile_blocks(scene.tiles[tiles[i].tile]);
    tiles[i].wanted = needed <= room;
    if (tiles[i].wanted) room -= needed;
  }
  return std::max(min_px, bin_start_px(last));
}

}  // namespace coppice
