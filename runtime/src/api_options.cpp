#include "api_options.h"

#include <memory>
#include <new>
#include <utility>

#include "api_checks.h"

namespace coppice {

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
