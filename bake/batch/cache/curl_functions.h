#pragma once

// libcurl, loaded by whoever names a server: it brings thirty libraries, which every other command of coppice would wait for.

#include <curl/curl.h>

#include "result.h"

namespace coppice::bake {

#define COPPICE_CURL_FUNCTIONS(f)                                                                                                          \
  f(easy_cleanup) f(easy_getinfo) f(easy_init) f(easy_setopt) f(easy_strerror) f(free) f(global_init) f(multi_add_handle) f(multi_cleanup) \
      f(multi_info_read) f(multi_init) f(multi_perform) f(multi_poll) f(multi_remove_handle) f(multi_setopt) f(slist_append)               \
          f(slist_free_all) f(url) f(url_cleanup) f(url_get) f(url_set)

/// Its functions, without their prefix.
struct CurlFunctions {
#define COPPICE_DECLARE(name) decltype(&::curl_##name) name = nullptr;
  COPPICE_CURL_FUNCTIONS(COPPICE_DECLARE)
#undef COPPICE_DECLARE
};

/// Loads it at the first call, for the rest of the process and those that are forked off it.
/// errors  unsupported: it is not installed, with the package's name and the system's reason
Result<const CurlFunctions*> load_curl();

}  // namespace coppice::bake
