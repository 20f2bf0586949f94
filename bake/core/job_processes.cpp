// A job talks to its parent through a pipe, in messages: a byte that says what follows, the length of that, and that. The parent reads
// until the pipe ends, which it does when the job's process has, however that came about.

#include "job_processes.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <span>
#include <vector>

#include "failure_text.h"
#include "temporary_file.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

constexpr int kOutOfMemoryExit = 70;  // no other way out of a job has this code

enum class Message : char { progress = 'p', result = 'r', failure = 'f' };

/// A short message is one write, which no other thread's comes into.
void send(int file, Message kind, std::span<const std::uint8_t> data) {
  std::array<std::uint8_t, 512> block{};
  const std::uint64_t length = data.size();
  block[0] = static_cast<std::uint8_t>(kind);
  std::memcpy(block.data() + 1, &length, sizeof length);
  const std::size_t head = 1 + sizeof length, inside = std::min(data.size(), block.size() - head);
  std::copy_n(data.begin(), inside, block.begin() + head);
  if (!write_all(file, std::span(block).first(head + inside), {}) || !write_all(file, data.subspan(inside), {}))
    ::_exit(1);  // nobody listens
}

std::uint64_t memory_limit_bytes = 0;  // the one that the job's process has

std::string hint_of_limit(std::uint64_t bytes) {
  if (bytes == 0) return {};
  return ": it needs more than the " + std::to_string(bytes / 1'000'000) + " MB of --max-memory-mb; raise that";
}

/// Where memory runs out, in whatever thread and library, the job ends with a code of its own: nothing can be made then, and some libraries
/// do not survive an exception.
void limit_memory(std::uint64_t bytes) {
  std::set_new_handler([] {
    remove_own_temporaries();
    ::_exit(kOutOfMemoryExit);
  });
  memory_limit_bytes = bytes;
  const rlimit limit{bytes, bytes};
  if (bytes > 0) static_cast<void>(::setrlimit(RLIMIT_DATA, &limit));
}

std::string time_limit_text(double seconds) {
  char text[96];
  std::snprintf(text, sizeof text, "it takes more than the %g s of --max-seconds; raise that", seconds);
  return text;
}

/// The job's process. Leaves without the parent's exit handlers and buffers, which are copies here.
[[noreturn]] void become_job(std::size_t job, pid_t parent, int file, const JobCallbacks& callbacks, const JobLimits& limits) {
  limit_memory(limits.memory_bytes);
  // When the parent dies so does this, and leaves no temporary file.
  static_cast<void>(::signal(SIGTERM, end_by_signal));
  static_cast<void>(::prctl(PR_SET_PDEATHSIG, SIGTERM));
  if (::getppid() != parent) ::_exit(1);  // it died before that took effect
  std::string failure;
  try {
    const std::string result = callbacks.run(job, [file, sent = 0.0](double fraction) mutable {
      if (fraction < sent + 0.002) return;  // only steps that a bar would show: pipes are no place for millions of messages
      sent = fraction;
      send(file, Message::progress, {reinterpret_cast<const std::uint8_t*>(&fraction), sizeof fraction});
    });
    send(file, Message::result, bytes_of(result));
    ::_exit(0);
  } catch (const std::bad_alloc&) {
    ::_exit(kOutOfMemoryExit);
  } catch (const std::exception& error) {
    failure = failure_text(error);
  }
  send(file, Message::failure, bytes_of(failure));
  ::_exit(0);
}

using Clock = std::chrono::steady_clock;

struct RunningJob {
  std::size_t job = 0;
  pid_t process = 0;
  int file = -1;
  std::string unread;  ///< bytes of messages that are not whole yet
  JobEnd end{{}, "it ended without a result", 0};
  Clock::time_point started = Clock::now();
  bool timed_out = false;
};

/// Kills the jobs whose time is up. returns  until the next one's is, in milliseconds as poll() takes them
int kill_late(std::vector<RunningJob>& running, double max_seconds) {
  if (max_seconds <= 0.0) return -1;
  double next_s = 60.0;
  for (RunningJob& job : running) {
    const double left_s = max_seconds - std::chrono::duration<double>(Clock::now() - job.started).count();
    if (left_s <= 0.0 && !job.timed_out) {
      job.timed_out = true;
      ::kill(job.process, SIGKILL);
    }
    if (!job.timed_out) next_s = std::min(next_s, left_s);
  }
  return static_cast<int>(std::ceil(next_s * 1000.0));
}

/// Takes the messages that are whole off `running.unread`.
void take_messages(RunningJob& running, const JobCallbacks& callbacks) {
  constexpr std::size_t kHeadBytes = 1 + sizeof(std::uint64_t);
  std::size_t at = 0;
  while (running.unread.size() - at >= kHeadBytes) {
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, running.unread.data() + at + 1, sizeof bytes);
    if (running.unread.size() - at - kHeadBytes < bytes) break;
    const auto kind = static_cast<Message>(running.unread[at]);
    const std::string text = running.unread.substr(at + kHeadBytes, bytes);
    at += kHeadBytes + bytes;
    double fraction = 0.0;
    if (kind == Message::result)
      running.end = {text, {}, 0};
    else if (kind == Message::failure)
      running.end = {{}, text, 0};
    else if (callbacks.progressed && text.size() == sizeof fraction)
      callbacks.progressed(running.job, (std::memcpy(&fraction, text.data(), sizeof fraction), fraction));
  }
  running.unread.erase(0, at);
}

/// False at the end of the pipe.
bool read_some(RunningJob& running, const JobCallbacks& callbacks) {
  char block[4096];
  const ssize_t count = ::read(running.file, block, sizeof block);
  if (count < 0) return errno == EINTR || errno == EAGAIN;
  running.unread.append(block, static_cast<std::size_t>(count));
  take_messages(running, callbacks);
  return count > 0;
}

void finish(RunningJob& running, const JobCallbacks& callbacks, const JobLimits& limits) {
  ::close(running.file);
  int status = 0;
  rusage usage{};
  while (::wait4(running.process, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  // Some libraries abort where memory lacks.
  const std::string may_need = limits.memory_bytes > 0 ? "; it may need more than --max-memory-mb allows" : "";
  if (WIFEXITED(status) && WEXITSTATUS(status) == kOutOfMemoryExit)
    running.end = {{}, "out of memory" + hint_of_limit(limits.memory_bytes), 0, limits.memory_bytes == 0};
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    running.end = {{}, std::string("ended by a signal: ") + ::strsignal(signal) + may_need, 0, signal == SIGKILL || signal == SIGTERM};
  }
  if (WIFSIGNALED(status) && running.timed_out) running.end = {{}, time_limit_text(limits.seconds), 0};
  running.end.peak_rss_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  callbacks.ended(running.job, std::move(running.end));
}

/// Where the system gives no process the job has ended.
void start(std::size_t job, std::vector<RunningJob>& running, const JobCallbacks& callbacks, const JobLimits& limits) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    callbacks.ended(job, {{}, std::string("no pipe: ") + std::strerror(errno), 0, true});
    return;
  }
  const pid_t parent = ::getpid(), process = ::fork();
  if (process == 0) {
    ::close(ends[0]);
    for (const RunningJob& other : running) ::close(other.file);
    become_job(job, parent, ends[1], callbacks, limits);
  }
  const int reason = errno;
  ::close(ends[1]);
  if (process < 0) {
    ::close(ends[0]);
    callbacks.ended(job, {{}, std::string("no process: ") + std::strerror(reason), 0, true});
    return;
  }
  running.push_back({job, process, ends[0], {}});
}

}  // namespace

std::string memory_limit_hint() {
  return hint_of_limit(memory_limit_bytes);
}

void run_jobs(std::size_t count, std::size_t at_a_time, const JobCallbacks& callbacks, const JobLimits& limits) {
  std::vector<RunningJob> running;
  std::size_t next = 0;
  while (next < count || !running.empty()) {
    while (next < count && running.size() < at_a_time) start(next++, running, callbacks, limits);
    if (running.empty()) continue;
    std::vector<pollfd> files;
    files.reserve(running.size());
    for (const RunningJob& job : running) files.push_back({job.file, POLLIN, 0});
    if (::poll(files.data(), files.size(), kill_late(running, limits.seconds)) < 0) continue;
    for (std::size_t i = running.size(); i-- > 0;) {
      if (files[i].revents == 0 || read_some(running[i], callbacks)) continue;
      RunningJob ended = std::move(running[i]);
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
      finish(ended, callbacks, limits);
    }
  }
}

}  // namespace coppice::bake
