#pragma once

// Prepares wind for shaders: a plant's field behind its table, and a frame's wind as numbers of a view. coppice_wind.h computes the motion.

#include <cstdint>
#include <span>

#include "coppice/coppice.h"
#include "coppice_wind.h"
#include "wind_field.h"

namespace coppice {

/// A wind with the values for lookups in its map.
struct PlacedWind {
  coppice_wind wind{};            ///< the map's data is read when a frame begins, and not afterwards
  dvec3 origin_m{0, 0, 0};        ///< the origin that the map's rectangle counts from
  float max_map_mps = 0.0f;       ///< highest speed in the map
  float reach_share = 0.0f;       ///< wind_reach_share of the plant that moves most
  std::uint64_t map_address = 0;  ///< WindNow::map; 0: there is no map
};

/// The winds of a frame, and of the frame before at coppice_wind.time_before_s.
struct FrameWind {
  PlacedWind now, before;
};

/// Maximum load anywhere, which limits how far plants move.
float max_wind_load(const PlacedWind& wind);

/// Maximum motion of a plant at full load, relative to its sphere's radius.
float wind_reach_share(const WindField& field, float sphere_radius_m);

/// Maximum speed of a map, [places][2]; rounded up.
float max_wind_mps(std::span<const float> map);

/// Number of words behind a plant's table: gpu::kWindNodes, and one for each node.
std::size_t wind_word_count(const WindField& field);
/// words: [wind_word_count]
void pack_wind(const WindField& field, std::span<std::uint32_t> words);

/// wind: within coppice_wind's ranges. eye_m: from the world's first origin; places in shaders are relative to it
gpu::WindNow wind_now(const PlacedWind& wind, const dvec3& eye_m);

/// Computes the same for hosts. gusts: out, except for its size
void set_gusts(const PlacedWind& wind, const dvec3& place_m, coppice_gusts& gusts);

}  // namespace coppice
