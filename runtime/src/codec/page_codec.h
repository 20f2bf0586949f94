#pragma once

#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "result.h"
#include "tree.h"

namespace coppice {

/// Quads by node id, stored a page at a time so that a page's memory can come and go on its own.
struct NodeQuads {
  QuantisedQuad* root = nullptr;
  /// [pages up to and including the one to decode] page k: nodes 2 * COPPICE_PAGE_SPLITS * k + 1 onwards, two for each of its splits
  std::span<QuantisedQuad* const> pages;

  QuantisedQuad& operator[](std::uint32_t node) const {
    if (node == 0) return *root;
    return pages[(node - 1) / (2 * COPPICE_PAGE_SPLITS)][(node - 1) % (2 * COPPICE_PAGE_SPLITS)];
  }
};

/// Splits [first_split, first_split + out.size()) from a PAGE chunk's bytes. New vertices are stored relative to the parent's quad, so
/// the quads of all earlier nodes are needed; the page's own are added to them. Checks parents (<= 2s), slots (four different),
/// coordinates and cards (< card_count). Whether a parent is alive depends on earlier pages and is not checked here. Any thread.
/// quads  [2 * (first_split + out.size()) + 1] by node id. In: nodes 0 .. 2 * first_split. Out: the rest. On error the rest is garbage.
/// out    [split count of the page], at most COPPICE_PAGE_SPLITS
/// errors  bad_file: not the Draco point cloud FORMAT.md describes; out_of_memory; invalid_argument: a span of the wrong length
Result<void> decode_page(std::span<const std::uint8_t> bytes, std::uint32_t first_split, std::uint32_t card_count,
                         std::span<QuantisedQuad> quads, std::span<Split> out);

/// The same on paged quads. first_split must be a page's first; the page's own quads must have room for two per split.
Result<void> decode_page(std::span<const std::uint8_t> bytes, std::uint32_t first_split, std::uint32_t card_count, const NodeQuads& quads,
                         std::span<Split> out);

}  // namespace coppice
