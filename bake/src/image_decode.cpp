#include "image_decode.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>

#define STB_IMAGE_RESIZE_IMPLEMENTATION
#define STB_IMAGE_RESIZE_STATIC
#include <stb_image.h>
#include <stb_image_resize.h>

namespace coppice::bake {
namespace {

constexpr int kMaxSourceSide = 16384;
constexpr std::int64_t kMaxSourcePixels = std::int64_t{1} << 26;

Error bad(const char* what) {
  return Error{Status::bad_file, what};
}

struct FreePixels {
  void operator()(stbi_uc* pixels) const { stbi_image_free(pixels); }
};

int scaled(int side, int longer_side, std::uint32_t max_side_px) {
  const auto rounded = (static_cast<std::int64_t>(side) * max_side_px + longer_side / 2) / longer_side;
  return static_cast<int>(std::max<std::int64_t>(rounded, 1));
}

}  // namespace

Result<Image> decode_image(std::span<const std::uint8_t> bytes, std::uint32_t max_side_px) {
  if (bytes.empty() || bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return bad("no image data");
  const int byte_count = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  if (stbi_info_from_memory(bytes.data(), byte_count, &width, &height, &channels) == 0) return bad("not a PNG or JPEG image");
  if (width < 1 || height < 1 || width > kMaxSourceSide || height > kMaxSourceSide || std::int64_t{width} * height > kMaxSourcePixels)
    return bad("image too large");
  const std::unique_ptr<stbi_uc, FreePixels> pixels(stbi_load_from_memory(bytes.data(), byte_count, &width, &height, &channels, 4));
  if (!pixels) return bad("damaged image");

  const int longer_side = std::max(width, height);
  const bool shrink = static_cast<std::uint32_t>(longer_side) > max_side_px;
  const int out_width = shrink ? scaled(width, longer_side, max_side_px) : width;
  const int out_height = shrink ? scaled(height, longer_side, max_side_px) : height;
  Image image;
  image.width = static_cast<std::uint32_t>(out_width);
  image.height = static_cast<std::uint32_t>(out_height);
  image.rgba.resize(std::size_t{image.width} * image.height * 4);
  if (!shrink) {
    std::copy_n(pixels.get(), image.rgba.size(), image.rgba.data());
  } else if (stbir_resize_uint8_srgb(pixels.get(), width, height, 0, image.rgba.data(), out_width, out_height, 0, 4, 3, 0) == 0) {
    return Error{Status::out_of_memory, "image resize"};
  }
  return image;
}

}  // namespace coppice::bake
