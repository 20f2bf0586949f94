#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "atomic_file.h"
#include "commands.h"
#include "inspect.h"
#include "output.h"
#include "verify_scene.h"

namespace coppice::bake {
namespace {

struct VerifyArguments {
  std::filesystem::path input;
  bool allow_outside = false;
};

int run_scene(const VerifyArguments& arguments, std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kMostLines = 100;
  const SceneVerifyReport report =
      verify_scene(bytes, arguments.input.parent_path(), arguments.allow_outside ? OutsideFiles::allowed : OutsideFiles::refused);
  for (std::size_t i = 0; i < std::min(report.errors.size(), kMostLines); ++i) report_failure(arguments.input, report.errors[i]);
  if (report.errors.size() > kMostLines)
    std::fprintf(stderr, "coppice: %s: and %zu more errors\n", shown(arguments.input).c_str(), report.errors.size() - kMostLines);
  if (!report.errors.empty()) return 1;
  std::printf("%s: ok: %llu plants in %u tiles, %u species, %s\n", shown(arguments.input).c_str(),
              static_cast<unsigned long long>(report.plants_checked), report.tiles_checked, report.species_checked,
              readable_bytes(report.bytes_checked).c_str());
  return 0;
}

int run(const VerifyArguments& arguments) {
  const auto bytes = read_file(arguments.input);
  if (!bytes) return report_failure(arguments.input, bytes.error());
  if (is_scene(*bytes)) return run_scene(arguments, *bytes);
  const auto report = verify(*bytes);
  if (!report) return report_failure(arguments.input, report.error());
  std::printf("%s: ok: %u chunks, %u splits, %u wood triangles, %u leaf mesh triangles, %s\n", shown(arguments.input).c_str(),
              report->chunks_checked, report->splits_decoded, report->wood_triangles_decoded, report->leaf_mesh_triangles_decoded,
              readable_bytes(report->bytes_checked).c_str());
  return 0;
}

}  // namespace

void add_verify_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<VerifyArguments>();
  CLI::App* command = app.add_subcommand(
      "verify", "Check a .coppice file, or a .forest file with all its plants: every checksum, page, tile and invariant; exit 0 or 1");
  command->add_option("input", arguments->input, "A .coppice or a .forest file")->required()->type_name("IN.coppice|IN.forest");
  command->add_flag("--allow-outside", arguments->allow_outside, "Let a scene name plants outside its folder");
  command->callback([arguments, exit_code] { *exit_code = run(*arguments); });
}

}  // namespace coppice::bake
