// coppice bake-all --slurm on a real Slurm: the same files as on one machine, whatever dies on the way. Needs Debian's slurm-wlm and munge.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "servers.h"
#include "tool.h"

namespace coppice::test::slurm_bake_test {

namespace fs = std::filesystem;

constexpr std::size_t kHazels = 8;
/// What coppice keeps beside outputs begins so.
const std::string kKept = ".coppice-";
/// About a second a plant on a processor of its own: long enough to be cut short.
const Words kQuick = {"--views", "8", "--resolution", "96", "--candidates", "4"};

/// Hazels of some seeds, and what bake-all makes of them on this machine alone. Made once.
struct Plants {
  TemporaryFolder folder;
  fs::path inputs = folder / "plants";
  std::map<std::string, std::string> baked;

  Plants() {
    fs::create_directories(inputs / "hedge");
    for (std::size_t i = 0; i < kHazels; ++i) {
      const fs::path path = inputs / (i % 2 == 0 ? "." : "hedge") / ("hazel" + std::to_string(i) + ".glb");
      run_tool({"plant", "corylus", "-o", path, "--seed", std::to_string(i + 1)});
    }
    run_tool(joined({"bake-all", inputs, "-o", folder / "alone", "--quiet"}, kQuick));
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
    if (const std::string missing = SlurmCluster::missing(); !missing.empty()) GTEST_SKIP() << missing;
    ASSERT_EQ(plants().baked.size(), kHazels);
    cluster_ = std::make_unique<SlurmCluster>();
  }

  [[nodiscard]] Words submit(const Words& more = {}, const fs::path& input = plants().inputs) const {
    return joined(joined({"bake-all", input, "-o", out_, "--slurm", "--report", report_}, kQuick), more);
  }
  [[nodiscard]] ProcessResult tool(const Words& arguments, const Words& variables = {}) const {
    return run_tool(arguments, {.environment = joined(cluster_->environment().environment, variables)});
  }
  [[nodiscard]] std::unique_ptr<BackgroundProcess> start(const Words& arguments) const {
    return std::make_unique<BackgroundProcess>(kTool, arguments, cluster_->environment());
  }
  /// The folders of all arrays so far, in their order.
  [[nodiscard]] std::vector<fs::path> arrays() const {
    std::vector<fs::path> folders;
    if (!fs::exists(out_ / ".coppice-cluster")) return folders;
    for (const fs::directory_entry& entry : fs::directory_iterator(out_ / ".coppice-cluster"))
      if (entry.is_directory()) folders.push_back(entry.path());
    std::ranges::sort(folders);
    return folders;
  }
  /// The outputs of plants that were baked, by all journals.
  [[nodiscard]] std::multiset<std::string> baked() const {
    std::string journals;
    for (const fs::path& folder : arrays())
      for (const auto& [name, text] : outputs(folder))
        if (name.ends_with(".jsonl")) journals += text + "\n";
    std::multiset<std::string> found;
    std::istringstream lines(journals);
    for (std::string line; std::getline(lines, line);)
      if (const auto entry = nlohmann::json::parse(line, nullptr, false); entry.is_object() && entry["outcome"] == "baked")
        found.insert(entry["output"].get<std::string>());
    return found;
  }
  /// All plants are there, byte for byte, and none was baked more than once: what was cut had not been baked.
  void expect_whole() const {
    EXPECT_TRUE(outputs(out_, kKept) == plants().baked);
    const std::multiset<std::string> all = baked();
    for (const std::string& output : all) EXPECT_EQ(all.count(output), 1u) << output;
  }

  /// False if the first node has no task after a while.
  [[nodiscard]] bool first_node_works() const {
    return comes_true([&] { return !cluster_->processes_on(0).empty(); });
  }
  /// Processes on the first node that bake: coppice itself and the one it forked off for a plant.
  [[nodiscard]] std::vector<int> bakers() const {
    std::vector<int> ids = cluster_->processes_on(0);
    std::erase_if(ids, [](int id) {
      std::error_code gone;
      return fs::read_symlink("/proc/" + std::to_string(id) + "/exe", gone) != fs::canonical(kTool);
    });
    return ids;
  }
  [[nodiscard]] std::string queued_job() const {
    const std::string jobs = cluster_->queue("%F");
    return jobs.substr(0, jobs.find('\n'));
  }
  /// The number in an option of an array's script.
  [[nodiscard]] static std::uint64_t limit_of(const fs::path& folder, const std::string& option) {
    const std::string script = read_text(folder / "run.sh"), start = "#SBATCH --" + option + "=";
    return std::stoull(script.substr(script.find(start) + start.size()));
  }

  static void write_program(const fs::path& path, const std::string& commands) {
    write_text(path, "#!/bin/sh\n" + commands);
    fs::permissions(path, fs::perms::owner_all);
  }
  /// A program for --coppice that waits as long as hold_ is there, then does as coppice does.
  [[nodiscard]] fs::path holding_coppice() const {
    write_text(hold_, "");
    write_program(folder_ / "coppice",
                  "while [ -e '" + hold_.string() + "' ]; do sleep 0.1; done\nexec '" + std::string(kTool) + "' \"$@\"\n");
    return folder_ / "coppice";
  }

  TemporaryFolder folder_;
  fs::path report_ = folder_ / "report.json", hold_ = folder_ / "hold";
  fs::path out_ = folder_ / "out of 100% trees";  // spaces and signs that sbatch and shells read otherwise
  std::unique_ptr<SlurmCluster> cluster_;
};

TEST_F(SlurmBake, BytesAreThoseOfOneMachine) {
  const Words shared{"--cache", folder_ / "shared cache"};
  const ProcessResult first = tool(submit(shared));
  EXPECT_EQ(first.exit_code, 0) << first.err << first.out;
  EXPECT_EQ(counts_in(report_), (BatchCounts{kHazels, 0, 0}));
  EXPECT_TRUE(mentions(first.out, {"hedge/hazel1"}));
  EXPECT_EQ(count_of(first.err, "\n"), 1u) << "the job: " << first.err;
  expect_whole();
  EXPECT_EQ(arrays().size(), 1u);

  // Into another OUT: the nodes have filled the cache, and no task is needed.
  out_ = folder_ / "out2";
  const ProcessResult second = tool(submit(shared));
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(second.err, "");
  EXPECT_EQ(counts_in(report_), (BatchCounts{0, kHazels, 0}));
  expect_whole();
  EXPECT_TRUE(arrays().empty());
}

TEST_F(SlurmBake, APlantsOwnFaultIsItsOwnAndNotTriedAgain) {
  const fs::path list = folder_ / "list.json";
  fs::copy(plants().inputs / "hazel0.glb", folder_ / "hazel.glb");
  write_text(folder_ / "letter.glb", "this is a letter, not a plant\n");
  write_text(folder_ / "rules.json", R"({"classes": [{"material": "leaves", "class": "leaf"}]})");
  write_text(folder_ / "torn.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 12, "uri": "gone.bin"}]})");
  write_text(list, R"([{"input": "hazel.glb", "classes": "rules.json", "output": "a/hazel.coppice"}, {"input": "letter.glb"},
                       {"input": "hazel.glb", "metric": "geometric", "no_wind": true}, {"input": "torn.gltf"}])");
  const ProcessResult result = tool(submit({}, list));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(counts_in(report_), (BatchCounts{2, 0, 2}));
  EXPECT_TRUE(mentions(result.err, {"letter.glb", "torn.gltf", "gone.bin"}));
  EXPECT_EQ(arrays().size(), 1u);
  ASSERT_EQ(run_tool(joined({"bake-all", list, "-o", folder_ / "alone", "--quiet"}, kQuick)).exit_code, 1);
  EXPECT_TRUE(outputs(out_, kKept) == outputs(folder_ / "alone", kKept));
}

TEST_F(SlurmBake, ANodeDiesInTheMiddle) {
  const auto submitter = start(submit({"--quiet"}));
  // One that bakes, and has baked.
  ASSERT_TRUE(comes_true([&] { return !baked().empty() && !bakers().empty(); })) << submitter->err();
  cluster_->kill_node(0);
  ASSERT_TRUE(comes_true([&] { return cluster_->run("sinfo", {"-h", "-N", "-o", "%T"}).out.find("down") != std::string::npos; }));
  // Slurm waits two minutes before it starts such a task again; nobody here has to.
  for (const char* task : {"_0", "_1"})
    static_cast<void>(cluster_->run("scontrol", {"update", "JobId=" + queued_job() + task, "StartTime=now"}));
  EXPECT_EQ(submitter->wait(), 0) << submitter->err();
  EXPECT_EQ(submitter->err(), "") << "nothing was lost";
  expect_whole();
}

TEST_F(SlurmBake, WhatWasKilledIsTriedAgainWithMore) {
  for (const bool whole_task : {false, true}) {
    out_ = folder_ / (whole_task ? "task" : "bake");
    const auto submitter = start(submit());
    std::vector<int> ids;
    ASSERT_TRUE(comes_true([&] { return (ids = bakers()).size() >= 2; })) << submitter->err();
    // The youngest of them bakes a plant; a kernel without memory kills such a one.
    ids = whole_task ? cluster_->processes_on(0) : std::vector<int>{ids.back()};
    for (const int id : ids) ::kill(id, SIGKILL);
    EXPECT_EQ(submitter->wait(), 0) << submitter->err();
    expect_whole();
    const std::vector<fs::path> all = arrays();
    ASSERT_EQ(all.size(), 2u) << submitter->err();
    EXPECT_NEAR(static_cast<double>(limit_of(all[1], "mem-per-cpu")), 2.0 * static_cast<double>(limit_of(all[0], "mem-per-cpu")), 1.0);
    EXPECT_EQ(limit_of(all[1], "time"), 2 * limit_of(all[0], "time"));
  }
}

TEST_F(SlurmBake, TheControllerIsKilledAndComesBack) {
  const auto submitter = start(submit());
  ASSERT_TRUE(comes_true([&] { return !baked().empty(); })) << submitter->err();
  const std::string job = queued_job();
  cluster_->kill_controller();
  const std::size_t before = baked().size();
  ASSERT_TRUE(comes_true([&] { return baked().size() > before; })) << "nodes go on";
  cluster_->start_controller();
  // A controller that was killed before it had saved which tasks run starts them again, finds them there, and then holds the job and drains
  // the nodes: an administrator has to tell it to go on.
  EXPECT_TRUE(comes_true([&] {
    static_cast<void>(cluster_->run("scontrol", {"update", "NodeName=node[1-2]", "State=RESUME"}));
    static_cast<void>(cluster_->run("scontrol", {"release", job}));
    std::this_thread::sleep_for(std::chrono::seconds(1));
    return baked().size() == kHazels;
  })) << cluster_->queue("%i %T %r");
  EXPECT_EQ(submitter->wait(), 0) << submitter->err();
  expect_whole();
}

/// The same command again goes on, whatever the one before it had done.
TEST_F(SlurmBake, TheSubmitterIsKilledAtAnyMoment) {
  const std::vector<std::function<bool()>> moments = {
      [&] { return !arrays().empty(); },
      [&] { return !arrays().empty() && fs::exists(arrays().front() / "run.sh"); },
      [&] { return !arrays().empty() && cluster_->queue("%j").find(arrays().front().filename()) != std::string::npos; },
      [&] { return baked().size() >= 2; },
  };
  for (std::size_t moment = 0; moment < moments.size(); ++moment) {
    SCOPED_TRACE("moment " + std::to_string(moment));
    out_ = folder_ / ("moment " + std::to_string(moment)).c_str();
    const auto submitter = start(submit());
    ASSERT_TRUE(comes_true(moments[moment])) << submitter->err();
    submitter->send(SIGKILL);
    submitter->wait();
    const ProcessResult again = tool(submit());
    EXPECT_EQ(again.exit_code, 0) << again.err << again.out;
    EXPECT_EQ(counts_in(report_).failed, 0u);
    expect_whole();
  }
}

TEST_F(SlurmBake, CtrlCLeavesTheTasksAndTheSameCommandTakesThemUp) {
  const Words command = submit({"--coppice", holding_coppice()});
  const auto submitter = start(command);
  ASSERT_TRUE(first_node_works()) << submitter->err();
  EXPECT_EQ(tool(command).exit_code, 1) << "another waits for this batch";
  submitter->send(SIGINT);
  EXPECT_EQ(submitter->wait(), 130);
  EXPECT_TRUE(mentions(submitter->err(), {"scancel " + queued_job()}));
  const auto again = start(command);
  ASSERT_TRUE(comes_true([&] { return mentions(again->err(), {arrays().front().filename().string()}); })) << again->err();
  fs::remove(hold_);
  EXPECT_EQ(again->wait(), 0) << again->err();
  EXPECT_EQ(counts_in(report_), (BatchCounts{0, kHazels, 0})) << "the first command's tasks have baked them";
  EXPECT_EQ(arrays().size(), 1u);
  expect_whole();
}

TEST_F(SlurmBake, WhatSlurmRefusesIsShown) {
  expect_failure(tool(submit({"--", "--partition=nowhere"})), {"sbatch", "nowhere"});
  EXPECT_TRUE(arrays().empty());
  const ProcessResult missing = tool(submit(), {"PATH=/nowhere"});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_TRUE(mentions(missing.err, {"slurm-client"}));
  EXPECT_EQ(count_of(missing.err, "\n"), 1u) << missing.err;
}

/// The controller has the job, and sbatch did not hear it.
TEST_F(SlurmBake, ASubmissionThatTimesOutIsFoundInTheQueue) {
  const fs::path programs = folder_ / "programs";
  const std::string failure = "sbatch: error: Batch job submission failed: Socket timed out on send/recv operation";
  write_program(programs / "sbatch",
                "'" + program_on_path("sbatch").string() + "' \"$@\" > /dev/null\necho '" + failure + "' >&2\nexit 1\n");
  // SQUEUE_PARTITION: a person likes to see that; it is not what is asked.
  const ProcessResult result = tool(submit(), {"PATH=" + programs.string() + ":" + std::getenv("PATH"), "SQUEUE_PARTITION=another"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  expect_whole();
  EXPECT_EQ(arrays().size(), 1u);
}

TEST_F(SlurmBake, ScancelEndsARun) {
  const auto submitter = start(submit({"--coppice", holding_coppice()}));
  ASSERT_TRUE(first_node_works()) << submitter->err();
  EXPECT_EQ(cluster_->run("scancel", {queued_job()}).exit_code, 0);
  EXPECT_EQ(submitter->wait(), 1);
  EXPECT_TRUE(mentions(submitter->err(), {"hazel0.glb", "CANCELLED"}));
  EXPECT_EQ(arrays().size(), 1u);
}

TEST_F(SlurmBake, ACoppiceThatNodesDoNotHaveIsToldAfterThreeAttempts) {
  const ProcessResult result = tool(submit({"--coppice", "/nowhere/coppice"}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(arrays().size(), 3u);
  EXPECT_TRUE(mentions(result.err, {"FAILED", arrays().back().string()}));
  EXPECT_TRUE(mentions(read_text(arrays().back() / "0.log"), {"/nowhere/coppice"}));
}

}  // namespace coppice::test::slurm_bake_test
