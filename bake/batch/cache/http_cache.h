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

/// A process's way to a server, over one connection that is kept from request to request. Once it is_off() it asks no more; count() adds
/// what other processes met. A process may be forked off before the first request.
/// thread  one
class HttpCache : public FailureCount {
 public:
  HttpCache(std::string url, CacheCredentials credentials);
  HttpCache(HttpCache&&) noexcept;
  HttpCache& operator=(HttpCache&&) = delete;
  ~HttpCache();

  /// max_bytes  a larger .coppice file is not read
  /// returns  nothing where the server has no such entry
  /// errors   io: the server cannot be reached, is too slow, or refuses; bad_file: the entry is damaged
  Result<std::optional<CachedBake>> get(const std::string& key, std::uint64_t max_bytes);
  /// Makes or replaces an entry; the record comes last. errors  io, as get
  Result<void> put(const std::string& key, const CachedBake& entry);

 private:
  struct Connection;
  struct Answer {
    long status = 0;
    std::vector<std::uint8_t> body;
  };

  Result<Answer> request(const std::string& file, const std::span<const std::uint8_t>* body, std::uint64_t max_bytes);
  Result<std::optional<std::vector<std::uint8_t>>> get_file(const std::string& file, std::uint64_t max_bytes);
  Result<void> put_file(const std::string& file, std::span<const std::uint8_t> bytes);

  std::string url_;
  CacheCredentials credentials_;
  std::unique_ptr<Connection> connection_;
};

}  // namespace coppice::bake
