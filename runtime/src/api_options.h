#pragma once

// What the functions that create contexts have in common.

#include <string>

#include "abi.h"
#include "api_call.h"
#include "context.h"

namespace coppice {

/// A hook that may be left out: `ours` is without functions then. Returns what is wrong, or an empty string.
template <class Hook>
std::string read_hook(const Hook* theirs, const char* name, Hook& ours) {
  ours = struct_defaults<Hook>();
  return theirs == nullptr ? "" : read_struct(theirs, name, ours);
}

/// A problem of a field of `name`; empty: none.
std::string in_struct(const char* name, const std::string& problem);

/// Returns what is wrong with the desc or one of its hooks, or an empty string. options.hooks.log is set as soon as it can be read.
std::string read_options(const coppice_context_desc* desc, ContextOptions& options);

/// The status of a call that has no context, told to the log of the options.
coppice_status fail(const ContextOptions& options, const char* function, const Error& error);
coppice_status refuse(const ContextOptions& options, const char* function, const std::string& problem);

/// context: not null. function: of the API
coppice_status create_context(const ContextOptions& options, const MakeBackend& make_backend, const char* function,
                              coppice_context** context);

}  // namespace coppice
