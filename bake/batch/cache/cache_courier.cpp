// A message is a letter and a key: 'f' fetch, whose key is followed by what the entry is worth, and 'r' record, both with the socket that
// the answer goes to, 'd' damaged, 'o' offer. An answer is one byte, with a file in memory where there is an entry.

#include "cache_courier.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "cache_report_json.h"
#include "temporary_file.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

using Clock = std::chrono::steady_clock;

/// Closes itself. Shared by those who may answer.
class OpenFile {
 public:
  explicit OpenFile(int file) : file_(file) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (file_ >= 0) ::close(file_);
  }
  [[nodiscard]] int get() const { return file_; }

 private:
  int file_;
};

union FileMessage {
  cmsghdr head;
  std::array<char, CMSG_SPACE(sizeof(int))> bytes;
};

/// One message, with a file or without (-1). Nobody listening is no failure.
bool send_message(int socket, std::string text, int file) {
  iovec part{text.data(), text.size()};
  FileMessage control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (file >= 0) {
    message.msg_control = &control;
    message.msg_controllen = sizeof control;
    cmsghdr* head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(head), &file, sizeof file);
  }
  ssize_t sent = 0;
  do sent = ::sendmsg(socket, &message, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  return sent >= 0;
}

struct Message {
  std::string text;  ///< empty: the other end is closed
  int file = -1;
};

Message receive_message(int socket) {
  std::array<char, 256> text{};
  iovec part{text.data(), text.size()};
  FileMessage control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = &control;
  message.msg_controllen = sizeof control;
  ssize_t count = 0;
  do count = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  while (count < 0 && errno == EINTR);
  Message received;
  if (count > 0) received.text.assign(text.data(), static_cast<std::size_t>(count));
  const cmsghdr* head = CMSG_FIRSTHDR(&message);
  if (head != nullptr && head->cmsg_type == SCM_RIGHTS) std::memcpy(&received.file, CMSG_DATA(head), sizeof received.file);
  return received;
}

bool is_readable(int file, int milliseconds) {
  pollfd polled{file, POLLIN, 0};
  return ::poll(&polled, 1, milliseconds) > 0;
}

/// A file in memory with these bytes; -1 where the system gives none.
int memory_file(const std::vector<std::uint8_t>& bytes) {
  const int file = ::memfd_create("coppice-cache-entry", MFD_CLOEXEC);
  if (file < 0) return -1;
  if (write_all(file, bytes, "an entry of the cache")) return file;
  ::close(file);
  return -1;
}

std::optional<std::vector<std::uint8_t>> contents(int file) {
  const off_t bytes = ::lseek(file, 0, SEEK_END);
  if (bytes < 0) return std::nullopt;
  std::vector<std::uint8_t> contents(static_cast<std::size_t>(bytes));
  std::size_t at = 0;
  while (at < contents.size()) {
    const ssize_t count = ::pread(file, contents.data() + at, contents.size() - at, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return std::nullopt;
    at += static_cast<std::size_t>(count);
  }
  return contents;
}

void serve(RemoteCache& cache, const Message& message) {
  const std::string key = message.text.substr(1);
  if (message.text[0] == 'o') cache.offer(key);
  if (message.text[0] == 'd') cache.found_damaged(key);
  const auto reply = std::make_shared<OpenFile>(message.file);
  const auto answer = [reply](const std::vector<std::uint8_t>& bytes) {
    const OpenFile file(bytes.empty() ? -1 : memory_file(bytes));
    send_message(reply->get(), file.get() >= 0 ? "y" : "n", file.get());
  };
  if (message.text[0] == 'r') cache.fetch_record(key, answer);
  if (message.text[0] != 'f') return;
  std::istringstream words(key);
  std::string wanted;
  EntryWorth worth;
  words >> wanted >> worth.seconds >> worth.most_bytes;
  cache.fetch(wanted, worth, answer);
}

void run(const RemoteCacheOptions& options, int socket, int report) {
  RemoteCache cache(options);
  for (bool is_open = true; is_open;) {
    cache.step(1.0, socket);
    while (is_open && is_readable(socket, 0)) {
      const Message message = receive_message(socket);
      is_open = !message.text.empty();
      if (is_open) serve(cache, message);
    }
  }
  cache.finish();
  const std::string text = nlohmann::json(cache.report()).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  static_cast<void>(write_all(report, bytes_of(text), "the cache's report"));
}

/// The courier's process. Leaves without the parent's exit handlers, which are copies here.
[[noreturn]] void become_courier(const RemoteCacheOptions& options, pid_t parent, int socket, int report) {
  std::set_new_handler([] { ::_exit(1); });
  static_cast<void>(::signal(SIGPIPE, SIG_IGN));
  static_cast<void>(::signal(SIGTERM, SIG_DFL));
  static_cast<void>(::prctl(PR_SET_PDEATHSIG, SIGTERM));
  // What is typed at the terminal is for the batch: this ends with it, and not before.
  static_cast<void>(::signal(SIGINT, SIG_IGN));
  if (::getppid() != parent) ::_exit(1);  // it died before that took effect
  try {
    run(options, socket, report);
  } catch (const std::exception&) {
    ::_exit(1);  // the parent misses the report, and says so
  }
  ::_exit(0);
}

}  // namespace

std::optional<std::vector<std::uint8_t>> CourierLine::fetch(const std::string& key, const EntryWorth& worth) const {
  return ask("f" + key + " " + std::to_string(worth.seconds) + " " + std::to_string(worth.most_bytes));
}

std::optional<std::vector<std::uint8_t>> CourierLine::fetch_record(const std::string& name) const {
  return ask("r" + name);
}

std::optional<std::vector<std::uint8_t>> CourierLine::ask(const std::string& question) const {
  if (socket_ < 0) return std::nullopt;
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return std::nullopt;
  const OpenFile answers(ends[0]);
  const bool asked = send_message(socket_, question, ends[1]);
  ::close(ends[1]);
  if (!asked) return std::nullopt;
  const Message answer = receive_message(answers.get());
  const OpenFile file(answer.file);
  return file.get() >= 0 ? contents(file.get()) : std::nullopt;
}

void CourierLine::found_damaged(const std::string& key) const {
  if (socket_ >= 0) send_message(socket_, "d" + key, -1);
}

void CourierLine::offer(const std::string& key) const {
  if (socket_ >= 0) send_message(socket_, "o" + key, -1);
}

CacheCourier::CacheCourier(int socket, int report, pid_t process, std::string where)
    : socket_(socket), report_(report), process_(process), where_(std::move(where)) {}

CacheCourier::CacheCourier(CacheCourier&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      report_(std::exchange(other.report_, -1)),
      process_(std::exchange(other.process_, 0)),
      where_(std::move(other.where_)),
      start_(other.start_) {}

CacheCourier::~CacheCourier() {
  stop();
}

Result<CacheCourier> CacheCourier::start(const RemoteCacheOptions& options) {
  COPPICE_CHECK(load_http());  // here, where somebody hears that it is missing
  int line[2], report[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, line) != 0) return system_error("no socket", "cache", errno);
  const OpenFile courier_line(line[1]);
  CacheCourier courier(line[0], -1, 0, options.url);
  if (::pipe2(report, O_CLOEXEC) != 0) return system_error("no pipe", "cache", errno);
  courier.report_ = report[0];
  const OpenFile courier_report(report[1]);
  const pid_t parent = ::getpid(), process = ::fork();
  if (process == 0) {
    ::close(line[0]);
    ::close(report[0]);
    become_courier(options, parent, line[1], report[1]);
  }
  if (process < 0) return system_error("no process", "cache", errno);
  courier.process_ = process;
  return courier;
}

void CacheCourier::stop() {
  if (socket_ >= 0) ::close(std::exchange(socket_, -1));
  if (report_ >= 0) ::close(std::exchange(report_, -1));
  if (process_ <= 0) return;
  ::kill(process_, SIGKILL);
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
  process_ = 0;
}

CacheReport CacheCourier::finish() {
  const Clock::time_point start = Clock::now();
  CacheReport report = take_report();
  report.lost_seconds += std::chrono::duration<double>(Clock::now() - start).count();
  return report;
}

CacheReport CacheCourier::take_report() {
  ::close(std::exchange(socket_, -1));
  // As long as the courier may take, and a little for its last words.
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
  const auto until =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::max(2.0, 0.05 * elapsed_s) + 0.5));
  std::string text;
  std::array<char, 4096> block{};
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    if (left <= 0 || !is_readable(report_, static_cast<int>(left))) break;
    const ssize_t count = ::read(report_, block.data(), block.size());
    if (count == 0) break;
    if (count > 0) text.append(block.data(), static_cast<std::size_t>(count));
  }
  stop();
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_object()) return json.get<CacheReport>();
  CacheReport lost;
  lost.where = where_;
  lost.trouble = "the process that asks it ended early, or had no answer in time";
  return lost;
}

}  // namespace coppice::bake
