#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "coppice/format.h"
#include "result.h"
#include "tree.h"

namespace coppice::bake {

struct PageSource {
  std::span<const Split> splits;    ///< the page's; parents are earlier nodes, slots four different ones (asserted)
  std::uint32_t first_split = 0;    ///< index of splits[0]
  std::span<const PageNode> nodes;  ///< [>= 2 * (first_split + splits.size()) + 1] by id: the parents' corners, cards and fades, the
                                    ///< children's fades and next splits
  glm::vec3 box_extent{1.0f};       ///< the leaf box's, m: it says what is square in the plant
  std::uint32_t quantised_max = COPPICE_QUANTISED_MAX;  ///< the plant's
};

/// Encodes a PAGE chunk. decode_page returns exactly `splits`. Same arguments, same bytes.
/// errors  invalid_argument: over COPPICE_MAX_PAGE_BYTES
Result<std::vector<std::uint8_t>> encode_page(const PageSource& source);

}  // namespace coppice::bake
