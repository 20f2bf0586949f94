#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "commands.h"
#include "completion.h"

namespace coppice::bake {

void add_completion_command(CLI::App& app, int* exit_code) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("completion", "Print a script with which a shell completes this program's commands and options");
  command->footer(
      "`cmake --install` puts these scripts where shells look for them. Without that, in ~/.bashrc, in ~/.zshrc after compinit, or in "
      "~/.config/fish/config.fish:\n"
      "  source <(coppice completion bash)\n"
      "  source <(coppice completion zsh)\n"
      "  coppice completion fish | source\n"
      "coppice-forest --completion prints those of coppice-forest.");
  command->add_option("shell", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember(std::vector<std::string>(command_line::kShells.begin(), command_line::kShells.end())))
      ->type_name("SHELL");
  command->callback([name = app.get_name(), shell, exit_code] {
    std::fputs(command_line::completion_script(name, *shell).c_str(), stdout);
    *exit_code = 0;
  });
}

}  // namespace coppice::bake
