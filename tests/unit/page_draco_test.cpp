// Pages of version 1, which nothing writes any more.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "decoded_pages.h"
#include "page_draco_layout.h"
#include "reader.h"

namespace coppice {
namespace {

TEST(SlotRank, EveryRankIsAnotherOrderOfFourSlots) {
  std::set<std::array<std::uint8_t, 4>> seen;
  for (std::uint32_t set = 0; set < 70; ++set)
    for (std::uint32_t order = 0; order < 24; ++order) {
      const auto slots = page_draco_layout::slots_of_rank(set, order);
      for (std::uint8_t slot : slots) ASSERT_LT(slot, 8);
      ASSERT_EQ(std::set<std::uint8_t>(slots.begin(), slots.end()).size(), 4u);
      ASSERT_TRUE(seen.insert(slots).second);
    }
}

TEST(SlotRank, CountsFromTheFirstFour) {
  EXPECT_EQ(page_draco_layout::slots_of_rank(0, 0), (std::array<std::uint8_t, 4>{0, 1, 2, 3}));
  EXPECT_EQ(page_draco_layout::slots_of_rank(69, 23), (std::array<std::uint8_t, 4>{7, 6, 5, 4}));
}

TEST(PredictCorner, CompletesAParallelogram) {
  page_draco_layout::Slots slots;
  slots.set(4, {100, 100, 100});
  slots.set(5, {200, 100, 100});
  slots.set(6, {250, 180, 90});
  EXPECT_EQ(page_draco_layout::predict_corner(slots, 7), (QuantisedPoint{150, 180, 90}));
}

TEST(PredictCorner, FallsBackStepByStep) {
  page_draco_layout::Slots slots;
  slots.set(0, {400, 800, 0});
  EXPECT_EQ(page_draco_layout::predict_corner(slots, 4), (QuantisedPoint{400, 800, 0}));  // nothing of the child: the centre
  EXPECT_EQ(page_draco_layout::predict_corner(slots, 2), (QuantisedPoint{400, 800, 0}));  // the corner across
  slots.set(5, {0, 0, 100});
  EXPECT_EQ(page_draco_layout::predict_corner(slots, 1), (QuantisedPoint{350, 700, 12}));  // a quarter towards (200, 400, 50)
  slots.set(7, {100, 0, 101});
  EXPECT_EQ(page_draco_layout::predict_corner(slots, 4), (QuantisedPoint{50, 0, 100}));  // both neighbours: the middle
}

TEST(PredictCorner, StaysInTheBox) {
  page_draco_layout::Slots slots;
  slots.set(0, {0, 16383, 5});
  slots.set(1, {9000, 0, 5});
  slots.set(2, {0, 16383, 5});
  EXPECT_EQ(page_draco_layout::predict_corner(slots, 3), (QuantisedPoint{0, 16383, 5}));
}

/// A file of version 1 and its pages.
struct OldFile {
  std::vector<std::uint8_t> bytes;
  PlantFile front;
  PageNode root;

  [[nodiscard]] std::vector<std::uint8_t> page(std::uint32_t index) const {
    const coppice_file_chunk& chunk = *find_chunk(front, COPPICE_CHUNK_PAGE, index);
    const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(chunk.offset);
    return {first, first + static_cast<std::ptrdiff_t>(chunk.bytes)};
  }
};

OldFile old_file() {
  OldFile file;
  std::ifstream stream(std::filesystem::path(COPPICE_TEST_DATA) / "v1/two_pages.coppice", std::ios::binary);
  file.bytes.assign(std::istreambuf_iterator<char>(stream), {});
  file.front = *read_front(file.bytes, file.bytes.size());
  file.root.card = file.front.plant.root_card;
  for (std::size_t corner = 0; corner < 4; ++corner) std::copy_n(file.front.plant.root_quad[corner], 3, file.root.corners[corner].begin());
  return file;
}

/// Page 1 decoded from `bytes`.
Result<std::vector<Split>> second_page(const OldFile& file, std::span<const std::uint8_t> bytes) {
  const coppice_file_plant& plant = file.front.plant;
  bake::DecodedPages pages(file.root);
  COPPICE_CHECK(pages.add(file.page(0), page_split_count(plant, 0), plant.card_count, 1));
  return pages.add(bytes, page_split_count(plant, 1), plant.card_count, 1);
}

void expect_valid(const OldFile& file, const std::vector<Split>& splits) {
  for (std::size_t i = 0; i < splits.size(); ++i) {
    ASSERT_LE(splits[i].parent, 2 * (COPPICE_PAGE_SPLITS + i));
    ASSERT_EQ(std::set<std::uint8_t>(splits[i].parent_slots.begin(), splits[i].parent_slots.end()).size(), 4u);
    for (std::uint8_t card : splits[i].cards) ASSERT_LT(card, file.front.plant.card_count);
    for (const auto& vertex : splits[i].new_vertices)
      for (std::uint16_t coordinate : vertex) ASSERT_LE(coordinate, COPPICE_QUANTISED_MAX);
  }
}

TEST(OldPage, IsStillRead) {
  const OldFile file = old_file();
  ASSERT_EQ(file.front.header.version, 1u);
  const auto splits = second_page(file, file.page(1));
  ASSERT_TRUE(splits) << splits.error().message();
  expect_valid(file, *splits);
}

// The last attribute's bits have no length of their own: Draco reads zeros for those that are missing. check_chunk knows the length.
TEST(OldPage, TruncatedGivesAnErrorOrValidSplits) {
  const OldFile file = old_file();
  const auto page = file.page(1);
  std::size_t refused = 0;
  for (std::size_t length = 0; length < page.size(); ++length) {
    const std::vector<std::uint8_t> exact(page.data(), page.data() + length);
    const auto splits = second_page(file, exact);
    if (splits) expect_valid(file, *splits);
    refused += splits ? 0u : 1u;
  }
  EXPECT_GT(refused, page.size() * 9 / 10);
}

TEST(OldPage, AFlippedBitGivesAnErrorOrValidSplits) {
  const OldFile file = old_file();
  const auto page = file.page(1);
  for (std::size_t at = 0; at < page.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<std::uint8_t> bytes = page;
      bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1 << bit));
      if (const auto splits = second_page(file, bytes)) expect_valid(file, *splits);
    }
}

TEST(OldPage, RefusesTrailingBytes) {
  const OldFile file = old_file();
  auto page = file.page(1);
  page.push_back(0);
  const auto splits = second_page(file, page);
  ASSERT_FALSE(splits);
  EXPECT_STREQ(splits.error().what, "page length");
}

}  // namespace
}  // namespace coppice
