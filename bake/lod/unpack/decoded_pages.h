#pragma once

// Decodes pages one after another outside the streamer, for tools and tests.

#include <cstdint>
#include <span>
#include <vector>

#include "page_codec.h"
#include "reader.h"

namespace coppice::bake {

class DecodedPages {
 public:
  /// root  the root node of a plant with so many leaves and cards
  DecodedPages(const PageNode& root, std::uint32_t leaf_count, std::uint32_t card_count,
               std::uint32_t quantised_max = COPPICE_QUANTISED_MAX)
      : root_(root), info_{0, leaf_count, card_count, quantised_max} {}

  /// Decodes the next page. errors  those of decode_page
  Result<std::vector<Split>> add(std::span<const std::uint8_t> bytes) {
    info_.page = static_cast<std::uint32_t>(pages_.size());
    std::vector<Split> splits(page_split_count(info_.leaf_count, info_.page));
    pages_.emplace_back(2 * splits.size());
    places_.push_back(pages_.back().data());
    COPPICE_CHECK(decode_page(bytes, info_, {{&root_, places_}, splits}, scratch_, decoders_));
    return splits;
  }

  /// All nodes by id, the root first.
  [[nodiscard]] std::vector<PageNode> nodes() const {
    std::vector<PageNode> all = {root_};
    for (const std::vector<PageNode>& page : pages_) all.insert(all.end(), page.begin(), page.end());
    return all;
  }

 private:
  PageNode root_;
  PageInfo info_;
  std::vector<std::vector<PageNode>> pages_;
  std::vector<PageNode*> places_;
  PageScratch scratch_{};
  DecoderPool decoders_;
};

}  // namespace coppice::bake
