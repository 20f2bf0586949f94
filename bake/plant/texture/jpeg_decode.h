#pragma once

#include <cstdint>
#include <span>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Decodes a JPEG to opaque RGBA: baseline and progressive, grey, RGB, YCbCr, and CMYK and YCCK by their product. EXIF is ignored.
/// errors  those of decode_image; unsupported also: 12 bits, lossless, arithmetic coding; bad_file also: what libjpeg would fill in
Result<Image> decode_jpeg(std::span<const std::uint8_t> bytes);

}  // namespace coppice::bake
