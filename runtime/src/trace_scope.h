#pragma once

#include <cstdint>

#include "hooks.h"

namespace coppice {

/// Reports a call to the trace hook, from its construction to its destruction.
class TraceScope {
 public:
  TraceScope(const coppice_trace& trace, coppice_trace_kind kind) : trace_(trace), kind_(kind), start_ns_(trace_start(trace)) {}
  TraceScope(const TraceScope&) = delete;
  TraceScope& operator=(const TraceScope&) = delete;
  ~TraceScope() { trace_end(trace_, {0, kind_, nullptr, nullptr, 0, 0, start_ns_, 0}); }

 private:
  const coppice_trace& trace_;
  coppice_trace_kind kind_;
  std::uint64_t start_ns_;
};

}  // namespace coppice
