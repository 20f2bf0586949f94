#include "image_decode.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>

#define STB_IMAGE_RESIZE_IMPLEMENTATION
#define STB_IMAGE_RESIZE_STATIC
#include <stb_image.h>
#include <stb_image_resize.h>
#include <webp/decode.h>

namespace coppice::bake {
namespace {

constexpr int kMaxSourceSide = 16384;
constexpr std::int64_t kMaxSourcePixels = std::int64_t{1} << 26;

Error bad(const char* what) {
  return Error{Status::bad_file, what};
}
Error unsupported(const char* what) {
  return Error{Status::unsupported, what};
}

bool is_too_large(int width, int height) {
  return width < 1 || height < 1 || width > kMaxSourceSide || height > kMaxSourceSide || std::int64_t{width} * height > kMaxSourcePixels;
}

bool is_webp(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 12 && std::memcmp(bytes.data(), "RIFF", 4) == 0 && std::memcmp(bytes.data() + 8, "WEBP", 4) == 0;
}

Result<Image> decode_webp(std::span<const std::uint8_t> bytes) {
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(bytes.data(), bytes.size(), &features) != VP8_STATUS_OK) return bad("damaged image");
  if (features.has_animation != 0) return unsupported("animated image");
  if (is_too_large(features.width, features.height)) return unsupported("image too large");
  Image image;
  image.width = static_cast<std::uint32_t>(features.width);
  image.height = static_cast<std::uint32_t>(features.height);
  image.rgba.resize(std::size_t{image.width} * image.height * 4);
  if (WebPDecodeRGBAInto(bytes.data(), bytes.size(), image.rgba.data(), image.rgba.size(), features.width * 4) == nullptr)
    return bad("damaged image");
  return image;
}

struct FreePixels {
  void operator()(stbi_uc* pixels) const { stbi_image_free(pixels); }
};

Result<Image> decode_with_stb(std::span<const std::uint8_t> bytes) {
  const int byte_count = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  if (stbi_info_from_memory(bytes.data(), byte_count, &width, &height, &channels) == 0) return unsupported("not a PNG, JPEG or WebP image");
  if (is_too_large(width, height)) return unsupported("image too large");
  const std::unique_ptr<stbi_uc, FreePixels> pixels(stbi_load_from_memory(bytes.data(), byte_count, &width, &height, &channels, 4));
  if (!pixels) return bad("damaged image");
  Image image;
  image.width = static_cast<std::uint32_t>(width);
  image.height = static_cast<std::uint32_t>(height);
  image.rgba.assign(pixels.get(), pixels.get() + std::size_t{image.width} * image.height * 4);
  return image;
}

int scaled(int side, int longer_side, std::uint32_t max_side_px) {
  const auto rounded = (static_cast<std::int64_t>(side) * max_side_px + longer_side / 2) / longer_side;
  return static_cast<int>(std::max<std::int64_t>(rounded, 1));
}

}  // namespace

Result<Image> decode_image(std::span<const std::uint8_t> bytes, std::uint32_t max_side_px) {
  if (bytes.empty() || bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return unsupported("no image data");
  COPPICE_TRY(source, is_webp(bytes) ? decode_webp(bytes) : decode_with_stb(bytes));
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
