#include "cache_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "text_files.h"

namespace coppice::test {
namespace {

namespace fs = std::filesystem;

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

std::uint16_t bind_free_port(int socket) {
  sockaddr_in address = loopback(0);
  socklen_t length = sizeof address;
  if (::bind(socket, reinterpret_cast<const sockaddr*>(&address), length) != 0 ||
      ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length) != 0)
    throw std::runtime_error("no free port");
  return ntohs(address.sin_port);
}

std::uint16_t free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const std::uint16_t port = bind_free_port(socket);
  ::close(socket);
  return port;
}

bool is_listened_at(std::uint16_t port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = loopback(port);
  const bool connected = ::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(socket);
  return connected;
}

std::string url_of(std::uint16_t port) {
  return "http://127.0.0.1:" + std::to_string(port);
}

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

/// Everything that a connection receives up to and with `end`; empty at the connection's end.
std::string receive_until(int socket, std::string& unread, const std::string& end) {
  while (unread.find(end) == std::string::npos) {
    std::array<char, 4096> block{};
    const ssize_t count = ::read(socket, block.data(), block.size());
    if (count <= 0) return {};
    unread.append(block.data(), static_cast<std::size_t>(count));
  }
  std::string head = unread.substr(0, unread.find(end) + end.size());
  unread.erase(0, head.size());
  return head;
}

std::string receive_bytes(int socket, std::string& unread, std::size_t bytes) {
  while (unread.size() < bytes) {
    std::array<char, 65536> block{};
    const ssize_t count = ::read(socket, block.data(), block.size());
    if (count <= 0) break;
    unread.append(block.data(), static_cast<std::size_t>(count));
  }
  std::string body = unread.substr(0, bytes);
  unread.erase(0, body.size());
  return body;
}

void send_all(int socket, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t count = ::write(socket, text.data() + at, text.size() - at);
    if (count <= 0) return;
    at += static_cast<std::size_t>(count);
  }
}

/// The server's process.
class Serving {
 public:
  Serving(fs::path folder, const ServerFaults& faults) : folder_(std::move(folder)), faults_(faults) {}

  [[noreturn]] void listen_at(int socket) {
    while (true) {
      const int connection = ::accept(socket, nullptr, nullptr);
      if (connection >= 0) std::thread([this, connection] { serve(connection); }).detach();
    }
  }

 private:
  void serve(int connection) {
    std::string unread;
    while (serve_one(connection, unread)) {
    }
    ::close(connection);
  }

  /// False: the connection is at its end.
  bool serve_one(int connection, std::string& unread) {
    const std::string head = receive_until(connection, unread, "\r\n\r\n");
    std::string method, target;
    std::istringstream(head) >> method >> target;
    if (target.empty() || target.find("..") != std::string::npos) return false;
    const std::string length = "Content-Length: ";
    const std::size_t at = head.find(length);
    const std::string body = receive_bytes(connection, unread, at == std::string::npos ? 0 : std::stoul(head.substr(at + length.size())));
    log(method + " " + target);
    std::this_thread::sleep_for(std::chrono::duration<double>(faults_.delay_s));
    return method == "PUT" ? put(connection, target, body) : get(connection, method, target);
  }

  bool put(int connection, const std::string& target, const std::string& body) {
    if (faults_.put_status != 0) return answer(connection, faults_.put_status, "", true);
    const std::scoped_lock lock(mutex_);
    const fs::path path = folder_ / target.substr(1);
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << body;
    return answer(connection, 201, "", true);
  }

  bool get(int connection, const std::string& method, const std::string& target) {
    if (faults_.get_status != 0) return answer(connection, faults_.get_status, "", method != "HEAD");
    std::string body;
    {
      const std::scoped_lock lock(mutex_);
      const fs::path path = folder_ / target.substr(1);
      std::error_code error;
      if (!fs::is_regular_file(path, error)) return answer(connection, 404, "", method != "HEAD");
      body = read_text(path);
    }
    const bool is_entry = target.ends_with(".coppice");
    if (is_entry) body.append(faults_.padding_bytes, '\0');
    if (is_entry && faults_.bytes_per_s > 0.0 && method != "HEAD") return trickle(connection, body);
    if (faults_.wrong_bytes && is_entry) body[body.size() / 2] = static_cast<char>(body[body.size() / 2] ^ 1);
    if (!faults_.half_bodies || !is_entry || method == "HEAD") return answer(connection, 200, body, method != "HEAD");
    send_all(connection, head_of(200, body.size()) + body.substr(0, body.size() / 2));
    return false;
  }

  bool trickle(int connection, const std::string& body) const {
    constexpr double kStep_s = 0.05;
    send_all(connection, head_of(200, body.size()));
    const auto step = static_cast<std::size_t>(faults_.bytes_per_s * kStep_s);
    for (std::size_t at = 0; at < body.size(); at += step) {
      send_all(connection, body.substr(at, step));
      std::this_thread::sleep_for(std::chrono::duration<double>(kStep_s));
    }
    return true;
  }

  static std::string head_of(int status, std::size_t bytes) {
    return "HTTP/1.1 " + std::to_string(status) + " Said\r\nContent-Length: " + std::to_string(bytes) + "\r\n\r\n";
  }

  static bool answer(int connection, int status, const std::string& body, bool with_body) {
    send_all(connection, head_of(status, body.size()) + (with_body ? body : ""));
    return true;
  }

  void log(const std::string& line) {
    const std::scoped_lock lock(mutex_);
    std::ofstream(folder_ / "requests.log", std::ios::app) << line << "\n";
  }

  fs::path folder_;
  ServerFaults faults_;
  std::mutex mutex_;
};

}  // namespace

FaultyServer::FaultyServer(fs::path folder, const ServerFaults& faults) : folder_(std::move(folder)) {
  fs::create_directories(folder_);
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  port_ = bind_free_port(socket);
  if (::listen(socket, 64) != 0) throw std::runtime_error("cannot listen");
  process_ = ::fork();
  if (process_ < 0) throw std::runtime_error("fork failed");
  if (process_ == 0) {
    static_cast<void>(::signal(SIGPIPE, SIG_IGN));
    static_cast<void>(::prctl(PR_SET_PDEATHSIG, SIGKILL));
    Serving(folder_, faults).listen_at(socket);
  }
  ::close(socket);
}

FaultyServer::~FaultyServer() {
  ::kill(process_, SIGKILL);
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

std::string FaultyServer::url() const {
  return url_of(port_);
}

std::vector<std::string> FaultyServer::requests() const {
  return lines_of(folder_ / "requests.log");
}

std::string dead_url() {
  return url_of(free_port());
}

bool Nginx::is_there() {
  return fs::exists("/usr/sbin/nginx");
}

Nginx::Nginx(const fs::path& folder, std::string server_block) : folder_(folder), port_(free_port()) {
  const auto put = [&server_block](const std::string& from, const std::string& to) {
    const std::size_t at = server_block.find(from);
    if (at == std::string::npos) throw std::runtime_error("no " + from + " in the server block");
    server_block.replace(at, from.size(), to);
  };
  put("8080", "127.0.0.1:" + std::to_string(port_));
  put("/srv/coppice-cache", root().string());
  for (const char* name : {"objects", "body", "logs"}) fs::create_directories(folder_ / name);
  std::ofstream(folder_ / "nginx.conf") << (::geteuid() == 0 ? "user root;\n" : "") << "pid nginx.pid;\nevents {}\nhttp {\n"
                                        << "log_format short '$request_method $uri $status';\naccess_log logs/access.log short;\n"
                                        << "client_body_temp_path body; proxy_temp_path body/p; fastcgi_temp_path body/f;\n"
                                        << "uwsgi_temp_path body/u; scgi_temp_path body/s;\n"
                                        << server_block << "\n}\n";
  process_ = std::make_unique<BackgroundProcess>(
      "/usr/sbin/nginx", std::vector<std::string>{"-p", folder_.string() + "/", "-e", "logs/error.log", "-c", folder_ / "nginx.conf", "-g",
                                                  "daemon off; worker_processes 1;"});
  for (int i = 0; !is_listened_at(port_); ++i) {
    if (i == 500) throw std::runtime_error("nginx does not start: " + process_->err() + read_text(folder_ / "logs/error.log"));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

std::string Nginx::url() const {
  return url_of(port_);
}

std::vector<std::string> Nginx::requests() const {
  return lines_of(folder_ / "logs/access.log");
}

}  // namespace coppice::test
