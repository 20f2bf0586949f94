#include "servers.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <ext/stdio_filebuf.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <istream>
#include <ostream>
#include <regex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tool.h"

namespace coppice::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// A socket, and its port of the loopback address, which was free.
std::pair<int, std::uint16_t> bound_socket() {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* const any_address = reinterpret_cast<sockaddr*>(&address);
  socklen_t length = sizeof address;
  if (::bind(socket, any_address, length) != 0 || ::getsockname(socket, any_address, &length) != 0)
    throw std::runtime_error("no free port");
  return {socket, ntohs(address.sin_port)};
}

std::string url_of(std::uint16_t port) {
  return "http://127.0.0.1:" + std::to_string(port);
}

std::string head(int status, const std::string& length, const std::string& more = "") {
  return "HTTP/1.1 " + std::to_string(status) + " Said\r\nConnection: close\r\n" + more +
         (length.empty() ? "" : "Content-Length: " + length + "\r\n") + "\r\n";
}

void answer_rightly(const ServerRequest& request, std::ostream& out) {
  out << head(request.status, std::to_string(request.content.size())) << request.content;
}

/// Reads a request, keeps what is put and finds what is asked for. False where it is not whole.
bool read_request(std::istream& in, const fs::path& folder, ServerRequest& request) {
  std::string line, body;
  in >> request.method >> request.target;
  const std::string length = "Content-Length: ";
  while (std::getline(in, line) && line != "\r")
    if (line.starts_with(length)) body.resize(std::stoul(line.substr(length.size())));
  if (!in.read(body.data(), static_cast<std::streamsize>(body.size()))) return false;
  std::ofstream(folder / "requests.log", std::ios::app) << request.method + " " + request.target + "\n";
  const fs::path path = folder / request.target.substr(1);
  if (request.method == "PUT") write_text(path, body);
  request.status = request.method == "PUT" ? 201 : fs::exists(path) ? 200 : 404;
  if (request.status == 200) request.content = read_text(path);
  return true;
}

/// Answers one request of a connection and closes it.
void serve(int connection, std::uint16_t port, const fs::path& folder, const ServerFault& fault) {
  __gnu_cxx::stdio_filebuf<char> in_buffer(connection, std::ios::in), out_buffer(::dup(connection), std::ios::out);
  std::istream in(&in_buffer);
  std::ostream out(&out_buffer);
  ServerRequest request{.port = port};
  if (!fault.is_deaf && !read_request(in, folder, request)) return;
  (fault.answer ? fault.answer : answer_rightly)(request, out);
  out.flush();
}

using Answer = std::function<void(const ServerRequest&, std::ostream&)>;

Answer says(int to_get, int to_put) {
  return [=](const ServerRequest& request, std::ostream& out) { out << head(request.method == "PUT" ? to_put : to_get, "0"); };
}

Answer says(const std::string& text) {
  return [=](const ServerRequest&, std::ostream& out) { out << text; };
}

/// Goes on until nobody listens any more.
Answer says_without_end(const std::string& first, const std::string& again, std::chrono::milliseconds pause = 0ms) {
  return [=](const ServerRequest&, std::ostream& out) {
    out << first;
    while (out << again << std::flush) std::this_thread::sleep_for(pause);
  };
}

/// For .coppice files that it has. All else it answers rightly.
Answer of_plants(const Answer& answer) {
  return [=](const ServerRequest& request, std::ostream& out) {
    (request.status == 200 && request.target.ends_with(".coppice") ? answer : Answer(answer_rightly))(request, out);
  };
}

Answer of_plants(const std::function<std::string(std::string)>& text) {
  return of_plants(Answer([=](const ServerRequest& request, std::ostream& out) { out << text(request.content); }));
}

Answer then_waits(const Answer& answer) {
  return [=](const ServerRequest& request, std::ostream& out) {
    answer(request, out);
    out << std::flush;
    if (request.target.ends_with(".coppice") && request.method == "GET") std::this_thread::sleep_for(60s);
  };
}

Answer late(std::chrono::milliseconds delay, const Answer& answer) {
  return [=](const ServerRequest& request, std::ostream& out) {
    std::this_thread::sleep_for(delay);
    answer(request, out);
  };
}

/// gzip's form of zeros without end: 2,064 of them in each 13 bytes.
Answer says_zeros_without_end(const std::string& coding) {
  using namespace std::string_literals;
  std::string again;
  for (int i = 0; i < 1000; ++i) again += "\xa3\x60\x14\x8c\x82\x51\x30\x0a\x46\xc1\x28\x18\x05";
  return says_without_end(head(200, "", coding + ": gzip\r\n") + "\x1f\x8b\x08\0\0\0\0\0\0\x03\x62\x18\x05"s, again);
}

/// HOST, FOLDER and every PORT are filled in.
constexpr const char* kConfig = R"(ClusterName=coppice
SlurmctldHost=HOST(127.0.0.1)
SlurmctldPort=PORT
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=FOLDER/munge/socket
StateSaveLocation=FOLDER/state
SlurmctldPidFile=FOLDER/controller.pid
SlurmctldLogFile=FOLDER/controller.log
SlurmdPidFile=FOLDER/%n.pid
SlurmdLogFile=FOLDER/%n.log
SlurmdSpoolDir=FOLDER/%n
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
# Nothing of the machine's: no control groups, no database, no mail.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MailProg=/bin/true
# Faults are found soon, and forgotten as soon.
ReturnToService=2
SlurmdTimeout=5
SlurmctldTimeout=5
KillWait=2
MinJobAge=10
MessageTimeout=5
SchedulerParameters=bf_interval=1,sched_interval=1,batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
NodeName=node1 NodeHostname=HOST NodeAddr=127.0.0.1 Port=PORT CPUs=1 RealMemory=16000 State=UNKNOWN
NodeName=node2 NodeHostname=HOST NodeAddr=127.0.0.1 Port=PORT CPUs=1 RealMemory=16000 State=UNKNOWN
PartitionName=farm Nodes=ALL Default=YES MaxTime=INFINITE State=UP
)";

std::string config_in(const fs::path& folder) {
  const std::string host = read_text("/proc/sys/kernel/hostname");
  std::string config = std::regex_replace(kConfig, std::regex("HOST"), host.substr(0, host.find_first_of(".\n")));
  config = std::regex_replace(config, std::regex("FOLDER"), folder.string());
  for (std::size_t at = 0; (at = config.find("PORT")) != std::string::npos;) config.replace(at, 4, std::to_string(free_port()));
  return config;
}

std::string node_name(std::size_t node) {
  return "node" + std::to_string(node + 1);
}

/// 0 where the process has just ended.
int parent_of(int id) {
  const std::string status = read_text("/proc/" + std::to_string(id) + "/status"), name = "PPid:";
  const std::size_t at = status.find(name);
  return at == std::string::npos ? 0 : std::stoi(status.substr(at + name.size()));
}

}  // namespace

std::vector<ServerFault> all_server_faults() {
  const auto redirect = [](const ServerRequest& request, std::ostream& out) {
    out << head(307, "0", "Location: http://localhost:" + std::to_string(request.port) + "/elsewhere\r\n");
  };
  const auto no_put = [](const ServerRequest& request, std::ostream& out) {
    late(request.method == "PUT" ? 60s : 0s, says(404, 201))(request, out);
  };
  const auto half = [](const std::string& content) {
    return head(200, std::to_string(content.size())) + content.substr(content.size() / 2);
  };
  const auto flipped = [](std::string content) {
    content[content.size() / 2] = static_cast<char>(content[content.size() / 2] ^ 1);
    return head(200, std::to_string(content.size())) + content;
  };
  const auto deep_record = [](const ServerRequest& request, std::ostream& out) {
    const std::string brackets(4u << 20, '[');
    if (request.target.ends_with(".record") && request.status == 200)
      out << head(200, std::to_string(brackets.size())) << brackets;
    else
      answer_rightly(request, out);
  };
  const std::string any_length = head(200, ""), page = "<html><title>Log in</title></html>", junk(7'500, '\0');
  return {
      {.name = "answers_503", .answer = says(503, 503), .told = "503"},
      {.name = "answers_401", .answer = says(401, 401), .told = "COPPICE_CACHE_CREDENTIALS"},
      {.name = "answers_403", .answer = says(403, 403), .told = "403"},
      {.name = "answers_404_to_all", .answer = says(404, 404), .told = "404"},
      {.name = "is_read_only", .answer = says(404, 403), .told = "403"},
      {.name = "is_full", .answer = says(404, 507), .told = "507"},
      {.name = "answers_206", .answer = of_plants([](const std::string& content) { return head(206, "") + content; }), .told = "206"},
      {.name = "redirects", .answer = redirect, .told = "307"},
      {.name = "flips_a_bit", .answer = of_plants(flipped), .lines = 3},
      {.name = "shows_a_page", .answer = says(head(200, std::to_string(page.size())) + page), .lines = 3},
      {.name = "sends_brackets_in_brackets", .answer = deep_record, .lines = 3},
      {.name = "sends_half", .answer = of_plants(half)},
      {.name = "sends_half_and_waits", .answer = then_waits(of_plants(half))},
      {.name = "sends_more_than_announced",
       .answer = of_plants([](const std::string& content) { return head(200, std::to_string(content.size())) + content + "more"; }),
       .lines = 0,
       .is_found = true},
      {.name = "announces_too_much", .answer = says(head(200, "99999999999999999999"))},
      {.name = "announces_two_lengths", .answer = says(head(200, "5", "Content-Length: 7\r\n") + "1234567"), .lines = 3},
      {.name = "trickles", .answer = of_plants(says_without_end(any_length, junk.substr(5'000), 50ms))},
      {.name = "drips", .answer = of_plants(says_without_end(any_length, junk, 50ms))},
      {.name = "sends_without_end", .answer = of_plants(says_without_end(any_length, junk))},
      {.name = "sends_a_missing_page_without_end", .answer = says_without_end(head(404, ""), junk)},
      {.name = "sends_zeros_in_gzip", .answer = of_plants(says_zeros_without_end("Content-Encoding"))},
      {.name = "sends_zeros_in_gzip_for_transfer", .answer = of_plants(says_zeros_without_end("Transfer-Encoding"))},
      {.name = "sends_trailers_without_end",
       .answer = says_without_end(head(200, "", "Transfer-Encoding: chunked\r\n") + "0\r\n", "Trailer: x\r\n")},
      {.name = "says_102_without_end", .answer = says_without_end("", "HTTP/1.1 102 Said\r\nNote: x\r\n\r\n")},
      {.name = "sends_headers_without_end", .answer = says_without_end("HTTP/1.1 200 Said\r\n", "Note: x\r\n")},
      {.name = "sends_a_header_without_end", .answer = says_without_end("HTTP/1.1 200 Said\r\nNote: ", "x")},
      {.name = "is_no_http_server", .answer = says("SSH-2.0-server\r\n")},
      {.name = "closes_at_once", .answer = says(""), .is_deaf = true},
      {.name = "closes_unanswered", .answer = says("")},
      {.name = "closes_in_the_status", .answer = says("HTTP/1.1 20")},
      {.name = "closes_in_a_header", .answer = says("HTTP/1.1 200 Said\r\nContent-Le"), .lines = 3},
      {.name = "is_20_s_late", .answer = late(20s, answer_rightly)},
      {.name = "never_listens", .answer = late(60s, says("")), .is_deaf = true},
      {.name = "never_answers_a_put", .answer = no_put},
      {.name = "knows_no_tls", .answer = says(page), .is_deaf = true, .scheme = "https"},
      {.name = "waits_in_tls", .answer = late(60s, says("")), .is_deaf = true, .scheme = "https"},
  };
}

ServerFault late_server() {
  return {.name = "is_late", .answer = late(2500ms, says(404, 201))};
}

void PrintTo(const ServerFault& fault, std::ostream* out) {
  *out << fault.name;
}

FaultyServer::FaultyServer(const fs::path& folder, const ServerFault& fault) : log_(folder / "requests.log"), scheme_(fault.scheme) {
  fs::create_directories(folder);
  const auto [socket, port] = bound_socket();
  port_ = port;
  if (::listen(socket, 64) != 0) throw std::runtime_error("cannot listen");
  process_ = ::fork();
  if (process_ < 0) throw std::runtime_error("fork failed");
  if (process_ == 0) {
    static_cast<void>(::signal(SIGPIPE, SIG_IGN));
    static_cast<void>(::prctl(PR_SET_PDEATHSIG, SIGKILL));
    while (true)
      if (const int connection = ::accept(socket, nullptr, nullptr); connection >= 0)
        std::thread(serve, connection, port_, folder, fault).detach();
  }
  ::close(socket);
}

FaultyServer::~FaultyServer() {
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

std::string FaultyServer::url() const {
  return scheme_ + url_of(port_).substr(4);
}

std::string FaultyServer::requests() const {
  return read_text(log_);
}

std::uint16_t free_port() {
  const auto [socket, port] = bound_socket();
  ::close(socket);
  return port;
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
  fs::create_directories(root());
  write_text(folder_ / "nginx.conf", std::string(::geteuid() == 0 ? "user root;" : "") + R"(
pid nginx.pid;
events {}
http {
access_log access.log;
client_body_temp_path body; proxy_temp_path proxy; fastcgi_temp_path fastcgi; uwsgi_temp_path uwsgi; scgi_temp_path scgi;
)" + server_block + "\n}\n");
  process_ = std::make_unique<BackgroundProcess>("/usr/sbin/nginx", Words{"-p", folder_.string() + "/", "-e", "error.log", "-c",
                                                                          folder_ / "nginx.conf", "-g", "daemon off; worker_processes 1;"});
  // nginx writes its number once it listens.
  if (!comes_true([&] { return fs::exists(folder_ / "nginx.pid"); }, 5s))
    throw std::runtime_error("nginx does not start: " + process_->err() + read_text(folder_ / "error.log"));
}

std::string Nginx::url() const {
  return url_of(port_);
}

std::size_t Nginx::request_count() const {
  return count_of(read_text(folder_ / "access.log"), "\n");
}

std::string SlurmCluster::missing() {
  for (const std::string name : {"munged", "slurmctld", "slurmd", "sbatch", "squeue"})
    if (program_on_path(name).empty()) return "no " + name + ": third_party/install --optional installs slurm-wlm and munge";
  return ::geteuid() == 0 ? "" : "slurmd needs root";
}

SlurmCluster::SlurmCluster() {
  fs::create_directories(folder_ / "state");
  write_text(folder_ / "slurm.conf", config_in(folder_.path()));
  const fs::path munge = folder_ / "munge";
  std::string key(64, '\0');
  std::ifstream("/dev/urandom", std::ios::binary).read(key.data(), static_cast<std::streamsize>(key.size()));
  write_text(munge / "key-file", key);
  fs::permissions(munge / "key-file", fs::perms::owner_read);
  Words options{"--foreground", "--force"};  // the folders above are not root's alone
  for (const std::string name : {"key-file", "socket", "pid-file", "log-file", "seed-file"})
    options.push_back("--" + name + "=" + (munge / name).string());
  munge_ = start("munged", options);
  if (!comes_true([&] { return fs::exists(munge / "socket"); })) throw std::runtime_error("munged does not start: " + munge_->err());
  start_controller();
  // A node has a processor of its own, as far as there are as many.
  for (std::size_t node = 0; node < nodes_.size(); ++node)
    nodes_[node] = start("taskset", {"--cpu-list", std::to_string(node % std::max(1u, std::thread::hardware_concurrency())),
                                     program_on_path("slurmd"), "-D", "-N", node_name(node), "-f", folder_ / "slurm.conf"});
  if (!comes_true([&] { return run("sinfo", {"--noheader", "--Node", "--format=%T"}).out == "idle\nidle\n"; }))
    throw std::runtime_error("Slurm does not start: " + controller_->err() + nodes_.front()->err());
}

SlurmCluster::~SlurmCluster() {
  for (std::size_t node = 0; node < nodes_.size(); ++node) kill_node(node);
}

ProcessOptions SlurmCluster::environment() const {
  ProcessOptions options;
  options.environment = {"SLURM_CONF=" + (folder_ / "slurm.conf").string()};
  return options;
}

std::unique_ptr<BackgroundProcess> SlurmCluster::start(const std::string& name, const std::vector<std::string>& arguments) const {
  return std::make_unique<BackgroundProcess>(program_on_path(name), arguments, environment());
}

ProcessResult SlurmCluster::run(const std::string& name, const std::vector<std::string>& arguments) const {
  return run_process(program_on_path(name), arguments, environment());
}

std::string SlurmCluster::queue(const std::string& format) const {
  return run("squeue", {"--noheader", "--array", "--states=all", "--format=" + format}).out;
}

std::vector<int> SlurmCluster::processes_on(std::size_t node) const {
  const std::string cluster = environment().environment.front(), name = "SLURMD_NODENAME=" + node_name(node);
  std::vector<int> ids;
  for (const fs::directory_entry& process : fs::directory_iterator("/proc")) {
    const std::string variables = read_text(process.path() / "environ");
    if (variables.find(cluster) != std::string::npos && variables.find(name) != std::string::npos)
      ids.push_back(std::stoi(process.path().filename()));
  }
  std::ranges::sort(ids);
  return ids;
}

void SlurmCluster::kill_node(std::size_t node) {
  if (!nodes_[node]) return;
  nodes_[node]->send(SIGKILL);
  const std::vector<int> tasks = processes_on(node);
  // The daemon of a task is the script's parent. It dies first: it would tell the controller of the others' deaths.
  for (const int id : tasks)
    if (const int parent = parent_of(id); read_text("/proc/" + std::to_string(parent) + "/cmdline").starts_with("slurmstepd"))
      ::kill(parent, SIGKILL);
  for (const int id : tasks) ::kill(id, SIGKILL);
  nodes_[node].reset();
}

void SlurmCluster::kill_controller() {
  controller_->send(SIGKILL);
  controller_.reset();
}

void SlurmCluster::start_controller() {
  controller_ = start("slurmctld", {"-D", "-f", folder_ / "slurm.conf"});
}

}  // namespace coppice::test
