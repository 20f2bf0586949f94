#pragma once

// What a command reads paths for and writes: files that are tried before the work, the standard output, text that is fit for a terminal,
// failures and warnings.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "result.h"
#include "text_bytes.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace coppice::bake {

/// A path as it may be printed: core/printable.h.
std::string shown(const std::filesystem::path& path);

/// Whether the output is "-", the standard output. It then gets nothing else.
bool is_standard_output(const std::filesystem::path& output);

/// Adds an option that takes the path of an output; an empty one is a usage error.
CLI::Option* add_output_option(CLI::App& command, const std::string& names, std::filesystem::path& path, const std::string& help);

enum class Content : std::uint8_t { binary, text };

/// Refuses, before any work is done, an output that is one of the other files of the command, or that cannot be written: folders that are
/// missing are made, and the temporary file that will become the output is made and removed. Temporary files that killed processes left
/// beside it go too.
/// others   empty paths are skipped
/// content  what "-" will get: binary is not for terminals
/// errors   invalid_argument, io; name the path
Result<void> check_output(const std::filesystem::path& output, const std::vector<std::filesystem::path>& others,
                          Content content = Content::binary);

/// check_output for all outputs of a command, which are not to be one of its inputs or each other. Empty paths are skipped.
Result<void> check_outputs(const std::vector<std::pair<std::filesystem::path, Content>>& outputs,
                           const std::vector<std::filesystem::path>& inputs);

/// Refuses "-" for a command that cannot write there. why: the rest of the line. errors  invalid_argument
Result<void> refuse_standard_output(const std::filesystem::path& output, const char* why);

struct Output {
  std::filesystem::path path;  ///< empty: not asked for
  std::span<const std::uint8_t> bytes;
};

/// Writes all outputs, or none: the first becomes a file when all are on disk as temporary files. Then prints `text` to the standard
/// output, unless that is an output. Says what fails. returns the exit code
int write_outputs(const std::vector<Output>& outputs, const std::string& text);

/// Flushes and closes the standard output. What could not be written there makes of a success a failure, with a line that says so.
/// returns the exit code
int finish_standard_output(int exit_code);

/// Prints "coppice: FILE: message" to stderr; returns 1, the exit code of every failure that is not a usage error.
int report_failure(const std::filesystem::path& file, const Error& error);

/// Prints each as "coppice: warning: FILE: warning" to stderr.
void print_warnings(const std::filesystem::path& file, const std::vector<std::string>& warnings);

/// 1234567 -> "1.2 MB".
std::string readable_bytes(std::uint64_t bytes);

}  // namespace coppice::bake
