#pragma once

#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "decoder_pool.h"
#include "page_model.h"
#include "result.h"
#include "tree.h"

namespace coppice {

/// Nodes by id, stored in one array a page, so that each page's memory can be freed alone.
struct NodePages {
  const PageNode* root = nullptr;
  /// [pages up to and including the one to decode] page k: nodes 2 * COPPICE_PAGE_SPLITS * k + 1 onwards, two for each of its splits
  std::span<PageNode* const> pages;

  const PageNode& operator[](std::uint32_t node) const { return node == 0 ? *root : at(node); }
  /// node > 0
  [[nodiscard]] PageNode& at(std::uint32_t node) const {
    return pages[(node - 1) / (2 * COPPICE_PAGE_SPLITS)][(node - 1) % (2 * COPPICE_PAGE_SPLITS)];
  }
};

/// Says which page the bytes are.
struct PageInfo {
  std::uint32_t page = 0;
  std::uint32_t leaf_count = 0;                         ///< the plant's
  std::uint32_t card_count = 0;                         ///< the plant's
  std::uint32_t quantised_max = COPPICE_QUANTISED_MAX;  ///< the plant's
};

/// Destination of a decoded page.
struct PageOutput {
  /// All fields of the page's nodes are written; nodes of earlier pages and the root are read.
  NodePages nodes;
  /// [splits of the page], or empty. Tools read the splits themselves.
  std::span<Split> splits;
};

/// Makes node 0, which is in no page.
PageNode root_node(const coppice_file_plant& plant);

/// Decodes a PAGE chunk (FORMAT.md) into the layout the GPU reads. Checks that each split replaces one node, and checks slots (four
/// different), coordinates and cards (< card_count). Any thread. Allocates a set of decoders if the pool has none free, else nothing. On
/// error the page's own nodes are undefined.
/// scratch  any value, before and after
/// errors  bad_file: not what FORMAT.md describes; out_of_memory: for decoders; invalid_argument: a span of the wrong length
Result<void> decode_page(std::span<const std::uint8_t> bytes, const PageInfo& info, const PageOutput& out, PageScratch& scratch,
                         DecoderPool& decoders);

}  // namespace coppice
