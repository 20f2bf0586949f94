#pragma once

// The sub-commands of `coppice`. Each adds itself to the app and, when chosen, leaves its exit code in *exit_code.

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
void add_evaluate_command(CLI::App& app, int* exit_code);
void add_scene_command(CLI::App& app, int* exit_code);
void add_view_command(CLI::App& app, int* exit_code);
void add_completion_command(CLI::App& app, int* exit_code);

}  // namespace coppice::bake
