// Parts of a batch on several machines without Slurm: shards, journals, and tasks that somebody else starts.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "gltf_builder.h"
#include "process.h"

namespace {

namespace fs = std::filesystem;
using coppice::test::BackgroundProcess;
using coppice::test::ProcessResult;
using coppice::test::run_process;
using coppice::test::TemporaryFolder;

const std::vector<std::string> kQuick = {"--views", "2", "--resolution", "16", "--quiet"};

std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

ProcessResult coppice_tool(const std::vector<std::string>& arguments) {
  return run_process(COPPICE_TOOL, arguments);
}

std::string read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::map<std::string, std::string> outputs(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_regular_file() && name.rfind(".coppice-", 0) != 0) files[name] = read_text(entry.path());
  }
  return files;
}

class BakeParts : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(plants_);
    for (int i = 0; i < 7; ++i)
      coppice::test::write_file(plants_ / ("small" + std::to_string(i) + ".glb"), coppice::test::small_plant().glb());
    ASSERT_EQ(coppice_tool(joined({"bake-all", plants_, "-o", folder_ / "alone"}, kQuick)).exit_code, 0);
  }

  TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants", out_ = folder_ / "out";
};

TEST_F(BakeParts, ShardsAreAllPlantsOnceAndMayRunAtTheSameTime) {
  std::vector<std::unique_ptr<BackgroundProcess>> shards;
  for (const char* shard : {"1/3", "2/3", "3/3"})
    shards.push_back(std::make_unique<BackgroundProcess>(
        COPPICE_TOOL,
        joined({"bake-all", plants_, "-o", out_, "--shard", shard, "--report", folder_ / (std::string("report") + shard[0]).c_str()},
               kQuick)));
  for (const auto& shard : shards) EXPECT_EQ(shard->wait(), 0) << shard->err();
  EXPECT_TRUE(outputs(out_) == outputs(folder_ / "alone"));
  std::multiset<std::string> baked;
  for (const char* name : {"report1", "report2", "report3"}) {
    const auto json = nlohmann::json::parse(read_text(folder_ / name));
    EXPECT_GE(json["plants"].size(), 2u);
    for (const auto& plant : json["plants"]) baked.insert(plant["input"].get<std::string>());
  }
  EXPECT_EQ(baked.size(), 7u);
  EXPECT_EQ(std::set<std::string>(baked.begin(), baked.end()).size(), 7u);
}

TEST_F(BakeParts, MoreShardsThanPlantsAreEmpty) {
  const ProcessResult result = coppice_tool(joined({"bake-all", plants_, "-o", out_, "--shard", "9/9"}, kQuick));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(outputs(out_).empty());
}

TEST_F(BakeParts, AJournalHasALineForEachPlant) {
  std::ofstream(plants_ / "letter.glb") << "this is a letter, not a plant\n";
  const fs::path path = folder_ / "journal.jsonl", report = folder_ / "report.json";
  EXPECT_EQ(coppice_tool(joined({"bake-all", plants_, "-o", out_, "--journal", path, "--report", report}, kQuick)).exit_code, 1);
  const auto reported = nlohmann::json::parse(read_text(report))["plants"];
  std::set<nlohmann::json> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.insert(nlohmann::json::parse(line));
  EXPECT_EQ(lines, std::set<nlohmann::json>(reported.begin(), reported.end()));
  EXPECT_EQ(lines.size(), 8u);
}

TEST_F(BakeParts, APrintedScriptCanBeRunByHandAndFollowed) {
  const ProcessResult printed = coppice_tool(joined({"bake-all", plants_, "-o", out_, "--slurm", "--print"}, kQuick));
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_EQ(printed.out.rfind("#!/bin/sh\n#SBATCH ", 0), 0u) << printed.out;
  const fs::path script = folder_ / "script";
  std::ofstream(script) << printed.out;
  std::size_t tasks = 0;
  for (; printed.out.find("--array=0-" + std::to_string(tasks) + "\n") == std::string::npos; ++tasks) ASSERT_LT(tasks, 7u) << printed.out;
  BackgroundProcess following(COPPICE_TOOL, {"bake-all", "-o", out_, "--attach"});
  for (std::size_t task = 0; task <= tasks; ++task) {
    const ProcessResult ran = run_process("/bin/sh", {script, std::to_string(task)});
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
  }
  EXPECT_EQ(following.wait(), 0) << following.err();
  EXPECT_TRUE(outputs(out_) == outputs(folder_ / "alone"));
}

TEST_F(BakeParts, WhatDoesNotGoTogetherIsAUsageError) {
  const auto base = std::vector<std::string>{"bake-all", plants_, "-o", out_};
  for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{{"--shard", "0/3"},
                                                                                    {"--shard", "4/3"},
                                                                                    {"--shard", "3"},
                                                                                    {"--shard", "1/3x"},
                                                                                    {"--attach"},
                                                                                    {"--print"},
                                                                                    {"--coppice", "x"},
                                                                                    {"--", "-p", "long"},
                                                                                    {"--slurm", "--shard", "1/2"},
                                                                                    {"--slurm", "--threads", "2"},
                                                                                    {"--slurm", "--journal", "x"}}) {
    const ProcessResult result = coppice_tool(joined(base, more));
    EXPECT_EQ(result.exit_code, 2) << more.front();
    EXPECT_FALSE(fs::exists(out_)) << more.front();
  }
  EXPECT_EQ(coppice_tool({"bake-all", "-o", out_}).exit_code, 2);
  const ProcessResult nothing = coppice_tool({"bake-all", "-o", out_, "--attach"});
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_NE(nothing.err.find("no run on a cluster"), std::string::npos) << nothing.err;
}

}  // namespace
