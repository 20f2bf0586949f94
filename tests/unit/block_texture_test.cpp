// Blocks that are put together in the test, and what they must decode to.

#include "block_texture.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <vector>

#include "results.h"

namespace coppice::block_texture_test {

using Bytes = std::vector<std::uint8_t>;
using Texel = std::array<int, 4>;

/// Index i in the lowest two bits of texel 0, and so on; 0xe4 is 0 1 2 3 from left to right.
const Bytes kRows0123(4, 0xe4);

Bytes concat(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::vector<Texel> decode(std::uint32_t format, std::uint32_t width, std::uint32_t height, const Bytes& stored) {
  EXPECT_EQ(stored.size(), texture_level_bytes(format, width, height));
  Bytes rgba(std::size_t{width} * height * 4);
  decode_texture_level(format, {width, height, 0, stored.size()}, stored, rgba);
  std::vector<Texel> texels;
  for (std::size_t i = 0; i < rgba.size(); i += 4) texels.push_back({rgba[i], rgba[i + 1], rgba[i + 2], rgba[i + 3]});
  return texels;
}

// 0xffff is white, 0x0000 black; 0xf800 red, 0x001f blue.
TEST(BlockTexture, FourColoursWhereTheFirstIsTheLargerNumberElseAMeanAndBlack) {
  const auto four = decode(COPPICE_TEXTURE_BC1, 4, 4, concat({0x00, 0xf8, 0x1f, 0x00}, kRows0123));
  const auto mean = decode(COPPICE_TEXTURE_BC1, 4, 4, concat({0x1f, 0x00, 0x00, 0xf8}, kRows0123));
  const std::array<Texel, 4> expected_four{{{255, 0, 0, 255}, {0, 0, 255, 255}, {170, 0, 85, 255}, {85, 0, 170, 255}}};
  const std::array<Texel, 4> expected_mean{{{0, 0, 255, 255}, {255, 0, 0, 255}, {128, 0, 128, 255}, {0, 0, 0, 255}}};
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(four[i], expected_four[i % 4]) << i;
    EXPECT_EQ(mean[i], expected_mean[i % 4]) << i;
  }
}

TEST(BlockTexture, Bc3HasFourColoursAlways) {
  const Bytes alphas = {255, 255, 0, 0, 0, 0, 0, 0};
  const auto texels = decode(COPPICE_TEXTURE_BC3, 4, 4, concat(alphas, concat({0x1f, 0x00, 0x00, 0xf8}, kRows0123)));
  EXPECT_EQ(texels[2], (Texel{85, 0, 170, 255}));
  EXPECT_EQ(texels[3], (Texel{170, 0, 85, 255}));
}

/// Texel i has alpha index i % 8.
const Bytes kAlphaIndices = {0x88, 0xc6, 0xfa, 0x88, 0xc6, 0xfa};

TEST(BlockTexture, EightAlphasOrSixAndTheExtremes) {
  const Bytes colours = {0xff, 0xff, 0, 0, 0, 0, 0, 0};
  const auto eight = decode(COPPICE_TEXTURE_BC3, 4, 4, concat(concat({210, 0}, kAlphaIndices), colours));
  const std::array<int, 8> expected_eight{210, 0, 180, 150, 120, 90, 60, 30};
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(eight[i], (Texel{255, 255, 255, expected_eight[i % 8]})) << i;
  const auto six = decode(COPPICE_TEXTURE_BC3, 4, 4, concat(concat({50, 100}, kAlphaIndices), colours));
  const std::array<int, 8> expected_six{50, 100, 60, 70, 80, 90, 0, 255};
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(six[i][3], expected_six[i % 8]) << i;
}

TEST(BlockTexture, LastBlocksAreCutAtTheEdge) {
  // Two blocks for five columns, one for three rows: red, then blue, of which only the first column is inside.
  const Bytes red = {0x00, 0xf8, 0, 0, 0, 0, 0, 0}, blue = {0x1f, 0x00, 0, 0, 0, 0, 0, 0};
  const auto texels = decode(COPPICE_TEXTURE_BC1, 5, 3, concat(red, blue));
  ASSERT_EQ(texels.size(), 15u);
  for (std::size_t i = 0; i < texels.size(); ++i) EXPECT_EQ(texels[i], i % 5 == 4 ? (Texel{0, 0, 255, 255}) : (Texel{255, 0, 0, 255})) << i;
}

Bytes bc1_chunk(std::uint32_t width, std::uint32_t height, std::uint32_t mip_count, std::size_t block_count) {
  const coppice_file_texture header{width, height, mip_count, COPPICE_TEXTURE_BC1};
  Bytes chunk(sizeof header + 8 * block_count);
  std::memcpy(chunk.data(), &header, sizeof header);
  for (std::size_t i = sizeof header; i < chunk.size(); ++i) chunk[i] = static_cast<std::uint8_t>(37 * i);
  return chunk;
}

TEST(BlockTexture, AChunkDecodesToOneOfRgba8) {
  const Bytes chunk = bc1_chunk(6, 5, 3, 4 + 1 + 1);
  const auto layout = test::must(read_texture(chunk));
  Bytes decoded(decoded_texture_bytes(layout));
  ASSERT_EQ(decoded.size(), 16u + 4 * (30 + 6 + 1));
  decode_texture(layout, chunk, decoded);
  const auto plain = test::must(read_texture(decoded));
  EXPECT_EQ(plain.format, std::uint32_t{COPPICE_TEXTURE_RGBA8});
  ASSERT_EQ(plain.levels().size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const MipLevel &from = layout.levels()[i], &to = plain.levels()[i];
    Bytes expected(to.bytes);
    decode_texture_level(COPPICE_TEXTURE_BC1, from, std::span(chunk).subspan(from.offset, from.bytes), expected);
    EXPECT_EQ(Bytes(decoded.begin() + static_cast<std::ptrdiff_t>(to.offset),
                    decoded.begin() + static_cast<std::ptrdiff_t>(to.offset + to.bytes)),
              expected)
        << i;
  }
}

TEST(BlockTexture, AWrongNumberOfBlocksIsRefused) {
  for (const std::size_t blocks : {0u, 5u, 7u, 1000u}) {
    const auto layout = read_texture(bc1_chunk(6, 5, 3, blocks));
    EXPECT_STREQ(layout.error().what, "texture length") << blocks;
    EXPECT_EQ(layout.error().offset, sizeof(coppice_file_texture));
  }
}

}  // namespace coppice::block_texture_test
