#include "slurm_cluster.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <regex>
#include <stdexcept>
#include <thread>

#include "cache_server.h"
#include "tool.h"

namespace coppice::test {
namespace {

namespace fs = std::filesystem;

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

std::string SlurmCluster::missing() {
  std::string names;
  for (const char* name : {"munged", "slurmctld", "slurmd", "sbatch", "squeue"})
    if (program_on_path(name).empty()) names += std::string(names.empty() ? "" : ", ") + name;
  if (!names.empty()) return "no " + names + ": third_party/install --optional installs slurm-wlm and munge";
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
