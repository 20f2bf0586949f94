#pragma once

#include <functional>
#include <string>
#include <vector>

namespace forest {

/// How a process ended, and what it wrote.
struct ChildEnd {
  bool in_time = false;  ///< else it was killed
  int exit_code = -1;    ///< -1: it was killed, or a signal ended it
  int signal = 0;        ///< that signal, unless it was killed
  double seconds = 0;
  std::string out, err;
};

/// Runs this program again and waits for its end. One that is not dead a second after it was killed, because its driver holds it, is left.
/// waiting  called several times a second with the seconds so far; may be empty
/// errors  Failure: it cannot be started
ChildEnd run_self(const std::vector<std::string>& arguments, double limit_s, const std::function<void(double)>& waiting);

}  // namespace forest
