#pragma once

#include <cstdint>
#include <span>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Decodes a PNG of any kind to RGBA of 8 bits. It keeps the high bytes of 16 bits, and applies no colour profile or gamma.
/// errors  those of decode_image; bad_file also: a wrong checksum, and anything that libpng has to guess
Result<Image> decode_png(std::span<const std::uint8_t> bytes);

}  // namespace coppice::bake
