#include "png.h"

#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>

#include "output.h"

namespace forest {

void write_png(const std::string& file, std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> rgba) {
  std::vector<std::uint8_t> rgb(std::size_t{width} * height * 3);
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i)
    for (std::size_t channel = 0; channel < 3; ++channel) rgb[3 * i + channel] = rgba[4 * i + channel];
  const auto w = static_cast<int>(width);
  int bytes = 0;
  const std::unique_ptr<unsigned char, void (*)(void*)> png(
      stbi_write_png_to_mem(rgb.data(), 3 * w, w, static_cast<int>(height), 3, &bytes), std::free);
  if (!png) throw std::bad_alloc();
  write_output(file, {reinterpret_cast<const char*>(png.get()), static_cast<std::size_t>(bytes)});
}

}  // namespace forest
