#pragma once

// The sub-commands of `coppice`. Each adds itself to the app and, when chosen, leaves its exit code in *exit_code.

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace coppice::bake {

void add_plant_command(CLI::App& app, int* exit_code);
void add_bake_command(CLI::App& app, int* exit_code);
void add_bake_all_command(CLI::App& app, int* exit_code);
void add_cache_command(CLI::App& app, int* exit_code);
void add_inspect_command(CLI::App& app, int* exit_code);
void add_verify_command(CLI::App& app, int* exit_code);
void add_export_command(CLI::App& app, int* exit_code);
void add_evaluate_command(CLI::App& app, int* exit_code);  ///< as the help lists it; its words are coppice-lab's to read
void add_scene_command(CLI::App& app, int* exit_code);
void add_view_command(CLI::App& app, int* exit_code);
void add_completion_command(CLI::App& app, int* exit_code);

/// A hint for a command line of bake-all that was refused because it lacks the -- before options of sbatch; else empty.
std::string sbatch_hint(const std::vector<std::string>& words);

/// Becomes coppice-lab where the command line is one of `evaluate`, or a shell completes one.
/// words    without the program's name
/// returns  the exit code where coppice-lab cannot be started; nothing for other commands
std::optional<int> evaluate_in_lab(std::vector<std::string> words);

}  // namespace coppice::bake
