#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace coppice::test {

struct ProcessResult {
  int exit_code = -1;                ///< -1 when a signal ended it
  int signal = 0;                    ///< that signal, 0 for none
  std::string out;                   ///< standard output
  std::string err;                   ///< standard error
  std::uint64_t peak_rss_bytes = 0;  ///< of the largest of its processes
};

struct ProcessOptions {
  std::optional<std::chrono::milliseconds> kill_after;    ///< SIGKILL once it has run so long
  std::optional<std::filesystem::path> kill_when_exists;  ///< SIGKILL once this file is there
  std::optional<std::uint64_t> largest_file_bytes;        ///< a write beyond this fails, or ends it with SIGXFSZ
  std::optional<std::filesystem::path> out;               ///< where standard output goes, instead of into the result
  std::vector<std::string> environment;                   ///< NAME=VALUE, beside those of this process
};

/// Runs a program to its end and collects what it prints. Standard input is empty; no shell is involved.
/// program  path; arguments  without the program itself
/// Throws std::runtime_error when it cannot be started.
ProcessResult run_process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                          const ProcessOptions& options = {});

/// A program that runs beside the test; ended by the destructor. What it prints can be read while it runs.
class BackgroundProcess {
 public:
  /// As run_process.
  BackgroundProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments, const ProcessOptions& options = {});
  ~BackgroundProcess();
  BackgroundProcess(const BackgroundProcess&) = delete;
  BackgroundProcess& operator=(const BackgroundProcess&) = delete;
  [[nodiscard]] std::string out() const;
  [[nodiscard]] std::string err() const;
  /// Waits for its end. returns the exit code, -1 when a signal ended it
  int wait();
  /// Sends a signal, unless it was waited for.
  void send(int signal) const;
  /// Its number; -1 once it was waited for.
  [[nodiscard]] int id() const { return child_; }

 private:
  std::filesystem::path folder_;
  int child_ = -1;
};

/// The program in the first folder of PATH that has it; empty: in none.
std::filesystem::path program_on_path(const std::string& name);

/// A folder of its own below the system's temporary one, removed with everything in it by the destructor.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Lines that were broken for a terminal, whole again: those that begin with spaces are joined to the ones before.
std::string unwrapped(const std::string& text);

}  // namespace coppice::test
