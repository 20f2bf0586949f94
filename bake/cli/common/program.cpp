#include "program.h"

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <sstream>
#include <string_view>

#include "command_line.h"
#include "completion.h"
#include "failure_text.h"
#include "output.h"
#include "printable.h"
#include "temporary_file.h"

namespace coppice::bake {
namespace {

/// A program that was started without them would give their numbers to its own files, and print into those.
void open_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    if (::fcntl(stream, F_GETFD) < 0 && errno == EBADF) {
      // What is printed to a standard output that is not there fails, as it should.
      const int opened = ::open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
      static_cast<void>(opened);  // the lowest number that is free
    }
}

/// One that the parent ignores, as nohup does, stays ignored.
void clean_up_on(int signal) {
  struct sigaction action {};
  if (::sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) return;
  action = {};
  action.sa_handler = end_by_signal;
  static_cast<void>(::sigaction(signal, &action, nullptr));
}

/// Says that memory has run out and ends the program. Allocates nothing.
[[noreturn]] void end_out_of_memory() noexcept {
  // Where threads come here at the same time, one has the word.
  static std::atomic_flag ending = ATOMIC_FLAG_INIT;
  while (ending.test_and_set()) ::pause();
  remove_own_temporaries();
  constexpr std::string_view kLine = "coppice: out of memory\n";
  const ssize_t ignored = ::write(STDERR_FILENO, kLine.data(), kLine.size());
  static_cast<void>(ignored);  // there is nobody left to tell
  ::_exit(1);
}

/// An exception that got out of a thread of TBB's, or of a function that may not throw.
[[noreturn]] void end_by_exception() noexcept {
  try {
    if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    end_out_of_memory();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "coppice: %s\n", printable(failure_text(error)).c_str());
  } catch (...) {
    std::fprintf(stderr, "coppice: unknown exception\n");
  }
  remove_own_temporaries();
  ::_exit(1);
}

void install_first() {
  std::set_new_handler(end_out_of_memory);
  std::set_terminate(end_by_exception);
}

// Before the constructors of shared libraries, which allocate too: [[gnu::constructor]] comes after them, and where no memory is left they
// would end the program by SIGABRT (OutOfMemory, first allocation).
[[gnu::section(".preinit_array"), gnu::used]] void (*const first_of_all)() = install_first;

void install_endings() {
  open_standard_streams();
  // Beyond a limit of the file's size a write fails with its reason, which says more than this signal.
  static_cast<void>(::signal(SIGXFSZ, SIG_IGN));
  for (const int signal : std::array{SIGHUP, SIGINT, SIGQUIT, SIGPIPE, SIGALRM, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU}) clean_up_on(signal);
}

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
