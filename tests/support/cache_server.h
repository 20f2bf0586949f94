#pragma once

// Servers for tests of the shared cache, on the loopback address: one of ours, which does wrong on purpose, and nginx.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "process.h"

namespace coppice::test {

/// What a server does wrong with entries; 0 and false: nothing.
struct ServerFaults {
  int get_status = 0, put_status = 0;  ///< the answer to every request of that kind
  bool half_bodies = false;            ///< ends the connection in the middle of what is asked for
  bool wrong_bytes = false;            ///< flips a bit of it
  double delay_s = 0.0;                ///< before each answer
  std::size_t padding_bytes = 0;       ///< after what is asked for
  double bytes_per_s = 0.0;            ///< sends what is asked for no faster
};

/// A process that keeps what is put into it as files of a folder, at their paths. Ended by the destructor.
class FaultyServer {
 public:
  explicit FaultyServer(std::filesystem::path folder, const ServerFaults& faults = {});
  ~FaultyServer();
  FaultyServer(const FaultyServer&) = delete;
  FaultyServer& operator=(const FaultyServer&) = delete;

  [[nodiscard]] std::string url() const;
  /// "GET /KEY.record" of each, in their order.
  [[nodiscard]] std::vector<std::string> requests() const;

 private:
  std::filesystem::path folder_;
  std::uint16_t port_ = 0;
  int process_ = -1;
};

/// A port of the loopback address, and an address on one, at which nobody listens.
std::uint16_t free_port();
std::string dead_url();

/// nginx with a `server` block in which "8080" is a free port and "/srv/coppice-cache" a folder. Without the program is_there() is false.
class Nginx {
 public:
  /// Throws std::runtime_error where nginx does not start.
  Nginx(const std::filesystem::path& folder, std::string server_block);

  [[nodiscard]] static bool is_there();
  [[nodiscard]] std::string url() const;
  /// Where the objects are.
  [[nodiscard]] std::filesystem::path root() const { return folder_ / "objects"; }
  /// "GET /KEY.record 200" of each so far, in the order of their ends.
  [[nodiscard]] std::vector<std::string> requests() const;

 private:
  std::filesystem::path folder_;
  std::uint16_t port_ = 0;
  std::unique_ptr<BackgroundProcess> process_;
};

}  // namespace coppice::test
