#pragma once

// Shared by the functions that create contexts.

#include <string>

#include "abi.h"
#include "api_call.h"
#include "context.h"

namespace coppice {

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
