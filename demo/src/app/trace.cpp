#include "trace.h"

#include <array>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "output.h"

namespace forest {
namespace {

constexpr std::array kKindNames = {
    "read", "decode", "upload", "coppice_frame_begin", "coppice_record_upload", "coppice_record_cull", "coppice_record_draw"};

// A path's bytes need not be UTF-8.
constexpr auto kReplaceBytes = nlohmann::ordered_json::error_handler_t::replace;

double microseconds(std::uint64_t ns) {
  return 1e-3 * static_cast<double>(ns);
}

}  // namespace

void Trace::on_span(void* user, const coppice_trace_span* span) {
  auto& trace = *static_cast<Trace*>(user);
  const std::lock_guard lock(trace.mutex_);
  const auto thread = trace.threads_.try_emplace(std::this_thread::get_id(), static_cast<std::uint32_t>(trace.threads_.size() + 1));
  trace.spans_.push_back({*span, span->path != nullptr ? span->path : "", span->chunk != nullptr ? span->chunk : "", thread.first->second});
}

void Trace::write(const std::string& file) {
  const std::lock_guard lock(mutex_);
  auto events = nlohmann::ordered_json::array();
  std::uint64_t id = 0;
  for (const Span& recorded : spans_) {
    const coppice_trace_span& span = recorded.span;
    nlohmann::ordered_json event;
    const char* kind = kKindNames.at(static_cast<std::size_t>(span.kind));
    event["name"] = recorded.chunk.empty() ? std::string(kind) : std::string(kind) + " " + recorded.chunk;
    event["cat"] = kind;
    event["pid"] = 1;
    event["tid"] = recorded.thread;
    event["ts"] = microseconds(span.start_ns);
    if (!recorded.chunk.empty())
      event["args"] = {{"plant", std::filesystem::path(recorded.path).stem().string()}, {"index", span.index}, {"bytes", span.bytes}};
    if (span.kind != COPPICE_TRACE_READ) {
      event["ph"] = "X";
      event["dur"] = microseconds(span.end_ns - span.start_ns);
      events.push_back(event);
      continue;
    }
    event["ph"] = "b";
    event["id"] = ++id;
    events.push_back(event);
    event["ph"] = "e";
    event["ts"] = microseconds(span.end_ns);
    events.push_back(event);
  }
  write_output(
      file,
      nlohmann::ordered_json{{"displayTimeUnit", "ms"}, {"traceEvents", std::move(events)}}.dump(-1, ' ', false, kReplaceBytes) + '\n');
}

}  // namespace forest
