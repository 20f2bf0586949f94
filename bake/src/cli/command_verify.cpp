#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "atomic_file.h"
#include "commands.h"
#include "inspect.h"

namespace coppice::bake {
namespace {

int run(const std::filesystem::path& input) {
  const auto bytes = read_file(input);
  if (!bytes) return report_failure(input, bytes.error());
  const auto report = verify(*bytes);
  if (!report) return report_failure(input, report.error());
  std::printf("%s: ok: %u chunks, %u splits, %u wood triangles, %u leaf mesh triangles, %s\n", input.c_str(), report->chunks_checked,
              report->splits_decoded, report->wood_triangles_decoded, report->leaf_mesh_triangles_decoded,
              readable_bytes(report->bytes_checked).c_str());
  return 0;
}

}  // namespace

void add_verify_command(CLI::App& app, int* exit_code) {
  auto input = std::make_shared<std::filesystem::path>();
  CLI::App* command =
      app.add_subcommand("verify", "Check a .coppice file: every checksum, every page decoded, every invariant; exit 0 or 1");
  command->add_option("input", *input, "A .coppice file")->required();
  command->callback([input, exit_code] { *exit_code = run(*input); });
}

}  // namespace coppice::bake
