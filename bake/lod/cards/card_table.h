#pragma once

#include <cstdint>
#include <vector>

#include "plant.h"

namespace coppice::bake {

/// A small table of cards that many leaves share.
struct SharedCards {
  std::vector<Card> table;             ///< at most COPPICE_MAX_CARDS
  std::vector<std::uint32_t> card_of;  ///< [leaf_count] index into table
};

/// Shares equal cards. If a material has an image, uvs are rounded to 1/4096 and moved by whole numbers so that their mean lies in [0, 1),
/// since textures repeat. A material without an image has one card, the unit square. If there are more than COPPICE_MAX_CARDS distinct
/// cards, the table takes the first card of each material and then, one by one, the card farthest from its nearest in the table (the first
/// wins a tie); every other leaf shows the nearest card of its material.
SharedCards share_cards(const std::vector<Card>& cards, const std::vector<Material>& materials);

}  // namespace coppice::bake
