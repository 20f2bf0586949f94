#pragma once

// The program `coppice` from outside: how tests start it, and what its errors and reports have.

#include <chrono>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "mentions.h"
#include "places.h"
#include "process.h"
#include "text_files.h"

namespace coppice::test {

using Words = std::vector<std::string>;

/// Runs coppice to its end.
ProcessResult run_tool(const Words& arguments, const ProcessOptions& options = {});

/// Expects this exit code, and that the standard error names all of these.
void expect_failure(const ProcessResult& result, const Words& names, int exit_code = 1);

/// Expects exit code 1, and on the standard error one line, however it is broken for a terminal, that names all of these.
/// about  what is tried, for failures
void expect_error(const ProcessResult& result, const Words& names, const std::string& about = "");

/// The same, and that the line is not broken, and nothing is on the standard output.
void expect_one_line_error(const ProcessResult& result, const Words& names, const std::string& about = "");

/// How often a part stands in a text, overlaps too.
std::size_t count_of(const std::string& text, const std::string& part);

nlohmann::json read_json(const std::filesystem::path& path);
std::set<std::string> keys_of(const nlohmann::json& object);

/// What a report of bake-all counts.
struct BatchCounts {
  std::size_t baked = 0, cached = 0, failed = 0;
  bool operator==(const BatchCounts&) const = default;
};
BatchCounts counts_in(const std::filesystem::path& report);
void PrintTo(const BatchCounts& counts, std::ostream* out);

/// False if it has not come true after so long. Polls: nothing here is timed.
bool comes_true(const std::function<bool()>& condition, std::chrono::seconds most = std::chrono::seconds(120));

}  // namespace coppice::test
