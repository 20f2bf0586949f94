#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace coppice::bake {

/// Says when a cache is no longer asked, so that it never costs more than it may.
class CacheBreaker {
 public:
  /// How bad it is: `grave` stops at once (no connection, no answer, forbidden); of `odd` answers (503, half a body) three in a row do.
  enum class Setback { odd, grave };

  /// job_count  of those that may wait at the same time; >= 1
  explicit CacheBreaker(std::size_t job_count) : job_count_(job_count) {}

  void went_well() { odd_in_a_row_ = 0; }
  /// why  "it answers 503"; the first stays
  void went_wrong(Setback setback, const std::string& why);
  /// Time that jobs waited in vain; summed over the jobs.
  void lost(double seconds);
  /// For how long jobs have been waiting now for the first byte of an answer; summed over the jobs. With what is lost, most of what the
  /// batch may lose opens it: the rest is for its end.
  void waiting(double seconds);

  [[nodiscard]] bool is_open() const { return open_; }
  /// Of the first setback; empty without one.
  [[nodiscard]] const std::string& why() const { return why_; }
  /// Of the batch's wall time, as far as lost() knows.
  [[nodiscard]] double seconds_lost() const;
  /// What may still be lost by the batch, seconds of its wall time: the larger of 2 s and 5 % of its time, less what is.
  [[nodiscard]] double seconds_left() const;

 private:
  [[nodiscard]] double seconds_allowed() const;

  std::size_t job_count_;
  std::size_t odd_in_a_row_ = 0;
  bool open_ = false;
  double lost_s_ = 0.0;  ///< of all jobs
  std::string why_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace coppice::bake
