#pragma once

// What `coppice` and `coppice-lab` have in common between the start of the process and its exit code.

#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace coppice::bake {

struct Program {
  const char* name;   ///< in messages and in the help: "coppice"
  const char* about;  ///< the head of the help
  /// Adds options and sub-commands to the app. A callback of theirs leaves the exit code in *exit_code.
  std::function<void(CLI::App& app, int* exit_code)> declare;
  /// Returns lines to print below a usage error that an unknown word caused. Empty: there are none.
  std::function<std::string(const std::vector<std::string>& words)> hint = {};
};

/// Runs the program on its command line: parses it, calls what was chosen, and prints help, usage errors and failures. It also answers a
/// shell that completes a command line. Where a signal, an exception or lack of memory ends the process, its temporary files go first, and
/// the last says so in one line.
/// returns  the exit code: 0, 1 where something failed, 2 for a usage error
int run_program(const Program& program, int argc, char** argv);

}  // namespace coppice::bake
