#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace coppice::test {

struct ProcessResult {
  int exit_code = -1;  ///< -1 when a signal ended it
  int signal = 0;      ///< that signal, 0 for none
  std::string out;     ///< standard output
  std::string err;     ///< standard error
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

}  // namespace coppice::test
