#pragma once

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// How much of each eighth of a card, from its stalk's edge to the opposite one, is seen among all leaves: 0..1, where nothing hides it 1.
using ShownShares = std::array<float, 8>;
inline constexpr ShownShares kAllShown{1, 1, 1, 1, 1, 1, 1, 1};

/// [card] The stalk's end of a leaf is often darker than its tip, and hidden by others. One colour for the whole leaf is that of what is
/// seen. Parallel over views; the result does not depend on it.
/// plant   tree, card_table, materials, images and sphere are read
/// errors  invalid_argument: a material names an image that is not there
Result<std::vector<ShownShares>> shown_shares(const BakedPlant& plant);

}  // namespace coppice::bake
