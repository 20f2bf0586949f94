#include "process.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "text_files.h"

namespace coppice::test {
namespace {

constexpr int kCannotStart = 127;

/// Runs in the child, between fork and exec: only calls that are safe there.
[[noreturn]] void become(char* const* argv, char* const* environment, const char* out, const char* err, const ProcessOptions& options) {
  constexpr int kCreate = O_WRONLY | O_CREAT | O_TRUNC;
  const int in_file = ::open("/dev/null", O_RDONLY);
  const int out_file = ::open(out, kCreate, 0600);
  const int err_file = ::open(err, kCreate, 0600);
  if (in_file < 0 || out_file < 0 || err_file < 0) ::_exit(kCannotStart);
  ::dup2(in_file, STDIN_FILENO);
  ::dup2(out_file, STDOUT_FILENO);
  ::dup2(err_file, STDERR_FILENO);
  if (options.largest_file_bytes) {
    const rlimit limit{*options.largest_file_bytes, *options.largest_file_bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ::execve(argv[0], argv, environment);
  ::_exit(kCannotStart);
}

/// Waits, killing the child when its time is up. Polls: a test may be 5 ms late.
int wait_for(pid_t child, const ProcessOptions& options, std::uint64_t& peak_rss_bytes) {
  int status = 0;
  rusage usage{};
  const auto start = std::chrono::steady_clock::now();
  bool killed = !options.kill_after && !options.kill_when_exists;
  const auto is_time = [&] {
    std::error_code error;
    return (options.kill_after && std::chrono::steady_clock::now() - start >= *options.kill_after) ||
           (options.kill_when_exists && std::filesystem::exists(*options.kill_when_exists, error));
  };
  while (true) {
    const pid_t ended = ::wait4(child, &status, killed ? 0 : WNOHANG, &usage);
    peak_rss_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
    if (ended == child) return status;
    if (ended < 0 && errno != EINTR) throw std::runtime_error("waitpid failed");
    if (!killed && is_time()) {
      ::kill(child, SIGKILL);
      killed = true;
    }
    if (!killed) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

/// As exec takes them: valid as long as `texts` is.
std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  list.reserve(texts.size() + 1);
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

/// Starts the program; what it prints goes to the files.
pid_t start(const std::filesystem::path& program, const std::vector<std::string>& arguments, const ProcessOptions& options,
            const std::string& out, const std::string& err) {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const std::vector<char*> argv = pointers(words);
  std::vector<std::string> variables = options.environment;
  // A name stands once: programs differ in which of two they take.
  const auto is_set = [&options](const std::string& name) {
    return std::ranges::any_of(options.environment, [&](const std::string& set) { return set.starts_with(name); });
  };
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string text = *variable;
    if (!is_set(text.substr(0, text.find('=') + 1))) variables.push_back(text);
  }
  const std::vector<char*> environment = pointers(variables);
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) become(argv.data(), environment.data(), out.c_str(), err.c_str(), options);
  return child;
}

std::filesystem::path make_temporary_folder() {
  std::string name = (std::filesystem::temp_directory_path() / "coppice-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make a temporary folder: " + std::string(std::strerror(errno)));
  return name;
}

}  // namespace

ProcessResult run_process(const std::filesystem::path& program, const std::vector<std::string>& arguments, const ProcessOptions& options) {
  const TemporaryFolder folder;
  const std::string out = options.out.value_or(folder / "out");
  const std::string err = folder / "err";
  ProcessResult result;
  const int status = wait_for(start(program, arguments, options, out, err), options, result.peak_rss_bytes);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  if (!options.out) result.out = read_text(out);
  result.err = read_text(err);
  if (result.exit_code == kCannotStart) throw std::runtime_error("cannot start " + program.string());
  return result;
}

BackgroundProcess::BackgroundProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                                     const ProcessOptions& options)
    : folder_(make_temporary_folder()) {
  child_ = start(program, arguments, options, folder_ / "out", folder_ / "err");
}

BackgroundProcess::~BackgroundProcess() {
  if (child_ > 0) {
    ::kill(child_, SIGTERM);
    ::waitpid(child_, nullptr, 0);
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string BackgroundProcess::out() const {
  return read_text(folder_ / "out");
}

std::string BackgroundProcess::err() const {
  return read_text(folder_ / "err");
}

int BackgroundProcess::wait() {
  std::uint64_t peak_rss_bytes = 0;
  const int status = wait_for(std::exchange(child_, -1), {}, peak_rss_bytes);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void BackgroundProcess::send(int signal) const {
  if (child_ > 0) ::kill(child_, signal);
}

std::filesystem::path program_on_path(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (std::filesystem::exists(std::filesystem::path(folder) / name)) return std::filesystem::path(folder) / name;
  return {};
}

TemporaryFolder::TemporaryFolder() : path_(make_temporary_folder()) {}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // a leftover folder in /tmp is no reason to fail
  std::filesystem::remove_all(path_, ignored);
}

std::string unwrapped(const std::string& text) {
  return std::regex_replace(text, std::regex("\n +"), " ");
}

}  // namespace coppice::test
