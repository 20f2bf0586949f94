#pragma once

// Reads single texels of a stored texture, for the distant appearance of cards and triangles.

#include <array>
#include <cstdint>
#include <span>

#include "reader.h"

namespace coppice {

/// A mip level of a texture, as RGBA8 in sRGB.
struct Texels {
  std::uint32_t width = 0, height = 0;
  HookBuffer rgba;
};

/// Returns the smallest level whose longer side is at least this, or the largest there is. chunk: a TEXTURE chunk of this layout
/// errors  out_of_memory
Result<Texels> level_of(const TextureLayout& layout, std::span<const std::uint8_t> chunk, std::uint32_t side_px,
                        const coppice_allocator& allocator);

/// Linear colour and alpha, 0..1.
using Texel = std::array<float, 4>;

/// Interpolates linearly between the four nearest texels; the texture repeats. u, v: any finite number
Texel texel_at(const Texels& texels, float u, float v);

}  // namespace coppice
