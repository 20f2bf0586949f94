#pragma once

// The engine's hooks inside the runtime, memory from the allocator hook, and defaults for hooks that an engine leaves out.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "coppice/coppice.h"
#include "job_order.h"
#include "result.h"
#include "thread_pool.h"
#include "uring_io.h"

namespace coppice {

/// Complete hooks: every function pointer is set but log.write, trace.span and io.cancel.
struct Hooks {
  coppice_allocator allocator{};
  coppice_jobs jobs{};
  coppice_io io{};
  coppice_log log{};
  coppice_trace trace{};
};

/// The objects behind the default jobs and io hooks.
struct DefaultHooks {
  coppice_allocator allocator{};
  std::unique_ptr<ThreadPool> pool;  ///< null if the jobs hook is the engine's and the kernel reads
  std::unique_ptr<UringIo> uring;    ///< null if the io hook is the engine's or the pool reads
};

/// Says who reads files if the engine gives no io hook.
enum class Reading : std::uint8_t { automatic, thread_pool };  ///< automatic: io_uring if the kernel has it

/// Hooks with defaults filled in: malloc, a thread pool of the context's own for jobs, io_uring for files (or pread on that pool if the
/// kernel has none). Jobs go through a JobOrder. log and trace stay as they are.
struct HookSet {
  Hooks hooks;
  bool real_files = false;                 ///< the io hook is ours, so paths are the file system's
  std::unique_ptr<JobOrder> order;         ///< behind hooks.jobs
  std::unique_ptr<DefaultHooks> defaults;  ///< null if the engine has set its own jobs and io. Must outlive every use of `hooks`
};

/// Returns a hook that uses malloc.
coppice_allocator default_allocator();

/// errors  invalid_argument: an incomplete hook
Result<void> check_hooks(const Hooks& given);

/// Fills in defaults. A hook counts as given if all its function pointers are set; an incomplete one is an error.
/// errors  invalid_argument: an incomplete hook; out_of_memory: no thread can be started, with the system's reason
Result<HookSet> complete_hooks(const Hooks& given, Reading reading = Reading::automatic);

/// Reads a monotonic clock, ns since some moment. Any thread.
std::uint64_t now_ns();

/// Returns the time if there is a trace hook, else 0.
inline std::uint64_t trace_start(const coppice_trace& trace) {
  return trace.span != nullptr ? now_ns() : 0;
}

/// Ends a span that trace_start began if there is a trace hook. span: without its size and end
inline void trace_end(const coppice_trace& trace, coppice_trace_span span) {
  if (trace.span == nullptr) return;
  span.struct_size = sizeof span;
  span.end_ns = now_ns();
  trace.span(trace.user, &span);
}

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

/// Writes one line to the log hook, if there is one. The line passes through printable(), because paths come from files. Any thread.
void log_line(const coppice_log& log, coppice_log_level level, const char* format, ...) __attribute__((format(printf, 3, 4)));

/// An array from the allocator hook, whose length may come from a file: allocation fails with a status instead of aborting.
/// Elements start value-initialised.
template <class T>
class HookArray {
 public:
  HookArray() = default;
  HookArray(HookArray&& other) noexcept
      : allocator_(other.allocator_), data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  HookArray& operator=(HookArray&& other) noexcept {
    HookArray moved(std::move(other));
    std::swap(allocator_, moved.allocator_);
    std::swap(data_, moved.data_);
    std::swap(size_, moved.size_);
    return *this;
  }
  ~HookArray() { reset(); }

  /// Allocates `count` elements; 0 gives an empty array without a call to the hook.
  /// errors  out_of_memory: the hook returned null, or the size in bytes does not fit size_t
  static Result<HookArray> allocate(const coppice_allocator& allocator, std::size_t count) {
    Result<HookArray> array = allocate_for_overwrite(allocator, count);
    if (array) std::uninitialized_value_construct_n(array->data_, count);
    return array;
  }
  /// The same without values: whoever fills it also takes the page faults of a large array, which may be a job or the kernel.
  static Result<HookArray> allocate_for_overwrite(const coppice_allocator& allocator, std::size_t count) {
    HookArray array;
    array.allocator_ = allocator;
    if (count == 0) return array;
    if (count > SIZE_MAX / kElementBytes) return Error{Status::out_of_memory, "array too large"};
    array.data_ = static_cast<T*>(allocator.allocate(allocator.user, count * kElementBytes, alignof(T)));
    if (array.data_ == nullptr) return Error{Status::out_of_memory, "the allocator hook returned null"};
    array.size_ = count;
    return array;
  }

  void reset() {
    if (data_ != nullptr) {
      std::destroy_n(data_, size_);
      allocator_.free(allocator_.user, data_, size_ * kElementBytes);
    }
    data_ = nullptr;
    size_ = 0;
  }

  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t bytes() const { return size_ * kElementBytes; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  const T& back() const { return span().back(); }
  [[nodiscard]] std::span<T> span() { return {data_, size_}; }
  [[nodiscard]] std::span<const T> span() const { return {data_, size_}; }
  T& operator[](std::size_t i) { return span()[i]; }
  const T& operator[](std::size_t i) const { return span()[i]; }

 private:
  static constexpr std::size_t kElementBytes = sizeof(T);  // NOLINT(bugprone-sizeof-expression): T may be a pointer

  coppice_allocator allocator_{};
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Replaces the array. errors  as HookArray::allocate; the array stays as it is
template <class T>
Result<void> allocate_into(HookArray<T>& array, const coppice_allocator& allocator, std::size_t count) {
  return move_into(array, HookArray<T>::allocate(allocator, count));
}

/// Returns a copy with `count` elements, which must not be fewer. errors  as HookArray::allocate
template <class T>
Result<HookArray<T>> enlarged_copy(const HookArray<T>& array, const coppice_allocator& allocator, std::size_t count) {
  COPPICE_TRY(larger, HookArray<T>::allocate(allocator, count));
  std::ranges::copy(array.span(), larger.data());
  return larger;
}

/// Returns a copy of the text with a zero behind it. errors  as HookArray::allocate
Result<HookArray<char>> copied_text(std::string_view text, const coppice_allocator& allocator);

/// Arguments of roomy_count.
struct Growth {
  std::uint32_t now = 0, needed = 0;
  std::uint32_t first = 0;    ///< the first capacity
  std::uint32_t maximum = 0;  ///< maximum; >= needed
  std::uint32_t step = 1;     ///< the result is a multiple of it, or the maximum
};
/// Returns one and a half times the present capacity, or `needed` if that is more. Adding n elements one by one then copies 3 n at most.
constexpr std::uint32_t roomy_count(const Growth& growth) {
  if (growth.needed <= growth.now) return growth.now;
  const std::uint64_t target = std::max<std::uint64_t>({growth.needed, growth.now + std::uint64_t{growth.now} / 2, growth.first});
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(growth.maximum, (target + growth.step - 1) / growth.step * growth.step));
}

/// Bytes from the allocator hook.
using HookBuffer = HookArray<std::uint8_t>;

}  // namespace coppice
