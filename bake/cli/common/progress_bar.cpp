#include "progress_bar.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>

#include "printable.h"

namespace coppice::bake {
namespace {

constexpr int kMostCells = 40, kLeastCells = 8, kMostNoteColumns = 40;  // a note gets so many before the bar does
constexpr auto kRedrawInterval = std::chrono::milliseconds(50);
/// Stage, percent, seconds and what is left take so many columns beside the bar.
constexpr int kTextColumns = 12 + 2 + 2 + 4 + 9 + 15;

int terminal_columns() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

/// What is left of a stage if it goes on as it went; nothing while there is little to go by.
std::string left_text(double seconds, double fraction) {
  constexpr double kLeastFraction = 0.002, kLeastSeconds = 0.2;
  if (fraction < kLeastFraction || fraction >= 1.0 || seconds < kLeastSeconds) return {};
  const double left = seconds * (1.0 - fraction) / fraction;
  std::array<char, 32> text{};
  if (left < 99.5)
    std::snprintf(text.data(), text.size(), ", %.0f s left", left);
  else
    std::snprintf(text.data(), text.size(), ", %.0f min left", left / 60.0);
  return text.data();
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
  const int noted = std::min(static_cast<int>(note.size()), kMostNoteColumns);
  const int columns = terminal_columns(), cells = std::clamp(columns - kTextColumns - noted, kLeastCells, kMostCells);
  const int filled = static_cast<int>(clamped * cells);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') + std::string(static_cast<std::size_t>(cells - filled), '.');
  const double seconds = std::chrono::duration<double>(now - stage_start_).count();
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), "%-12s [%s] %3d%% %6.1f s%s", stage_.c_str(), bar.c_str(), static_cast<int>(clamped * 100.0),
                seconds, left_text(seconds, clamped).c_str());
  // A line that wraps is not erased by going back to its start.
  const int note_columns = std::max(0, columns - 2 - static_cast<int>(std::strlen(line.data())));
  std::fprintf(stderr, "\r%.*s %.*s\033[K", columns - 1, line.data(), note_columns, printable(note).c_str());
  static_cast<void>(std::fflush(stderr));
}

void ProgressBar::clear() {
  if (!enabled_ || stage_.empty()) return;
  std::fprintf(stderr, "\r\033[K");
  static_cast<void>(std::fflush(stderr));
  stage_.clear();
}

}  // namespace coppice::bake
