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
  std::span<const Split> splits;    ///< of the page; parents are earlier nodes, slots four different ones (asserted)
  std::uint32_t first_split = 0;    ///< index of splits[0]
  std::span<const PageNode> nodes;  ///< [>= 2 * (first_split + splits.size()) + 1] by id: corners, cards and fades of the parents, fades of
                                    ///< the children and what replaces them
  glm::vec3 box_extent{1.0f};       ///< of the leaf box, m: what is square in the plant
  std::uint32_t quantised_max = COPPICE_QUANTISED_MAX;  ///< of the plant
};

/// A PAGE chunk: decode_page gives `splits` back exactly. Same arguments, same bytes.
/// errors  invalid_argument: over COPPICE_MAX_PAGE_BYTES
Result<std::vector<std::uint8_t>> encode_page(const PageSource& source);

}  // namespace coppice::bake
