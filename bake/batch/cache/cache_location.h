#pragma once

// The place of a shared cache, the credentials for it, and when to stop using it.

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>

#include "result.h"

namespace coppice::bake {

/// The cache of an output folder, in it, and the runs of its batches on a cluster (cluster_batch.h).
inline constexpr const char *kOwnCache = ".coppice-cache", *kOwnClusterRuns = ".coppice-cluster";

/// The environment variable that names a shared cache where --cache does not.
inline constexpr const char* kCacheVariable = "COPPICE_CACHE";

enum class CacheMode { read, read_write };

/// Counts what a cache costs. After three failures in a row, or once it has taken more time than it may, it is used no more.
class FailureCount {
 public:
  FailureCount() = default;
  explicit FailureCount(double most_lost_s) : left_s_(most_lost_s) {}
  void count(bool failed) { in_a_row_ = failed ? in_a_row_ + 1 : 0; }
  /// Takes note of time for which nothing was had.
  void lose(double seconds) { left_s_ -= seconds; }
  [[nodiscard]] bool is_off() const { return in_a_row_ >= 3 || left_s_ < 0.0; }

 private:
  std::uint32_t in_a_row_ = 0;
  double left_s_ = std::numeric_limits<double>::infinity();
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
