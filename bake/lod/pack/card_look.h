#pragma once

// What a card shows from afar in place of its texture: a mean colour, and an outline of 8 x 8 cells.

#include <cstdint>
#include <span>
#include <vector>

#include "card_shown.h"
#include "coppice/format.h"

namespace coppice::bake {

/// Fills in albedo and mask of a card whose material and uv are set.
/// material  the card's
/// textures  [texture] TEXTURE chunks
/// shown     how much each eighth counts in the mean colour
void set_card_look(const coppice_file_material& material, std::span<const std::vector<std::uint8_t>> textures, const ShownShares& shown,
                   coppice_file_card& card);

}  // namespace coppice::bake
