#pragma once

// Requests to one server, many at a time over connections that are kept, from one thread: libcurl's multi interface.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "cache_location.h"
#include "result.h"

namespace coppice::bake {

enum class HttpMethod { get, head, put, remove };

struct HttpRequest {
  HttpMethod method = HttpMethod::get;
  std::string url = {};
  std::vector<std::uint8_t> body = {};  ///< of a put
  /// Given up when it moves less than this in `stall_seconds`; waiting for a connection and for the answer is moving nothing.
  double stall_seconds = 1.5;
  std::uint64_t stall_bytes = 256'000;
  std::uint64_t most_bytes = std::uint64_t{1} << 30;  ///< of the answer's body: one that is larger is not read
  /// Called whenever more of the answer's body is there: how much it is, and of how much, 0 where the server does not say. May be empty
  std::function<void(std::uint64_t bytes, std::uint64_t of)> progress = {};
};

/// Why there is no whole answer.
enum class HttpTrouble { none, unreachable, too_slow, cut_short, too_large };

struct HttpAnswer {
  int status = 0;                       ///< of HTTP; 0 without one
  std::vector<std::uint8_t> body = {};  ///< empty unless `trouble` is none
  std::uint64_t content_bytes = 0;      ///< as the answer's head says; of a head request those that a get would give
  HttpTrouble trouble = HttpTrouble::none;
  std::string why = {};  ///< words for a person, without path or credentials; empty where there is no trouble
};

/// What HttpTransfers are made with: to be called before there are any. A process that is forked off after that has it too.
/// errors  unsupported: as load_curl
Result<void> load_http();

/// thread  one. The process may get threads: libcurl looks up names in one.
class HttpTransfers {
 public:
  using Done = std::function<void(HttpAnswer)>;

  HttpTransfers(CacheCredentials credentials, std::size_t at_a_time);
  ~HttpTransfers();
  HttpTransfers(const HttpTransfers&) = delete;
  HttpTransfers& operator=(const HttpTransfers&) = delete;

  /// `done` is called from step(), and may start others.
  void start(HttpRequest request, Done done);
  /// Moves what can be moved; where there is nothing, waits until there is, until `also` can be read, or so many seconds.
  /// also  a file descriptor, or -1
  void step(double seconds, int also = -1);
  /// Started and not done.
  [[nodiscard]] std::size_t count() const { return waiting_.size() + running_.size(); }

 private:
  struct Transfer;
  using Clock = std::chrono::steady_clock;

  void begin(std::unique_ptr<Transfer> transfer);
  void take_finished();
  void give_up_stalled();
  void finish(Transfer& transfer, HttpAnswer answer);

  CacheCredentials credentials_;
  std::size_t at_a_time_;
  void* multi_;
  void* headers_ = nullptr;
  std::deque<std::unique_ptr<Transfer>> waiting_;
  std::list<std::unique_ptr<Transfer>> running_;
  Clock::time_point last_step_ = Clock::now();
};

bool is_success(int status);
bool is_absent(int status);

/// "it answers 503 (service unavailable)", with what to do about it where that is known.
std::string status_text(int status);

}  // namespace coppice::bake
