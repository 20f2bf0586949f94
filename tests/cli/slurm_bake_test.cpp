// coppice bake-all --slurm on a real Slurm: the same files as on one machine, whatever dies on the way. Needs Debian's slurm-wlm and munge.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <sys/stat.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cache_server.h"
#include "documents.h"
#include "gltf_builder.h"
#include "mentions.h"
#include "places.h"
#include "process.h"
#include "slurm_cluster.h"
#include "text_files.h"

namespace slurm_bake_test {

namespace fs = std::filesystem;
using coppice::test::BackgroundProcess;
using coppice::test::FaultyServer;
using coppice::test::joined;
using coppice::test::lines_that_name;
using coppice::test::mentions;
using coppice::test::outputs;
using coppice::test::ProcessOptions;
using coppice::test::ProcessResult;
using coppice::test::program_on_path;
using coppice::test::read_text;
using coppice::test::run_process;
using coppice::test::SlurmCluster;
using coppice::test::TemporaryFolder;
using coppice::test::write_text;

constexpr std::size_t kHazels = 8;
/// What coppice keeps beside outputs begins so.
const std::string kKept = ".coppice-";
/// About a second a plant on a processor of its own: long enough to be cut short.
const std::vector<std::string> kQuick = {"--views", "8", "--resolution", "96", "--candidates", "4"};

/// False if it has not come true after so long. Polls: nothing here is timed.
bool comes_true(const std::function<bool()>& condition, std::chrono::seconds most = std::chrono::seconds(120)) {
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < most) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

/// What a report counts: baked, cached, failed.
struct Counts {
  std::size_t baked = 0, cached = 0, failed = 0;
  bool operator==(const Counts&) const = default;
};

Counts counts_in(const fs::path& report) {
  const auto json = nlohmann::json::parse(read_text(report));
  return {json["baked"], json["cached"], json["failed"]};
}

void PrintTo(const Counts& counts, std::ostream* out) {
  *out << counts.baked << " baked, " << counts.cached << " cached, " << counts.failed << " failed";
}

/// Hazels of some seeds, and what bake-all makes of them on this machine alone. Made once.
struct Plants {
  TemporaryFolder folder;
  fs::path inputs = folder / "plants";
  std::map<std::string, std::string> baked;

  Plants() {
    fs::create_directories(inputs / "hedge");
    for (std::size_t i = 0; i < kHazels; ++i) {
      const fs::path path = inputs / (i % 2 == 0 ? "." : "hedge") / ("hazel" + std::to_string(i) + ".glb");
      run_process(coppice::test::kTool, {"plant", "corylus", "-o", path, "--seed", std::to_string(i + 1)});
    }
    run_process(coppice::test::kTool, joined({"bake-all", inputs, "-o", folder / "alone", "--quiet"}, kQuick));
    baked = outputs(folder / "alone", kKept);
  }
};

const Plants& plants() {
  static const Plants made;
  return made;
}

class SlurmBake : public testing::Test {
 protected:
  void SetUp() override {
    const std::string missing = SlurmCluster::missing();
    if (!missing.empty()) GTEST_SKIP() << missing;
    ASSERT_EQ(plants().baked.size(), kHazels);
    inputs_ = plants().inputs;
    cluster_ = std::make_unique<SlurmCluster>(2);
  }

  [[nodiscard]] std::vector<std::string> submit(const std::vector<std::string>& more = {}) const {
    return joined(joined({"bake-all", inputs_, "-o", out_, "--slurm"}, kQuick), more);
  }
  [[nodiscard]] ProcessResult tool(const std::vector<std::string>& arguments) const {
    return run_process(coppice::test::kTool, arguments, cluster_->environment());
  }
  [[nodiscard]] std::unique_ptr<BackgroundProcess> start(const std::vector<std::string>& arguments) const {
    return std::make_unique<BackgroundProcess>(coppice::test::kTool, arguments, cluster_->environment());
  }
  [[nodiscard]] ProcessResult attach(const std::vector<std::string>& more = {}) const {
    return tool(joined({"bake-all", "-o", out_, "--attach"}, more));
  }

  /// What a run says on stderr that loses nothing.
  static bool names_only_its_job(const std::string& err) {
    return std::regex_match(err, std::regex("coppice: [^\n]*scancel [0-9]+[^\n]*\n"));
  }

  /// The newest run's folder; empty: there is none yet.
  [[nodiscard]] fs::path run_folder() const {
    fs::path newest;
    std::error_code absent;
    for (fs::directory_iterator entry(out_ / ".coppice-farm", absent), end; !absent && entry != end; entry.increment(absent))
      newest = std::max(newest, entry->path());
    return newest;
  }

  [[nodiscard]] std::vector<fs::path> tries(const std::string& extension) const {
    std::vector<fs::path> files;
    std::error_code absent;
    for (fs::directory_iterator entry(run_folder() / "tries", absent), end; !absent && entry != end; entry.increment(absent))
      if (entry->path().extension() == extension) files.push_back(entry->path());
    return files;
  }

  /// Entries of all journals of the run.
  [[nodiscard]] std::vector<nlohmann::json> journal() const {
    std::vector<nlohmann::json> entries;
    for (const fs::path& path : tries(".plants")) {
      std::ifstream file(path);
      for (std::string line; std::getline(file, line);)
        if (auto entry = nlohmann::json::parse(line, nullptr, false); entry.is_object()) entries.push_back(std::move(entry));
    }
    return entries;
  }

  [[nodiscard]] std::size_t baked_count() const {
    const auto entries = journal();
    return static_cast<std::size_t>(std::ranges::count_if(entries, [](const auto& entry) { return entry["outcome"] == "baked"; }));
  }

  /// What bake-all makes of the inputs on this machine alone.
  [[nodiscard]] std::map<std::string, std::string> expected() const {
    if (inputs_ == plants().inputs) return plants().baked;
    const std::string start = inputs_.filename().string() + "/";
    std::map<std::string, std::string> below;
    for (const auto& [name, bytes] : plants().baked)
      if (name.starts_with(start)) below[name.substr(start.size())] = bytes;
    return below;
  }

  /// All plants are there, byte for byte, and none was baked more than once: what was cut had not been baked.
  void expect_whole() const {
    EXPECT_TRUE(outputs(out_, kKept) == expected());
    std::map<std::string, int> times;
    for (const nlohmann::json& entry : journal())
      if (entry["outcome"] == "baked") ++times[entry["output"].get<std::string>()];
    for (const auto& [output, count] : times) EXPECT_EQ(count, 1) << output;
  }

  static void write_program(const fs::path& path, const std::string& commands) {
    write_text(path, "#!/bin/sh\n" + commands);
    ::chmod(path.c_str(), 0755);
  }

  /// A program for --coppice that waits as long as `hold` is there, then does as coppice does.
  [[nodiscard]] fs::path holding_coppice(const fs::path& hold) const {
    const fs::path path = folder_ / "holding-coppice";
    write_program(path,
                  "while [ -e '" + hold.string() + "' ]; do sleep 0.1; done\nexec '" + std::string(coppice::test::kTool) + "' \"$@\"\n");
    return path;
  }

  TemporaryFolder folder_;
  fs::path inputs_;
  fs::path out_ = folder_ / "out of 100% trees";  // spaces and signs that sbatch and shells read otherwise
  std::unique_ptr<SlurmCluster> cluster_;
};

/// Processes of the run that bake: coppice itself and the one it forked off for a plant.
std::vector<int> bakers(const SlurmCluster& cluster, std::size_t node) {
  std::vector<int> found;
  for (const int id : cluster.processes_on(node)) {
    std::error_code gone;
    const fs::path program = fs::read_symlink("/proc/" + std::to_string(id) + "/exe", gone);
    if (!gone && program == fs::canonical(coppice::test::kTool)) found.push_back(id);
  }
  return found;
}

TEST_F(SlurmBake, BytesAreThoseOfOneMachine) {
  const fs::path report = folder_ / "report.json";
  const ProcessResult first = tool(submit({"--report", report}));
  EXPECT_EQ(first.exit_code, 0) << first.err << first.out;
  EXPECT_EQ(counts_in(report), (Counts{kHazels, 0, 0}));
  EXPECT_TRUE(mentions(first.out, {"hedge/hazel1"}));
  EXPECT_TRUE(names_only_its_job(first.err)) << first.err;
  expect_whole();

  const auto json = nlohmann::json::parse(read_text(report));
  EXPECT_EQ(json["nodes"], 2);
  std::set<std::string> nodes, keys;
  for (const auto& [key, value] : json.items()) keys.insert(key);
  for (const auto& plant : json["plants"]) {
    nodes.insert(plant["node"].get<std::string>());
    EXPECT_EQ(plant["attempts"], 1);
    EXPECT_GE(plant["queue_seconds"], 0.0);
    for (const auto& [key, value] : plant.items()) keys.insert(key);
  }
  EXPECT_EQ(nodes, (std::set<std::string>{"node1", "node2"}));
  const std::string readme = coppice::test::source_text("bake/README.md");
  std::set<std::string> told = coppice::test::column_spans(coppice::test::table_after(readme, "`coppice bake-all --report F.json`"), 0);
  told.merge(coppice::test::column_spans(coppice::test::table_after(readme, "`coppice bake-all --slurm --report F.json`"), 0));
  told.erase("error");  // none failed
  EXPECT_EQ(keys, told);

  const ProcessResult second = tool(submit({"--report", report}));
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(counts_in(report), (Counts{0, kHazels, 0}));
  // A run that has ended tells again how.
  fs::remove(report);
  const ProcessResult again = attach({"--report", report});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(counts_in(report), (Counts{0, kHazels, 0}));
}

/// Nodes keep what they bake in the folder that --cache names, and the next batch, into another OUT, needs none of them.
TEST_F(SlurmBake, NodesFillASharedCache) {
  const fs::path shared = folder_ / "shared cache", report = folder_ / "report.json";
  const ProcessResult first = tool(submit({"--cache", shared}));
  EXPECT_EQ(first.exit_code, 0) << first.err << first.out;
  expect_whole();
  EXPECT_FALSE(fs::exists(out_ / ".coppice-cache" / "lock")) << "the shared folder takes its place";
  const ProcessResult second =
      tool(joined({"bake-all", inputs_, "-o", folder_ / "out2", "--slurm", "--cache", shared, "--report", report}, kQuick));
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(counts_in(report), (Counts{0, kHazels, 0}));
  EXPECT_EQ(outputs(folder_ / "out2", kKept), plants().baked);
}

/// The submitter finds them all, by one question for what is there.
TEST_F(SlurmBake, WhatAServerHasNeedsNoTask) {
  const FaultyServer server(folder_ / "objects");
  const fs::path report = folder_ / "report.json";
  const auto fill = [&] {
    const fs::path filled = folder_ / "filled.json";
    const ProcessResult result = run_process(
        coppice::test::kTool,
        joined({"bake-all", inputs_, "-o", plants().folder / "alone", "--quiet", "--cache", server.url(), "--report", filled}, kQuick));
    return result.exit_code == 0 && nlohmann::json::parse(read_text(filled))["cache"]["unsent"] == 0;
  };
  ASSERT_TRUE(comes_true(fill));
  const std::size_t before = server.requests().size();
  const ProcessResult warm = tool(submit({"--cache", server.url(), "--report", report}));
  EXPECT_EQ(warm.exit_code, 0) << warm.err;
  EXPECT_EQ(warm.err, "");
  EXPECT_EQ(counts_in(report), (Counts{0, kHazels, 0}));
  EXPECT_EQ(outputs(out_, kKept), plants().baked);
  EXPECT_FALSE(fs::exists(run_folder() / "submission-001.json"));
  EXPECT_EQ(cluster_->queue("%j"), "");
  const std::vector<std::string> all = server.requests(), asked(all.begin() + static_cast<std::ptrdiff_t>(before), all.end());
  EXPECT_EQ(asked.size(), 1 + kHazels);
  EXPECT_EQ(asked.front(), "GET /v1/index");
  EXPECT_EQ(std::ranges::count(asked, "GET /v1/index"), 1);
  EXPECT_TRUE(std::ranges::all_of(asked, [](const std::string& request) { return request.starts_with("GET /v1/"); }));
  const auto cache = nlohmann::json::parse(read_text(report))["cache"];
  EXPECT_EQ(cache["where"], server.url());
  EXPECT_EQ(cache["found"], kHazels);
  EXPECT_EQ(cache["requests"], 1 + kHazels);
  EXPECT_EQ(cache["trouble"], "");

  const ProcessResult again = tool(submit({"--cache", server.url()}));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(server.requests().size(), all.size() + 1) << "now all of it is in OUT's cache";
}

TEST_F(SlurmBake, ADeadServerCostsTheSubmitterNoPlant) {
  const std::string url = coppice::test::dead_url();
  const fs::path report = folder_ / "report.json";
  const ProcessResult result = tool(submit({"--cache", url, "--report", report}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  expect_whole();
  EXPECT_TRUE(mentions(result.err, {url}));
  EXPECT_EQ(std::ranges::count(result.err, '\n'), 2) << "the job and the server: " << result.err;
  const auto cache = nlohmann::json::parse(read_text(report))["cache"];
  EXPECT_EQ(cache["unasked"], kHazels);
  EXPECT_LT(cache["lost_seconds"], 10.0);
}

TEST_F(SlurmBake, APlantsOwnFaultIsItsOwnAndNotTriedAgain) {
  const fs::path list = folder_ / "list.json", report = folder_ / "report.json";
  fs::copy(plants().inputs / "hazel0.glb", folder_ / "hazel.glb");
  write_text(folder_ / "letter.glb", "this is a letter, not a plant\n");
  write_text(folder_ / "rules.json", R"({"classes": [{"material": "leaves", "class": "leaf"}]})");
  write_text(list, R"([{"input": "hazel.glb", "classes": "rules.json", "output": "a/hazel.coppice"}, {"input": "letter.glb"},
                       {"input": "hazel.glb", "metric": "geometric", "no_wind": true}, {"input": "torn.gltf"}])");
  write_text(folder_ / "torn.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 12, "uri": "gone.bin"}]})");
  const ProcessResult result = tool(joined({"bake-all", list, "-o", out_, "--slurm", "--report", report}, kQuick));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(counts_in(report), (Counts{2, 0, 2}));
  EXPECT_TRUE(mentions(result.err, {"letter.glb", "torn.gltf", "gone.bin"}));
  for (const char* node : {"node1", "node2"}) EXPECT_FALSE(mentions(result.err, {node})) << "no node is to blame";
  EXPECT_FALSE(fs::exists(run_folder() / "submission-002.json"));
  ASSERT_EQ(run_process(coppice::test::kTool, joined({"bake-all", list, "-o", folder_ / "alone", "--quiet"}, kQuick)).exit_code, 1);
  EXPECT_TRUE(outputs(out_, kKept) == outputs(folder_ / "alone", kKept));
  EXPECT_EQ(attach().exit_code, 1);
}

TEST_F(SlurmBake, ANodeDiesInTheMiddle) {
  for (const bool slurm_requeues : {true, false}) {
    out_ = folder_ / (slurm_requeues ? "requeue" : "no requeue");
    const auto submitter = start(submit(slurm_requeues ? std::vector<std::string>{} : std::vector<std::string>{"--", "--no-requeue"}));
    // One that bakes, and has baked.
    ASSERT_TRUE(comes_true([&] { return baked_count() >= 1 && !bakers(*cluster_, 0).empty(); })) << submitter->err();
    cluster_->kill_node(0);
    ASSERT_TRUE(comes_true([&] { return cluster_->run("sinfo", {"-h", "-N", "-o", "%T"}).out.find("down") != std::string::npos; }));
    // Slurm waits two minutes before it starts such a task again; nobody here has to.
    const std::string jobs = cluster_->queue("%F"), job = jobs.substr(0, jobs.find('\n'));
    for (const char* task : {"_0", "_1"})
      if (slurm_requeues) static_cast<void>(cluster_->run("scontrol", {"update", "JobId=" + job + task, "StartTime=now"}));
    EXPECT_EQ(submitter->wait(), 0) << submitter->err();
    expect_whole();
    cluster_->start_node(0);
    ASSERT_TRUE(comes_true([&] { return cluster_->run("sinfo", {"-h", "-N", "-o", "%T"}).out.find("down") == std::string::npos; }));
  }
}

TEST_F(SlurmBake, AKilledBakeIsTriedAgainWithMoreMemory) {
  const auto submitter = start(submit());
  // The youngest of them bakes a plant; a kernel without memory kills such a one.
  std::vector<int> ids;
  ASSERT_TRUE(comes_true([&] { return (ids = bakers(*cluster_, 0)).size() >= 2; })) << submitter->err();
  ASSERT_EQ(::kill(ids.back(), SIGKILL), 0);
  EXPECT_EQ(submitter->wait(), 0) << submitter->err();
  EXPECT_FALSE(names_only_its_job(submitter->err())) << submitter->err();
  expect_whole();
  const auto first = nlohmann::json::parse(read_text(run_folder() / "submission-001.json"));
  nlohmann::json last;
  for (int number = 2; fs::exists(run_folder() / ("submission-00" + std::to_string(number) + ".json")); ++number)
    last = nlohmann::json::parse(read_text(run_folder() / ("submission-00" + std::to_string(number) + ".json")));
  ASSERT_TRUE(last.is_object());
  EXPECT_EQ(last["attempt"], 2);
  EXPECT_EQ(last["memory_bytes"].get<std::uint64_t>(), 2 * first["memory_bytes"].get<std::uint64_t>());
  EXPECT_EQ(last["minutes"].get<int>(), 2 * first["minutes"].get<int>());
}

TEST_F(SlurmBake, AKilledTaskIsTriedAgainFromWhereItWas) {
  const auto submitter = start(submit());
  ASSERT_TRUE(comes_true([&] { return baked_count() >= 1 && !bakers(*cluster_, 1).empty(); })) << submitter->err();
  // All of it: script, coppice and the bake.
  for (const int id : cluster_->processes_on(1)) ::kill(id, SIGKILL);
  EXPECT_EQ(submitter->wait(), 0) << submitter->err();
  EXPECT_TRUE(mentions(submitter->err(), {"node2"}));
  EXPECT_TRUE(fs::exists(run_folder() / "submission-002.json"));
  expect_whole();
}

TEST_F(SlurmBake, ATaskThatTakesTooLongIsTriedAgain) {
  // Slurm counts in minutes.
  const fs::path hold = folder_ / "hold";
  write_text(hold, "");
  const auto submitter = start(submit({"--coppice", holding_coppice(hold), "--", "--time=1"}));
  ASSERT_TRUE(comes_true([&] { return tries(".start").size() == 2; })) << submitter->err();
  ASSERT_TRUE(comes_true([&] { return fs::exists(run_folder() / "submission-002.json"); }, std::chrono::seconds(180)))
      << cluster_->queue("%i %T %M %l");
  fs::remove(hold);
  EXPECT_EQ(submitter->wait(), 0) << submitter->err();
  EXPECT_TRUE(mentions(submitter->err(), {"TIMEOUT"}));
  expect_whole();
}

TEST_F(SlurmBake, TheControllerIsKilledAndComesBack) {
  const auto submitter = start(submit());
  ASSERT_TRUE(comes_true([&] { return baked_count() >= 1; })) << submitter->err();
  const std::string jobs = cluster_->queue("%F"), job = jobs.substr(0, jobs.find('\n'));
  cluster_->kill_controller();
  const std::size_t before = baked_count();
  ASSERT_TRUE(comes_true([&] { return baked_count() > before; })) << "nodes go on";
  cluster_->start_controller();
  // One that was killed before it had saved which tasks run starts them again, finds them there, and then holds the job and drains the
  // nodes: an administrator has to tell it to go on.
  EXPECT_TRUE(comes_true([&] {
    static_cast<void>(cluster_->run("scontrol", {"update", "NodeName=node[1-2]", "State=RESUME"}));
    static_cast<void>(cluster_->run("scontrol", {"release", job}));
    std::this_thread::sleep_for(std::chrono::seconds(1));
    return fs::exists(run_folder() / "report.json");
  })) << cluster_->queue("%i %T %r");
  EXPECT_EQ(submitter->wait(), 0) << submitter->err();
  EXPECT_TRUE(names_only_its_job(submitter->err())) << submitter->err();
  expect_whole();
}

TEST_F(SlurmBake, TheSubmitterIsKilledAtAnyMoment) {
  inputs_ = plants().inputs / "hedge";  // half of them, six times
  const std::vector<std::function<bool()>> moments = {
      [&] { return !run_folder().empty(); },
      [&] { return fs::exists(run_folder() / "submission-001.sh"); },
      [&] { return fs::exists(run_folder() / "run.json"); },
      [&] { return cluster_->queue("%j").find(run_folder().filename()) != std::string::npos; },
      [&] { return !tries(".start").empty(); },
      [&] { return baked_count() >= 2; },
  };
  for (std::size_t moment = 0; moment < moments.size(); ++moment) {
    SCOPED_TRACE("moment " + std::to_string(moment));
    out_ = folder_ / ("moment " + std::to_string(moment)).c_str();
    const auto submitter = start(submit());
    ASSERT_TRUE(comes_true(moments[moment])) << submitter->err();
    submitter->send(SIGKILL);
    submitter->wait();
    const fs::path report = folder_ / ("report" + std::to_string(moment)).c_str();
    const bool has_begun = fs::exists(run_folder() / "run.json");
    ProcessResult attached = attach({"--report", report});
    if (!has_begun) {
      EXPECT_EQ(attached.exit_code, 1);
      attached = tool(submit({"--report", report}));
    }
    EXPECT_EQ(attached.exit_code, 0) << attached.err << attached.out;
    EXPECT_EQ(counts_in(report).failed, 0u);
    expect_whole();
  }
}

TEST_F(SlurmBake, CtrlCLeavesTheRunAndAttachTakesItUp) {
  const fs::path hold = folder_ / "hold";
  write_text(hold, "");
  const auto submitter = start(submit({"--coppice", holding_coppice(hold)}));
  ASSERT_TRUE(comes_true([&] { return tries(".start").size() == 2; })) << submitter->err();
  {
    // Neither a second one that follows it, nor a second run.
    const ProcessResult second = attach();
    EXPECT_EQ(second.exit_code, 1);
    EXPECT_TRUE(mentions(second.err, {run_folder().filename().string()}));
  }
  submitter->send(SIGINT);
  EXPECT_EQ(submitter->wait(), 130);
  EXPECT_TRUE(mentions(submitter->err(), {"--attach"}));
  const std::string jobs = cluster_->queue("%F"), ends = "scancel " + jobs.substr(0, jobs.find('\n'));
  EXPECT_EQ(lines_that_name(submitter->err(), ends), 2u) << "as it was submitted, and at the end: " << submitter->err();
  const ProcessResult other = tool(submit());
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_TRUE(mentions(other.err, {"--attach", ends}));
  EXPECT_EQ(tool(submit({"--print"})).exit_code, 1) << "its run would hide this one";
  fs::remove(hold);
  const fs::path report = folder_ / "report.json";
  const ProcessResult attached = attach({"--report", report});
  EXPECT_EQ(attached.exit_code, 0) << attached.err;
  EXPECT_EQ(counts_in(report).baked, kHazels);
  expect_whole();
}

TEST_F(SlurmBake, TasksThatRunTwiceAtOnceGiveTheSameBytes) {
  const auto submitter = start(submit());
  ASSERT_TRUE(comes_true([&] { return !tries(".start").empty(); })) << submitter->err();
  // As when a scheduler starts a task again whose node it has lost sight of.
  const fs::path script = run_folder() / "submission-001.sh";
  BackgroundProcess twin("/bin/sh", {script, "0"}), other("/bin/sh", {script, "1"});
  EXPECT_EQ(submitter->wait(), 0) << submitter->err();
  twin.wait();
  other.wait();
  EXPECT_TRUE(outputs(out_, kKept) == plants().baked);
}

TEST_F(SlurmBake, WhatSlurmRefusesIsShown) {
  const ProcessResult refused = tool(submit({"--", "--partition=nowhere"}));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_TRUE(mentions(refused.err, {"sbatch", "nowhere"}));
  EXPECT_TRUE(run_folder().empty()) << "a run that never was";
  ProcessOptions elsewhere = cluster_->environment();
  elsewhere.environment.emplace_back("PATH=/nowhere");
  const ProcessResult missing = run_process(coppice::test::kTool, submit(), elsewhere);
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_TRUE(mentions(missing.err, {"slurm-client"}));
  EXPECT_EQ(std::ranges::count(missing.err, '\n'), 1) << missing.err;
}

/// The controller has the job, and sbatch did not hear it.
TEST_F(SlurmBake, ASubmissionThatTimesOutIsFoundInTheQueue) {
  const fs::path path = folder_ / "programs" / "sbatch", once = folder_ / "timed out";
  const std::string real = "'" + program_on_path("sbatch").string() + "' \"$@\"", mark = "'" + once.string() + "'";
  write_program(path, "[ -e " + mark + " ] && exec " + real + "\n: > " + mark + "\n" + real +
                          " > /dev/null\necho 'sbatch: error: Batch job submission failed: Socket timed out on send/recv operation' >&2\n"
                          "exit 1\n");
  ProcessOptions options = cluster_->environment();
  options.environment.push_back("PATH=" + path.parent_path().string() + ":" + std::getenv("PATH"));
  options.environment.emplace_back("SQUEUE_PARTITION=another");  // what somebody likes to see is not what we ask
  const ProcessResult result = run_process(coppice::test::kTool, submit(), options);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(names_only_its_job(result.err)) << result.err;
  expect_whole();
  EXPECT_FALSE(fs::exists(run_folder() / "submission-002.json"));
  const std::string jobs = cluster_->queue("%F");
  EXPECT_EQ(jobs.find_first_not_of(jobs.substr(0, jobs.find('\n')) + "\n"), std::string::npos) << "one job: " << jobs;
}

/// Slurm takes tasks that ask for more time than a partition gives, and lets them wait for ever.
TEST_F(SlurmBake, ATryThatNobodyMayHaveTheTimeForGetsLess) {
  const auto submitter = start(submit());
  std::vector<int> ids;
  ASSERT_TRUE(comes_true([&] { return (ids = bakers(*cluster_, 0)).size() >= 2; })) << submitter->err();
  const auto first = nlohmann::json::parse(read_text(run_folder() / "submission-001.json"));
  const std::string most = first["minutes"].dump();
  ASSERT_EQ(cluster_->run("scontrol", {"update", "PartitionName=farm", "MaxTime=" + most}).exit_code, 0);
  ASSERT_EQ(::kill(ids.back(), SIGKILL), 0);
  EXPECT_EQ(submitter->wait(), 0) << submitter->err();
  expect_whole();
  const auto second = nlohmann::json::parse(read_text(run_folder() / "submission-002.json"));
  const auto third = nlohmann::json::parse(read_text(run_folder() / "submission-003.json"));
  EXPECT_EQ(second["minutes"], 2 * first["minutes"].get<int>());
  EXPECT_EQ(third["minutes"], first["minutes"]);
  EXPECT_EQ(third["attempt"], 2);
  EXPECT_EQ(third["memory_bytes"], 2 * first["memory_bytes"].get<std::uint64_t>()) << "memory is not what there is too little of";

  ASSERT_EQ(cluster_->run("scontrol", {"update", "PartitionName=farm", "MaxTime=1"}).exit_code, 0);
  out_ = folder_ / "never";
  const auto never = start(submit({"--", "--time=5"}));
  ASSERT_TRUE(comes_true([&] { return lines_that_name(never->err(), "scancel") == 2; }))
      << "as it was submitted, and now: " << never->err();
  const std::string said = never->err(), ends = said.substr(said.rfind("scancel "));
  EXPECT_EQ(cluster_->run("scancel", {ends.substr(8, ends.find(' ', 8) - 8)}).exit_code, 0);
  EXPECT_EQ(never->wait(), 1) << never->err();
}

TEST_F(SlurmBake, ANodeWithoutTheProgramGetsNoMoreTasks) {
  const fs::path path = folder_ / "coppice of node2";
  write_program(path, "[ \"$SLURMD_NODENAME\" = node1 ] && exit 127\nexec '" + std::string(coppice::test::kTool) + "' \"$@\"\n");
  const fs::path report = folder_ / "report.json";
  const ProcessResult result = tool(submit({"--coppice", path, "--report", report}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  expect_whole();
  EXPECT_TRUE(mentions(result.err, {"node1", "127"}));
  EXPECT_EQ(lines_that_name(result.err, "node1"), 1u) << result.err;
  for (const nlohmann::json& plant : nlohmann::json::parse(read_text(report))["plants"]) EXPECT_EQ(plant["node"], "node2");
}

/// One file is a link to itself there, which is read as badly as one on a server that is gone.
TEST_F(SlurmBake, ANodeThatDoesNotSeeThePlantsGetsNoMoreTasks) {
  const fs::path path = folder_ / "blind coppice";
  write_program(
      path, "[ \"$SLURMD_NODENAME\" = node1 ] || exec '" + std::string(coppice::test::kTool) +
                "' \"$@\"\nexec unshare --mount sh -c 'mount -t tmpfs none \"$0\" && ln -s hazel0.glb \"$0/hazel0.glb\" && exec \"$@\"' '" +
                inputs_.string() + "' '" + std::string(coppice::test::kTool) + "' \"$@\"\n");
  if (run_process("/usr/bin/unshare", {"--mount", "true"}).exit_code != 0) GTEST_SKIP() << "no mount namespaces here";
  const ProcessResult result = tool(submit({"--coppice", path}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(outputs(out_, kKept) == plants().baked);
  EXPECT_TRUE(mentions(result.err, {"node1"}));
}

TEST_F(SlurmBake, ScancelEndsARun) {
  const fs::path hold = folder_ / "hold";
  write_text(hold, "");
  const auto submitter = start(submit({"--coppice", holding_coppice(hold)}));
  ASSERT_TRUE(comes_true([&] { return !tries(".start").empty(); })) << submitter->err();
  const std::string jobs = cluster_->queue("%F");
  EXPECT_EQ(cluster_->run("scancel", {jobs.substr(0, jobs.find('\n'))}).exit_code, 0);
  EXPECT_EQ(submitter->wait(), 1);
  EXPECT_TRUE(mentions(submitter->err(), {"hazel0.glb"}));
  EXPECT_FALSE(fs::exists(run_folder() / "submission-002.json"));
}

TEST_F(SlurmBake, ACoppiceThatNodesDoNotHaveIsNamed) {
  const ProcessResult result = tool(submit({"--coppice", "/nowhere/coppice"}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(mentions(result.err, {"127", "/nowhere/coppice", "--coppice"}));
  EXPECT_NE(result.err.find(".glb, "), std::string::npos) << "plants with one error are told together: " << result.err;
}

}  // namespace slurm_bake_test
