#pragma once

#include <cstdint>
#include <span>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Decodes a PNG of any kind to RGBA of 8 bits. It keeps the high bytes of 16 bits, and applies no colour profile or gamma.
/// errors  those of decode_image; bad_file also: a wrong checksum, and anything that libpng has to guess
Result<Image> decode_png(std::span<const std::uint8_t> bytes);

/// Decodes a JPEG to opaque RGBA: baseline and progressive, grey, RGB, YCbCr, and CMYK and YCCK by their product. EXIF is ignored.
/// errors  those of decode_image; unsupported also: 12 bits, lossless, arithmetic coding; bad_file also: what libjpeg would fill in
Result<Image> decode_jpeg(std::span<const std::uint8_t> bytes);

}  // namespace coppice::bake
