// Every pixel comes from the file, or there is an error.

#include "image_decode.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "encoded_images.h"
#include "gltf_builder.h"
#include "gltf_compress.h"
#include "results.h"

namespace coppice::bake::image_decode_test {

using test::encode_jpeg;
using test::encode_png_form;
using test::ImageBytes;
using test::PngForm;
using test::with_png_chunk;

constexpr std::uint32_t kAnySide = 16384;

/// From a heap block of exactly the file's size, so that a sanitizer sees a read past its end.
Result<Image> decode(const ImageBytes& file) {
  const ImageBytes exact(file.begin(), file.end());
  return decode_image(exact, kAnySide);
}

Image decoded(const ImageBytes& file) {
  return test::must(decode(file));
}

void expect_error(const ImageBytes& file, Status status) {
  const auto image = decode(file);
  test::expect_error(image, status);
  EXPECT_EQ(image.error().message().find('\n'), std::string::npos);
}

ImageBytes first(const ImageBytes& file, std::size_t count) {
  return {file.begin(), file.begin() + static_cast<std::ptrdiff_t>(count)};
}

PngForm gradient(int bit_depth, int color_type, bool interlaced) {
  PngForm form{.width = 13, .height = 11, .bit_depth = bit_depth, .color_type = color_type, .interlaced = interlaced};
  if (color_type == 3)
    form.palette = {0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9, 8, 8, 8, 7, 7, 7, 6, 6, 6,
                    0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9, 8, 8, 8, 7, 7, 7, 6, 6, 6};
  for (std::size_t i = 0; i < 13 * 11 * 8; ++i)
    form.rows.push_back(static_cast<std::uint8_t>(color_type == 3 && bit_depth == 8 ? i % 16 : 29 * i));
  return form;
}

std::vector<std::pair<std::string, ImageBytes>> good_images() {
  std::vector<std::pair<std::string, ImageBytes>> images;
  for (const bool interlaced : {false, true})
    for (const auto& [depth, type] :
         {std::pair{8, 6}, {16, 6}, {8, 2}, {16, 2}, {1, 0}, {4, 0}, {8, 0}, {16, 0}, {4, 3}, {8, 3}, {8, 4}, {16, 4}})
      images.emplace_back("png_" + std::to_string(depth) + "_" + std::to_string(type) + (interlaced ? "_interlaced" : ""),
                          encode_png_form(gradient(depth, type, interlaced)));
  images.emplace_back("png_of_stb", test::png(5, 4, {10, 200, 30, 128}));
  for (const bool progressive : {false, true})
    for (const int components : {1, 3, 4})
      images.emplace_back((progressive ? "jpeg_progressive_" : "jpeg_") + std::to_string(components),
                          encode_jpeg({.width = 21, .height = 18, .components = components, .progressive = progressive}));
  images.emplace_back("jpeg_ycck", encode_jpeg({.components = 4, .ycck = true}));
  images.emplace_back("webp_lossless", test::webp(7, 5, {10, 200, 30, 128}));
  images.emplace_back("webp_lossy", test::encode_lossy_webp(19, 17));
  return images;
}

TEST(ImageDecode, OnlyPngJpegAndWebp) {
  expect_error(test::empty_pnm(), Status::unsupported);
  expect_error(test::empty_tga(), Status::unsupported);
  ImageBytes pnm = test::empty_pnm();
  pnm.resize(pnm.size() + std::size_t{3} * 200 * 200);
  expect_error(pnm, Status::unsupported);
  for (const std::string start : {"GIF89a", "BM", "8BPS", "#?RADIANCE\n", "\x53\x80\xf6\x34"})
    expect_error(ImageBytes(start.begin(), start.end()), Status::unsupported);
}

TEST(ImageDecode, AJpegWithoutAScanEndsEarly) {
  expect_error(test::jpeg_without_scan(), Status::bad_file);
}

TEST(ImageDecode, EveryTruncationIsAnError) {
  for (const auto& [name, file] : good_images()) {
    EXPECT_TRUE(decode(file)) << name << ": " << decode(file).error().message();
    for (std::size_t n = 0; n < file.size(); ++n) {
      const auto image = decode(first(file, n));
      ASSERT_FALSE(image) << name << ": " << n << " of " << file.size();
      ASSERT_EQ(image.error().status, Status::bad_file) << name << ": " << image.error().message();
    }
  }
}

TEST(ImageDecode, AJpegThatEndsEarlyWithAMarkerIsAnErrorToo) {
  for (const bool progressive : {false, true}) {
    const ImageBytes file = encode_jpeg({.width = 64, .height = 64, .progressive = progressive});
    for (std::size_t n = 20; n + 2 < file.size(); ++n) {
      ImageBytes cut = first(file, n);
      cut.insert(cut.end(), {0xff, 0xd9});
      EXPECT_FALSE(decode(cut)) << n << " of " << file.size() << (progressive ? ", progressive" : "");
    }
  }
}

TEST(ImageDecode, SameBytesSamePixelsAndDamageNeverMore) {
  for (const auto& [name, file] : good_images()) {
    for (std::size_t n = 0; n < file.size(); ++n) {
      ImageBytes damaged = file;
      damaged[n] ^= 0x11;
      const auto image = decode(damaged), again = decode(damaged);
      ASSERT_EQ(static_cast<bool>(image), static_cast<bool>(again)) << name << " byte " << n;
      if (!image) continue;
      ASSERT_EQ(image->rgba.size(), std::size_t{4} * image->width * image->height) << name;
      ASSERT_EQ(image->rgba, again->rgba) << name << " byte " << n;
    }
  }
}

TEST(ImageDecode, EveryDamagedByteOfAPngIsAnError) {
  const ImageBytes file = encode_png_form(gradient(8, 6, false));
  for (std::size_t n = 8; n < file.size(); ++n) {
    ImageBytes damaged = file;
    damaged[n] ^= 0x10;
    EXPECT_FALSE(decode(damaged)) << "byte " << n;
  }
}

TEST(ImageDecode, PngFormsGiveTheirPixels) {
  using Bytes = ImageBytes;
  const auto pixels = [](const PngForm& form) { return decoded(encode_png_form(form)).rgba; };
  EXPECT_EQ(pixels({.width = 2, .bit_depth = 8, .color_type = 6, .rows = {1, 2, 3, 4, 5, 6, 7, 8}}), (Bytes{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(pixels({.width = 2, .bit_depth = 8, .color_type = 2, .rows = {1, 2, 3, 4, 5, 6}}), (Bytes{1, 2, 3, 255, 4, 5, 6, 255}));
  EXPECT_EQ(pixels({.width = 2, .bit_depth = 8, .color_type = 2, .transparency = {0, 4, 0, 5, 0, 6}, .rows = {1, 2, 3, 4, 5, 6}}),
            (Bytes{1, 2, 3, 255, 4, 5, 6, 0}));
  EXPECT_EQ(pixels({.width = 2, .bit_depth = 16, .color_type = 4, .rows = {0x12, 0xff, 0x34, 0xff, 0x56, 0, 0x78, 0}}),
            (Bytes{0x12, 0x12, 0x12, 0x34, 0x56, 0x56, 0x56, 0x78}))
      << "the high byte";
  EXPECT_EQ(pixels({.width = 2, .bit_depth = 16, .color_type = 0, .transparency = {9, 8}, .rows = {9, 8, 9, 9}}),
            (Bytes{9, 9, 9, 0, 9, 9, 9, 255}))
      << "transparent is what is equal in both bytes";
  EXPECT_EQ(pixels({.width = 3, .bit_depth = 1, .color_type = 0, .rows = {0b01000000}}),
            (Bytes{0, 0, 0, 255, 255, 255, 255, 255, 0, 0, 0, 255}));
  EXPECT_EQ(pixels({.width = 2, .bit_depth = 4, .color_type = 0, .transparency = {0, 0xf}, .rows = {0x3f}}),
            (Bytes{51, 51, 51, 255, 255, 255, 255, 0}));
  EXPECT_EQ(pixels({.width = 2, .bit_depth = 4, .color_type = 3, .palette = {1, 2, 3, 4, 5, 6}, .transparency = {77}, .rows = {0x01}}),
            (Bytes{1, 2, 3, 77, 4, 5, 6, 255}));
}

TEST(ImageDecode, AnInterlacedPngIsTheSamePicture) {
  for (const auto& [depth, type] : {std::pair{8, 6}, {16, 2}, {1, 0}, {4, 3}})
    EXPECT_EQ(decoded(encode_png_form(gradient(depth, type, true))).rgba, decoded(encode_png_form(gradient(depth, type, false))).rgba);
}

TEST(ImageDecode, AnInflatingPngIsAnErrorAndTakesNoMemory) {
  // 8 MB of pixels behind a header of one pixel.
  const ImageBytes file =
      encode_png_form({.width = 8192, .height = 8192, .bit_depth = 1, .color_type = 0, .rows = ImageBytes(8192 * 1024)});
  expect_error(with_png_chunk(file, "IHDR", 0, {0, 0, 0, 1, 0, 0, 0, 1}), Status::bad_file);
  // One pixel behind a header of 2^26.
  const ImageBytes small = encode_png_form({.bit_depth = 1, .color_type = 0, .rows = {0}});
  expect_error(with_png_chunk(small, "IHDR", 0, {0, 0, 0x20, 0, 0, 0, 0x20, 0}), Status::bad_file);
  expect_error(with_png_chunk(small, "IHDR", 0, {0, 0, 0x40, 1, 0, 0, 0, 1}), Status::unsupported);
}

void expect_near(const Image& image, std::array<int, 4> rgba) {
  ASSERT_FALSE(image.rgba.empty());
  for (std::size_t i = 0; i < image.rgba.size(); ++i) ASSERT_NEAR(image.rgba[i], rgba[i % 4], 4) << i;
}

TEST(ImageDecode, JpegFormsGiveTheirColours) {
  for (const bool progressive : {false, true}) {
    expect_near(decoded(encode_jpeg({.components = 1, .progressive = progressive, .pixel = {90}})), {90, 90, 90, 255});
    expect_near(decoded(encode_jpeg({.progressive = progressive, .pixel = {200, 100, 50}})), {200, 100, 50, 255});
    // Inks: c * k / 255 of what Adobe stores, which is inverted.
    expect_near(decoded(encode_jpeg({.components = 4, .progressive = progressive, .pixel = {200, 100, 50, 128}})), {100, 50, 25, 255});
    expect_near(decoded(encode_jpeg({.components = 4, .progressive = progressive, .ycck = true, .pixel = {200, 100, 50, 128}})),
                {100, 50, 25, 255});
    expect_near(decoded(encode_jpeg({.components = 4, .progressive = progressive, .adobe = false, .pixel = {55, 155, 205, 127}})),
                {100, 50, 25, 255});
  }
}

TEST(ImageDecode, AJpegOfWhichAComponentIsMissingIsAnError) {
  ImageBytes file = encode_jpeg({.width = 8, .height = 8, .components = 1});
  // A frame of three components, of which the scan has the first.
  for (std::size_t at = 2; at + 1 < file.size(); ++at) {
    if (file[at] != 0xff || file[at + 1] != 0xc0) continue;
    const ImageBytes second_and_third{2, 0x11, 0, 3, 0x11, 0};
    file[at + 3] = static_cast<std::uint8_t>(file[at + 3] + second_and_third.size());
    file[at + 9] = 3;
    file.insert(file.begin() + static_cast<std::ptrdiff_t>(at + 13), second_and_third.begin(), second_and_third.end());
    break;
  }
  expect_error(file, Status::bad_file);
}

TEST(ImageDecode, AJpegTooShortForItsHeaderIsAnErrorBeforeItIsDecoded) {
  ImageBytes file = encode_jpeg({.components = 1});
  for (std::size_t at = 2; at + 8 < file.size(); ++at)
    if (file[at] == 0xff && file[at + 1] == 0xc0) {
      file[at + 5] = file[at + 7] = 0x1f;
      break;
    }
  expect_error(file, Status::bad_file);
}

}  // namespace coppice::bake::image_decode_test
