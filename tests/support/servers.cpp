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

/// Answers one request of a connection and closes it.
void serve(int connection, const fs::path& folder, const ServerFaults& faults) {
  __gnu_cxx::stdio_filebuf<char> in_buffer(connection, std::ios::in), out_buffer(::dup(connection), std::ios::out);
  std::istream in(&in_buffer);
  std::ostream out(&out_buffer);
  std::string method, target, line, body;
  in >> method >> target;
  const std::string length = "Content-Length: ";
  while (std::getline(in, line) && line != "\r")
    if (line.starts_with(length)) body.resize(std::stoul(line.substr(length.size())));
  if (!in.read(body.data(), static_cast<std::streamsize>(body.size()))) return;
  std::ofstream(folder / "requests.log", std::ios::app) << method + " " + target + "\n";
  std::this_thread::sleep_for(std::chrono::duration<double>(faults.delay_s));

  const fs::path path = folder / target.substr(1);
  int status = method == "PUT" ? faults.put_status : faults.get_status;
  std::string sent;
  if (status == 0 && method == "PUT") {
    write_text(path, body);
    status = 201;
  } else if (status == 0) {
    sent = read_text(path);
    status = fs::exists(path) ? 200 : 404;
  }
  const SentBody fault = status == 200 && target.ends_with(".coppice") ? faults.body : SentBody::whole;
  const std::size_t announced_bytes = sent.size() + (fault == SentBody::trickling ? 50'000'000 : 0);
  if (fault == SentBody::wrong) sent[sent.size() / 2] = static_cast<char>(sent[sent.size() / 2] ^ 1);
  if (fault == SentBody::half) sent.resize(sent.size() / 2);
  out << "HTTP/1.1 " << status << " Said\r\nConnection: close\r\nContent-Length: " << announced_bytes << "\r\n\r\n" << sent << std::flush;
  while (fault == SentBody::trickling && out << std::string(2'500, '\0') << std::flush) std::this_thread::sleep_for(50ms);
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

std::vector<NamedFaults> all_server_faults() {
  return {{"503", {.get_status = 503, .put_status = 503}, "503"},
          {"401", {.get_status = 401, .put_status = 401}, "COPPICE_CACHE_CREDENTIALS"},
          {"403", {.get_status = 403, .put_status = 403}, "403"},
          {"404 to all", {.get_status = 404, .put_status = 404}, "404"},
          {"moved", {.get_status = 301, .put_status = 301}, "301"},
          {"read only", {.put_status = 403}, "403"},
          {"full: 507", {.put_status = 507}, "507"},
          {"half a body", {.body = SentBody::half}, "", true},
          {"wrong bytes", {.body = SentBody::wrong}, "damaged", true},
          {"trickling", {.body = SentBody::trickling}, "", true},
          {"20 s of delay", {.delay_s = 20.0}, "", true}};
}

FaultyServer::FaultyServer(const fs::path& folder, const ServerFaults& faults) : log_(folder / "requests.log") {
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
        std::thread(serve, connection, folder, faults).detach();
  }
  ::close(socket);
}

FaultyServer::~FaultyServer() {
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

std::string FaultyServer::url() const {
  return url_of(port_);
}

std::size_t FaultyServer::request_count() const {
  return count_of(read_text(log_), "\n");
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
