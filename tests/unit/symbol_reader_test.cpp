#include "symbol_reader.h"

#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <random>

#include "symbol_writer.h"

namespace coppice::symbol_reader_test {

using Bytes = std::vector<std::uint8_t>;

std::vector<std::uint32_t> shared_out(const Bytes& digits) {
  std::vector<std::uint32_t> probabilities(digits.size());
  share_out(digits, probabilities);
  return probabilities;
}

TEST(ShareOut, GivesEverythingAwayAndToEverySymbolThatCounts) {
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    Bytes digits;
    for (std::size_t i = random() % 256; i > 0; --i)
      digits.push_back(static_cast<std::uint8_t>(random() % 3 == 0 ? 0 : random() % kWeightDigits));
    digits.push_back(1);
    const auto probabilities = shared_out(digits);
    for (std::size_t i = 0; i < digits.size(); ++i) EXPECT_EQ(probabilities[i] > 0, digits[i] > 0);
    EXPECT_EQ(std::accumulate(probabilities.begin(), probabilities.end(), 0u), kProbabilityOne);
    EXPECT_GT(probabilities[end_symbol(probabilities)], kEndShare);
  }
}

TEST(WeightDigits, AreNearTheCounts) {
  EXPECT_EQ(bake::weight_digits(std::vector<std::uint32_t>{192, 0, 96, 1}), (Bytes{15, 0, 13, 1}));
  EXPECT_EQ(bake::weight_digits(std::vector<std::uint32_t>{5}), (Bytes{15}));
  EXPECT_EQ(bake::weight_digits(std::vector<std::uint32_t>{100000, 1}), (Bytes{15, 1}));
}

/// Symbols of a skewed distribution, with their table.
struct Message {
  Bytes digits, symbols, block;
  std::vector<std::uint32_t> probabilities;

  [[nodiscard]] SymbolReader reader() const {
    SymbolReader reader(256);
    reader.set_table(digits);
    return reader;
  }
};

Message message(std::size_t length, unsigned alphabet, std::uint32_t seed = 7) {
  Message result;
  for (unsigned i = 0; i < alphabet; ++i) result.digits.push_back(static_cast<std::uint8_t>(std::max(1, 15 - static_cast<int>(i))));
  result.probabilities = shared_out(result.digits);
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < length; ++i) {
    std::uint32_t at = random() % kProbabilityOne;
    std::uint8_t symbol = 0;
    for (; at >= result.probabilities[symbol]; ++symbol) at -= result.probabilities[symbol];
    result.symbols.push_back(symbol);
  }
  result.block = bake::write_symbols(result.probabilities, result.symbols);
  return result;
}

/// In a heap block of exactly that size, for AddressSanitizer.
struct Exact {
  explicit Exact(std::span<const std::uint8_t> from) : bytes(std::make_unique<std::uint8_t[]>(from.size())), size(from.size()) {
    std::ranges::copy(from, bytes.get());
  }
  [[nodiscard]] std::span<const std::uint8_t> span() const { return {bytes.get(), size}; }
  std::unique_ptr<std::uint8_t[]> bytes;
  std::size_t size;
};

void expect_round_trip(const Message& sent) {
  SymbolReader reader = sent.reader();
  EXPECT_EQ(reader.only_one(), sent.digits.size() == 1);
  EXPECT_EQ(sent.block.empty(), sent.symbols.empty() || sent.digits.size() == 1);
  ASSERT_TRUE(reader.start(sent.block));
  for (std::uint8_t symbol : sent.symbols) ASSERT_EQ(reader.next(), symbol);
  EXPECT_TRUE(reader.finished()) << sent.symbols.size() << " of " << sent.digits.size();
}

TEST(Symbols, ComeBack) {
  for (std::size_t length : {0u, 1u, 2u, 3u, 1000u})
    for (unsigned alphabet : {1u, 2u, 16u, 200u, 256u})
      for (std::uint32_t seed = 0; seed < 20; ++seed) expect_round_trip(message(length, alphabet, seed));
  Message rarest = message(0, 256);
  rarest.symbols = {0, 255, 255};
  rarest.block = bake::write_symbols(rarest.probabilities, rarest.symbols);
  expect_round_trip(rarest);
}

TEST(Symbols, TakeTheirEntropy) {
  const Message sent = message(20000, 16);
  std::vector<double> costs = bake::symbol_costs(sent.probabilities);
  double bits = 0.0;
  for (std::uint8_t symbol : sent.symbols) bits += costs[symbol];
  EXPECT_NEAR(static_cast<double>(sent.block.size()) * 8.0, bits, 0.002 * bits + 32.0);
}

bool reads_to_the_end(const Message& sent, std::span<const std::uint8_t> block, std::size_t count) {
  const Exact exact(block);
  SymbolReader reader = sent.reader();
  if (!reader.start(exact.span())) return false;
  for (std::size_t i = 0; i < count; ++i)
    if (reader.next() >= sent.digits.size()) ADD_FAILURE() << "a symbol that is not in the table";
  return reader.finished();
}

TEST(Symbols, ACutOrLongerBlockAndOneTooManyOrTooFewAreNoticed) {
  const Message sent = message(300, 16);
  EXPECT_TRUE(reads_to_the_end(sent, sent.block, 300));
  for (std::size_t size = 0; size < sent.block.size(); ++size) {
    EXPECT_FALSE(reads_to_the_end(sent, std::span(sent.block).first(size), 300)) << size;
    EXPECT_FALSE(reads_to_the_end(sent, std::span(sent.block).subspan(sent.block.size() - size), 300)) << size;
  }
  Bytes longer = sent.block;
  longer.insert(longer.begin(), 0);
  EXPECT_FALSE(reads_to_the_end(sent, longer, 300));
  for (const std::size_t count : {299u, 301u}) EXPECT_FALSE(reads_to_the_end(sent, sent.block, count));
  EXPECT_FALSE(reads_to_the_end(sent, {}, 1));
}

TEST(Symbols, AStateThatIsNotThereIsRefused) {
  SymbolReader reader = message(0, 16).reader();
  for (const Bytes& block : {Bytes{0x40}, Bytes{0xc0}, Bytes{0, 0x80}, Bytes{1, 2, 3, 0xc0}, Bytes{0xff, 0xff, 0xbf}})
    EXPECT_FALSE(reader.start(Exact(block).span()));
  EXPECT_TRUE(reader.start(Bytes{0x3f}));
}

void expect_bits_back(const std::vector<bake::PlainBits>& sent) {
  std::size_t used = 0;
  for (const auto& [bits, count] : sent) used += count;
  const Bytes bytes = bake::write_bits(sent);
  EXPECT_EQ(bytes.size(), 4 + 4 * (used / 32 + 1));
  BitReader reader;
  ASSERT_TRUE(reader.start(bytes));
  for (const auto& [bits, count] : sent) ASSERT_EQ(reader.next(count), bits);
  EXPECT_TRUE(reader.finished());
}

TEST(PlainBits, ComeBack) {
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    std::mt19937 random(seed);
    std::vector<bake::PlainBits> sent;
    for (std::uint32_t i = 0; i < 30 * seed; ++i) {
      const auto count = static_cast<std::uint32_t>(1 + random() % 32);
      sent.push_back({static_cast<std::uint32_t>(random() & (~std::uint64_t{0} >> (64 - count))), count});
    }
    expect_bits_back(sent);
  }
  expect_bits_back({{0xdeadbeefu, 32}, {0x12345678u, 32}});
}

TEST(PlainBits, WhatIsLeftOverIsNoticed) {
  const std::vector<bake::PlainBits> sent = {{5, 3}, {1, 1}, {9, 32}};
  const Bytes bytes = bake::write_bits(sent);
  BitReader reader;
  ASSERT_TRUE(reader.start(bytes));
  reader.next(3);
  EXPECT_FALSE(reader.finished()) << "a word";
  ASSERT_TRUE(reader.start(bytes));
  reader.next(32);
  EXPECT_FALSE(reader.finished()) << "bits that are not 0";
}

TEST(PlainBits, EndWhereTheirLengthSays) {
  const std::vector<bake::PlainBits> sent = {{5, 3}};
  const Bytes bytes = bake::write_bits(sent);
  const Exact exact(bytes);
  BitReader reader;
  ASSERT_TRUE(reader.start(exact.span()));
  for (int i = 0; i < 100; ++i) reader.next(31);
  EXPECT_FALSE(reader.finished()) << "nothing is read past the end";
  for (int length : {0, 3, 5, 8, 255}) {
    Bytes other = bytes;
    other[0] = static_cast<std::uint8_t>(length);
    EXPECT_FALSE(reader.start(Exact(other).span())) << length;
  }
  for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(reader.start(Exact(std::span(bytes).first(size)).span()));
}

TEST(DecoderPool, KeepsOneSetAndMakesOthersWhenItIsTaken) {
  DecoderPool pool;
  const DecoderPool::Set* kept = nullptr;
  {
    const DecoderPool::Lease lease(pool);
    kept = &*lease;
  }
  for (int round = 0; round < 3; ++round) {
    const DecoderPool::Lease one(pool), other(pool);
    EXPECT_NE(&*one, &*other);
    EXPECT_TRUE(&*one == kept || round > 0);
  }
}

}  // namespace coppice::symbol_reader_test
