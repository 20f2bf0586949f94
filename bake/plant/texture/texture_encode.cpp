// stb_dxt compresses the colours, this file the alphas: the nearest of a block's eight alphas may lie on the other side of the alpha test,
// which stb_dxt does not know. It moved up to 8 % of the texels of a coarse mip level across.

#include "texture_encode.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#define STB_DXT_IMPLEMENTATION
#define STB_DXT_STATIC
#include <stb_dxt.h>

#include "block_texture.h"
#include "coppice/format.h"
#include "normal_map.h"
#include "parallel_for.h"
#include "texture_mips.h"

namespace coppice::bake {

namespace {

constexpr std::uint32_t kBlockSide = 4;
constexpr std::size_t kBlockTexels = 16;
/// Minimum number of block rows a task.
constexpr std::size_t kRowGrain = 8;

struct Block {
  std::array<std::uint8_t, 4 * kBlockTexels> rgba;  ///< alpha 255, as stb_dxt wants it
  std::array<std::uint8_t, kBlockTexels> alpha;
};

/// Texels from (left, top) on; beyond the image they repeat its edge.
Block block_at(const Image& image, std::uint32_t left, std::uint32_t top) {
  Block block{};
  for (std::uint32_t i = 0; i < kBlockTexels; ++i) {
    const std::uint32_t x = std::min(left + i % kBlockSide, image.width - 1), y = std::min(top + i / kBlockSide, image.height - 1);
    const std::uint8_t* texel = image.rgba.data() + (std::size_t{y} * image.width + x) * 4;
    std::copy_n(texel, 3, block.rgba.data() + std::size_t{i} * 4);
    block.rgba[std::size_t{i} * 4 + 3] = 255;
    block.alpha[i] = texel[3];
  }
  return block;
}

/// The eight alphas of a block in sevenths, by index, the ends first.
std::array<int, 8> alpha_palette(int highest, int lowest) {
  std::array<int, 8> palette{7 * highest, 7 * lowest};
  for (int i = 1; i < 7; ++i) palette[static_cast<std::size_t>(i) + 1] = (7 - i) * highest + i * lowest;
  return palette;
}

/// Finds the nearest alpha on the texel's side of the cutoff. A decoder may round the alphas between the ends, so one within half a step of
/// the cutoff does not count. One alpha always fits: the highest is solid if any of the block is, the lowest is a hole if any is.
std::uint64_t alpha_index(std::uint8_t alpha, const std::array<int, 8>& palette, float alpha_cutoff) {
  const bool solid = is_solid(alpha, alpha_cutoff);
  const float cutoff_sevenths = alpha_cutoff * 255.0f * 7.0f;
  std::size_t best = 0;
  int best_distance = 1 << 20;
  for (std::size_t i = 0; i < palette.size(); ++i) {
    const auto value = static_cast<float>(palette[i]);
    const bool fits = i < 2   ? is_solid(static_cast<std::uint8_t>(palette[i] / 7), alpha_cutoff) == solid
                      : solid ? value > cutoff_sevenths + 3.5f
                              : value < cutoff_sevenths - 3.5f;
    const int distance = std::abs(palette[i] - 7 * alpha);
    if (!fits || distance >= best_distance) continue;
    best = i;
    best_distance = distance;
  }
  return best;
}

/// out  8 bytes
void encode_alphas(const Block& block, float alpha_cutoff, std::uint8_t* out) {
  const auto [lowest, highest] = std::ranges::minmax(block.alpha);
  out[0] = highest;
  out[1] = lowest;
  const std::array<int, 8> palette = alpha_palette(highest, lowest);
  std::uint64_t indices = 0;
  // Equal ends mean another palette, whose index 0 is the same alpha.
  for (std::size_t i = 0; i < kBlockTexels && highest > lowest; ++i) indices |= alpha_index(block.alpha[i], palette, alpha_cutoff) << 3 * i;
  for (std::size_t i = 0; i < 6; ++i) out[2 + i] = static_cast<std::uint8_t>(indices >> 8 * i & 0xffu);
}

/// out  [texture_level_bytes]
void encode_level(const Image& level, std::uint32_t format, float alpha_cutoff, std::uint8_t* out) {
  if (format == COPPICE_TEXTURE_RGBA8) {
    std::ranges::copy(level.rgba, out);
    return;
  }
  const std::size_t alpha_bytes = format == COPPICE_TEXTURE_BC3 ? 8 : 0, block_bytes = alpha_bytes + 8;
  const std::uint32_t columns = (level.width + kBlockSide - 1) / kBlockSide, rows = (level.height + kBlockSide - 1) / kBlockSide;
  const auto encode_row = [&](std::uint32_t row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const Block block = block_at(level, column * kBlockSide, row * kBlockSide);
      std::uint8_t* target = out + (std::size_t{row} * columns + column) * block_bytes;
      if (alpha_bytes > 0) encode_alphas(block, alpha_cutoff, target);
      stb_compress_dxt_block(target + alpha_bytes, block.rgba.data(), 0, STB_DXT_HIGHQUAL);
    }
  };
  parallel_for(rows, encode_row, kRowGrain);
}

/// level  the first, in which texels that nothing shows have the alpha of those beside them
std::uint32_t format_of(const Image& level, bool is_normal_map, float alpha_cutoff, TextureCoding coding) {
  if (coding == TextureCoding::rgba8) return COPPICE_TEXTURE_RGBA8;
  if (is_normal_map) return COPPICE_TEXTURE_BC3;
  bool has_alpha = false;
  for (std::size_t i = 3; i < level.rgba.size(); i += 4) has_alpha = has_alpha || level.rgba[i] != 255;
  return has_alpha && alpha_cutoff > 0.0f ? COPPICE_TEXTURE_BC3 : COPPICE_TEXTURE_BC1;
}

std::vector<Image> stored_levels(const Image& normal_map) {
  std::vector<Image> levels = normal_map_levels(normal_map);
  for (Image& level : levels) level = stored_normal_map(level);
  return levels;
}

}  // namespace

Result<std::vector<std::uint8_t>> encode_texture(const Image& image, float alpha_cutoff, TextureCoding coding) {
  if (image.width == 0 || image.height == 0 || image.rgba.size() != std::size_t{image.width} * image.height * 4)
    return Error{Status::invalid_argument, "texture: the image's bytes do not match its size"};
  const std::vector<Image> levels = image.is_normal_map ? stored_levels(image) : mip_levels(image, alpha_cutoff);
  const coppice_file_texture header{levels[0].width, levels[0].height, static_cast<std::uint32_t>(levels.size()),
                                    format_of(levels[0], image.is_normal_map, alpha_cutoff, coding)};
  std::vector<std::uint8_t> chunk(sizeof header);
  std::memcpy(chunk.data(), &header, sizeof header);
  for (const Image& level : levels) {
    const std::size_t at = chunk.size();
    chunk.resize(at + static_cast<std::size_t>(texture_level_bytes(header.format, level.width, level.height)));
    encode_level(level, header.format, alpha_cutoff, chunk.data() + at);
  }
  return chunk;
}

}  // namespace coppice::bake
