#pragma once

// What tests start on free ports of the loopback address: servers for a shared cache, one of ours, which does wrong on purpose, and nginx;
// and a Slurm cluster.

#include <array>
#include <cstddef>
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
