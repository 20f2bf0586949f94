#include "child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <thread>

#include "failure.h"

namespace forest {
namespace {

using Clock = std::chrono::steady_clock;
using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// Files do not fill up as pipes do, and nobody has to read them meanwhile.
File temporary_file() {
  File file(std::tmpfile(), std::fclose);
  if (!file) throw Failure(std::string("cannot make a temporary file: ") + std::strerror(errno));
  return file;
}

std::string text_of(std::FILE* file) {
  std::string text;
  std::array<char, 4096> block{};
  std::rewind(file);
  while (const std::size_t count = std::fread(block.data(), 1, block.size(), file)) text.append(block.data(), count);
  return text;
}

pid_t start_self(std::vector<std::string> arguments, std::FILE* out, std::FILE* err) {
  arguments.insert(arguments.begin(), "coppice-forest");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&files, ::fileno(out), STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&files, ::fileno(err), STDERR_FILENO);
  pid_t child = 0;
  const int reason = ::posix_spawn(&child, "/proc/self/exe", &files, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&files);
  if (reason != 0) throw Failure(std::string("cannot start this program again: ") + std::strerror(reason));
  return child;
}

/// False: it runs on.
bool wait_until(pid_t child, Clock::time_point end, int& status, const std::function<void()>& waiting) {
  while (::waitpid(child, &status, WNOHANG) != child) {
    if (Clock::now() >= end) return false;
    waiting();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return true;
}

}  // namespace

ChildEnd run_self(const std::vector<std::string>& arguments, double limit_s, const std::function<void(double)>& waiting) {
  const File out = temporary_file(), err = temporary_file();
  const auto start = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  const pid_t child = start_self(arguments, out.get(), err.get());
  ChildEnd end;
  int status = 0;
  end.in_time = wait_until(child, start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limit_s)), status, [&] {
    if (waiting) waiting(seconds());
  });
  end.seconds = seconds();
  if (end.in_time) {
    end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  } else {
    ::kill(child, SIGKILL);
    wait_until(child, Clock::now() + std::chrono::seconds(1), status, [] {});
  }
  end.out = text_of(out.get());
  end.err = text_of(err.get());
  return end;
}

}  // namespace forest
