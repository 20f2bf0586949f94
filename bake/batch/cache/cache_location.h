#pragma once

// The place of a shared cache, the credentials for it, and when to stop using it.

#include <cstdint>
#include <filesystem>
#include <string>

#include "result.h"

namespace coppice::bake {

/// The cache of an output folder, in it.
inline constexpr const char* kOwnCache = ".coppice-cache";

/// The environment variable that names a shared cache where --cache does not.
inline constexpr const char* kCacheVariable = "COPPICE_CACHE";

enum class CacheMode { read, read_write };

/// Counts the failures of a cache in a row. After three of them it is used no more.
class FailureCount {
 public:
  void count(bool failed) { in_a_row_ = failed ? in_a_row_ + 1 : 0; }
  [[nodiscard]] bool is_off() const { return in_a_row_ >= 3; }

 private:
  std::uint32_t in_a_row_ = 0;
};

/// A folder or an address, one of the two.
struct CacheLocation {
  std::filesystem::path folder;
  std::string url;  ///< http or https, without user, query, fragment and a slash at its end: it may be printed
};

/// Tells an address from a folder by "://".
/// errors  invalid_argument: empty; an address of another protocol, one that is none, or one with a user, a password, a query or a
///         fragment. The message has none of these.
Result<CacheLocation> parse_cache_location(const std::string& text);

/// The environment variable that has credentials: "USER:PASSWORD", or "Bearer TOKEN".
inline constexpr const char* kCredentialsVariable = "COPPICE_CACHE_CREDENTIALS";

/// Not to be printed. All empty: those of ~/.netrc for the host, if there are any.
struct CacheCredentials {
  std::string user, password, token;
};

/// Those of the environment.
/// errors  invalid_argument: the variable is set and of neither form; the message has nothing of it
Result<CacheCredentials> credentials_of_environment();

}  // namespace coppice::bake
