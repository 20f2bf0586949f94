#pragma once

#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "page_model.h"
#include "result.h"
#include "tree.h"

namespace coppice {

/// Nodes by id, stored a page at a time so that a page's memory can come and go on its own.
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

/// Which page the bytes are.
struct PageInfo {
  std::uint32_t version = COPPICE_FORMAT_VERSION;  ///< of the file: coppice_file_header::version
  std::uint32_t page = 0;
  std::uint32_t split_count = 0;                        ///< 1 to COPPICE_PAGE_SPLITS
  std::uint32_t card_count = 0;                         ///< of the plant
  std::uint32_t quantised_max = COPPICE_QUANTISED_MAX;  ///< of the plant; other than this not in version 1
};

/// Where a page is decoded to.
struct PageOutput {
  /// The last page's nodes are written, all fields; those of earlier pages and the root are read, their `split` not even that.
  NodePages nodes;
  /// [split_count] Of the splits whose parents are in earlier pages: the parents. Those in the page itself have PageNode::split set.
  std::span<SplitPatch> patches;
  /// [split_count] or empty: the splits as such, for tools.
  std::span<Split> splits;
};

/// Decodes a PAGE chunk (FORMAT.md) into the layout the GPU reads. Checks parents (earlier nodes, not replaced before in the page), slots
/// (four different), coordinates and cards (< card_count). Whether a parent in an earlier page is still alive is for the caller to check.
/// Any thread. No allocation, except for pages of version 1. On error the page's own nodes are garbage.
/// scratch  any value, before and after
/// returns  how many patches were written, in order of their splits
/// errors  bad_file: not what FORMAT.md describes; out_of_memory (version 1 only); invalid_argument: a span of the wrong length
Result<std::uint32_t> decode_page(std::span<const std::uint8_t> bytes, const PageInfo& info, const PageOutput& out, PageScratch& scratch);

}  // namespace coppice
