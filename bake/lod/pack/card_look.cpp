// A card is sampled at 32 x 32 points of the mip level in which its texture is about 128 px wide. A cell of the mask has 4 x 4 of them.

#include "card_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

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

/// The cell at `step` of a Hilbert curve: neighbours on it are neighbours in the mask.
std::uint32_t hilbert_cell(std::uint32_t step) {
  std::uint32_t x = 0, y = 0;
  for (std::uint32_t side = 1; side < kCells; side *= 2, step /= 4) {
    const std::uint32_t right = step / 2 & 1, down = (step ^ right) & 1;
    if (down == 0) {
      if (right == 1) x = side - 1 - x, y = side - 1 - y;
      std::swap(x, y);
    }
    x += side * right;
    y += side * down;
  }
  return y * kCells + x;
}

/// Dithers the cells' coverage along the curve: parts of a leaf that are thinner than a cell keep their share.
void set_mask(const std::array<std::uint32_t, kCells * kCells>& covered, coppice_file_card& card) {
  constexpr std::uint32_t kSamples = kSamplesPerCell * kSamplesPerCell;
  const auto set = [&](std::size_t cell) { card.mask[cell / 32] |= 1u << cell % 32; };
  std::uint32_t carried = kSamples / 2;
  for (std::uint32_t step = 0; step < kCells * kCells; ++step) {
    const std::uint32_t cell = hilbert_cell(step);
    carried += covered[cell];
    if (carried < kSamples) continue;
    carried -= kSamples;
    set(cell);
  }
  if (card.mask[0] == 0 && card.mask[1] == 0) set(static_cast<std::size_t>(std::ranges::max_element(covered) - covered.begin()));
}

}  // namespace

void set_card_look(const coppice_file_material& material, std::span<const std::vector<std::uint8_t>> textures, const ShownShares& shown,
                   coppice_file_card& card) {
  std::array<double, 3> sum{};
  double weights = 0.0;
  std::array<std::uint32_t, kCells * kCells> covered{};
  const std::uint32_t texture = material_texture(material);
  if (const auto layout = texture < textures.size() ? read_texture(textures[texture]) : Error{Status::bad_file, "no texture"}) {
    const Texels texels = *level_of(*layout, textures[texture], kSampledSide_px, default_allocator());
    for (std::uint32_t y = 0; y < kSide; ++y)
      for (std::uint32_t x = 0; x < kSide; ++x) {
        const auto [u, v] = card_uv(card, (static_cast<float>(x) + 0.5f) / kSide, (static_cast<float>(y) + 0.5f) / kSide);
        const Texel texel = texel_at(texels, u, v);
        if (texel[3] < material.alpha_cutoff) continue;
        const double weight = double{shown[x * shown.size() / kSide]};
        for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += weight * static_cast<double>(texel[channel]);
        weights += weight;
        ++covered[y / kSamplesPerCell * kCells + x / kSamplesPerCell];
      }
  } else {
    covered.fill(kSamplesPerCell * kSamplesPerCell);
    sum.fill(weights = 1.0);
  }
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const float mean = weights > 0.0 ? static_cast<float>(sum[channel] / weights) : 1.0f;
    const float srgb = srgb_from_linear(std::clamp(mean * material.base_color[channel], 0.0f, 1.0f));
    card.albedo[channel] = static_cast<std::uint8_t>(std::lround(255.0f * srgb));
  }
  set_mask(covered, card);
}

}  // namespace coppice::bake
