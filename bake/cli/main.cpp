// The coppice command-line tool. One sub-command = one file in this folder.

#include <CLI/CLI.hpp>
#include <string>

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
  using namespace coppice::bake;
  for (const auto add :
       {add_plant_command, add_bake_command, add_bake_all_command, add_cache_command, add_inspect_command, add_verify_command,
        add_export_command, add_evaluate_command, add_scene_command, add_view_command, add_completion_command})
    add(app, exit_code);
}

}  // namespace

// Memory that runs out before the first command may end the program.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char** argv) {
  if (const auto exit_code = coppice::bake::evaluate_in_lab({argv + 1, argv + argc})) return *exit_code;
  return coppice::bake::run_program({"coppice", kAbout, declare, coppice::bake::sbatch_hint}, argc, argv);
}
