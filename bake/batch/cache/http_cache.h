#pragma once

// A cache on a server. It has the files of a cache's folder (bake_cache.h): GET reads them, PUT writes them.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake_cache.h"
#include "cache_location.h"
#include "result.h"

namespace coppice::bake {

/// What a request may cost.
struct RequestLimits {
  std::uint64_t bytes = std::uint64_t{64} << 20;  ///< a larger .coppice file is not read
  double seconds = 10.0;
};

/// A process's way to a server, over one connection that is kept from request to request. Once it is_off() it asks no more; count() adds
/// what other processes met. A process may be forked off before the first request.
/// thread  one
class HttpCache : public FailureCount {
 public:
  /// most_lost_s  what it may cost a batch: lose()
  HttpCache(std::string url, CacheCredentials credentials, double most_lost_s);
  HttpCache(HttpCache&&) noexcept;
  HttpCache& operator=(HttpCache&&) = delete;
  ~HttpCache();
  [[nodiscard]] const std::string& url() const { return url_; }

  /// returns  nothing where the server has no such entry
  /// errors   io: the server cannot be reached, is too slow, or refuses; bad_file: the entry is damaged, or one of another key
  Result<std::optional<CachedBake>> get(const std::string& key, const RequestLimits& limits);
  /// Makes or replaces an entry; the record comes last. errors  io, as get
  Result<void> put(const std::string& key, const CachedBake& entry, const RequestLimits& limits);

 private:
  struct Connection;
  struct Answer {
    long status = 0;
    std::vector<std::uint8_t> body;
  };

  Result<Answer> request(const std::string& file, const std::span<const std::uint8_t>* body, const RequestLimits& limits);
  Result<std::optional<std::vector<std::uint8_t>>> get_file(const std::string& file, const RequestLimits& limits);
  Result<void> put_file(const std::string& file, std::span<const std::uint8_t> bytes, const RequestLimits& limits);

  std::string url_;
  CacheCredentials credentials_;
  std::unique_ptr<Connection> connection_;
};

}  // namespace coppice::bake
