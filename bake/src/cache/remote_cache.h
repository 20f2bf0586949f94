#pragma once

// A cache on a server, behind the folder of a batch: what is fetched, what is sent, and when it is no longer asked.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "cache_breaker.h"
#include "cache_index.h"
#include "cache_location.h"
#include "http_transfers.h"

namespace coppice::bake {

struct RemoteCacheOptions {
  std::string url;
  CacheCredentials credentials;
  CacheMode mode = CacheMode::read_write;
  std::filesystem::path folder;  ///< where entries that are offered are read
  std::size_t job_count = 1;     ///< that may wait for it at the same time
  bool only_indexed = false;     ///< entries that the index lacks are not asked for
};

/// What a cache did for a batch, and what was lost by it.
struct CacheReport {
  std::string where;                     ///< folder or address; empty: there was none
  std::uint64_t found = 0, lacking = 0;  ///< entries that were asked for
  std::uint64_t sent = 0;                ///< that it got
  std::uint64_t requests = 0;            ///< of HTTP
  std::uint64_t unasked = 0;             ///< plants of which it could not say whether it has them
  std::uint64_t unsent = 0;              ///< results that it did not get
  std::uint64_t damaged = 0;             ///< entries that were not what they should be
  double lost_seconds = 0.0;             ///< wall time of the batch that went for nothing: waits in vain, and its end
  std::string trouble;                   ///< what was wrong with it; empty: nothing
};

/// thread  one
class RemoteCache {
 public:
  /// Asks for the index at once.
  explicit RemoteCache(RemoteCacheOptions options);

  /// done  called from step(), with the entry's bundle, not checked; empty: there is none, or it is not to be had
  void fetch(const std::string& key, std::function<void(std::vector<std::uint8_t>)> done);
  /// done  as in fetch, with the record at record_url(), not checked
  void fetch_record(const std::string& name, std::function<void(std::vector<std::uint8_t>)> done);
  /// The bundle that was fetched is damaged.
  void found_damaged(const std::string& key);
  /// Sends the folder's entry of that key, unless the cache has it or is only read.
  void offer(const std::string& key);
  /// Waits for answers, until `also` can be read, or so many seconds.
  void step(double seconds, int also);
  /// Sends what is left, then the index; no longer than the cache may still cost.
  void finish();

  [[nodiscard]] CacheReport report() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Wanted {
    Clock::time_point since;
    bool begins = false;  ///< to come
    std::vector<std::function<void(std::vector<std::uint8_t>)>> done;
  };

  void start(HttpRequest request, HttpTransfers::Done done);
  void ask_index();
  void read_index_answer(const HttpAnswer& answer);
  void look_for(const std::string& key);
  void get(const std::string& key);
  void read_entry_answer(const std::string& key, const HttpAnswer& answer);
  void answer_wanted(const std::string& key, const std::vector<std::uint8_t>& bundle);
  void close_if_open();
  void look_at_waiting();
  void send_next();
  void send(const std::string& key);
  void put(const std::string& key);
  void sent(const std::string& key, std::uint64_t bytes, const HttpAnswer& answer);
  void put_record(const std::string& key);
  void went_wrong(CacheBreaker& breaker, const HttpAnswer& answer);
  HttpAnswer ask(HttpRequest request, Clock::time_point until);
  void write_index(Clock::time_point until);

  RemoteCacheOptions options_;
  HttpTransfers transfers_;
  CacheBreaker reading_, writing_;
  bool index_is_pending_ = true, index_is_missing_ = false;
  CacheIndex index_, added_;
  std::set<std::string> gone_, damaged_;
  std::map<std::string, Wanted> wanted_;
  std::deque<std::string> offered_;
  std::set<std::string> offered_before_;
  std::size_t sending_ = 0;
  CacheReport report_;
};

}  // namespace coppice::bake
