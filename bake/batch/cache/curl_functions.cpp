#include "curl_functions.h"

#include <dlfcn.h>

namespace coppice::bake {
namespace {

Error missing() {
  const char* const reason = ::dlerror();
  return Error{Status::unsupported, "a cache on a server needs libcurl (Debian: apt-get install libcurl4), which cannot be loaded",
               Error::kNoOffset, reason != nullptr ? reason : ""};
}

Result<CurlFunctions> load() {
  void* const library = ::dlopen("libcurl.so.4", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return missing();
  CurlFunctions curl;
#define COPPICE_LOAD(name)                                                            \
  curl.name = reinterpret_cast<decltype(curl.name)>(::dlsym(library, "curl_" #name)); \
  if (curl.name == nullptr) return missing();
  COPPICE_CURL_FUNCTIONS(COPPICE_LOAD)
#undef COPPICE_LOAD
  return curl;
}

}  // namespace

Result<const CurlFunctions*> load_curl() {
  static const Result<CurlFunctions> loaded = load();
  if (!loaded) return loaded.error();
  return &*loaded;
}

}  // namespace coppice::bake
