#pragma once

// A Slurm cluster of two nodes with one processor each, on this machine, for one test: munged, slurmctld and slurmd in a folder of its own,
// on free ports of the loopback address. It needs no systemd, and touches no Slurm that the machine may have.

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "process.h"

namespace coppice::test {

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
