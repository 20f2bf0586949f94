#include "cache_breaker.h"

#include <algorithm>

namespace coppice::bake {

void CacheBreaker::went_wrong(Setback setback, const std::string& why) {
  constexpr std::size_t kMostOdd = 3;
  if (why_.empty()) why_ = why;
  if (setback == Setback::grave || ++odd_in_a_row_ >= kMostOdd) open_ = true;
}

void CacheBreaker::lost(double seconds) {
  lost_s_ += seconds;
  waiting(0.0);
}

void CacheBreaker::waiting(double seconds) {
  constexpr double kMost = 0.75;
  const double waited_s = seconds_lost() + seconds / static_cast<double>(job_count_);
  if (!open_ && waited_s > kMost * seconds_allowed()) went_wrong(Setback::grave, "it is slow: its answers cost more time than they save");
}

double CacheBreaker::seconds_lost() const {
  return lost_s_ / static_cast<double>(job_count_);
}

double CacheBreaker::seconds_allowed() const {
  constexpr double kLeast_s = 2.0, kShare = 0.05;
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  return std::max(kLeast_s, kShare * elapsed_s);
}

double CacheBreaker::seconds_left() const {
  return seconds_allowed() - seconds_lost();
}

}  // namespace coppice::bake
