#pragma once

#include <cstdint>
#include <span>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Decodes a PNG of any kind to RGBA of 8 bits. Of 16 bits the high ones are kept; colour profiles and gamma are not applied.
/// errors  those of decode_image. A wrong checksum, and anything that libpng has to guess, is damage
Result<Image> decode_png(std::span<const std::uint8_t> bytes);

}  // namespace coppice::bake
