#include "program.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <new>
#include <sstream>
#include <string_view>

#include "command_line.h"
#include "completion.h"
#include "endings.h"
#include "failure_text.h"
#include "output.h"
#include "printable.h"

namespace coppice::bake {
namespace {

/// What is printed to a file or a pipe is written when it is whole, so that the reason why it cannot be is at hand.
void buffer_standard_output() {
  static std::array<char, std::size_t{1} << 16> printed;
  if (::isatty(STDOUT_FILENO) == 0) static_cast<void>(std::setvbuf(stdout, printed.data(), _IOFBF, printed.size()));
}

/// Prints what is wrong with the command line. returns the exit code
int report_usage(const Program& program, const CLI::App& app, const CLI::ParseError& error, const std::vector<std::string>& words) {
  const std::string unknown = command_line::unknown_word(app, words);
  if (unknown.empty())
    app.exit(error);
  else
    std::fprintf(stderr, "%s\nRun with --help for more information.\n", printable(unknown).c_str());
  const bool is_extra = !unknown.empty() || error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError);
  if (is_extra && program.hint) std::fputs(program.hint(words).c_str(), stderr);
  return 2;
}

}  // namespace

int run_program(const Program& program, int argc, char** argv) {
  install_endings();
  buffer_standard_output();
  CLI::App app{program.about, program.name};
  app.formatter(command_line::help_format());
  // What is wrong with an argument quotes it.
  app.failure_message(
      [](const CLI::App*, const CLI::Error& error) { return printable(error.what()) + "\nRun with --help for more information.\n"; });
  int exit_code = 0;
  program.declare(app, &exit_code);
  try {
    if (argc == 1 && !app.get_subcommands({}).empty()) throw CLI::CallForHelp();
    if (argc > 1 && argv[1] == std::string_view(command_line::kCompleteOption))
      std::fputs(command_line::completions(app, {argv + 2, argv + argc}).c_str(), stdout);
    else
      app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    std::ostringstream text;  // --help, --version
    exit_code = app.exit(success, text, text);
    std::fputs(text.str().c_str(), stdout);
  } catch (const CLI::ParseError& error) {
    exit_code = report_usage(program, app, error, {argv + 1, argv + argc});
  } catch (const std::bad_alloc&) {
    end_out_of_memory();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "coppice: %s\n", printable(failure_text(error)).c_str());
    exit_code = 1;
  }
  return finish_standard_output(exit_code);
}

}  // namespace coppice::bake
