#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include <coppice/coppice.h>

namespace forest {

/// What the library did when, for chrome://tracing or ui.perfetto.dev. Thread: add from any, the rest from one.
class Trace {
 public:
  /// For coppice_context_desc.trace; this object must outlive the context.
  coppice_trace hook() { return {sizeof(coppice_trace), this, on_span}; }

  /// Chrome's trace event format. Reads overlap each other and are asynchronous events; the rest lies on the thread that did it.
  /// errors  Failure: the file cannot be written
  void write(const std::string& file);

 private:
  struct Span {
    coppice_trace_span span{};
    std::string path, chunk;
    std::uint32_t thread = 0;
  };
  static void on_span(void* user, const coppice_trace_span* span);

  std::mutex mutex_;
  std::vector<Span> spans_;
  std::unordered_map<std::thread::id, std::uint32_t> threads_;  ///< in order of their first span
};

}  // namespace forest
