#pragma once

// Golden images: a test draws a picture and compares it with a committed PNG. A reviewer must have looked at every PNG.
//
//     expect_golden("corylus_near_cut", picture, {}, gpu().driver_name);
//
// Beside tests/golden/NAME.png lies NAME.driver, the driver that drew it. On failure NAME.actual.png and NAME.difference.png are written to
// the build folder and their paths printed. COPPICE_UPDATE_GOLDEN=1 in the environment rewrites PNG and driver instead of comparing.

#include <cstdint>
#include <filesystem>
#include <string>

#include "picture.h"

namespace coppice::test {

/// A pixel differs when one of its channels is further from the golden's than channel_delta; so many pixels may differ, and none by more
/// than largest_delta. The defaults allow another compiler's rounding of the same driver, and an edge pixel here and there; another driver
/// is allowed 1 % of the pixels. Either shows as many pixels that are not background, within 20 %.
struct GoldenTolerance {
  std::uint32_t channel_delta = 4;  ///< 0..255
  double differing_share = 0.002;   ///< how many of all pixels
  std::uint32_t largest_delta = 255;
};

struct PictureDifference {
  bool same_size = false;
  std::uint32_t largest_delta = 0;  ///< over all pixels and channels
  double differing_share = 0.0;
  Picture picture;  ///< grey: the golden, darkened; red: pixels that differ, brighter for larger differences
};

/// golden, actual  of any size; of different sizes they differ everywhere and there is no difference picture
PictureDifference compare_pictures(const Picture& golden, const Picture& actual, std::uint32_t channel_delta);

bool within(const PictureDifference& difference, const GoldenTolerance& tolerance);

/// Throw std::runtime_error naming the path when it cannot be read or written. PNG of 8-bit RGBA.
Picture read_png(const std::filesystem::path& path);
void write_png(const std::filesystem::path& path, const Picture& picture);

/// Compares with, or rewrites, the golden image `name`: see above. Reports through GoogleTest.
/// driver  VulkanDevice::driver_name of the device that drew the picture
void expect_golden(const std::string& name, const Picture& picture, const GoldenTolerance& tolerance, const std::string& driver);

}  // namespace coppice::test
