// Parts of a batch on several machines without Slurm: shards, journals, and tasks that somebody else starts.

#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "gltf_builder.h"
#include "mentions.h"
#include "places.h"
#include "process.h"
#include "text_files.h"

namespace bake_parts_test {

namespace fs = std::filesystem;
using coppice::test::BackgroundProcess;
using coppice::test::joined;
using coppice::test::mentions;
using coppice::test::outputs;
using coppice::test::ProcessResult;
using coppice::test::read_text;
using coppice::test::run_process;
using coppice::test::TemporaryFolder;

/// What coppice keeps beside outputs begins so.
const std::string kKept = ".coppice-";
const std::vector<std::string> kQuick = {"--views", "2", "--resolution", "16", "--quiet"};

ProcessResult coppice_tool(const std::vector<std::string>& arguments) {
  return run_process(coppice::test::kTool, arguments);
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
        coppice::test::kTool,
        joined({"bake-all", plants_, "-o", out_, "--shard", shard, "--report", folder_ / (std::string("report") + shard[0]).c_str()},
               kQuick)));
  for (const auto& shard : shards) EXPECT_EQ(shard->wait(), 0) << shard->err();
  EXPECT_TRUE(outputs(out_, kKept) == outputs(folder_ / "alone", kKept));
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
  EXPECT_TRUE(outputs(out_, kKept).empty());
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

TEST_F(BakeParts, APrintedScriptCanBeRunManually) {
  const ProcessResult printed = coppice_tool(joined({"bake-all", plants_, "-o", out_, "--slurm", "--print"}, kQuick));
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_EQ(printed.out.rfind("#!/bin/sh\n#SBATCH ", 0), 0u) << printed.out;
  const fs::path script = folder_ / "script";
  std::ofstream(script) << printed.out;
  EXPECT_NE(run_process("/bin/sh", {script, "99"}).exit_code, 0);
  std::size_t tasks = 0;
  while (run_process("/bin/sh", {script, std::to_string(tasks)}).exit_code == 0) ASSERT_LE(++tasks, 7u);
  EXPECT_GE(tasks, 1u);
  EXPECT_TRUE(outputs(out_, kKept) == outputs(folder_ / "alone", kKept));
}

TEST_F(BakeParts, WhatDoesNotGoTogetherIsAUsageError) {
  const auto base = std::vector<std::string>{"bake-all", plants_, "-o", out_};
  for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{{"--shard", "0/3"},
                                                                                    {"--shard", "4/3"},
                                                                                    {"--shard", "3"},
                                                                                    {"--shard", "1/3x"},
                                                                                    {"--print"},
                                                                                    {"--coppice", "x"},
                                                                                    {"--cache-mode", "read"},
                                                                                    {"--", "-p", "long"},
                                                                                    {"--slurm", "--", "--wait"},
                                                                                    {"--slurm", "--", "--clusters=other"},
                                                                                    {"--slurm", "--shard", "1/2"},
                                                                                    {"--slurm", "--threads", "2"},
                                                                                    {"--slurm", "--journal", "x"}}) {
    const ProcessResult result = coppice_tool(joined(base, more));
    EXPECT_EQ(result.exit_code, 2) << more.front();
    EXPECT_FALSE(fs::exists(out_)) << more.front();
  }
  EXPECT_EQ(coppice_tool({"bake-all", "-o", out_}).exit_code, 2);
  const ProcessResult unseparated = coppice_tool(joined(base, {"--slurm", "-p", "long"}));
  EXPECT_EQ(unseparated.exit_code, 2);
  EXPECT_TRUE(mentions(unseparated.err, {"--slurm -- -p"}));
  const ProcessResult no_scheme = coppice_tool(joined(base, {"--cache", "studio.example:8080/plants"}));
  EXPECT_EQ(no_scheme.exit_code, 1);
  EXPECT_TRUE(mentions(no_scheme.err, {"http://", "studio.example:8080/plants"}));
}

}  // namespace bake_parts_test
