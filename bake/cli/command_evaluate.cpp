#include <CLI/CLI.hpp>

#include "commands.h"
#include "evaluate_command.h"
#include "output.h"
#include "sibling_program.h"

namespace coppice::bake {

void add_evaluate_command(CLI::App& app) {
  app.add_subcommand(kEvaluateCommand, kEvaluateAbout);
}

std::optional<int> evaluate_in_lab(const std::vector<std::string>& words) {
  if (words.empty() || words[0] != kEvaluateCommand) return std::nullopt;
  const auto lab = find_program(kLabProgram);
  const Error error = lab ? start_program(*lab, {words.begin() + 1, words.end()}) : lab.error();
  return report_failure(kEvaluateCommand, error);
}

}  // namespace coppice::bake
