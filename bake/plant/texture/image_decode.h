#pragma once

#include <cstdint>
#include <span>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// How an image's alpha is used: opaque materials show a texel's colour whatever its alpha is.
enum class ImageAlpha : std::uint8_t { mask, ignored };

/// Decodes a PNG, JPEG or WebP file, known by its first bytes. Scales it down, if need be, until the longer side is max_side_px; colours
/// are averaged by their alpha, so that what an alpha mask hides does not bleed into what it shows. An alpha that is ignored becomes 255.
/// Every pixel comes from the file, or there is an error.
/// ignored_mask  if it is not null, receives whether an ignored alpha looks like a mask: texels are hidden or shown, hardly any in between
/// errors  unsupported: not an image in one of these forms, over 16384 pixels wide or high, over 2^26 in all, or animated; bad_file:
///         damaged, or it ends early; `detail` has the decoder's reason; out_of_memory
Result<Image> decode_image(std::span<const std::uint8_t> bytes, std::uint32_t max_side_px, ImageAlpha alpha = ImageAlpha::mask,
                           bool* ignored_mask = nullptr);

}  // namespace coppice::bake
