#pragma once

#include <cstdint>
#include <span>

#include "result.h"
#include "tree.h"

namespace coppice {

/// Splits [first_split, first_split + out.size()) from a PAGE chunk's bytes. New vertices are stored relative to the parent's quad, so
/// the quads of all earlier nodes are needed; the page's own are added to them. Checks parents (<= 2s), slots (four different),
/// coordinates and cards (< card_count). Whether a parent is alive depends on earlier pages and is not checked here. Any thread.
/// quads  [2 * (first_split + out.size()) + 1] by node id. In: nodes 0 .. 2 * first_split. Out: the rest. On error the rest is garbage.
/// out    [split count of the page], at most COPPICE_PAGE_SPLITS
/// errors  bad_file: not the Draco point cloud FORMAT.md describes; out_of_memory; invalid_argument: a span of the wrong length
Result<void> decode_page(std::span<const std::uint8_t> bytes, std::uint32_t first_split, std::uint32_t card_count,
                         std::span<QuantisedQuad> quads, std::span<Split> out);

}  // namespace coppice
