#include "child_program.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

#include "temporary_file.h"

namespace coppice::bake {
namespace {

struct Pipe {
  std::array<int, 2> ends{-1, -1};
  Pipe() = default;
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  void close_end(std::size_t end) {
    if (ends[end] >= 0) ::close(ends[end]);
    ends[end] = -1;
  }
};

/// What the child has instead of this process's files, signals and group.
struct SpawnRules {
  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};
  SpawnRules(const Pipe& out, const Pipe& err) {
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&files, out.ends[1], STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&files, err.ends[1], STDERR_FILENO);
    ::posix_spawnattr_init(&attributes);
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    ::posix_spawnattr_setpgroup(&attributes, 0);
  }
  SpawnRules(const SpawnRules&) = delete;
  SpawnRules& operator=(const SpawnRules&) = delete;
  ~SpawnRules() {
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
  }
};

/// The environment but for variables whose names begin so.
std::vector<char*> environment_without(std::span<const std::string_view> hidden) {
  std::vector<char*> variables;
  for (char** variable = environ; *variable != nullptr; ++variable)
    if (std::ranges::none_of(hidden, [&](std::string_view start) { return std::string_view(*variable).starts_with(start); }))
      variables.push_back(*variable);
  variables.push_back(nullptr);
  return variables;
}

Result<pid_t> spawn(const std::vector<std::string>& words, const Pipe& out, const Pipe& err, std::span<const std::string_view> hidden) {
  std::vector<std::string> texts = words;
  std::vector<char*> argv;
  argv.reserve(texts.size() + 1);
  for (std::string& text : texts) argv.push_back(text.data());
  argv.push_back(nullptr);
  const SpawnRules rules(out, err);
  pid_t child = 0;
  const std::vector<char*> environment = environment_without(hidden);
  const int reason = ::posix_spawnp(&child, argv[0], &rules.files, &rules.attributes, argv.data(), environment.data());
  if (reason != 0) return system_error("cannot start", words.front(), reason);
  return child;
}

/// False at its end.
bool read_into(std::string& text, int file) {
  std::array<char, 4096> block{};
  const ssize_t count = ::read(file, block.data(), block.size());
  if (count < 0) return errno == EINTR || errno == EAGAIN;
  text.append(block.data(), static_cast<std::size_t>(count));
  return count > 0;
}

int wait_for_end(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

Result<ProgramEnd> run_program(const std::vector<std::string>& words, double max_seconds, const std::function<bool()>& waiting,
                               std::span<const std::string_view> hidden) {
  Pipe out, err;
  for (Pipe* pipe : {&out, &err})
    if (::pipe2(pipe->ends.data(), O_CLOEXEC) != 0) return system_error("no pipe for", words.front(), errno);
  COPPICE_TRY(child, spawn(words, out, err, hidden));
  out.close_end(1);
  err.close_end(1);

  ProgramEnd end;
  const auto start = std::chrono::steady_clock::now();
  bool reads_out = true, reads_err = true, killed = false;
  while (reads_out || reads_err) {
    std::array<pollfd, 2> files{{{reads_out ? out.ends[0] : -1, POLLIN, 0}, {reads_err ? err.ends[0] : -1, POLLIN, 0}}};
    const int ready = ::poll(files.data(), files.size(), 100);
    if (ready > 0 && files[0].revents != 0) reads_out = read_into(end.out, out.ends[0]);
    if (ready > 0 && files[1].revents != 0) reads_err = read_into(end.err, err.ends[0]);
    const bool is_late = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > max_seconds;
    if (!killed && (is_late || (waiting && !waiting()))) {
      ::kill(-child, SIGKILL);
      killed = true;
    }
  }
  end.exit_code = wait_for_end(child);
  if (killed) end.exit_code = -1;
  return end;
}

}  // namespace coppice::bake
