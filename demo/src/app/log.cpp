#include "log.h"

#include <cstdio>
#include <utility>

namespace forest {
namespace {

void on_log(void* user, coppice_log_level level, const char* text) {
  if (level == COPPICE_LOG_INFO) return;
  auto& log = *static_cast<Log*>(user);
  const std::lock_guard lock(log.mutex);
  if (!log.said.insert(text).second) return;
  log.waiting.push_back({level, text});
}

}  // namespace

coppice_log hook_of(Log& log) {
  return {sizeof(coppice_log), &log, on_log};
}

void say_waiting(Log& log) {
  const std::lock_guard lock(log.mutex);
  for (const Log::Line& line : log.waiting) {
    if (line.level == COPPICE_LOG_ERROR) ++log.error_count;
    std::fprintf(stderr, "coppice-forest: %s%s\n", line.level == COPPICE_LOG_WARNING ? "warning: " : "", line.text.c_str());
  }
  log.waiting.clear();
}

std::string take_reason(Log& log) {
  std::string reason;
  {
    const std::lock_guard lock(log.mutex);
    if (!log.waiting.empty() && log.waiting.back().level == COPPICE_LOG_ERROR) {
      reason = std::move(log.waiting.back().text);
      log.waiting.pop_back();
      log.said.erase(reason);  // a later call may fail for it too
    }
  }
  say_waiting(log);
  return reason;
}

}  // namespace forest
