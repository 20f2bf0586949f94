#include <CLI/CLI.hpp>
#include <utility>

#include "commands.h"
#include "completion.h"
#include "evaluate_command.h"
#include "output.h"
#include "sibling_program.h"

namespace coppice::bake {

void add_evaluate_command(CLI::App& app, int*) {
  app.add_subcommand(kEvaluateCommand, kEvaluateAbout);
}

std::optional<int> evaluate_in_lab(std::vector<std::string> words) {
  // A shell that completes is the laboratory's affair once it is behind the command.
  const bool completes = words.size() > 2 && words[0] == command_line::kCompleteOption;
  const std::size_t at = completes ? 1 : 0;
  if (words.size() <= at || words[at] != kEvaluateCommand) return std::nullopt;
  words.erase(words.begin() + static_cast<std::ptrdiff_t>(at));
  const auto lab = find_program(kLabProgram);
  return report_failure(kEvaluateCommand, lab ? start_program(*lab, std::move(words)) : lab.error());
}

}  // namespace coppice::bake
