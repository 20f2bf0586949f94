#include "output.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "atomic_file.h"
#include "job_processes.h"
#include "printable.h"
#include "taken_places.h"

namespace coppice::bake {
namespace {

constexpr const char* kStandardOutput = "the standard output";

Error refused(const char* what, const std::filesystem::path& output) {
  return Error{Status::invalid_argument, what, Error::kNoOffset, output.string()};
}

}  // namespace

std::string shown(const std::filesystem::path& path) {
  return printable(path.native());
}

bool is_standard_output(const std::filesystem::path& output) {
  return output == "-";
}

CLI::Option* add_output_option(CLI::App& command, const std::string& names, std::filesystem::path& path, const std::string& help) {
  const CLI::Validator named([](std::string& text) { return std::string(text.empty() ? "an output needs a name" : ""); }, "");
  return command.add_option(names, path, help)->check(named);
}

Result<void> check_output(const std::filesystem::path& output, const std::vector<std::filesystem::path>& others, Content content) {
  return check_outputs({{output, content}}, others);
}

Result<void> check_outputs(const std::vector<std::pair<std::filesystem::path, Content>>& outputs,
                           const std::vector<std::filesystem::path>& inputs) {
  TakenPlaces taken;
  for (const std::filesystem::path& input : inputs) COPPICE_CHECK(taken.add(input));
  bool has_standard_output = false;
  for (const auto& [output, content] : outputs) {
    if (is_standard_output(output)) {
      if (std::exchange(has_standard_output, true)) return refused("two outputs cannot both be the standard output", output);
      continue;
    }
    COPPICE_TRY(is_free, taken.add(output));
    if (!is_free) return refused("would be overwritten: another file of this command has the same path", output);
  }
  for (const auto& [output, content] : outputs) {
    if (output.empty()) continue;
    if (!is_standard_output(output)) {
      COPPICE_CHECK(make_folder_of(output));
      COPPICE_CHECK(try_writing(output));
    } else if (content == Content::binary && ::isatty(STDOUT_FILENO) == 1) {
      return refused("the standard output is a terminal: name a file, or send it to a program", output);
    }
  }
  return {};
}

Result<void> refuse_standard_output(const std::filesystem::path& output, const char* why) {
  if (is_standard_output(output)) return Error{Status::invalid_argument, "not to the standard output", Error::kNoOffset, why};
  return {};
}

int write_outputs(const std::vector<Output>& outputs, const std::string& text) {
  std::vector<TemporaryFile> files;
  files.reserve(outputs.size());
  const Output* standard_output = nullptr;
  for (const Output& output : outputs) {
    if (output.path.empty()) continue;
    if (is_standard_output(output.path)) {
      standard_output = &output;
      continue;
    }
    Result<TemporaryFile> file = stage_file(output.path, output.bytes);
    if (!file) return report_failure(output.path, file.error());
    files.push_back(*std::move(file));
  }
  if (standard_output != nullptr)
    if (const auto written = write_all(STDOUT_FILENO, standard_output->bytes, kStandardOutput); !written)
      return report_failure(standard_output->path, written.error());
  for (TemporaryFile& file : files)
    if (const auto published = file.publish(); !published) return report_failure({}, published.error());
  if (standard_output == nullptr) std::fputs(text.c_str(), stdout);
  return 0;
}

int finish_standard_output(int exit_code) {
  errno = 0;
  bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  const int reason = errno;
  // Network file systems say only here that there was no room.
  written = ::close(STDOUT_FILENO) == 0 && written;
  if (written || exit_code != 0) return exit_code;
  const int why = reason != 0 ? reason : errno;
  std::fprintf(stderr, "coppice: cannot write: %s: %s\n", kStandardOutput, why != 0 ? std::strerror(why) : "an earlier write failed");
  return 1;
}

int report_failure(const std::filesystem::path& file, const Error& error) {
  const std::string message = error.status == Status::out_of_memory ? "out of memory" + memory_limit_hint() : error.message();
  if (message.find(file.string()) != std::string::npos)
    std::fprintf(stderr, "coppice: %s\n", printable(message).c_str());
  else
    std::fprintf(stderr, "coppice: %s: %s\n", shown(file).c_str(), printable(message).c_str());
  return 1;
}

void print_warnings(const std::filesystem::path& file, const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings)
    std::fprintf(stderr, "coppice: warning: %s: %s\n", shown(file).c_str(), printable(warning).c_str());
}

std::string readable_bytes(std::uint64_t bytes) {
  static constexpr const char* kUnits[] = {"B", "kB", "MB", "GB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; value >= 1000.0 && unit + 1 < std::size(kUnits); ++unit) value /= 1000.0;
  char text[32];
  std::snprintf(text, sizeof text, unit == 0 ? "%.0f %s" : "%.1f %s", value, kUnits[unit]);
  return text;
}

}  // namespace coppice::bake
