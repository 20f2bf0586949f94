#pragma once

namespace CLI {
class App;
}

namespace coppice::bake {

/// Adds the options of `coppice evaluate`. Its callback evaluates, and leaves the exit code in *exit_code.
void declare_evaluate(CLI::App& command, int* exit_code);

}  // namespace coppice::bake
