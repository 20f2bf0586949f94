#pragma once

// Wind as shaders take it: a plant's field behind its table, and a frame's as numbers of a view. The motion itself is coppice_wind.h's.

#include <cstdint>
#include <span>

#include "coppice/coppice.h"
#include "coppice_wind.h"
#include "wind_field.h"

namespace coppice {

/// A wind with what its map needs to be looked up.
struct PlacedWind {
  coppice_wind wind{};            ///< the map itself is looked at when a frame begins, and by no one afterwards
  dvec3 origin_m{0, 0, 0};        ///< what the map's rectangle counts from
  float most_map_mps = 0.0f;      ///< the map's highest speed
  std::uint64_t map_address = 0;  ///< WindNow::map; 0: nothing is added
};

/// A frame's, and that of the frame before at coppice_wind.time_before_s.
struct FrameWind {
  PlacedWind now, before;
};

/// The load of what blows strongest anywhere; of how far plants can be moved.
float most_wind_load(const PlacedWind& wind);

/// The highest speed of a map, [places][2]; rounded up.
float most_wind_mps(std::span<const float> map);

/// Words behind a plant's table: gpu::kWindNodes, and one for each node.
std::size_t wind_word_count(const WindField& field);
/// words: [wind_word_count]
void pack_wind(const WindField& field, std::span<std::uint32_t> words);

/// wind: within coppice_wind's ranges. eye_m: from the world's first origin, what the places count from that shaders ask for
gpu::WindNow wind_now(const PlacedWind& wind, const dvec3& eye_m);

/// The same of what hosts are told. gusts: out, but for its size
void set_gusts(const PlacedWind& wind, const dvec3& place_m, coppice_gusts& gusts);

}  // namespace coppice
