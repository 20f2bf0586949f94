// libpng reports an error by a jump out of its own frames. Functions below that such a jump leaves have only locals without destructors;
// what needs a destructor belongs to the function that calls them.

#include "image_limits.h"

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <string>

#include <png.h>

namespace coppice::bake {
namespace {

// A byte of deflate gives at most so many bytes: what an image claims beyond that cannot be in the file.
constexpr std::uint64_t kMaxInflation = 1032;

struct PngReader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::span<const std::uint8_t> unread;
  bool ends_early = false;
  char message[96] = "";

  PngReader() = default;
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

[[noreturn]] void fail(png_structp png, png_const_charp message) {
  auto& reader = *static_cast<PngReader*>(png_get_error_ptr(png));
  std::snprintf(reader.message, sizeof reader.message, "%s", message);
  png_longjmp(png, 1);
}

void ignore(png_structp, png_const_charp) {}

void read_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto& reader = *static_cast<PngReader*>(png_get_io_ptr(png));
  if (count > reader.unread.size()) {
    reader.ends_early = true;
    png_error(png, "a chunk runs past the end");
  }
  std::memcpy(to, reader.unread.data(), count);
  reader.unread = reader.unread.subspan(count);
}

/// Reads up to the pixels. On false see `message`.
bool read_header(PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;  // NOLINT(cert-err52-cpp)
  png_set_read_fn(reader.png, &reader, read_bytes);
  png_set_user_limits(reader.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  png_set_crc_action(reader.png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  // Text, profiles and the like are skipped, not inflated.
  png_set_keep_unknown_chunks(reader.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_set_benign_errors(reader.png, 0);
  png_read_info(reader.png, reader.info);
  return true;
}

/// rgba  [height * width * 4], zeros
bool read_pixels(PngReader& reader, std::uint8_t* rgba, std::size_t row_bytes) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;  // NOLINT(cert-err52-cpp)
  png_set_strip_16(reader.png);
  png_set_expand(reader.png);
  png_set_gray_to_rgb(reader.png);
  png_set_add_alpha(reader.png, 0xff, PNG_FILLER_AFTER);
  const int pass_count = png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  if (png_get_rowbytes(reader.png, reader.info) != row_bytes) png_error(reader.png, "unexpected length of a row");
  const std::uint32_t height = png_get_image_height(reader.png, reader.info);
  for (int pass = 0; pass < pass_count; ++pass)
    for (std::uint32_t y = 0; y < height; ++y) png_read_row(reader.png, rgba + y * row_bytes, nullptr);
  png_read_end(reader.png, nullptr);
  return true;
}

Error error_of(const PngReader& reader) {
  const std::string message = reader.message;
  if (message.find("emory") != std::string::npos) return Error{Status::out_of_memory, "out of memory"};
  return Error{Status::bad_file, reader.ends_early ? kImageEndsEarly : kImageDamaged, Error::kNoOffset, message};
}

}  // namespace

Result<Image> decode_png(std::span<const std::uint8_t> bytes) {
  PngReader reader;
  reader.unread = bytes;
  reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, fail, ignore);
  if (reader.png != nullptr) reader.info = png_create_info_struct(reader.png);
  if (reader.info == nullptr) return Error{Status::out_of_memory, "out of memory"};
  if (!read_header(reader)) return error_of(reader);
  Image image;
  image.width = png_get_image_width(reader.png, reader.info);
  image.height = png_get_image_height(reader.png, reader.info);
  if (is_too_large(image.width, image.height)) return Error{Status::unsupported, kImageTooLarge};
  if (png_get_rowbytes(reader.png, reader.info) * std::uint64_t{image.height} > kMaxInflation * bytes.size())
    return Error{Status::bad_file, kImageEndsEarly, Error::kNoOffset, "so few bytes cannot hold its pixels"};
  image.rgba.resize(std::size_t{4} * image.width * image.height);
  if (!read_pixels(reader, image.rgba.data(), std::size_t{4} * image.width)) return error_of(reader);
  return image;
}

}  // namespace coppice::bake
