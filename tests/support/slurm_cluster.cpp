#include "slurm_cluster.h"

#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "cache_server.h"
#include "tool.h"

namespace coppice::test {
namespace {

namespace fs = std::filesystem;

/// Daemons are where not every user's PATH leads.
fs::path program(const std::string& name) {
  for (const char* folder : {"/usr/sbin", "/sbin", "/usr/local/sbin"})
    if (fs::exists(fs::path(folder) / name)) return fs::path(folder) / name;
  return program_on_path(name);
}

std::string host_name() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  const std::string whole = name.data();
  return whole.substr(0, whole.find('.'));
}

/// "node1", "node2" ...
std::string node_name(std::size_t node) {
  return "node" + std::to_string(node + 1);
}

std::string user_name() {
  const passwd* const user = ::getpwuid(::geteuid());
  return user != nullptr ? user->pw_name : "root";
}

void write_key(const fs::path& path) {
  std::random_device random;
  std::ofstream file(path, std::ios::binary);
  for (int i = 0; i < 64; ++i) file.put(static_cast<char>(random()));
  file.close();
  ::chmod(path.c_str(), 0400);
}

struct Process {
  int id = 0, parent = 0;
  std::string words;  ///< its command line, with spaces
};

/// "id (name) state parent ..."; 0 where that is not there, as of a process that has just ended.
int parent_in(const std::string& stat) {
  const std::size_t end = stat.rfind(") ");
  if (end == std::string::npos || end + 4 >= stat.size()) return 0;
  return std::stoi(stat.substr(end + 4));
}

std::vector<Process> all_processes() {
  std::vector<Process> processes;
  std::error_code error;
  for (fs::directory_iterator entry("/proc", error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename();
    if (!std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; })) continue;
    Process process{std::stoi(name), parent_in(read_text(entry->path() / "stat")), read_text(entry->path() / "cmdline")};
    std::ranges::replace(process.words, '\0', ' ');
    processes.push_back(std::move(process));
  }
  return processes;
}

}  // namespace

std::string SlurmCluster::missing() {
  std::string names;
  for (const char* name : {"munged", "slurmctld", "slurmd", "sbatch", "squeue"})
    if (program(name).empty()) names += std::string(names.empty() ? "" : ", ") + name;
  if (!names.empty()) return "no " + names + ": third_party/install --optional installs slurm-wlm and munge";
  if (::geteuid() != 0) return "slurmd needs root";
  return {};
}

SlurmCluster::SlurmCluster(std::size_t node_count) : nodes_(node_count) {
  const fs::path munge = folder_ / "munge";
  fs::create_directories(munge);
  ::chmod(munge.c_str(), 0700);
  fs::create_directories(folder_ / "state");
  write_key(munge / "key");
  write_config(node_count);
  // --force: the folders above are not root's alone.
  munge_ = std::make_unique<BackgroundProcess>(
      program("munged"), std::vector<std::string>{"--foreground", "--force", "--key-file=" + (munge / "key").string(),
                                                  "--socket=" + (munge / "socket").string(), "--pid-file=" + (munge / "pid").string(),
                                                  "--log-file=" + (munge / "log").string(), "--seed-file=" + (munge / "seed").string()});
  if (!comes_true([&] { return fs::exists(munge / "socket"); })) throw std::runtime_error("munged does not start: " + munge_->err());
  start_controller();
  for (std::size_t node = 0; node < node_count; ++node) start_node(node);
  const bool up = comes_true([&] {
    const std::string states = run("sinfo", {"--noheader", "--Node", "--format=%T"}).out;
    std::istringstream lines(states);
    std::size_t idle = 0;
    for (std::string line; std::getline(lines, line);) idle += line == "idle" ? 1u : 0u;
    return idle == node_count;
  });
  if (!up) throw std::runtime_error("Slurm does not start: " + controller_->err() + nodes_.front()->err());
}

SlurmCluster::~SlurmCluster() {
  for (std::size_t node = 0; node < nodes_.size(); ++node) kill_node(node);
}

void SlurmCluster::write_config(std::size_t node_count) const {
  const std::string host = host_name(), user = user_name(), folder = folder_.path().string();
  std::ofstream config(folder_ / "slurm.conf");
  config << "ClusterName=coppice\nSlurmctldHost=" << host << "(127.0.0.1)\nSlurmctldPort=" << free_port() << "\nSlurmUser=" << user
         << "\nSlurmdUser=" << user << "\nAuthType=auth/munge\nAuthInfo=socket=" << folder << "/munge/socket\nStateSaveLocation=" << folder
         << "/state\nSlurmctldPidFile=" << folder << "/controller.pid\nSlurmdPidFile=" << folder << "/%n.pid\nSlurmdSpoolDir=" << folder
         << "/%n\nSlurmctldLogFile=" << folder << "/controller.log\nSlurmdLogFile=" << folder << R"(/%n.log
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
# Nothing of the machine's: no control groups, no database, no mail.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MailProg=/bin/true
SwitchType=switch/none
MpiDefault=none
# Faults are found soon, and forgotten as soon.
ReturnToService=2
SlurmdTimeout=5
SlurmctldTimeout=5
InactiveLimit=0
KillWait=2
MinJobAge=10
MessageTimeout=5
SchedulerType=sched/backfill
SchedulerParameters=bf_interval=1,sched_interval=1,batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
)";
  for (std::size_t node = 0; node < node_count; ++node)
    config << "NodeName=" << node_name(node) << " NodeHostname=" << host << " NodeAddr=127.0.0.1 Port=" << free_port()
           << " CPUs=1 RealMemory=16000 State=UNKNOWN\n";
  config << "PartitionName=farm Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n";
}

ProcessOptions SlurmCluster::environment() const {
  ProcessOptions options;
  options.environment = {"SLURM_CONF=" + (folder_ / "slurm.conf").string()};
  return options;
}

ProcessResult SlurmCluster::run(const std::string& name, const std::vector<std::string>& arguments) const {
  return run_process(program(name), arguments, environment());
}

std::string SlurmCluster::queue(const std::string& format) const {
  return run("squeue", {"--noheader", "--array", "--states=all", "--format=" + format}).out;
}

std::vector<int> SlurmCluster::processes_on(std::size_t node) const {
  const std::vector<Process> processes = all_processes();
  std::set<int> ids;
  const std::string spool = (folder_.path() / node_name(node)).string() + "/job";
  for (const Process& process : processes)
    if (process.words.find(spool) != std::string::npos) ids.insert(process.id);
  for (bool grows = true; grows;) {
    grows = false;
    for (const Process& process : processes)
      if (ids.contains(process.parent)) grows = ids.insert(process.id).second || grows;
  }
  return {ids.begin(), ids.end()};
}

void SlurmCluster::kill_node(std::size_t node) {
  if (nodes_[node]) nodes_[node]->send(SIGKILL);
  // The step's daemon is the script's parent.
  const std::vector<int> below = processes_on(node);
  std::set<int> ids(below.begin(), below.end()), parents;
  const std::vector<Process> processes = all_processes();
  for (const Process& process : processes)
    if (ids.contains(process.id)) parents.insert(process.parent);
  for (const Process& process : processes)
    if (parents.contains(process.id) && process.words.starts_with("slurmstepd")) ids.insert(process.id);
  for (const int id : ids) ::kill(id, SIGKILL);
  nodes_[node].reset();
}

void SlurmCluster::start_node(std::size_t node) {
  // Where there is taskset, a node has a processor of its own, as far as there are as many.
  const fs::path pin = program("taskset");
  const std::string processor = std::to_string(node % std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::string> words{pin,  "--cpu-list",    processor, program("slurmd"),     "-D",
                                 "-N", node_name(node), "-f",      folder_ / "slurm.conf"};
  if (pin.empty()) words.erase(words.begin(), words.begin() + 3);
  nodes_[node] =
      std::make_unique<BackgroundProcess>(words.front(), std::vector<std::string>(words.begin() + 1, words.end()), environment());
}

void SlurmCluster::kill_controller() {
  controller_->send(SIGKILL);
  controller_.reset();
}

void SlurmCluster::start_controller() {
  controller_ = std::make_unique<BackgroundProcess>(program("slurmctld"),
                                                    std::vector<std::string>{"-D", "-f", (folder_ / "slurm.conf").string()}, environment());
}

}  // namespace coppice::test
