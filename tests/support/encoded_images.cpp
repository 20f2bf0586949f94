#include "encoded_images.h"

#include <cstdio>  // before jpeglib.h, which uses FILE
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include <jpeglib.h>
#include <png.h>
#include <webp/encode.h>

namespace coppice::test {
namespace {

void append(png_structp png, png_bytep bytes, std::size_t count) {
  auto& file = *static_cast<ImageBytes*>(png_get_io_ptr(png));
  file.insert(file.end(), bytes, bytes + count);
}

std::size_t row_bytes(const PngForm& form) {
  const std::size_t channels = form.color_type == 2 ? 3 : form.color_type == 4 ? 2 : form.color_type == 6 ? 4 : 1;
  return (channels * static_cast<std::size_t>(form.bit_depth) * form.width + 7) / 8;
}

std::uint32_t checksum(const std::uint8_t* bytes, std::size_t count) {
  std::uint32_t crc = 0xffffffff;
  for (std::size_t i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

std::uint32_t read_u32(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 | bytes[3];
}

}  // namespace

ImageBytes encode_png_form(const PngForm& form) {
  ImageBytes file;
  // Whatever goes wrong ends the test program.
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &file, append, nullptr);
  png_set_IHDR(png, info, form.width, form.height, form.bit_depth, form.color_type,
               form.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (!form.palette.empty()) {
    std::vector<png_color> colors;
    for (std::size_t i = 0; i < form.palette.size(); i += 3) colors.push_back({form.palette[i], form.palette[i + 1], form.palette[i + 2]});
    png_set_PLTE(png, info, colors.data(), static_cast<int>(colors.size()));
  }
  if (!form.transparency.empty()) {
    png_color_16 color{};
    const auto sample = [&](std::size_t i) {
      return static_cast<png_uint_16>(2 * i + 1 < form.transparency.size() ? form.transparency[2 * i] << 8 | form.transparency[2 * i + 1]
                                                                           : 0);
    };
    color.gray = color.red = sample(0);
    color.green = sample(1);
    color.blue = sample(2);
    png_set_tRNS(png, info, form.transparency.data(), static_cast<int>(form.color_type == 3 ? form.transparency.size() : 1), &color);
  }
  png_write_info(png, info);
  const int passes = png_set_interlace_handling(png);
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t y = 0; y < form.height; ++y) png_write_row(png, form.rows.data() + y * row_bytes(form));
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return file;
}

ImageBytes with_png_chunk(ImageBytes png, const std::string& chunk, std::size_t at, const ImageBytes& bytes) {
  for (std::size_t head = 8; head + 12 <= png.size(); head += 12 + read_u32(&png[head])) {
    if (std::memcmp(&png[head + 4], chunk.data(), 4) != 0) continue;
    std::memcpy(&png[head + 8 + at], bytes.data(), bytes.size());
    const std::size_t length = read_u32(&png[head]);
    const std::uint32_t crc = checksum(&png[head + 4], 4 + length);
    for (std::size_t i = 0; i < 4; ++i) png[head + 8 + length + i] = static_cast<std::uint8_t>(crc >> (24 - 8 * i));
    return png;
  }
  throw std::runtime_error("no chunk " + chunk);
}

ImageBytes encode_jpeg(const JpegForm& form) {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long byte_count = 0;
  jpeg_mem_dest(&info, &bytes, &byte_count);
  info.image_width = form.width;
  info.image_height = form.height;
  info.input_components = form.components;
  info.in_color_space = form.components == 1 ? JCS_GRAYSCALE : form.components == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&info);
  if (form.ycck) jpeg_set_colorspace(&info, JCS_YCCK);
  if (form.components == 4) info.write_Adobe_marker = form.adobe ? TRUE : FALSE;
  jpeg_set_quality(&info, 95, TRUE);
  if (form.progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  const auto channels = static_cast<std::size_t>(form.components);
  for (std::uint32_t y = 0; y < form.height; ++y) {
    ImageBytes row(channels * form.width);
    for (std::size_t i = 0; i < row.size(); ++i)
      row[i] = form.pixel.empty() ? static_cast<std::uint8_t>(5 * i + 11 * y) : form.pixel[i % channels];
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&info, &rows, 1);
  }
  jpeg_finish_compress(&info);
  ImageBytes file(bytes, bytes + byte_count);
  jpeg_destroy_compress(&info);
  std::free(bytes);
  return file;
}

ImageBytes encode_lossy_webp(int width, int height) {
  ImageBytes rgba;
  for (int i = 0; i < 4 * width * height; ++i) rgba.push_back(static_cast<std::uint8_t>(37 * i));
  std::uint8_t* bytes = nullptr;
  const std::size_t byte_count = WebPEncodeRGBA(rgba.data(), width, height, 4 * width, 60.0f, &bytes);
  ImageBytes file(bytes, bytes + byte_count);
  WebPFree(bytes);
  return file;
}

ImageBytes empty_pnm() {
  const std::string text = "P6 200 200 255\n";
  return {text.begin(), text.end()};
}

ImageBytes empty_tga() {
  return {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 200, 0, 200, 0, 32, 8};
}

ImageBytes jpeg_without_scan() {
  return {0xff, 0xd8, 0xff, 0xc0, 0, 17, 8, 0, 200, 0, 200, 3, 1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0, 0xff, 0xd9};
}

}  // namespace coppice::test
