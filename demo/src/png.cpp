#include "png.h"

#include <filesystem>
#include <system_error>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>

#include "failure.h"

namespace forest {

void write_png(const std::string& file, std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> rgba) {
  std::vector<std::uint8_t> rgb(std::size_t{width} * height * 3);
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i)
    for (std::size_t channel = 0; channel < 3; ++channel) rgb[3 * i + channel] = rgba[4 * i + channel];
  std::error_code ignored;  // a folder that cannot be made shows as a file that cannot be written
  std::filesystem::create_directories(std::filesystem::path(file).parent_path(), ignored);
  const auto w = static_cast<int>(width);
  if (!stbi_write_png(file.c_str(), w, static_cast<int>(height), 3, rgb.data(), 3 * w)) throw Failure("cannot write " + file);
}

}  // namespace forest
