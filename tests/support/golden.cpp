#include "golden.h"
#include "places.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include <gtest/gtest.h>

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb_image.h>
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>

namespace coppice::test {
namespace {

std::uint32_t pixel_delta(const std::uint8_t* a, const std::uint8_t* b) {
  int delta = 0;
  for (int channel = 0; channel < 4; ++channel) delta = std::max(delta, std::abs(a[channel] - b[channel]));
  return static_cast<std::uint32_t>(delta);
}

bool updating() {
  const char* value = std::getenv("COPPICE_UPDATE_GOLDEN");
  return value != nullptr && std::strcmp(value, "1") == 0;
}

void rewrite(const std::filesystem::path& png, const std::filesystem::path& driver_file, const Picture& picture,
             const std::string& driver) {
  write_png(png, picture);
  std::ofstream file(driver_file);
  file << driver << '\n';
  if (!file.flush()) throw std::runtime_error("cannot write " + driver_file.string());
  std::printf("rewrote %s: look at it before you commit it\n", png.c_str());
}

std::string first_line(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

/// Another make of GPU covers other pixels of a leaf's edge: 0.47 % of them where lavapipe's and NVIDIA's pictures of hazel are compared.
constexpr double kOtherDriverShare = 0.01;
/// A picture shows as much as the golden one, give or take this share: a plant of few pixels must not be missed.
constexpr double kShownTolerance = 0.2;

/// Share of the pixels that differ from the first one, the background.
double shown_share(const Picture& picture) {
  std::size_t shown = 0;
  const std::size_t count = picture.rgba.size() / 4;
  for (std::size_t i = 0; i < count; ++i) shown += pixel_delta(&picture.rgba[0], &picture.rgba[4 * i]) > 0;
  return static_cast<double>(shown) / static_cast<double>(count);
}

/// By the driver's name, whatever its version.
bool is_same_driver(const std::string& a, const std::string& b) {
  return a.substr(0, a.find(' ')) == b.substr(0, b.find(' '));
}

void report_failure(const std::string& name, const PictureDifference& difference, const Picture& picture, const std::string& drivers) {
  const std::filesystem::path folder = std::filesystem::path(kOutputFolder) / "golden";
  std::filesystem::create_directories(folder);
  write_png(folder / (name + ".actual.png"), picture);
  if (difference.same_size) write_png(folder / (name + ".difference.png"), difference.picture);
  ADD_FAILURE() << name << ": " << 100.0 * difference.differing_share << "% of the pixels differ, the largest difference is "
                << difference.largest_delta << " of 255\n"
                << drivers << "\nsee " << (folder / name).string() << ".actual.png and .difference.png";
}

}  // namespace

PictureDifference compare_pictures(const Picture& golden, const Picture& actual, std::uint32_t channel_delta) {
  PictureDifference result;
  result.same_size = golden.width_px == actual.width_px && golden.height_px == actual.height_px;
  if (!result.same_size) {
    result.largest_delta = 255;
    result.differing_share = 1.0;
    return result;
  }
  result.picture = golden;
  const std::size_t pixel_count = std::size_t{golden.width_px} * golden.height_px;
  std::size_t differing = 0;
  for (std::size_t i = 0; i < pixel_count; ++i) {
    const std::uint32_t delta = pixel_delta(&golden.rgba[4 * i], &actual.rgba[4 * i]);
    result.largest_delta = std::max(result.largest_delta, delta);
    std::uint8_t* out = &result.picture.rgba[4 * i];
    const auto grey = static_cast<std::uint8_t>((out[0] + 2 * out[1] + out[2]) / 12);
    out[0] = out[1] = out[2] = grey;
    out[3] = 255;
    if (delta > channel_delta) {
      ++differing;
      out[0] = static_cast<std::uint8_t>(std::min(255u, 127u + delta));
    }
  }
  result.differing_share = pixel_count == 0 ? 0.0 : static_cast<double>(differing) / static_cast<double>(pixel_count);
  return result;
}

bool within(const PictureDifference& difference, const GoldenTolerance& tolerance) {
  return difference.same_size && difference.differing_share <= tolerance.differing_share &&
         difference.largest_delta <= tolerance.largest_delta;
}

Picture read_png(const std::filesystem::path& path) {
  int width = 0, height = 0, channels = 0;
  stbi_uc* pixels = stbi_load(path.c_str(), &width, &height, &channels, 4);
  if (pixels == nullptr) throw std::runtime_error("cannot read " + path.string() + ": " + stbi_failure_reason());
  Picture picture{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
  picture.rgba.assign(pixels, pixels + std::size_t{picture.width_px} * picture.height_px * 4);
  stbi_image_free(pixels);
  return picture;
}

void write_png(const std::filesystem::path& path, const Picture& picture) {
  const auto width = static_cast<int>(picture.width_px);
  if (stbi_write_png(path.c_str(), width, static_cast<int>(picture.height_px), 4, picture.rgba.data(), 4 * width) == 0)
    throw std::runtime_error("cannot write " + path.string());
}

void expect_golden(const std::string& name, const Picture& picture, const GoldenTolerance& tolerance, const std::string& driver) {
  const std::filesystem::path folder = std::filesystem::path(kTestFolder) / "golden";
  const std::filesystem::path png = folder / (name + ".png");
  const std::filesystem::path driver_file = folder / (name + ".driver");
  if (updating()) return rewrite(png, driver_file, picture, driver);
  if (!std::filesystem::exists(png)) {
    ADD_FAILURE() << "no golden image " << png.string() << ": run once with COPPICE_UPDATE_GOLDEN=1 and look at it";
    return;
  }
  const std::string golden_driver = first_line(driver_file);
  ASSERT_FALSE(golden_driver.empty()) << "cannot read " << driver_file;
  const Picture golden = read_png(png);
  GoldenTolerance allowed = tolerance;
  if (!is_same_driver(golden_driver, driver)) allowed.differing_share = std::max(allowed.differing_share, kOtherDriverShare);
  const PictureDifference difference = compare_pictures(golden, picture, allowed.channel_delta);
  EXPECT_NEAR(shown_share(picture), shown_share(golden), kShownTolerance * shown_share(golden)) << name;
  if (!within(difference, allowed))
    report_failure(name, difference, picture, "golden drawn by " + golden_driver + "\nthis one by     " + driver);
}

}  // namespace coppice::test
