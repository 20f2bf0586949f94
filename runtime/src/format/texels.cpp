#include "texels.h"

#include <algorithm>
#include <cmath>

#include "block_texture.h"
#include "srgb.h"

namespace coppice {

Result<Texels> level_of(const TextureLayout& layout, std::span<const std::uint8_t> chunk, std::uint32_t side_px,
                        const coppice_allocator& allocator) {
  const MipLevel* level = &layout.levels().front();
  for (const MipLevel& smaller : layout.levels())
    if (std::max(smaller.width, smaller.height) >= side_px) level = &smaller;
  Texels texels{level->width, level->height, {}};
  COPPICE_CHECK(allocate_into(texels.rgba, allocator, std::size_t{4} * level->width * level->height));
  decode_texture_level(layout.format, *level,
                       chunk.subspan(static_cast<std::size_t>(level->offset), static_cast<std::size_t>(level->bytes)), texels.rgba.span());
  return texels;
}

Texel texel_at(const Texels& texels, float u, float v) {
  const auto wrap = [](float at, std::uint32_t side) {
    const auto whole = static_cast<std::int64_t>(std::floor(at));
    const auto period = static_cast<std::int64_t>(side);
    return static_cast<std::size_t>((whole % period + period) % period);
  };
  const float x = u * static_cast<float>(texels.width) - 0.5f, y = v * static_cast<float>(texels.height) - 0.5f;
  const float right = x - std::floor(x), down = y - std::floor(y);
  Texel sum{};
  for (int corner = 0; corner < 4; ++corner) {
    const int rows = corner / 2;
    const float weight = (corner % 2 != 0 ? right : 1.0f - right) * (rows != 0 ? down : 1.0f - down);
    const std::size_t column = wrap(x + static_cast<float>(corner % 2), texels.width);
    const std::size_t row = wrap(y + static_cast<float>(rows), texels.height);
    const std::uint8_t* texel = texels.rgba.data() + 4 * (row * texels.width + column);
    for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += weight * linear_from_srgb8(texel[channel]);
    sum[3] += weight * static_cast<float>(texel[3]) / 255.0f;
  }
  return sum;
}

}  // namespace coppice
