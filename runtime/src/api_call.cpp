#include "api_call.h"

#include <algorithm>
#include <new>
#include <utility>

#include "api_checks.h"
#include "hooks.h"
#include "printable.h"

namespace coppice {
namespace {

/// The error of calls without a context.
ErrorLine& thread_error() {
  thread_local ErrorLine error;
  return error;
}

coppice_status fail_without_context(const coppice_log& log, const char* function, coppice_status status, const std::string& message) {
  thread_error().set(function, message);
  log_line(log, COPPICE_LOG_ERROR, "%s: %s", function, message.c_str());
  return status;
}

}  // namespace

void ErrorLine::set(const char* function, const std::string& message) {
  const std::string line = printable(std::string(function) + ": " + message);
  std::size_t bytes = std::min(line.size(), kBytes - 1);
  // cuts between whole characters
  while (bytes < line.size() && bytes > 0 && (static_cast<unsigned char>(line[bytes]) & 0xc0u) == 0x80u) --bytes;
  std::copy_n(line.data(), bytes, text_.data());
  text_[bytes] = 0;
}

bool CallGuard::enter(const char* function, Access access) {
  if (!kChecks) return true;
  std::int32_t inside = inside_.load(std::memory_order_relaxed);
  do {
    if (access == Access::exclusive ? inside != 0 : inside < 0) return false;
  } while (!inside_.compare_exchange_weak(inside, access == Access::exclusive ? -1 : inside + 1, std::memory_order_acquire));
  function_ = function;
  thread_ = std::this_thread::get_id();
  return true;
}

void CallGuard::leave(Access access) {
  if (!kChecks) return;
  if (access == Access::exclusive)
    inside_.store(0, std::memory_order_release);
  else
    inside_.fetch_sub(1, std::memory_order_release);
}

std::string CallGuard::conflict() const {
  const std::string function = function_.load();
  if (thread_.load() == std::this_thread::get_id()) return "called from inside " + function + ": a hook may not call back into Coppice";
  return "another thread is inside " + function + " with the same context: calls on one context must follow each other";
}

Call::Call(const coppice_context* context, const char* function, Access access) : context_(context), function_(function), access_(access) {
  if (context == nullptr) {
    thread_error().set(function, "context is null");
    begun_ = COPPICE_ERROR_INVALID_ARGUMENT;
    return;
  }
  if (!context->guard.enter(function, access)) begun_ = refuse(context->guard.conflict());
}

Call::~Call() {
  if (begun_ == COPPICE_OK) context_->guard.leave(access_);
}

coppice_status Call::refuse(const std::string& problem) const {
  return tell(COPPICE_ERROR_INVALID_ARGUMENT, problem);
}

coppice_status Call::tell(coppice_status status, const std::string& message) const {
  log_line(context_->context->log(), COPPICE_LOG_ERROR, "%s: %s", function_, message.c_str());
  const std::lock_guard lock(context_->error_mutex);
  context_->error.set(function_, message);
  return status;
}

coppice_status Call::finish(const Result<void>& result) const {
  return result ? COPPICE_OK : tell(static_cast<coppice_status>(result.error().status), result.error().message());
}

coppice_status Call::logged(const Error& error, const char* subject) const {
  const std::lock_guard lock(context_->error_mutex);
  context_->error.set(function_, (subject != nullptr ? std::string(subject) + ": " : "") + error.message());
  return static_cast<coppice_status>(error.status);
}

coppice_status Call::lost() const {
  return logged({Status::device_lost, "the Vulkan device is lost"});
}

coppice_status finish_open(const Call& call, const char* path, const Result<std::uint64_t>& opened, std::uint64_t* handle) {
  if (!opened) return call.logged(opened.error(), path);
  *handle = *opened;
  return COPPICE_OK;
}

std::string in_struct(const char* name, const std::string& problem) {
  return problem.empty() ? "" : std::string(name) + "." + problem;
}

std::string read_options(const coppice_context_desc* desc, ContextOptions& options) {
  std::string problem = read_struct(desc, "desc", options.desc);
  const std::string log_problem = read_hook(options.desc.log, "desc.log", options.hooks.log);
  const auto check = [&problem](std::string next) {
    if (problem.empty()) problem = std::move(next);
  };
  check(log_problem);
  check(read_hook(options.desc.allocator, "desc.allocator", options.hooks.allocator));
  check(read_hook(options.desc.jobs, "desc.jobs", options.hooks.jobs));
  check(read_hook(options.desc.io, "desc.io", options.hooks.io));
  check(read_hook(options.desc.trace, "desc.trace", options.hooks.trace));
  check(in_struct("desc", desc_problem(options.desc)));
  return problem;
}

coppice_status fail(const ContextOptions& options, const char* function, const Error& error) {
  return fail_without_context(options.hooks.log, function, static_cast<coppice_status>(error.status), error.message());
}

coppice_status refuse(const ContextOptions& options, const char* function, const std::string& problem) {
  return fail_without_context(options.hooks.log, function, COPPICE_ERROR_INVALID_ARGUMENT, problem);
}

coppice_status create_context(const ContextOptions& options, const MakeBackend& make_backend, const char* function,
                              coppice_context** context) {
  auto created = Context::create(options, make_backend);
  if (!created) return fail(options, function, created.error());
  *context = new (std::nothrow) coppice_context{.context = *std::move(created)};
  return *context != nullptr ? COPPICE_OK : fail(options, function, {Status::out_of_memory, "context"});
}

}  // namespace coppice

const char* coppice_last_error(const coppice_context* context) {
  if (context == nullptr) return coppice::thread_error().text();
  // The calling thread's own copy: another thread's call may fail while this one reads.
  thread_local coppice::ErrorLine copy;
  const std::lock_guard lock(context->error_mutex);
  copy = context->error;
  return copy.text();
}
