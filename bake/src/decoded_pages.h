#pragma once

// Pages decoded one after another outside the streamer: tools and tests.

#include <cstdint>
#include <span>
#include <vector>

#include "page_codec.h"

namespace coppice::bake {

class DecodedPages {
 public:
  explicit DecodedPages(const PageNode& root, std::uint32_t quantised_max = COPPICE_QUANTISED_MAX)
      : root_(root), quantised_max_(quantised_max) {}

  /// Decodes the next page. errors  those of decode_page
  Result<std::vector<Split>> add(std::span<const std::uint8_t> bytes, std::uint32_t split_count, std::uint32_t card_count,
                                 std::uint32_t version = COPPICE_FORMAT_VERSION) {
    pages_.emplace_back(2 * std::size_t{split_count});
    places_.push_back(pages_.back().data());
    std::vector<SplitPatch> patches(split_count);
    std::vector<Split> splits(split_count);
    const auto page = static_cast<std::uint32_t>(pages_.size() - 1);
    COPPICE_TRY(patch_count, decode_page(bytes, {version, page, split_count, card_count, quantised_max_},
                                         {{&root_, places_}, patches, splits}, scratch_));
    patch_count_ = patch_count;
    return splits;
  }

  /// All nodes by id, the root first. Splits of parents in earlier pages are not marked.
  [[nodiscard]] std::vector<PageNode> nodes() const {
    std::vector<PageNode> all = {root_};
    for (const std::vector<PageNode>& page : pages_) all.insert(all.end(), page.begin(), page.end());
    return all;
  }

  /// Patches of the last page.
  [[nodiscard]] std::uint32_t patch_count() const { return patch_count_; }

 private:
  PageNode root_;
  std::uint32_t quantised_max_;
  std::vector<std::vector<PageNode>> pages_;
  std::vector<PageNode*> places_;
  PageScratch scratch_{};
  std::uint32_t patch_count_ = 0;
};

}  // namespace coppice::bake
