#pragma once

// Every entry and every record of a cache on a server, by the listings of its folders.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "http_transfers.h"
#include "result.h"

namespace coppice::bake {

struct ListedEntry {
  std::string key;
  std::uint64_t bytes = 0;
  std::int64_t modified_s = 0;  ///< since 1970, UTC
};

/// Answers one request. thread  as HttpTransfers
using HttpAsk = std::function<HttpAnswer(HttpRequest)>;

/// In order of the keys. A cache that has nothing yet has none.
/// errors  unsupported: the server gives no listings in JSON; io: it does not answer
Result<std::vector<ListedEntry>> list_cache(const HttpAsk& ask, const std::string& cache_url);

/// The names of records: record_url() makes addresses of them. errors  as list_cache
Result<std::vector<std::string>> list_records(const HttpAsk& ask, const std::string& cache_url);

}  // namespace coppice::bake
