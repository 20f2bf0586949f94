// The coppice command-line tool. One sub-command = one file in this folder.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>

#include "commands.h"
#include "coppice/coppice.h"
#include "job_processes.h"

namespace coppice::bake {

int report_failure(const std::filesystem::path& file, const Error& error) {
  const std::string message = error.message() + (error.status == Status::out_of_memory ? memory_limit_hint() : "");
  if (message.find(file.string()) != std::string::npos)
    std::fprintf(stderr, "coppice: %s\n", message.c_str());
  else
    std::fprintf(stderr, "coppice: %s: %s\n", file.c_str(), message.c_str());
  return 1;
}

Result<void> check_output(const std::filesystem::path& output, const std::vector<std::filesystem::path>& others) {
  std::error_code absent;
  for (const std::filesystem::path& other : others)
    if (!other.empty() && (output.lexically_normal() == other.lexically_normal() || std::filesystem::equivalent(output, other, absent)))
      return Error{Status::invalid_argument, "would be overwritten: another file of this command has the same path", Error::kNoOffset,
                   output.string()};
  const std::filesystem::path folder = output.has_parent_path() ? output.parent_path() : std::filesystem::path(".");
  if (access(folder.c_str(), W_OK) != 0)
    return Error{Status::io, "cannot be written", Error::kNoOffset, output.string() + ": " + std::strerror(errno)};
  return {};
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
  CLI::App app{
      "Coppice bakes plants for streaming level of detail.\n\n"
      "A first session:\n"
      "  coppice plant willow -o willow.glb         grow a plant, or bring your own .glb\n"
      "  coppice bake willow.glb -o willow.coppice  order its leaves for every level of detail\n"
      "  coppice inspect willow.coppice             see what is inside\n"
      "  coppice-forest --plants willow.coppice     walk through it\n"};
  app.set_version_flag("--version", std::to_string(COPPICE_VERSION_MAJOR) + "." + std::to_string(COPPICE_VERSION_MINOR) + "." +
                                        std::to_string(COPPICE_VERSION_PATCH));
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);

  int exit_code = 0;
  coppice::bake::add_plant_command(app, &exit_code);
  coppice::bake::add_bake_command(app, &exit_code);
  coppice::bake::add_bake_all_command(app, &exit_code);
  coppice::bake::add_inspect_command(app, &exit_code);
  coppice::bake::add_verify_command(app, &exit_code);
  coppice::bake::add_export_command(app, &exit_code);
  coppice::bake::add_evaluate_command(app, &exit_code);
  coppice::bake::add_scene_command(app, &exit_code);

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);  // --help, --version
  } catch (const CLI::ParseError& error) {
    app.exit(error);
    return 2;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "coppice: out of memory\n");
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "coppice: %s\n", error.what());
    return 1;
  }
  return exit_code;
}
