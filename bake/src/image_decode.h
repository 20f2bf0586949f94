#pragma once

#include <cstdint>
#include <span>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Decodes a PNG, JPEG, WebP or other file that stb_image reads. Downscaled, if need be, until the longer side is max_side_px; colours are
/// averaged by their alpha, so that what an alpha mask hides does not bleed into what it shows. errors  unsupported: not an image in one of
/// these forms, over 16384 pixels wide or high, over 2^26 in all, or animated;
///         bad_file: damaged
Result<Image> decode_image(std::span<const std::uint8_t> bytes, std::uint32_t max_side_px);

}  // namespace coppice::bake
