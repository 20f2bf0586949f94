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
void add_view_command(CLI::App& app, int* exit_code);

/// Prints "coppice: FILE: message" to stderr, or "coppice: out of memory"; returns 1, the exit code of every failure that is not a usage
/// error.
int report_failure(const std::filesystem::path& file, const Error& error);

/// Prints each as "coppice: warning: FILE: warning" to stderr.
void print_warnings(const std::filesystem::path& file, const std::vector<std::string>& warnings);

/// 1234567 -> "1.2 MB".
std::string readable_bytes(std::uint64_t bytes);

}  // namespace coppice::bake
