#include "image_decode.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <string_view>

#define STB_IMAGE_RESIZE_IMPLEMENTATION
#define STB_IMAGE_RESIZE_STATIC
#include <stb_image_resize.h>
#include <webp/decode.h>

#include "image_limits.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

using namespace std::string_view_literals;

Error bad(const char* what) {
  return Error{Status::bad_file, what};
}
Error unsupported(const char* what) {
  return Error{Status::unsupported, what};
}

/// Whether a file starts with these bytes; '?' stands for any.
bool starts_like(std::string_view file, std::string_view start) {
  const auto fits = [](char byte, char wanted) { return byte == wanted || wanted == '?'; };
  return std::equal(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(std::min(file.size(), start.size())), start.begin(), fits);
}

Error webp_error(VP8StatusCode status) {
  if (status == VP8_STATUS_OUT_OF_MEMORY) return Error{Status::out_of_memory, "out of memory"};
  return bad(status == VP8_STATUS_NOT_ENOUGH_DATA || status == VP8_STATUS_SUSPENDED ? kImageEndsEarly : kImageDamaged);
}

Result<Image> decode_webp(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kRiffHeadBytes = 8;
  std::uint32_t riff_bytes = 0;
  std::memcpy(&riff_bytes, bytes.data() + 4, sizeof riff_bytes);
  if (riff_bytes > bytes.size() - kRiffHeadBytes) return bad(kImageEndsEarly);
  WebPDecoderConfig config;
  if (WebPInitDecoderConfig(&config) == 0) return Error{Status::internal, "libwebp of another version"};
  if (const VP8StatusCode status = WebPGetFeatures(bytes.data(), bytes.size(), &config.input); status != VP8_STATUS_OK)
    return webp_error(status);
  if (config.input.has_animation != 0) return unsupported("animated image");
  if (config.input.width < 1 || config.input.height < 1) return bad(kImageDamaged);
  Image image;
  image.width = static_cast<std::uint32_t>(config.input.width);
  image.height = static_cast<std::uint32_t>(config.input.height);
  if (is_too_large(image.width, image.height)) return unsupported(kImageTooLarge);
  image.rgba.resize(std::size_t{image.width} * image.height * 4);
  config.output.colorspace = MODE_RGBA;
  config.output.is_external_memory = 1;
  config.output.u.RGBA = {image.rgba.data(), config.input.width * 4, image.rgba.size()};
  if (const VP8StatusCode status = WebPDecode(bytes.data(), bytes.size(), &config); status != VP8_STATUS_OK) return webp_error(status);
  return image;
}

Result<Image> decode_any(std::span<const std::uint8_t> bytes) {
  struct Format {
    std::string_view start;
    Result<Image> (*decode)(std::span<const std::uint8_t>);
  };
  constexpr std::array<Format, 3> kFormats{
      {{"\x89PNG\r\n\x1a\n"sv, decode_png}, {"\xff\xd8\xff"sv, decode_jpeg}, {"RIFF????WEBP"sv, decode_webp}}};
  const std::string_view file = as_text(bytes);
  for (const Format& format : kFormats)
    if (starts_like(file, format.start)) return file.size() < format.start.size() ? bad(kImageEndsEarly) : format.decode(bytes);
  if (starts_like(file, "\xabKTX ")) return unsupported(kKtxImage);
  if (starts_like(file, "DDS ")) return unsupported("DDS is not read; save the image as PNG");
  if (starts_like(file, kGitLfsPointer)) return unsupported(kIsGitLfsPointer);
  return unsupported("not a PNG, JPEG or WebP image");
}

/// Whether alpha hides a part of the image and shows another. Other things that alpha holds, roughness say, have all values.
bool has_mask(const Image& image) {
  constexpr std::uint8_t kHidden = 8, kShown = 247;
  std::size_t hidden = 0, shown = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    hidden += image.rgba[i] < kHidden ? 1u : 0u;
    shown += image.rgba[i] > kShown ? 1u : 0u;
  }
  const std::size_t count = image.rgba.size() / 4;
  return 50 * hidden > count && 10 * shown > count && 4 * (hidden + shown) > 3 * count;
}

int scaled(int side, int longer_side, std::uint32_t max_side_px) {
  const auto rounded = (static_cast<std::int64_t>(side) * max_side_px + longer_side / 2) / longer_side;
  return static_cast<int>(std::max<std::int64_t>(rounded, 1));
}

}  // namespace

Result<Image> decode_image(std::span<const std::uint8_t> bytes, std::uint32_t max_side_px, ImageAlpha alpha, bool* ignored_mask) {
  COPPICE_TRY(source, decode_any(bytes));
  if (ignored_mask != nullptr) *ignored_mask = alpha == ImageAlpha::ignored && has_mask(source);
  for (std::size_t i = 3; i < source.rgba.size() && alpha == ImageAlpha::ignored; i += 4) source.rgba[i] = 255;
  const std::uint32_t longer_side = std::max(source.width, source.height);
  if (longer_side <= max_side_px) return source;

  const int width = static_cast<int>(source.width), height = static_cast<int>(source.height);
  Image image;
  image.width = static_cast<std::uint32_t>(scaled(width, static_cast<int>(longer_side), max_side_px));
  image.height = static_cast<std::uint32_t>(scaled(height, static_cast<int>(longer_side), max_side_px));
  image.rgba.resize(std::size_t{image.width} * image.height * 4);
  if (stbir_resize_uint8_srgb(source.rgba.data(), width, height, 0, image.rgba.data(), static_cast<int>(image.width),
                              static_cast<int>(image.height), 0, 4, 3, 0) == 0)
    return Error{Status::out_of_memory, "image resize"};
  return image;
}

}  // namespace coppice::bake
