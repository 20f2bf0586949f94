#pragma once

#include <chrono>
#include <string>

namespace coppice::bake {

/// A progress bar on stderr, one line per stage, with the time that the stage has taken and is likely to take yet; as wide as the terminal
/// allows. Silent when stderr is no terminal.
class ProgressBar {
 public:
  enum class Visibility { on_terminal, never };
  explicit ProgressBar(Visibility visibility);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// note  shown behind the bar, cut to what fits
  void show(const char* stage, double fraction, const std::string& note = {});
  /// Erases the line, so that what is printed next starts clean.
  void clear();

 private:
  bool enabled_;
  std::string stage_;
  std::chrono::steady_clock::time_point stage_start_;
  std::chrono::steady_clock::time_point last_drawn_;
};

}  // namespace coppice::bake
