#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "coppice/format.h"
#include "page_model.h"
#include "result.h"
#include "tree.h"

namespace coppice::bake {

/// The shapes that enough of the quads have for a page to name them: the parallelogram, then up to three others, the most common first. A
/// shape is the place of corner 3 relative to the other three, so leaves of one model share it however they are placed.
std::vector<page_model::Shape> common_shapes(std::span<const QuantisedQuad> quads);

struct PageSource {
  std::span<const Split> splits;    ///< the page's; parents are earlier nodes, slots four different ones (asserted)
  std::uint32_t first_split = 0;    ///< index of splits[0]
  std::span<const PageNode> nodes;  ///< [>= 2 * (first_split + splits.size()) + 1] by id: all fields, but by_death, of the children and
                                    ///< their parents
  glm::vec3 box_extent{1.0f};       ///< the leaf box's, m: it says what is square in the plant
  std::uint32_t quantised_max = COPPICE_QUANTISED_MAX;  ///< the plant's
};

/// Encodes a PAGE chunk. decode_page returns exactly `splits`. Same arguments, same bytes.
/// errors  invalid_argument: over COPPICE_MAX_PAGE_BYTES
Result<std::vector<std::uint8_t>> encode_page(const PageSource& source);

}  // namespace coppice::bake
