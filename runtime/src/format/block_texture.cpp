// BC1 has two colours of 16 bits and 16 indices of 2 bits. If the first colour is the larger number, indices 2 and 3 lie between the two;
// else 2 is their mean and 3 is black. BC3 has two alphas and 16 indices of 3 bits, then a BC1 block that always has four colours. Values
// between are rounded to the nearest; GPUs may differ by one or two.

#include "block_texture.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

namespace coppice {

namespace {

using Bytes = std::span<const std::uint8_t>;
using Rgba8 = std::array<std::uint8_t, 4>;
using Block = std::array<Rgba8, 16>;  ///< row by row

constexpr std::uint32_t kBlockSide = 4;

std::uint64_t block_bytes(std::uint32_t format) {
  return format == COPPICE_TEXTURE_BC1 ? 8 : 16;
}

std::uint64_t blocks_along(std::uint32_t side) {
  return (std::uint64_t{side} + kBlockSide - 1) / kBlockSide;
}

Rgba8 texel_of_565(std::uint32_t packed) {
  const std::uint32_t red = packed >> 11 & 31u, green = packed >> 5 & 63u, blue = packed & 31u;
  return {static_cast<std::uint8_t>(red << 3 | red >> 2), static_cast<std::uint8_t>(green << 2 | green >> 4),
          static_cast<std::uint8_t>(blue << 3 | blue >> 2), 255};
}

/// Computes (weight_a * a + weight_b * b) / their sum, for colour only.
Rgba8 between(const Rgba8& a, const Rgba8& b, std::uint32_t weight_a, std::uint32_t weight_b) {
  const std::uint32_t sum = weight_a + weight_b;
  Rgba8 result{0, 0, 0, 255};
  for (std::size_t channel = 0; channel < 3; ++channel)
    result[channel] = static_cast<std::uint8_t>((a[channel] * weight_a + b[channel] * weight_b + sum / 2) / sum);
  return result;
}

/// bytes: 8
void decode_colours(Bytes bytes, bool four_always, Block& block) {
  const std::uint32_t first = bytes[0] | std::uint32_t{bytes[1]} << 8, second = bytes[2] | std::uint32_t{bytes[3]} << 8;
  std::array<Rgba8, 4> palette{texel_of_565(first), texel_of_565(second), {}, {0, 0, 0, 255}};
  if (four_always || first > second) {
    palette[2] = between(palette[0], palette[1], 2, 1);
    palette[3] = between(palette[0], palette[1], 1, 2);
  } else {
    palette[2] = between(palette[0], palette[1], 1, 1);
  }
  for (std::size_t i = 0; i < block.size(); ++i) block[i] = palette[std::uint32_t{bytes[4 + i / 4]} >> 2 * (i % 4) & 3u];
}

/// bytes: 8
void decode_alphas(Bytes bytes, Block& block) {
  std::array<std::uint8_t, 8> palette{bytes[0], bytes[1], 0, 0, 0, 0, 0, 255};
  const std::uint32_t steps = bytes[0] > bytes[1] ? 7 : 5;
  for (std::uint32_t i = 1; i < steps; ++i)
    palette[i + 1] = static_cast<std::uint8_t>((bytes[0] * (steps - i) + bytes[1] * i + steps / 2) / steps);
  std::uint64_t indices = 0;
  for (std::size_t i = 0; i < 6; ++i) indices |= std::uint64_t{bytes[2 + i]} << 8 * i;
  for (std::size_t i = 0; i < block.size(); ++i) block[i][3] = palette[indices >> 3 * i & 7u];
}

/// Stores the part of a block that is inside the level.
void store_block(const Block& block, const MipLevel& level, std::uint32_t left, std::uint32_t top, std::span<std::uint8_t> rgba) {
  const std::uint32_t columns = std::min(kBlockSide, level.width - left), rows = std::min(kBlockSide, level.height - top);
  for (std::uint32_t row = 0; row < rows; ++row)
    std::memcpy(rgba.data() + (std::size_t{top + row} * level.width + left) * 4, block[std::size_t{row} * kBlockSide].data(),
                std::size_t{columns} * 4);
}

}  // namespace

const char* texture_format_name(std::uint32_t format) {
  switch (format) {
    case COPPICE_TEXTURE_RGBA8:
      return "rgba8";
    case COPPICE_TEXTURE_BC3:
      return "bc3";
    case COPPICE_TEXTURE_BC1:
      return "bc1";
    default:
      return "unknown";
  }
}

std::uint64_t texture_level_bytes(std::uint32_t format, std::uint32_t width, std::uint32_t height) {
  if (format == COPPICE_TEXTURE_RGBA8) return std::uint64_t{width} * height * 4;
  return blocks_along(width) * blocks_along(height) * block_bytes(format);
}

void decode_texture_level(std::uint32_t format, const MipLevel& level, Bytes stored, std::span<std::uint8_t> rgba) {
  if (format == COPPICE_TEXTURE_RGBA8) {
    std::ranges::copy(stored, rgba.begin());
    return;
  }
  const std::size_t stride = static_cast<std::size_t>(block_bytes(format));
  std::size_t at = 0;
  Block block;
  for (std::uint32_t top = 0; top < level.height; top += kBlockSide)
    for (std::uint32_t left = 0; left < level.width; left += kBlockSide, at += stride) {
      decode_colours(stored.subspan(at + stride - 8, 8), format == COPPICE_TEXTURE_BC3, block);
      if (format == COPPICE_TEXTURE_BC3) decode_alphas(stored.subspan(at, 8), block);
      store_block(block, level, left, top, rgba);
    }
}

std::uint64_t decoded_texture_bytes(const TextureLayout& layout) {
  std::uint64_t bytes = sizeof(coppice_file_texture);
  for (const MipLevel& level : layout.levels()) bytes += texture_level_bytes(COPPICE_TEXTURE_RGBA8, level.width, level.height);
  return bytes;
}

void decode_texture(const TextureLayout& layout, Bytes chunk, std::span<std::uint8_t> decoded) {
  const coppice_file_texture header{layout.levels()[0].width, layout.levels()[0].height, layout.level_count, COPPICE_TEXTURE_RGBA8};
  std::memcpy(decoded.data(), &header, sizeof header);
  std::size_t at = sizeof header;
  for (const MipLevel& level : layout.levels()) {
    const auto bytes = static_cast<std::size_t>(texture_level_bytes(COPPICE_TEXTURE_RGBA8, level.width, level.height));
    decode_texture_level(layout.format, level, chunk.subspan(static_cast<std::size_t>(level.offset), static_cast<std::size_t>(level.bytes)),
                         decoded.subspan(at, bytes));
    at += bytes;
  }
}

}  // namespace coppice
