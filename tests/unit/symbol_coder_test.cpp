#include "symbol_coder.h"

#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <random>

#include "symbol_writer.h"

namespace coppice {
namespace {

TEST(SymbolWeight, FollowsTheTable) {
  const std::vector<std::uint32_t> expected = {0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192};
  for (std::uint32_t digit = 0; digit < kWeightDigits; ++digit) EXPECT_EQ(symbol_weight(digit), expected[digit]);
}

TEST(Zigzag, SmallStaysSmall) {
  EXPECT_EQ(zigzag(0), 0u);
  EXPECT_EQ(zigzag(-1), 1u);
  EXPECT_EQ(zigzag(1), 2u);
  for (std::int32_t value : {-16383, -5, 0, 7, 16383}) EXPECT_EQ(unzigzag(zigzag(value)), value);
}

TEST(ShareOut, KnownShares) {
  const std::vector<std::uint8_t> digits = {4, 0, 2};  // weights 4 0 2; 1 + 4 * 1022 / 6, 0, 1 + 2 * 1022 / 6; one left over
  std::vector<SymbolRange> ranges(3);
  share_out(digits, ranges);
  EXPECT_EQ(ranges[0].size, 683);
  EXPECT_EQ(ranges[1].size, 0);
  EXPECT_EQ(ranges[2].start, 683);
  EXPECT_EQ(ranges[2].size, 341);
}

TEST(ShareOut, CoversEverythingWithEverySymbolThatCounts) {
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    std::vector<std::uint8_t> digits;
    for (std::size_t i = random() % 256; i > 0; --i)
      digits.push_back(static_cast<std::uint8_t>(random() % 3 == 0 ? 0 : random() % kWeightDigits));
    digits.push_back(1);
    std::vector<SymbolRange> ranges(digits.size());
    share_out(digits, ranges);
    std::uint32_t at = 0;
    for (std::size_t i = 0; i < digits.size(); ++i) {
      EXPECT_EQ(ranges[i].start, at);
      EXPECT_EQ(ranges[i].size > 0, digits[i] > 0);
      at += ranges[i].size;
    }
    EXPECT_EQ(at, kProbabilityOne);
  }
}

TEST(WeightDigits, AreNearTheCounts) {
  EXPECT_EQ(bake::weight_digits(std::vector<std::uint32_t>{192, 0, 96, 1}), (std::vector<std::uint8_t>{15, 0, 13, 1}));
  EXPECT_EQ(bake::weight_digits(std::vector<std::uint32_t>{5}), (std::vector<std::uint8_t>{15}));
  EXPECT_EQ(bake::weight_digits(std::vector<std::uint32_t>{100000, 1}), (std::vector<std::uint8_t>{15, 1}));
}

/// Symbols of a skewed distribution, with their table.
struct Message {
  std::vector<SymbolRange> ranges;
  std::unique_ptr<SymbolTable> table = std::make_unique<SymbolTable>();
  std::vector<std::uint32_t> symbols;
  std::vector<std::uint16_t> words;
};

Message message(std::size_t length, unsigned alphabet) {
  Message result;
  std::vector<std::uint8_t> digits(alphabet);
  for (unsigned i = 0; i < alphabet; ++i) digits[i] = static_cast<std::uint8_t>(std::max(1, 15 - static_cast<int>(i)));
  result.ranges.resize(alphabet);
  share_out(digits, result.ranges);
  fill_symbol_table(result.ranges, *result.table);
  std::mt19937 random(7);
  std::vector<SymbolRange> of_symbols;
  for (std::size_t i = 0; i < length; ++i) {
    result.symbols.push_back(result.table->symbol_at[random() % kProbabilityOne]);
    of_symbols.push_back(result.ranges[result.symbols.back()]);
  }
  result.words = bake::write_symbols(of_symbols);
  return result;
}

TEST(Symbols, ComeBack) {
  for (std::size_t length : {0u, 1u, 2u, 3u, 1000u})
    for (unsigned alphabet : {1u, 2u, 16u, 200u}) {
      Message sent = message(length, alphabet);
      sent.words.push_back(0);  // readable bytes that are not part of it
      SymbolReader reader(reinterpret_cast<const std::uint8_t*>(sent.words.data()), sent.words.size() - 1);
      for (std::uint32_t symbol : sent.symbols) ASSERT_EQ(reader.next(*sent.table, sent.ranges.data()), symbol);
      EXPECT_TRUE(reader.finished());
    }
}

TEST(Symbols, TakeTheirEntropy) {
  const Message sent = message(20000, 16);
  std::vector<double> costs = bake::symbol_costs(sent.ranges);
  double bits = 0.0;
  for (std::uint32_t symbol : sent.symbols) bits += costs[symbol];
  EXPECT_NEAR(static_cast<double>(sent.words.size()) * 16.0, bits, 0.002 * bits + 64.0);
}

TEST(Symbols, ACutMessageIsNoticed) {
  const Message sent = message(300, 16);
  for (std::size_t count = 4; count < sent.words.size(); ++count) {
    const auto exact = std::make_unique<std::uint16_t[]>(count + 1);
    std::copy_n(sent.words.begin(), count, exact.get());
    SymbolReader reader(reinterpret_cast<const std::uint8_t*>(exact.get()), count);
    for (std::size_t i = 0; i < sent.symbols.size(); ++i) ASSERT_LT(reader.next(*sent.table, sent.ranges.data()), 16u);
    EXPECT_FALSE(reader.finished()) << count;
  }
}

TEST(PlainBits, ComeBack) {
  std::mt19937 random(3);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sent;
  bake::BitWriter writer;
  std::size_t used = 0;
  for (int i = 0; i < 500; ++i) {
    const auto count = static_cast<std::uint32_t>(random() % 28);
    sent.emplace_back(static_cast<std::uint32_t>(random()) & ((1u << count) - 1), count);
    writer.add(sent.back().first, count);
    used += count;
  }
  const auto bytes = writer.finish();
  EXPECT_EQ(bytes.size(), (used + 7) / 8);
  BitReader reader(bytes);
  for (const auto& [bits, count] : sent) ASSERT_EQ(reader.next(count), bits);
  EXPECT_EQ(reader.used(), used);
}

TEST(PlainBits, PastTheEndThereIsNoRead) {
  const auto exact = std::make_unique<std::uint8_t[]>(BitReader::kLeastBytes);
  BitReader reader({exact.get(), BitReader::kLeastBytes});
  for (int i = 0; i < 100; ++i) reader.next(45);
  EXPECT_EQ(reader.used(), 4500u);
}

}  // namespace
}  // namespace coppice
