// coppice-forest in a window, of an X server without a screen: what keys and sizes do, and where the overlay is. Needs Xvfb and xdotool.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "baked_corylus.h"
#include "golden.h"
#include "tool.h"

namespace coppice::test::window_test {

namespace fs = std::filesystem;

constexpr std::uint32_t kScreenWidth = 1000, kScreenHeight = 800;

/// Frames that differ by the overlay alone, however long the plant takes to stream: the camera looks at the sky,
/// whose clouds drift slowly.
const Words kStill{"--no-taa", "--no-shadows", "--render-scale", "1", "--frame-ms", "0"};
constexpr const char* kSky = "0 0 1.7 20 180 50\n";

void wait_half_a_second() {
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
}

/// A picture whose file is whole.
std::unique_ptr<Picture> picture_in(const fs::path& file) {
  try {
    return std::make_unique<Picture>(read_png(file));
  } catch (const std::exception&) {
    return nullptr;
  }
}

std::size_t files_in(const fs::path& folder) {
  std::error_code absent;
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder, absent), fs::directory_iterator()));
}

/// Pixels of `shown` that the overlay has made otherwise than in `plain`.
struct Overlaid {
  double share = 0;  ///< how much of the picture they are
  std::uint32_t left = ~0u, top = ~0u, right = 0, bottom = 0;
};

Overlaid overlaid(const Picture& plain, const Picture& shown) {
  constexpr int kDifference = 40;
  Overlaid found;
  if (plain.rgba.size() != shown.rgba.size()) return found;
  for (std::uint32_t i = 0; i < plain.width_px * plain.height_px; ++i) {
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(plain.rgba[4 * i + c] - shown.rgba[4 * i + c]));
    if (most < kDifference) continue;
    found.share += 1.0 / (plain.width_px * plain.height_px);
    found.left = std::min(found.left, i % plain.width_px);
    found.right = std::max(found.right, i % plain.width_px);
    found.top = std::min(found.top, i / plain.width_px);
    found.bottom = std::max(found.bottom, i / plain.width_px);
  }
  return found;
}

/// The demo in a window of an X server of its own.
class ForestWindow : public testing::Test {
 protected:
  void SetUp() override {
    if (program_on_path("Xvfb").empty() || program_on_path("xdotool").empty())
      GTEST_SKIP() << "Xvfb or xdotool is not installed (Debian: xvfb, xdotool): no window is opened";
    plant_ = bake_corylus(folder_);
    server_ = std::make_unique<BackgroundProcess>(program_on_path("Xvfb"),
                                                  Words{"-displayfd", "1", "-nolisten", "tcp", "-screen", "0",
                                                        std::to_string(kScreenWidth) + "x" + std::to_string(kScreenHeight) + "x24"});
    ASSERT_TRUE(comes_true([&] { return server_->out().ends_with("\n"); })) << server_->err();
    options_.environment = {"DISPLAY=:" + server_->out().substr(0, server_->out().size() - 1), "WAYLAND_DISPLAY="};
  }

  void open(const std::string& size, const Words& more = {}) {
    const fs::path camera = folder_ / "sky.txt";
    write_text(camera, kSky);
    const Words arguments{plant_, "--size", size, "--camera", camera, "--record", frames(), "--screenshot", saved()};
    forest_ = std::make_unique<BackgroundProcess>(kForest, joined(arguments, more), options_);
    ASSERT_TRUE(comes_true([&] { return files_in(frames()) > 0; })) << forest_->out() << forest_->err();
    window_ = xdo({"search", "--sync", "--name", "Coppice forest"});
    window_ = window_.substr(0, window_.find('\n'));
    xdo({"windowfocus", "--sync", window_});
  }

  std::string xdo(const Words& arguments) {
    const auto result = run_process(program_on_path("xdotool"), arguments, options_);
    EXPECT_EQ(result.exit_code, 0) << arguments.front() << ": " << result.err;
    return result.out;
  }

  void press(const std::string& key) {
    xdo({"key", key});
    wait_for_frames(5);  // a panel is laid out in its first frame and drawn in the next
  }

  void wait_for_frames(std::size_t count) {
    const std::size_t before = files_in(frames());
    EXPECT_TRUE(comes_true([&] { return files_in(frames()) > before + count; })) << forest_->err();
  }

  /// The window as it is, with the overlay.
  Picture shown() {
    const std::size_t count = files_in(frames());  // the last one may not be whole
    char name[16];
    std::snprintf(name, sizeof name, "%05zu.png", count - 2);
    return read_png(frames() / name);
  }

  /// Key P: without the overlay.
  Picture picture() {
    fs::remove(saved());
    xdo({"key", "p"});
    std::unique_ptr<Picture> picture;
    EXPECT_TRUE(comes_true([&] { return (picture = picture_in(saved())) != nullptr; })) << forest_->err();
    return picture ? *picture : Picture{};
  }

  bool shows_size(std::uint32_t width, std::uint32_t height) {
    return comes_true([&] {
      const Picture now = shown();
      return now.width_px == width && now.height_px == height;
    });
  }

  /// Escape; a picture of the last frame is saved before it ends.
  void close() {
    xdo({"key", "Escape"});
    EXPECT_EQ(forest_->wait(), 0) << forest_->err();
  }

  [[nodiscard]] fs::path frames() const { return folder_ / "frames"; }
  [[nodiscard]] fs::path saved() const { return folder_ / "saved.png"; }

  TemporaryFolder folder_;
  fs::path plant_;
  ProcessOptions options_;
  std::unique_ptr<BackgroundProcess> server_, forest_;
  std::string window_;
};

TEST_F(ForestWindow, FollowsItsSizeAndFillsTheScreen) {
  const fs::path statistics = folder_ / "statistics.json";
  open("360x240", {"--validation", "--stats", statistics});
  EXPECT_EQ(picture().width_px, 360u);
  xdo({"windowsize", "--sync", window_, "300", "200"});
  EXPECT_TRUE(shows_size(300, 200)) << shown().width_px << " x " << shown().height_px;
  const Picture smaller = picture();
  EXPECT_EQ(smaller.width_px, 300u);
  EXPECT_EQ(smaller.height_px, 200u);
  press("F11");
  EXPECT_TRUE(shows_size(kScreenWidth, kScreenHeight)) << shown().width_px << " x " << shown().height_px;
  press("F11");
  EXPECT_TRUE(shows_size(300, 200)) << shown().width_px << " x " << shown().height_px;
  close();
  EXPECT_EQ(read_json(statistics)["validation_messages"], 0) << forest_->out() << forest_->err();
}

TEST_F(ForestWindow, TheOverlayIsALineUnlessMoreIsAskedForAndStaysInside) {
  open("480x360", kStill);
  const Picture plain = picture();
  const auto now = [&] { return overlaid(plain, shown()); };
  wait_for_frames(5);
  Overlaid line;
  EXPECT_TRUE(comes_true([&] { return (line = now()).bottom < plain.height_px / 4; })) << "once what P said has gone";
  EXPECT_GT(line.share, 0.005);
  EXPECT_LT(line.share, 0.1);
  press("h");
  const Overlaid help = now();
  EXPECT_GT(help.share, 2 * line.share);
  press("h");
  press("Tab");
  const Overlaid all = now();
  EXPECT_GT(all.share, 0.3);
  for (const Overlaid& panel : {line, help, all}) {
    EXPECT_GE(panel.left, 4u);
    EXPECT_GE(panel.top, 4u);
    EXPECT_LT(panel.right, plain.width_px - 4);
    EXPECT_LT(panel.bottom, plain.height_px - 4);
  }
  press("Tab");
  EXPECT_LT(now().share, 0.002) << "nothing";
}

TEST_F(ForestWindow, SaysWhereAPictureWentAndPicturesHaveNoOverlay) {
  open("480x360", kStill);
  press("Tab");
  press("Tab");
  const Picture plain = picture();
  ASSERT_TRUE(comes_true([&] { return forest_->out().find(saved().string()) != std::string::npos; })) << forest_->out();
  wait_for_frames(2);
  const Overlaid message = overlaid(plain, shown());
  EXPECT_GT(message.share, 0.002) << "in the window too";
  EXPECT_GT(message.top, plain.height_px / 2);
  press("Tab");
  EXPECT_LT(overlaid(plain, picture()).share, 0.002);
}

TEST_F(ForestWindow, DrawsNothingWhileItIsHidden) {
  open("160x120");
  xdo({"windowunmap", "--sync", window_});
  wait_half_a_second();
  const std::size_t before = files_in(frames());
  wait_half_a_second();
  wait_half_a_second();
  EXPECT_EQ(files_in(frames()), before);
  xdo({"windowmap", "--sync", window_});
  wait_for_frames(3);
}

}  // namespace coppice::test::window_test
