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
  bool gave_up = false;                  ///< it was asked no more before the batch was done
  std::string trouble;                   ///< what was wrong with it; empty: nothing
};

/// What an entry is worth to whoever asks for it.
struct EntryWorth {
  double seconds = 0.0;          ///< that making it anew would take
  std::uint64_t most_bytes = 0;  ///< a larger one is refused
};

/// thread  one
class RemoteCache {
 public:
  /// Asks for the index at once.
  explicit RemoteCache(RemoteCacheOptions options);

  using Done = std::function<void(const std::vector<std::uint8_t>&)>;

  /// done  called from step(), with the entry's bundle, not checked; empty: there is none, or it is not to be had
  void fetch(const std::string& key, const EntryWorth& worth, Done done);
  /// done  as in fetch, with the record at record_url(), not checked
  void fetch_record(const std::string& name, Done done);
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
  /// An entry or a record that somebody waits for.
  struct Wanted {
    Clock::time_point since = Clock::now();
    EntryWorth worth;
    std::uint64_t bytes = 0, of = 0;  ///< that have come, and that there are; 0: not known
    std::vector<Done> done;

    [[nodiscard]] double waited_s() const;
    [[nodiscard]] double at_stake_s() const;
  };
  using WantedByName = std::map<std::string, Wanted>;

  void start(HttpRequest request, HttpTransfers::Done done);
  void ask_index();
  void read_index_answer(const HttpAnswer& answer);
  void look_for(const std::string& key);
  void get(const std::string& url, std::uint64_t most_bytes, WantedByName& wanted, const std::string& name, HttpTransfers::Done done);
  void read_entry_answer(const std::string& key, const HttpAnswer& answer);
  void read_record_answer(const std::string& name, const HttpAnswer& answer);
  static void answer_wanted(WantedByName& wanted, const std::string& name, const std::vector<std::uint8_t>& bytes);
  void let_go(WantedByName& wanted);
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
  WantedByName wanted_, wanted_records_;
  std::map<std::string, double> fetched_s_;  ///< how long entries took that came
  std::deque<std::string> offered_;
  std::set<std::string> offered_before_;
  std::size_t sending_ = 0, explaining_ = 0;  ///< entries, and records for explanations
  CacheReport report_;
};

}  // namespace coppice::bake
