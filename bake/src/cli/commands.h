#pragma once

// The sub-commands of `coppice`. Each adds itself to the app and, when chosen, leaves its exit code in *exit_code.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "result.h"

namespace CLI {
class App;
}

namespace coppice::bake {

void add_plant_command(CLI::App& app, int* exit_code);
void add_bake_command(CLI::App& app, int* exit_code);
void add_bake_all_command(CLI::App& app, int* exit_code);
void add_inspect_command(CLI::App& app, int* exit_code);
void add_verify_command(CLI::App& app, int* exit_code);
void add_export_command(CLI::App& app, int* exit_code);
void add_evaluate_command(CLI::App& app, int* exit_code);
void add_scene_command(CLI::App& app, int* exit_code);

/// Prints "coppice: FILE: message" to stderr; returns 1, the exit code of every failure that is not a usage error.
int report_failure(const std::filesystem::path& file, const Error& error);

/// Refuses, before any work is done, an output that is one of the other files of the command or whose folder cannot be written to.
/// others  empty paths are skipped
/// errors  invalid_argument, io; name the path
Result<void> check_output(const std::filesystem::path& output, const std::vector<std::filesystem::path>& others);

/// 1234567 -> "1.2 MB".
std::string readable_bytes(std::uint64_t bytes);

}  // namespace coppice::bake
