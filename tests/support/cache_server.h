#pragma once

// Servers for tests of the shared cache, on the loopback address: one of ours, which does wrong on purpose, and nginx.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "process.h"

namespace coppice::test {

/// How a server sends a .coppice file.
enum class SentBody {
  whole,
  half,       ///< then it ends the connection
  wrong,      ///< with another bit
  trickling,  ///< with 50 MB behind it, at 50 kB a second
};

struct ServerFaults {
  int get_status = 0, put_status = 0;  ///< the answer to every request of that kind; 0: as it should be
  SentBody body = SentBody::whole;
  double delay_s = 0.0;  ///< before each answer
};

struct NamedFaults {
  std::string name;
  ServerFaults faults;
  std::string told = {};   ///< what the line about it names beside the address; empty: nothing
  bool is_filled = false;  ///< the fault shows where the server has what is asked for
};
std::vector<NamedFaults> all_server_faults();

/// A process that keeps what is put into it as files of a folder, at their paths. Ended by the destructor.
class FaultyServer {
 public:
  explicit FaultyServer(const std::filesystem::path& folder, const ServerFaults& faults = {});
  ~FaultyServer();
  FaultyServer(const FaultyServer&) = delete;
  FaultyServer& operator=(const FaultyServer&) = delete;
  [[nodiscard]] std::string url() const;
  [[nodiscard]] std::size_t request_count() const;

 private:
  std::filesystem::path log_;
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
  [[nodiscard]] std::size_t request_count() const;

 private:
  std::filesystem::path folder_;
  std::uint16_t port_ = 0;
  std::unique_ptr<BackgroundProcess> process_;
};

}  // namespace coppice::test
