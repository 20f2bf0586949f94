#pragma once

// The first and last steps of every function of the C API. They find the context, refuse overlapping calls in debug builds, and turn an
// error into a status, a log line and the text of coppice_last_error.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "abi.h"
#include "context.h"
#include "coppice/coppice.h"
#include "result.h"

namespace coppice {

/// Holds the last error of a context or of a thread: a line of at most kBytes - 1 bytes.
class ErrorLine {
 public:
  static constexpr std::size_t kBytes = 1024;
  void set(const char* function, const std::string& message);
  [[nodiscard]] const char* text() const { return text_.data(); }

 private:
  std::array<char, kBytes> text_{};  ///< not a std::string: the destructor of a thread's line would run after the library is unloaded
};

/// Finds forbidden overlaps of calls on one context. Does nothing in release builds.
class CallGuard {
 public:
#if !defined(NDEBUG) || defined(_GLIBCXX_ASSERTIONS)
  static constexpr bool kChecks = true;
#else
  static constexpr bool kChecks = false;
#endif
  enum class Access : std::uint8_t { shared, exclusive };
  /// True if `function` may go on; leave() must follow then. function: static storage
  bool enter(const char* function, Access access);
  void leave(Access access);
  /// Says for a person why enter() has just returned false.
  [[nodiscard]] std::string conflict() const;

 private:
  std::atomic<std::int32_t> inside_{0};    ///< number of calls that share the context; -1: one call has exclusive access
  std::atomic<const char*> function_{""};  ///< the last one that entered
  std::atomic<std::thread::id> thread_{};  ///< the last one that entered
};

}  // namespace coppice

struct coppice_context {
  std::unique_ptr<coppice::Context> context;
  mutable coppice::CallGuard guard;
  mutable std::mutex error_mutex;
  mutable coppice::ErrorLine error;      ///< under error_mutex
  std::vector<coppice_camera> cameras;   ///< those of the last coppice_frame_begin
  std::vector<coppice_eye> second_eyes;  ///< indexed by camera; only cameras with a second eye use theirs
};

namespace coppice {

/// A call of the API on a context, from its first line to its last.
class Call {
 public:
  using Access = CallGuard::Access;
  /// context: may be null. function: its name, in static storage
  Call(const coppice_context* context, const char* function, Access access);
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  /// COPPICE_OK, or the reason why the call may not go on, which has been logged.
  [[nodiscard]] coppice_status begun() const { return begun_; }

  /// Logs a problem of an argument and returns its status. problem: begins with the field's name
  coppice_status refuse(const std::string& problem) const;
  /// Logs the error if there is one, and returns the status.
  coppice_status finish(const Result<void>& result) const;
  /// Keeps an error that is already in the log for coppice_last_error, and returns its status. subject: the file it is about; may be null
  coppice_status logged(const Error& error, const char* subject = nullptr) const;
  /// Returns the status of a lost device, which is already in the log.
  coppice_status lost() const;

 private:
  coppice_status tell(coppice_status status, const std::string& message) const;

  const coppice_context* context_;
  const char* function_;
  Access access_;
  coppice_status begun_ = COPPICE_OK;
};

// The next functions say what is wrong with handles and records; empty if nothing is.

std::string plant_problem(const coppice_context& context, coppice_plant plant);
/// Why the plant cannot be used: it is closed, or it failed to open.
std::string failed_plant_problem(const coppice_context& context, coppice_plant plant);
/// rest: what happens to the other records, for the message. movers: null, or the instances that the records are of, whose records do not
/// matter if they are gone
std::string placements_problem(const coppice_context& context, const gpu::PlacementRecords& records, const char* rest,
                               const coppice_instance* movers = nullptr);
/// name: of the argument
std::string view_problem(const coppice_context& context, coppice_view view, const std::string& name = "view");

/// Ends a call that opens a file and has logged its error already.
coppice_status finish_open(const Call& call, const char* path, const Result<std::uint64_t>& opened, std::uint64_t* handle);

// The next functions are for calls that create contexts.

/// Reads an optional hook; without one `ours` has no functions. Returns what is wrong, or an empty string.
template <class Hook>
std::string read_hook(const Hook* theirs, const char* name, Hook& ours) {
  ours = struct_defaults<Hook>();
  return theirs == nullptr ? "" : read_struct(theirs, name, ours);
}

/// Adds the struct's name to the problem of one of its fields; empty stays empty.
std::string in_struct(const char* name, const std::string& problem);

/// Returns what is wrong with the desc or one of its hooks, or an empty string. options.hooks.log is set as soon as it can be read.
std::string read_options(const coppice_context_desc* desc, ContextOptions& options);

/// Logs the error of a call without a context to the options' log, and returns its status.
coppice_status fail(const ContextOptions& options, const char* function, const Error& error);
coppice_status refuse(const ContextOptions& options, const char* function, const std::string& problem);

/// context: not null. function: the API's name for it
coppice_status create_context(const ContextOptions& options, const MakeBackend& make_backend, const char* function,
                              coppice_context** context);

}  // namespace coppice

/// Begins a call on `context`, for the macros below. access: shared if the context is const, else exclusive
#define COPPICE_BEGIN_CALL(access)                                                 \
  const coppice::Call call(context, __func__, coppice::CallGuard::Access::access); \
  if (call.begun() != COPPICE_OK) return call.begun()

/// Returns the status of a call whose argument has a problem.
#define COPPICE_REFUSE_IF(expression) \
  if (const std::string coppice_problem = (expression); !coppice_problem.empty()) return call.refuse(coppice_problem)
