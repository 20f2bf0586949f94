#pragma once

// Writes .forest files: sorts plants into an additive quadtree of tiles. See runtime/src/scene/SCENE.md.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "result.h"
#include "scene_reader.h"

namespace coppice::bake {

/// One plant of a scene, 24 bytes: ten million are 240 MB.
struct ScenePlant {
  std::array<float, 3> position_m{};
  float scale = 1.0f;
  std::uint16_t species = 0;
  std::uint16_t tint = kNoTint;  ///< as in coppice_scene_instance
  std::uint16_t yaw = 0;         ///< 65536ths of a turn round +Y
  bool mirrored = false;         ///< swaps left and right before it is turned

  static constexpr std::uint16_t kNoTint = 16 | 32 << 5 | 16 << 11;
};

/// Packs linear factors, 0 to about 1.95; larger ones are clamped.
std::uint16_t pack_tint(const std::array<float, 3>& rgb);

struct SceneStatistics {
  std::uint64_t plant_count = 0;
  std::uint32_t tile_count = 0;
  std::uint32_t level_count = 0;
  std::uint64_t file_bytes = 0;
};

/// Writes the bytes of a scene. The same plants, in any order, give the same bytes.
/// species   paths relative to where the scene will be
/// plants    not empty; reordered. Takes another 12 bytes a plant and 56 a tile
/// progress  receives the share that is done, 0..1, now and then; may be empty
/// errors  invalid_argument: a plant's species, scale or position is out of range; too many plants in one place; no plant; more than
///         COPPICE_MAX_SCENE_TILES tiles
Result<std::vector<std::uint8_t>> encode_scene(std::span<const SceneSpecies> species, std::span<ScenePlant> plants,
                                               SceneStatistics* statistics = nullptr, const std::function<void(float)>& progress = {});

}  // namespace coppice::bake
