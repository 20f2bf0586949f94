#include "progress_bar.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "printable.h"

namespace coppice::bake {
namespace {

constexpr int kBarCells = 40;
constexpr auto kRedrawInterval = std::chrono::milliseconds(50);

/// What the bar leaves of the terminal's line.
int note_columns() {
  constexpr int kBarColumns = 12 + 3 + kBarCells + 1 + 4 + 9 + 2;
  winsize size{};
  const int columns = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
  return std::max(0, columns - kBarColumns);
}

}  // namespace

ProgressBar::ProgressBar(Visibility visibility) : enabled_(visibility == Visibility::on_terminal && isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  clear();
}

void ProgressBar::show(const char* stage, double fraction, const std::string& note) {
  if (!enabled_) return;
  const auto now = std::chrono::steady_clock::now();
  const bool new_stage = stage_ != stage;
  if (!new_stage && fraction < 1.0 && now - last_drawn_ < kRedrawInterval) return;
  if (new_stage) {
    stage_ = stage;
    stage_start_ = now;
  }
  last_drawn_ = now;

  const double clamped = std::clamp(fraction, 0.0, 1.0);
  const int filled = static_cast<int>(clamped * kBarCells);
  const std::string bar =
      std::string(static_cast<std::size_t>(filled), '#') + std::string(static_cast<std::size_t>(kBarCells - filled), '.');
  const double seconds = std::chrono::duration<double>(now - stage_start_).count();
  std::fprintf(stderr, "\r%-12s [%s] %3d%% %6.1f s %.*s\033[K", stage_.c_str(), bar.c_str(), static_cast<int>(clamped * 100.0), seconds,
               note_columns(), printable(note).c_str());
  static_cast<void>(std::fflush(stderr));
}

void ProgressBar::clear() {
  if (!enabled_ || stage_.empty()) return;
  std::fprintf(stderr, "\r\033[K");
  static_cast<void>(std::fflush(stderr));
  stage_.clear();
}

}  // namespace coppice::bake
