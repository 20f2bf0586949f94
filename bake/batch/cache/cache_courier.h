#pragma once

// A process beside a batch that speaks with its remote cache, so that the process that starts the jobs has no threads (libcurl makes some)
// and all jobs share connections, the index and what is known of the cache's health. Jobs talk to it over a socket that they inherit. A job
// that asks is answered, or its question ends when the courier does.

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "remote_cache.h"
#include "result.h"

namespace coppice::bake {

/// A job's end. thread  any; a copy of a process may use it too
class CourierLine {
 public:
  CourierLine() = default;  ///< to no courier: it has nothing and takes nothing
  explicit CourierLine(int socket) : socket_(socket) {}

  /// The bundle of an entry, not checked; nothing where the cache has none or cannot be asked. Waits for the answer.
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> fetch(const std::string& key, const EntryWorth& worth) const;
  /// The record of the entry that was sent last of a plant with this file name; as fetch.
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> fetch_record(const std::string& name) const;
  /// What was fetched is damaged.
  void found_damaged(const std::string& key) const;
  /// The folder has an entry that the cache may lack.
  void offer(const std::string& key) const;

 private:
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> ask(const std::string& question) const;

  int socket_ = -1;
};

class CacheCourier {
 public:
  /// Starts the process, which dies with this one.
  /// errors  io: the system gives no process; unsupported: as load_http
  /// thread  this process must have no other threads
  static Result<CacheCourier> start(const RemoteCacheOptions& options);
  CacheCourier(CacheCourier&& other) noexcept;
  CacheCourier& operator=(CacheCourier&&) = delete;
  ~CacheCourier();

  [[nodiscard]] CourierLine line() const { return CourierLine(socket_); }
  /// Lets it send what is left, within the time that the cache may cost, and ends it. Jobs have ended.
  CacheReport finish();

 private:
  CacheCourier(int socket, int report, pid_t process, std::string where);
  void stop();
  CacheReport take_report();

  int socket_, report_;
  pid_t process_;
  std::string where_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace coppice::bake
