#include "endings.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string_view>

#include "failure_text.h"
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

// Before the constructors of all libraries, which allocate too.
[[gnu::section(".preinit_array"), gnu::used]] void (*const first_of_all)() = install_first;

}  // namespace

void end_out_of_memory() noexcept {
  // Of threads that come here at the same time one has the word.
  static std::atomic_flag ending = ATOMIC_FLAG_INIT;
  while (ending.test_and_set()) ::pause();
  remove_own_temporaries();
  constexpr std::string_view kLine = "coppice: out of memory\n";
  const ssize_t ignored = ::write(STDERR_FILENO, kLine.data(), kLine.size());
  static_cast<void>(ignored);  // there is nobody left to tell
  ::_exit(1);
}

void install_endings() {
  open_standard_streams();
  // Beyond a limit of the file's size a write fails with its reason, which says more than this signal.
  static_cast<void>(::signal(SIGXFSZ, SIG_IGN));
  for (const int signal : std::array{SIGHUP, SIGINT, SIGQUIT, SIGPIPE, SIGALRM, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU}) clean_up_on(signal);
}

}  // namespace coppice::bake
