// coppice-lab: the program that `coppice evaluate` becomes. To the user the two are one: its help and its messages say `coppice`.

#include <string>

#include "command_evaluate.h"
#include "evaluate_command.h"
#include "program.h"

// Memory that runs out before the first command may end the program.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char** argv) {
  const std::string name = std::string("coppice ") + coppice::bake::kEvaluateCommand;
  return coppice::bake::run_program({name.c_str(), coppice::bake::kEvaluateAbout, coppice::bake::declare_evaluate}, argc, argv);
}
