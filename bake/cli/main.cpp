// The coppice command-line tool. One sub-command = one file in this folder.

#include <CLI/CLI.hpp>
#include <string>

#include "cluster_arguments.h"
#include "command_line.h"
#include "commands.h"
#include "coppice/coppice.h"
#include "program.h"

namespace {

constexpr const char* kAbout =
    "Coppice bakes plants for streaming level of detail.\n\n"
    "A first session:\n"
    "  coppice plant willow -o willow.glb         grow a plant, or bring your own .glb\n"
    "  coppice bake willow.glb -o willow.coppice  order its leaves for every level of detail\n"
    "  coppice inspect willow.coppice             see what is inside\n"
    "  coppice-forest willow.coppice              look at it; with --count 2000, a forest of it\n"
    "  coppice view willow.glb                    the last three in one, for a first look at any plant\n";

void declare(CLI::App& app, int* exit_code) {
  app.set_version_flag("--version", std::to_string(COPPICE_VERSION_MAJOR) + "." + std::to_string(COPPICE_VERSION_MINOR) + "." +
                                        std::to_string(COPPICE_VERSION_PATCH));
  app.require_subcommand(1);
  coppice::bake::add_plant_command(app, exit_code);
  coppice::bake::add_bake_command(app, exit_code);
  coppice::bake::add_bake_all_command(app, exit_code);
  coppice::bake::add_cache_command(app, exit_code);
  coppice::bake::add_inspect_command(app, exit_code);
  coppice::bake::add_verify_command(app, exit_code);
  coppice::bake::add_export_command(app, exit_code);
  coppice::bake::add_evaluate_command(app);
  coppice::bake::add_scene_command(app, exit_code);
  coppice::bake::add_view_command(app, exit_code);
  coppice::bake::add_completion_command(app, exit_code);
}

}  // namespace

// Memory that runs out before the first command may end the program.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char** argv) {
  if (const auto exit_code = coppice::bake::evaluate_in_lab({argv + 1, argv + argc})) return *exit_code;
  return coppice::bake::run_program({"coppice", kAbout, declare, coppice::bake::sbatch_hint}, argc, argv);
}
