#pragma once

// Wind as shaders take it: a plant's field behind its table, and a frame's as numbers of a view. The motion itself is coppice_wind.h's.

#include <cstdint>
#include <span>

#include "coppice/coppice.h"
#include "coppice_wind.h"
#include "wind_field.h"

namespace coppice {

/// A frame's, and that of the frame before at coppice_wind.time_before_s.
struct FrameWind {
  coppice_wind now{}, before{};
};

/// Words behind a plant's table: gpu::kWindNodes, and one for each node.
std::size_t wind_word_count(const WindField& field);
/// words: [wind_word_count]
void pack_wind(const WindField& field, std::span<std::uint32_t> words);

/// wind: within its ranges. eye_m: from the world's first origin, what the places count from that shaders ask for
gpu::WindNow wind_now(const coppice_wind& wind, const dvec3& eye_m);

}  // namespace coppice
