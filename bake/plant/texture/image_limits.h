#pragma once

// What the decoders of images have in common.

#include <cstdint>
#include <span>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kMaxSourceSide_px = 16384;
#ifdef COPPICE_BUILD_FUZZ
// 2^26 pixels take a minute with sanitizers, which the fuzzer would count as a hang.
inline constexpr std::uint64_t kMaxSourcePixels = std::uint64_t{1} << 20;
#else
inline constexpr std::uint64_t kMaxSourcePixels = std::uint64_t{1} << 26;
#endif

/// Whether an image has no pixels, or more than are decoded.
inline bool is_too_large(std::uint64_t width, std::uint64_t height) {
  return width < 1 || height < 1 || width > kMaxSourceSide_px || height > kMaxSourceSide_px || width * height > kMaxSourcePixels;
}

inline constexpr const char* kImageEndsEarly = "image ends early";
inline constexpr const char* kImageDamaged = "damaged image";
inline constexpr const char* kImageTooLarge = "image too large";
inline constexpr const char* kKtxImage = "KTX2 is not read; `gltf-transform ktxdecompress in.glb out.glb` makes PNG of it";
// What git checks out in place of a large file.
inline constexpr const char* kGitLfsPointer = "version https://git-lfs";
inline constexpr const char* kIsGitLfsPointer = "a Git LFS pointer in place of the file; `git lfs pull` fetches it";

/// Decodes a PNG of any kind to RGBA of 8 bits. It keeps the high bytes of 16 bits, and applies no colour profile or gamma.
/// errors  those of decode_image; bad_file also: a wrong checksum, and anything that libpng has to guess
Result<Image> decode_png(std::span<const std::uint8_t> bytes);

/// Decodes a JPEG to opaque RGBA: baseline and progressive, grey, RGB, YCbCr, and CMYK and YCCK by their product. EXIF is ignored.
/// errors  those of decode_image; unsupported also: 12 bits, lossless, arithmetic coding; bad_file also: what libjpeg would fill in
Result<Image> decode_jpeg(std::span<const std::uint8_t> bytes);

}  // namespace coppice::bake
