// A card is sampled at 32 x 32 points of the mip level in which its texture is about 128 px wide. A cell of the mask has 4 x 4 of them. The
// fullest cells are set, as many as give the card's coverage, so that thin outlines do not vanish.

#include "card_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "srgb.h"
#include "texels.h"

namespace coppice::bake {
namespace {

constexpr std::uint32_t kSampledSide_px = 128;
constexpr std::uint32_t kCells = 8;
constexpr std::uint32_t kSamplesPerCell = 4;
constexpr std::uint32_t kSide = kCells * kSamplesPerCell;

/// Texture coordinate at (s, t) of a card, linear on each of its two triangles, as the hardware draws it.
std::array<float, 2> card_uv(const coppice_file_card& card, float s, float t) {
  std::array<float, 2> uv{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto at = [&](std::size_t corner) { return card.uv[corner][axis]; };
    uv[axis] = s >= t ? at(0) + s * (at(1) - at(0)) + t * (at(2) - at(1)) : at(0) + t * (at(3) - at(0)) + s * (at(2) - at(3));
  }
  return uv;
}

/// Sets the mask's cells by their number of covered samples, the fullest first.
void set_mask(const std::array<std::uint32_t, kCells * kCells>& covered, coppice_file_card& card) {
  std::array<std::uint32_t, kCells * kCells> order{};
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, [&](auto a, auto b) { return covered[a] != covered[b] ? covered[a] > covered[b] : a < b; });
  constexpr std::uint32_t kSamples = kSamplesPerCell * kSamplesPerCell;
  const std::uint32_t sum = std::accumulate(covered.begin(), covered.end(), 0u);
  const std::uint32_t wanted = std::clamp((sum + kSamples / 2) / kSamples, 1u, kCells * kCells);
  for (std::uint32_t i = 0; i < wanted; ++i) card.mask[order[i] / 32] |= 1u << order[i] % 32;
}

}  // namespace

void set_card_look(const coppice_file_material& material, std::span<const std::vector<std::uint8_t>> textures, coppice_file_card& card) {
  std::array<double, 3> sum{};
  std::array<std::uint32_t, kCells * kCells> covered{};
  const std::uint32_t texture = material_texture(material);
  if (const auto layout = texture < textures.size() ? read_texture(textures[texture]) : Error{Status::bad_file, "no texture"}) {
    const Texels texels = *level_of(*layout, textures[texture], kSampledSide_px, default_allocator());
    for (std::uint32_t y = 0; y < kSide; ++y)
      for (std::uint32_t x = 0; x < kSide; ++x) {
        const auto [u, v] = card_uv(card, (static_cast<float>(x) + 0.5f) / kSide, (static_cast<float>(y) + 0.5f) / kSide);
        const Texel texel = texel_at(texels, u, v);
        if (texel[3] < material.alpha_cutoff) continue;
        for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += static_cast<double>(texel[channel]);
        ++covered[y / kSamplesPerCell * kCells + x / kSamplesPerCell];
      }
  } else {
    covered.fill(kSamplesPerCell * kSamplesPerCell);
    sum.fill(kSide * kSide);
  }
  const std::uint32_t count = std::accumulate(covered.begin(), covered.end(), 0u);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const float mean = count > 0 ? static_cast<float>(sum[channel] / count) : 1.0f;
    const float srgb = srgb_from_linear(std::clamp(mean * material.base_color[channel], 0.0f, 1.0f));
    card.albedo[channel] = static_cast<std::uint8_t>(std::lround(255.0f * srgb));
  }
  set_mask(covered, card);
}

}  // namespace coppice::bake
