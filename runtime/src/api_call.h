#pragma once

// What every function of the C API does first and last: it finds its context, in debug builds refuses calls that overlap, and turns an
// error into a status, a line of the log and what coppice_last_error returns.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "context.h"
#include "coppice/coppice.h"
#include "result.h"

namespace coppice {

/// The last error of a context, or of a thread: a line of at most kBytes - 1 bytes.
class ErrorLine {
 public:
  static constexpr std::size_t kBytes = 1024;
  void set(const char* function, const std::string& message);
  [[nodiscard]] const char* text() const { return text_.data(); }

 private:
  std::array<char, kBytes> text_{};  ///< no std::string: a thread's needs no destructor, which would outlive a library that is unloaded
};

/// Finds calls on one context that overlap although they may not. Does nothing in release builds.
class CallGuard {
 public:
#if !defined(NDEBUG) || defined(_GLIBCXX_ASSERTIONS)
  static constexpr bool kChecks = true;
#else
  static constexpr bool kChecks = false;
#endif
  enum class Access : std::uint8_t { shared, exclusive };
  /// Whether `function` may go on; leave() must follow then. function: static storage
  bool enter(const char* function, Access access);
  void leave(Access access);
  /// What is in the way where enter() has just returned false, for a person.
  [[nodiscard]] std::string conflict() const;

 private:
  std::atomic<std::int32_t> inside_{0};    ///< calls that share the context; -1: one that has it alone
  std::atomic<const char*> function_{""};  ///< that entered last
  std::atomic<std::thread::id> thread_{};  ///< that entered last
};

}  // namespace coppice

struct coppice_context {
  std::unique_ptr<coppice::Context> context;
  mutable coppice::CallGuard guard;
  mutable std::mutex error_mutex;
  mutable coppice::ErrorLine error;      ///< under error_mutex
  std::vector<coppice_camera> cameras;   ///< of the last coppice_frame_begin
  std::vector<coppice_eye> second_eyes;  ///< by camera, of those that have one
};

namespace coppice {

/// One call of the API on a context, from its first line to its last.
class Call {
 public:
  using Access = CallGuard::Access;
  /// context: may be null. function: its name, static storage
  Call(const coppice_context* context, const char* function, Access access);
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  /// COPPICE_OK, or why the call may not go on, which has been told.
  [[nodiscard]] coppice_status begun() const { return begun_; }

  /// problem: an argument's, named by its field. Tells it.
  coppice_status refuse(const std::string& problem) const;
  /// Tells the error, if it is one.
  coppice_status finish(const Result<void>& result) const;
  /// Of an error that is in the log already, for coppice_last_error. subject: file that it is about; may be null
  coppice_status logged(const Error& error, const char* subject = nullptr) const;
  /// The device is lost. The log has heard when.
  coppice_status lost() const;

 private:
  coppice_status tell(coppice_status status, const std::string& message) const;

  const coppice_context* context_;
  const char* function_;
  Access access_;
  coppice_status begun_ = COPPICE_OK;
};

// What is wrong with handles and records; empty: nothing.

std::string plant_problem(const coppice_context& context, coppice_plant plant);
/// Of one that a call needs more of than its handle.
std::string failed_plant_problem(const coppice_context& context, coppice_plant plant);
/// rest: what becomes of the others, for the message
std::string placements_problem(const coppice_context& context, const gpu::PlacementRecords& records, const char* rest);
/// name: of the argument
std::string view_problem(const coppice_context& context, coppice_view view, const std::string& name = "view");

/// Of what opens a file, and has logged its error.
coppice_status finish_open(const Call& call, const char* path, const Result<std::uint64_t>& opened, std::uint64_t* handle);

/// An error of a call that has no context yet. log: may be without a function
coppice_status fail_without_context(const coppice_log& log, const char* function, coppice_status status, const std::string& message);

}  // namespace coppice

/// Begins a call on `context`, which the macros below go on with. access: shared where the context is const, else exclusive
#define COPPICE_BEGIN_CALL(access)                                                 \
  const coppice::Call call(context, __func__, coppice::CallGuard::Access::access); \
  if (call.begun() != COPPICE_OK) return call.begun()

/// Returns the status of a call whose argument has a problem.
#define COPPICE_REFUSE_IF(expression) \
  if (const std::string coppice_problem = (expression); !coppice_problem.empty()) return call.refuse(coppice_problem)
