#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "result.h"
#include "tree.h"

namespace coppice::bake {

/// A PAGE chunk: decode_page gives `splits` back exactly. Same arguments, same bytes.
/// splits       parents are earlier nodes, slots four different ones (asserted)
/// first_split  index of splits[0]
/// quads        [>= 2 * (first_split + splits.size()) + 1] by node id
/// errors  invalid_argument: over COPPICE_MAX_PAGE_BYTES; internal: Draco failed
Result<std::vector<std::uint8_t>> encode_page(std::span<const Split> splits, std::uint32_t first_split,
                                              std::span<const QuantisedQuad> quads);

}  // namespace coppice::bake
