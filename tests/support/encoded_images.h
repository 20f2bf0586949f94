#pragma once

// Image files of every kind that the importer reads, and wrong ones.

#include <cstdint>
#include <string>
#include <vector>

namespace coppice::test {

using ImageBytes = std::vector<std::uint8_t>;

/// A picture of `width` x `height` in one of PNG's forms; samples as they stand in the file, row by row, whole bytes each row.
struct PngForm {
  std::uint32_t width = 1, height = 1;
  int bit_depth = 8;
  int color_type = 6;  ///< 0 grey, 2 RGB, 3 palette, 4 grey and alpha, 6 RGBA
  bool interlaced = false;
  ImageBytes palette;       ///< RGB each
  ImageBytes transparency;  ///< the tRNS chunk's bytes
  ImageBytes rows;
};
ImageBytes encode_png_form(const PngForm& form);

/// The same file with other bytes in the chunk of that name, from `at` on, and a checksum that is right again.
ImageBytes with_png_chunk(ImageBytes png, const std::string& chunk, std::size_t at, const ImageBytes& bytes);

struct JpegForm {
  std::uint32_t width = 16, height = 16;
  int components = 3;  ///< 1 grey, 3 RGB given and YCbCr stored, 4 CMYK
  bool progressive = false;
  bool adobe = true;  ///< CMYK only: marked, and so stored inverted
  bool ycck = false;  ///< CMYK only: stored as YCCK
  ImageBytes pixel;   ///< `components` bytes, for every pixel; empty: a gradient
};
ImageBytes encode_jpeg(const JpegForm& form);

/// A gradient, lossy, with alpha.
ImageBytes encode_lossy_webp(int width, int height);

/// What was once read from beyond the end: a PNM and a TGA of nothing but a header, a JPEG of a frame without a scan.
ImageBytes empty_pnm();
ImageBytes empty_tga();
ImageBytes jpeg_without_scan();

}  // namespace coppice::test
