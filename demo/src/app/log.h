#pragma once

#include <coppice/coppice.h>

#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace forest {

/// What Coppice logs, from any thread, until the main thread prints it: each line once, however often it comes.
struct Log {
  struct Line {
    coppice_log_level level;
    std::string text;
  };

  std::mutex mutex;
  std::vector<Line> waiting;   ///< in the order in which they came
  std::set<std::string> said;  ///< every line that was printed
  std::uint32_t error_count = 0;
};

/// For coppice_context_desc. `log` must outlive the context.
coppice_log hook_of(Log& log);

/// Prints what is waiting to stderr. Main thread.
void say_waiting(Log& log);

/// Takes the newest error line that was not printed yet, which is the reason why a call has just failed; prints what came before it.
/// Empty: there is none.
std::string take_reason(Log& log);

}  // namespace forest
