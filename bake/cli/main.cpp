// The coppice command-line tool. One sub-command = one file in this folder.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <new>
#include <sstream>
#include <string>
#include <vector>

#include "cluster_arguments.h"
#include "command_line.h"
#include "commands.h"
#include "coppice/coppice.h"
#include "endings.h"
#include "failure_text.h"
#include "job_processes.h"
#include "output.h"
#include "printable.h"

namespace coppice::bake {

int report_failure(const std::filesystem::path& file, const Error& error) {
  const std::string message = error.message();
  if (error.status == Status::out_of_memory)
    std::fprintf(stderr, "coppice: out of memory%s\n", memory_limit_hint().c_str());
  else if (message.find(file.string()) != std::string::npos)
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

// Memory that runs out before the first command may end the program.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char** argv) {
  coppice::bake::install_endings();
  // What is printed to a file or a pipe is written when it is whole, so that the reason why it cannot be is at hand.
  static std::array<char, std::size_t{1} << 16> printed;
  if (::isatty(STDOUT_FILENO) == 0) static_cast<void>(std::setvbuf(stdout, printed.data(), _IOFBF, printed.size()));
  CLI::App app{
      "Coppice bakes plants for streaming level of detail.\n\n"
      "A first session:\n"
      "  coppice plant willow -o willow.glb         grow a plant, or bring your own .glb\n"
      "  coppice bake willow.glb -o willow.coppice  order its leaves for every level of detail\n"
      "  coppice inspect willow.coppice             see what is inside\n"
      "  coppice-forest willow.coppice              look at it; with --count 2000, a forest of it\n"
      "  coppice view willow.glb                    the last three in one, for a first look at any plant\n",
      "coppice"};
  app.set_version_flag("--version", std::to_string(COPPICE_VERSION_MAJOR) + "." + std::to_string(COPPICE_VERSION_MINOR) + "." +
                                        std::to_string(COPPICE_VERSION_PATCH));
  app.require_subcommand(1);
  app.formatter(coppice::command_line::help_format());
  // What is wrong with an argument quotes it.
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return coppice::printable(error.what()) + "\nRun with --help for more information.\n";
  });

  int exit_code = 0;
  coppice::bake::add_plant_command(app, &exit_code);
  coppice::bake::add_bake_command(app, &exit_code);
  coppice::bake::add_bake_all_command(app, &exit_code);
  coppice::bake::add_cache_command(app, &exit_code);
  coppice::bake::add_inspect_command(app, &exit_code);
  coppice::bake::add_verify_command(app, &exit_code);
  coppice::bake::add_export_command(app, &exit_code);
  coppice::bake::add_evaluate_command(app, &exit_code);
  coppice::bake::add_scene_command(app, &exit_code);
  coppice::bake::add_view_command(app, &exit_code);
  coppice::bake::add_completion_command(app, &exit_code);

  try {
    if (argc == 1) throw CLI::CallForHelp();
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    std::ostringstream text;  // --help, --version
    exit_code = app.exit(success, text, text);
    std::fputs(text.str().c_str(), stdout);
  } catch (const CLI::ParseError& error) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    const std::string unknown = coppice::command_line::unknown_word(app, words);
    if (unknown.empty())
      app.exit(error);
    else
      std::fprintf(stderr, "%s\nRun with --help for more information.\n", coppice::printable(unknown).c_str());
    if (!unknown.empty() || error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError))
      std::fputs(coppice::bake::sbatch_hint(words).c_str(), stderr);
    exit_code = 2;
  } catch (const std::bad_alloc&) {
    coppice::bake::end_out_of_memory();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "coppice: %s\n", coppice::printable(coppice::bake::failure_text(error)).c_str());
    exit_code = 1;
  }
  return coppice::bake::finish_standard_output(exit_code);
}
