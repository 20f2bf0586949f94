#include "page_codec.h"

#include <gtest/gtest.h>

#include <set>

#include "page_encode.h"
#include "page_layout.h"
#include "quantised_tree.h"
#include "random_tree.h"

namespace coppice {
namespace {

using bake::QuantisedTree;

QuantisedTree quantised(std::uint32_t leaf_count, std::uint32_t seed = 1) {
  return *bake::quantise_tree(test::random_tree(test::random_foliage(leaf_count, seed), seed));
}

std::uint32_t splits_in_page(const QuantisedTree& tree, std::uint32_t page) {
  return std::min(COPPICE_PAGE_SPLITS, static_cast<std::uint32_t>(tree.splits.size()) - page * COPPICE_PAGE_SPLITS);
}

std::vector<std::uint8_t> encoded(const QuantisedTree& tree, std::uint32_t page) {
  const std::uint32_t first = page * COPPICE_PAGE_SPLITS;
  return *bake::encode_page(std::span(tree.splits).subspan(first, splits_in_page(tree, page)), first, tree.quads);
}

struct DecodedPage {
  std::vector<QuantisedQuad> quads;
  std::vector<Split> splits;
};

Result<DecodedPage> decoded(const QuantisedTree& tree, std::uint32_t page, std::span<const std::uint8_t> bytes,
                            std::uint32_t card_count = 2) {
  const std::uint32_t first = page * COPPICE_PAGE_SPLITS, count = splits_in_page(tree, page);
  DecodedPage result{{tree.quads.begin(), tree.quads.begin() + 2 * first + 1}, std::vector<Split>(count)};
  result.quads.resize(2 * (first + count) + 1);
  COPPICE_CHECK(decode_page(bytes, first, card_count, result.quads, result.splits));
  return result;
}

void expect_equal(const Split& a, const Split& b) {
  EXPECT_EQ(a.parent, b.parent);
  EXPECT_EQ(a.parent_slots, b.parent_slots);
  EXPECT_EQ(a.new_vertices, b.new_vertices);
  EXPECT_EQ(a.cards, b.cards);
}

TEST(SlotRank, IsABijection) {
  std::set<std::array<std::uint8_t, 4>> seen;
  for (std::uint32_t set = 0; set < 70; ++set)
    for (std::uint32_t order = 0; order < 24; ++order) {
      const auto slots = page_layout::slots_of_rank({set, order});
      for (std::uint8_t slot : slots) ASSERT_LT(slot, 8);
      ASSERT_EQ(std::set<std::uint8_t>(slots.begin(), slots.end()).size(), 4u);
      ASSERT_TRUE(seen.insert(slots).second);
      const auto rank = page_layout::rank_of_slots(slots);
      ASSERT_EQ(rank.set, set);
      ASSERT_EQ(rank.order, order);
    }
}

TEST(SlotRank, CountsFromTheFirstFour) {
  EXPECT_EQ(page_layout::rank_of_slots({0, 1, 2, 3}).set, 0u);
  EXPECT_EQ(page_layout::rank_of_slots({0, 1, 2, 3}).order, 0u);
  EXPECT_EQ(page_layout::rank_of_slots({7, 6, 5, 4}).set, 69u);
  EXPECT_EQ(page_layout::rank_of_slots({7, 6, 5, 4}).order, 23u);
}

TEST(PredictCorner, CompletesAParallelogram) {
  page_layout::Slots slots;
  slots.set(4, {100, 100, 100});
  slots.set(5, {200, 100, 100});
  slots.set(6, {250, 180, 90});
  EXPECT_EQ(page_layout::predict_corner(slots, 7), (QuantisedPoint{150, 180, 90}));
}

TEST(PredictCorner, FallsBackStepByStep) {
  page_layout::Slots slots;
  slots.set(0, {400, 800, 0});
  EXPECT_EQ(page_layout::predict_corner(slots, 4), (QuantisedPoint{400, 800, 0}));  // nothing of the child: the centre
  EXPECT_EQ(page_layout::predict_corner(slots, 2), (QuantisedPoint{400, 800, 0}));  // the corner across
  slots.set(5, {0, 0, 100});
  EXPECT_EQ(page_layout::predict_corner(slots, 1), (QuantisedPoint{350, 700, 12}));  // a neighbour, a quarter towards (200, 400, 50)
  slots.set(7, {100, 0, 101});
  EXPECT_EQ(page_layout::predict_corner(slots, 4), (QuantisedPoint{50, 0, 100}));  // both neighbours: the middle
}

TEST(PredictCorner, StaysInTheBox) {
  page_layout::Slots slots;
  slots.set(0, {0, 16383, 5});
  slots.set(1, {9000, 0, 5});
  slots.set(2, {0, 16383, 5});
  EXPECT_EQ(page_layout::predict_corner(slots, 3), (QuantisedPoint{0, 16383, 5}));
}

TEST(PageCodec, GivesBackEverySplitAndQuad) {
  for (std::uint32_t leaf_count : {2u, 3u, 10u, 513u, 514u, 1500u}) {
    const QuantisedTree tree = quantised(leaf_count);
    for (std::uint32_t page = 0; page * COPPICE_PAGE_SPLITS < tree.splits.size(); ++page) {
      const auto result = decoded(tree, page, encoded(tree, page));
      ASSERT_TRUE(result) << leaf_count << " leaves, page " << page << ": " << result.error().message();
      for (std::size_t i = 0; i < result->splits.size(); ++i) expect_equal(result->splits[i], tree.splits[page * COPPICE_PAGE_SPLITS + i]);
      EXPECT_TRUE(std::equal(result->quads.begin(), result->quads.end(), tree.quads.begin()));
    }
  }
}

TEST(PageCodec, SameSplitsSameBytes) {
  const QuantisedTree tree = quantised(300);
  EXPECT_EQ(encoded(tree, 0), encoded(tree, 0));
}

void expect_valid(const DecodedPage& page) {
  for (std::size_t i = 0; i < page.splits.size(); ++i) {
    const Split& split = page.splits[i];
    ASSERT_LE(split.parent, 2 * i);
    ASSERT_EQ(std::set<std::uint8_t>(split.parent_slots.begin(), split.parent_slots.end()).size(), 4u);
    for (std::uint8_t card : split.cards) ASSERT_LT(card, 2);
    for (const auto& vertex : split.new_vertices)
      for (std::uint16_t coordinate : vertex) ASSERT_LE(coordinate, COPPICE_QUANTISED_MAX);
  }
}

// The last attribute's bits have no length of their own: Draco reads zeros for those that are missing. check_chunk knows the length.
TEST(PageCodec, ATruncatedPageGivesAnErrorOrValidSplits) {
  const QuantisedTree tree = quantised(40);
  const auto page = encoded(tree, 0);
  std::size_t refused = 0;
  for (std::size_t length = 0; length < page.size(); ++length) {
    const std::vector<std::uint8_t> exact(page.data(), page.data() + length);
    const auto result = decoded(tree, 0, exact);
    if (result) expect_valid(*result);
    refused += result ? 0u : 1u;
  }
  EXPECT_GT(refused, page.size() * 9 / 10);
}

TEST(PageCodec, RefusesTrailingBytes) {
  const QuantisedTree tree = quantised(40);
  auto page = encoded(tree, 0);
  page.push_back(0);
  const auto result = decoded(tree, 0, page);
  ASSERT_FALSE(result);
  EXPECT_STREQ(result.error().what, "page length");
}

TEST(PageCodec, AFlippedBitGivesAnErrorOrValidSplits) {
  const QuantisedTree tree = quantised(40);
  const auto page = encoded(tree, 0);
  for (std::size_t at = 0; at < page.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<std::uint8_t> bytes(page.begin(), page.end());
      bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1 << bit));
      if (const auto result = decoded(tree, 0, bytes)) expect_valid(*result);
    }
}

TEST(PageCodec, RefusesTheWrongSplitCount) {
  const QuantisedTree tree = quantised(40);
  const auto page = encoded(tree, 0);
  std::vector<QuantisedQuad> quads(2 * 38 + 1);
  std::vector<Split> splits(38);
  const auto result = decode_page(page, 0, 2, quads, splits);
  ASSERT_FALSE(result);
  EXPECT_STREQ(result.error().what, "page Draco header");
}

TEST(PageCodec, RefusesACardThatIsNotThere) {
  const QuantisedTree tree = quantised(40);
  const auto result = decoded(tree, 0, encoded(tree, 0), 1);
  ASSERT_FALSE(result);
  EXPECT_STREQ(result.error().what, "page card");
}

TEST(PageCodec, AsksForMatchingSpans) {
  const QuantisedTree tree = quantised(40);
  std::vector<QuantisedQuad> quads(tree.quads.size() - 1);
  std::vector<Split> splits(39);
  const auto result = decode_page(encoded(tree, 0), 0, 2, quads, splits);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().status, Status::invalid_argument);
}

}  // namespace
}  // namespace coppice
