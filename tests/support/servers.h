#pragma once

// What tests start on free ports of the loopback address: servers for a shared cache, one of ours, which does wrong on purpose, and nginx;
// and a Slurm cluster.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "process.h"

namespace coppice::test {

/// A request, and the right answer to it.
struct ServerRequest {
  std::string method, target;
  std::uint16_t port = 0;  ///< the server's
  int status = 0;
  std::string content;
};

/// A server that does wrong, as name, and what a client has to make of it.
struct ServerFault {
  std::string name;  ///< letters, digits and _
  std::function<void(const ServerRequest&, std::ostream& out)> answer;
  std::string told = {};  ///< what the line about it names beside the address
  std::size_t lines = 1;  ///< that tell of three plants
  bool is_found = false;  ///< the plants are had from it all the same
  bool is_deaf = false;   ///< it answers before it has read the request
  std::string scheme = "http";
};
std::vector<ServerFault> all_server_faults();
/// Has nothing and takes everything, each time after 2.5 s.
ServerFault late_server();
void PrintTo(const ServerFault& fault, std::ostream* out);

/// A process that keeps what is put into it as files of a folder, at their paths. Ended by the destructor.
class FaultyServer {
 public:
  /// Without a fault it does right.
  explicit FaultyServer(const std::filesystem::path& folder, const ServerFault& fault = {});
  ~FaultyServer();
  FaultyServer(const FaultyServer&) = delete;
  FaultyServer& operator=(const FaultyServer&) = delete;
  [[nodiscard]] std::string url() const;
  /// "METHOD TARGET" of each request, a line each.
  [[nodiscard]] std::string requests() const;

 private:
  std::filesystem::path log_;
  std::uint16_t port_ = 0;
  std::string scheme_;
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

/// A cluster of two nodes with one processor each, on this machine, for one test: munged, slurmctld and slurmd in a folder of its own. It
/// needs no systemd, and touches no Slurm that the machine may have.
class SlurmCluster {
 public:
  /// Why there can be none here, as for GTEST_SKIP: programs that are missing, or this is not root. Empty: there can.
  static std::string missing();

  /// Throws std::runtime_error where it does not come up.
  SlurmCluster();
  ~SlurmCluster();
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;

  /// What programs need in their environment to use it.
  [[nodiscard]] ProcessOptions environment() const;
  /// Runs one of Slurm's programs.
  [[nodiscard]] ProcessResult run(const std::string& program, const std::vector<std::string>& arguments) const;
  /// The words of `squeue --format=FORMAT`, a line each, of all tasks that Slurm knows.
  [[nodiscard]] std::string queue(const std::string& format) const;

  /// SIGKILL to the node's daemon and to all that runs on it. The controller finds out after some 25 s.
  void kill_node(std::size_t node);
  /// SIGKILL to the controller.
  void kill_controller();
  void start_controller();

  /// The scripts of tasks that run on a node, and all processes below them. Their ids rise.
  [[nodiscard]] std::vector<int> processes_on(std::size_t node) const;

 private:
  [[nodiscard]] std::unique_ptr<BackgroundProcess> start(const std::string& program, const std::vector<std::string>& arguments) const;

  TemporaryFolder folder_;
  std::unique_ptr<BackgroundProcess> munge_, controller_;
  std::array<std::unique_ptr<BackgroundProcess>, 2> nodes_;
};

}  // namespace coppice::test
