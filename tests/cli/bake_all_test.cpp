// coppice bake-all from outside: one command, and parts of a batch on several machines without Slurm: shards, journals, and tasks that
// somebody else starts.

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "documents.h"
#include "gltf_builder.h"
#include "tool.h"

namespace coppice::test::bake_all_test {

namespace fs = std::filesystem;

Words bake_all(const fs::path& input, const fs::path& output, const Words& more = {}) {
  return joined({"bake-all", input, "-o", output, "--views", "2", "--resolution", "16"}, more);
}

class BakeAll : public testing::Test {
 protected:
  /// A hazel, a hazel of another seed in a folder, and the smallest plant.
  void SetUp() override {
    fs::create_directories(plants_ / "hedge");
    ASSERT_EQ(run_tool({"plant", "corylus", "-o", plants_ / "hazel.glb"}).exit_code, 0);
    ASSERT_EQ(run_tool({"plant", "corylus", "-o", plants_ / "hedge" / "hazel.glb", "--seed", "2"}).exit_code, 0);
    write_file(plants_ / "small.glb", small_plant().glb());
  }

  TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants", out_ = folder_ / "out";
};

TEST_F(BakeAll, TakesOnePlantToo) {
  const ProcessResult result = run_tool(bake_all(plants_ / "small.glb", out_));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(outputs(out_).size(), 1u);
  EXPECT_TRUE(fs::exists(out_ / "small.coppice"));
}

TEST_F(BakeAll, ABadFileKeepsNoneOfTheOthersFromBeingBaked) {
  write_text(plants_ / "letter.glb", "this is a letter, not a plant\n");
  const fs::path report = folder_ / "report.json";
  const ProcessResult first = run_tool(bake_all(plants_, out_, {"--report", report}));
  EXPECT_EQ(first.exit_code, 1);
  EXPECT_EQ(count_of(first.err, "\n"), 1u) << first.err;
  EXPECT_TRUE(mentions(first.err, {"letter.glb"}));
  for (const char* plant : {"hedge/hazel", "letter", "small"}) EXPECT_EQ(lines_that_name(first.out, plant), 1u) << first.out;
  Words names;
  for (const auto& [name, bytes] : outputs(out_)) names.push_back(name);
  EXPECT_EQ(names, (Words{"hazel.coppice", "hedge/hazel.coppice", "small.coppice"}));
  for (const std::string& name : names) EXPECT_EQ(run_tool({"verify", out_ / name}).exit_code, 0) << name;

  const auto json = read_json(report);
  std::set<std::string> keys = keys_of(json);
  for (const auto& plant : json["plants"]) keys.merge(keys_of(plant));
  EXPECT_EQ(keys, column_spans(table_after(source_text("bake/README.md"), "`coppice bake-all --report F.json`"), 0));
  EXPECT_EQ(counts_in(report), (BatchCounts{3, 0, 1}));
  ASSERT_EQ(json["plants"].size(), 4u);
  EXPECT_EQ(json["plants"][0]["outcome"], "baked");
  EXPECT_EQ(json["plants"][0]["source_leaves"], 386);
  EXPECT_EQ(json["plants"][0]["file_bytes"], fs::file_size(out_ / "hazel.coppice"));
  EXPECT_EQ(json["plants"][0]["key"].get<std::string>().size(), 32u);
  EXPECT_GT(json["plants"][0]["bytes_per_leaf"], 4.0);
  EXPECT_EQ(json["plants"][2]["outcome"], "failed");
  EXPECT_NE(json["plants"][2]["error"], "");

  const ProcessResult second = run_tool(bake_all(plants_, out_, {"--report", report}));
  EXPECT_EQ(second.exit_code, 1) << "a plant that fails fails again";
  EXPECT_EQ(counts_in(report), (BatchCounts{0, 3, 1}));
}

TEST_F(BakeAll, AFailureIsToldOnceInAtMostAHundredColumns) {
  const std::string name = "a " + std::string(120, 'x') + ".glb";
  write_text(plants_ / "hedge" / "letter.glb", "this is a letter, not a plant\n");
  write_text(plants_ / name, "nor is this\n");
  const ProcessResult result = run_tool(bake_all(plants_, out_, {"--leaf-material", "^leaves of another plant altogether$"}));
  EXPECT_EQ(result.exit_code, 1);
  std::istringstream lines(result.err);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_EQ(count_of(result.err, "coppice: "), 3u) << "what fails for one reason is told together: " << result.err;
  EXPECT_EQ(count_of(result.err, ".glb, hedge/letter.glb: "), 1u) << result.err;
  EXPECT_EQ(count_of(result.err, "coppice: hazel.glb, hedge/hazel.glb: "), 1u) << result.err;
  EXPECT_EQ(count_of(result.err, "letter.glb"), 1u) << result.err;
  EXPECT_EQ(count_of(result.err, plants_.string()), 0u) << result.err;
  // Nothing is left out.
  EXPECT_TRUE(mentions(result.err, {"'wood'"}));
}

TEST_F(BakeAll, ASecondRunBakesAndWritesNothing) {
  ASSERT_EQ(run_tool(bake_all(plants_, out_)).exit_code, 0);
  const auto bytes = outputs(out_);
  const auto written = fs::last_write_time(out_ / "hazel.coppice");
  const fs::path report = folder_ / "report.json";
  const ProcessResult second = run_tool(bake_all(plants_, out_, {"--jobs", "3", "--report", report}));
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(counts_in(report), (BatchCounts{0, 3, 0}));
  EXPECT_EQ(fs::last_write_time(out_ / "hazel.coppice"), written);
  EXPECT_TRUE(outputs(out_) == bytes);
  const ProcessResult other = run_tool(bake_all(plants_, out_, {"--metric", "mi", "--quiet"}));
  EXPECT_EQ(other.out + other.err, "");
  EXPECT_TRUE(outputs(out_) != bytes);
}

TEST_F(BakeAll, TheBytesAreThoseOfASingleBakeForAnyNumberOfJobs) {
  ASSERT_EQ(run_tool(bake_all(plants_, folder_ / "one", {"--jobs", "1"})).exit_code, 0);
  ASSERT_EQ(run_tool(bake_all(plants_, folder_ / "two", {"--jobs", "2"})).exit_code, 0);
  EXPECT_TRUE(outputs(folder_ / "one") == outputs(folder_ / "two"));
  const Words quick{"--views", "2", "--resolution", "16", "--quiet"};
  ASSERT_EQ(run_tool(joined({"bake", plants_ / "hedge" / "hazel.glb", "-o", folder_ / "hazel.coppice"}, quick)).exit_code, 0);
  EXPECT_TRUE(outputs(folder_ / "one")["hedge/hazel.coppice"] == read_text(folder_ / "hazel.coppice"));
}

/// Killed at 200 moments of a batch, which are spread over the time that it takes.
TEST_F(BakeAll, AKilledRunGoesOnWhereItWas) {
  write_text(plants_ / "list.json", R"([{"input": "small.glb"}, {"input": "small.glb", "output": "far/small.coppice", "wind_stiffness": 2},
                                        {"input": "small.glb", "output": "still.coppice", "metric": "geometric"}])");
  const fs::path list = plants_ / "list.json", cache = folder_ / "cache", report = folder_ / "report.json";
  const auto batch = [&](const fs::path& out) { return bake_all(list, out, {"--jobs", "2", "--cache", cache, "--report", report}); };
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(run_tool(batch(folder_ / "whole")).exit_code, 0);
  const auto time = std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - start);
  const auto whole = outputs(folder_ / "whole");
  constexpr int kMoments = 200;
  std::size_t killed_between = 0;
  for (int moment = 0; moment < kMoments; ++moment) {
    for (const fs::path& folder : {cache, out_}) fs::remove_all(folder);
    ProcessOptions options;
    options.kill_after = std::chrono::duration_cast<std::chrono::milliseconds>(time * moment / kMoments);
    const ProcessResult killed = run_tool(batch(out_), options);
    for (const auto& [name, bytes] : fs::exists(out_) ? outputs(out_) : decltype(whole)())
      EXPECT_TRUE(name.ends_with(".tmp") || (whole.contains(name) && bytes == whole.at(name))) << name << " at moment " << moment;
    std::size_t kept = 0;
    if (fs::exists(cache)) {
      for (const auto& entry : fs::directory_iterator(cache)) kept += entry.path().extension() == ".record" ? 1u : 0u;
      const ProcessResult verified = run_tool({"cache", "verify", cache});
      EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
    }
    killed_between += killed.signal == SIGKILL && kept > 0 ? 1u : 0u;
    const ProcessResult resumed = run_tool(batch(out_));
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    const BatchCounts counts = counts_in(report);
    EXPECT_EQ(counts.baked + counts.cached, 3u);
    EXPECT_GE(counts.cached, kept) << "at moment " << moment;
    EXPECT_TRUE(outputs(out_) == whole) << "at moment " << moment;
  }
  EXPECT_GT(killed_between, 0u) << "it was never killed in the middle";
}

/// Another file is read in place of one of the plant's, at any opening. What the cache then has is what the plant's own files bake to.
TEST_F(BakeAll, AFileThatChangesWhileItIsReadIsNotBakedUnderTheKeyOfTheOther) {
  const fs::path gltf = plants_ / "oak.gltf", buffer = plants_ / "oak.bin", image = plants_ / "oak.png", normals = plants_ / "bumps.png";
  GltfBuilder builder = small_plant();
  builder.set_texture(0, png(2, 2, {10, 200, 30, 255}));
  builder.json["images"] = {{{"uri", "oak.png"}}, {{"uri", "bumps.png"}}};
  builder.json["textures"] = {{{"source", 0}}, {{"source", 1}}};
  builder.json["materials"][0]["normalTexture"] = {{"index", 1}};
  std::map<fs::path, std::string> others;  // by the file that each is read for
  const auto add = [&](const fs::path& path, const auto& now, const auto& other) {
    others[path] = path.string() + ".other";
    write_file(path, now);
    write_file(others[path], other);
  };
  add(buffer, builder.bin, std::vector<std::uint8_t>(builder.bin.size(), 0));
  add(image, png(2, 2, {10, 200, 30, 255}), png(2, 2, {200, 10, 30, 255}));
  add(normals, png(2, 2, {128, 128, 255, 255}), std::vector<std::uint8_t>());
  GltfBuilder larger = builder;
  larger.json["nodes"][0]["scale"] = {3, 3, 3};
  add(gltf, builder.gltf_beside("oak.bin"), larger.gltf_beside("oak.bin"));
  ASSERT_EQ(run_tool(bake_all(gltf, folder_ / "right")).exit_code, 0);
  const std::string right = read_text(folder_ / "right" / "oak.coppice");
  for (const auto& [path, other] : others) {
    std::size_t refused = 0;
    for (int opening = 1; opening <= 5; ++opening) {
      fs::remove_all(out_);
      const Words environment{std::string("LD_PRELOAD=") + kFailMallocLibrary, "COPPICE_OPEN_OTHER=" + std::to_string(opening),
                              "COPPICE_OPENED=" + path.string(), "COPPICE_OTHER=" + other};
      refused += run_tool(bake_all(gltf, out_), {.environment = environment}).exit_code == 1 ? 1u : 0u;
      const ProcessResult again = run_tool(bake_all(gltf, out_));
      EXPECT_EQ(again.exit_code, 0) << again.err;
      EXPECT_TRUE(read_text(out_ / "oak.coppice") == right) << path << " at opening " << opening;
    }
    EXPECT_GT(refused, 0u) << path;
  }
}

TEST_F(BakeAll, AListGivesPlantsOptionsOfTheirOwn) {
  write_text(plants_ / "list.json", R"([{"input": "hazel.glb", "metric": "geometric", "leaf_material": "^leaves$"},
                                        {"input": "hedge/hazel.glb", "classes": "rules.json"},
                                        {"input": "hazel.glb", "output": "far/hazel.coppice", "background": "off"}])");
  write_text(plants_ / "rules.json", R"({"classes": [{"material": "leaves", "class": "leaf"}]})");
  const ProcessResult result = run_tool(bake_all(plants_ / "list.json", out_));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto files = outputs(out_);
  ASSERT_EQ(files.size(), 3u);
  const ProcessResult inspected = run_tool({"inspect", out_ / "hazel.coppice"});
  EXPECT_TRUE(mentions(inspected.out, {"geometric"}));
  EXPECT_TRUE(files.count("far/hazel.coppice") == 1 && files.count("hedge/hazel.coppice") == 1);
}

TEST_F(BakeAll, AListThatIsWrongIsRefusedWithThePlace) {
  const std::vector<std::pair<std::string, std::string>> lists = {
      {R"([{"input": "hazel.glb", "metrik": "mi"}])", "[0].metrik"},
      {R"([{"input": "hazel.glb"}, {"input": "small.glb", "metric": "beauty"}])", "[1].metric"},
      {R"([{"input": "hazel.glb", "views": 0}])", "[0].views"},
      {R"([{"input": "hazel.glb", "views": [20]}])", "[0].views"},
      {R"([{"input": "hazel.glb", "help": true}])", "[0].help"},
      {R"([{"input": "hazel.glb", "leaf-material": "x"}])", "[0].leaf-material"},
      {R"([{"input": "hazel.glb", "output": "../hazel.coppice"}])", "[0].output"},
      {R"([{"input": "hazel.glb", "output": "a/.."}])", "[0].output"},
      {R"([{"input": "hazel.glb", "output": "/tmp/hazel.coppice"}])", "[0].output"},
      {R"([{"input": "hazel.glb", "output": ".coppice-cache/lock"}])", "[0].output"},
      {R"([{"input": "small.glb"}, {"input": "hazel.glb", "output": ".coppice-cluster/x/run.json"}])", "[1].output"},
      {R"([{"input": "hazel.glb", "output": "a\u0000b"}])", "[0].output"},
      {R"([{"input": "hazel.glb\u0000", "output": "a"}])", "[0].input"},
      {R"([{"input": "hazel\u001b.glb"}])", "[0].input"},
      {R"([{"input": "hazel.glb", "classes": "a\nb"}])", "[0].classes"},
      {R"([{"input": 7}])", "[0].input"},
      {R"([{"metric": "mi"}])", "[0].input"},
      {R"(["hazel.glb"])", "[0]"},
      {R"([{"input": "hazel.glb"}, {"input": "hazel.glb", "metric": "mi"}])", "hazel.coppice"},
      {R"([{"input": "hazel.glb",}])", "byte 23"},
      {R"({"input": "hazel.glb"})", "list.json"},
      {"[]", "list.json"},
      {"", "byte 0"}};
  for (const auto& [text, place] : lists) {
    write_text(plants_ / "list.json", text);
    expect_one_line_error(run_tool(bake_all(plants_ / "list.json", out_)), {"list.json", place}, text);
    EXPECT_FALSE(fs::exists(out_)) << text;
  }
}

TEST_F(BakeAll, WhatCannotWorkIsRefusedBeforeTheWork) {
  for (const Words& arguments :
       {Words{"bake-all", plants_}, bake_all(plants_, out_, {"--jobs", "many"}), Words{"bake-all", plants_, "-o", out_, "--views", "0"}})
    EXPECT_EQ(run_tool(arguments).exit_code, 2);
  const fs::path empty = folder_ / "empty", file = plants_ / "small.glb";
  fs::create_directory(empty);
  for (const auto& arguments :
       {bake_all(empty, out_), bake_all(folder_ / "nowhere", out_), bake_all(plants_, file), bake_all(plants_, out_, {"--report", file})})
    expect_one_line_error(run_tool(arguments), {});
  fs::copy(plants_ / "hazel.glb", plants_ / "hazel.gltf");
  expect_failure(run_tool(bake_all(plants_, out_)), {"hazel.glb", "hazel.gltf", "hazel.coppice"});
  EXPECT_EQ(fs::file_size(file), small_plant().glb().size());
}

/// What coppice keeps beside outputs begins so.
const std::string kKept = ".coppice-";

class BakeParts : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(plants_);
    for (int i = 0; i < 7; ++i) write_file(plants_ / ("small" + std::to_string(i) + ".glb"), small_plant().glb());
    ASSERT_EQ(run_tool(bake_all(plants_, folder_ / "alone")).exit_code, 0);
  }

  /// Whether OUT has what one command makes on one machine.
  [[nodiscard]] bool is_whole() const { return outputs(out_, kKept) == outputs(folder_ / "alone", kKept); }

  TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants", out_ = folder_ / "out";
};

TEST_F(BakeParts, ShardsAreAllPlantsOnceAndMayRunAtTheSameTime) {
  std::vector<std::unique_ptr<BackgroundProcess>> shards;
  for (const char* shard : {"1/3", "2/3", "3/3"})
    shards.push_back(std::make_unique<BackgroundProcess>(
        kTool, bake_all(plants_, out_, {"--shard", shard, "--report", folder_ / (std::string("report") + shard[0]).c_str()})));
  for (const auto& shard : shards) EXPECT_EQ(shard->wait(), 0) << shard->err();
  EXPECT_TRUE(is_whole());
  std::multiset<std::string> baked;
  for (const char* name : {"report1", "report2", "report3"}) {
    const auto json = read_json(folder_ / name);
    EXPECT_GE(json["plants"].size(), 2u);
    for (const auto& plant : json["plants"]) baked.insert(plant["input"].get<std::string>());
  }
  EXPECT_EQ(baked.size(), 7u);
  EXPECT_EQ(std::set<std::string>(baked.begin(), baked.end()).size(), 7u);
}

TEST_F(BakeParts, MoreShardsThanPlantsAreEmpty) {
  const ProcessResult result = run_tool(bake_all(plants_, out_, {"--shard", "9/9"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(outputs(out_, kKept).empty());
}

TEST_F(BakeParts, AJournalHasALineForEachPlant) {
  write_text(plants_ / "letter.glb", "this is a letter, not a plant\n");
  const fs::path path = folder_ / "journal.jsonl", report = folder_ / "report.json";
  EXPECT_EQ(run_tool(bake_all(plants_, out_, {"--journal", path, "--report", report})).exit_code, 1);
  const auto reported = read_json(report)["plants"];
  std::set<nlohmann::json> lines;
  std::istringstream journal(read_text(path));
  for (std::string line; std::getline(journal, line);) lines.insert(nlohmann::json::parse(line));
  EXPECT_EQ(lines, std::set<nlohmann::json>(reported.begin(), reported.end()));
  EXPECT_EQ(lines.size(), 8u);
}

TEST_F(BakeParts, APrintedScriptCanBeRunByHand) {
  const ProcessResult printed = run_tool(bake_all(plants_, out_, {"--slurm", "--print", "--quiet"}));
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_EQ(printed.out.rfind("#!/bin/sh\n#SBATCH ", 0), 0u) << printed.out;
  const fs::path script = folder_ / "script";
  write_text(script, printed.out);
  EXPECT_NE(run_process("/bin/sh", {script, "99"}).exit_code, 0);
  std::size_t tasks = 0;
  while (run_process("/bin/sh", {script, std::to_string(tasks)}).exit_code == 0) ASSERT_LE(++tasks, 7u);
  EXPECT_GE(tasks, 1u);
  EXPECT_TRUE(is_whole());
}

TEST_F(BakeParts, ATaskRunsOnlyInAFolderWhereNobodyElseWrites) {
  const ProcessResult printed = run_tool(bake_all(plants_, out_, {"--slurm", "--print", "--quiet"}));
  EXPECT_TRUE(mentions(printed.out, {"--output=/dev/null"})) << "Slurm itself would follow a link";
  const fs::path run = fs::directory_iterator(out_ / ".coppice-cluster")->path(), script = folder_ / "script", mine = folder_ / "mine";
  for (const fs::path& file : {script, mine}) write_text(file, file == mine ? "mine" : printed.out);
  fs::create_symlink(mine, run / "0.log");
  const auto refuses = [&] {
    return run_process("/bin/sh", {script, "0"}).exit_code != 0 && read_text(mine) == "mine" && outputs(out_, ".coppice-").empty();
  };
  for (const fs::perms others : {fs::perms::group_write, fs::perms::others_write}) {
    fs::permissions(run, fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec | others);
    EXPECT_TRUE(refuses());
  }
  fs::permissions(run, fs::perms::owner_all);
  if (::geteuid() != 0 || ::chown(run.c_str(), 4711, 4711) != 0) GTEST_SKIP() << "only root can act for another user";
  EXPECT_TRUE(refuses());
}

TEST_F(BakeParts, WhatDoesNotGoTogetherIsAUsageError) {
  const Words base{"bake-all", plants_, "-o", out_};
  const std::vector<Words> wrong{{"--shard", "0/3"},
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
                                 {"--slurm", "--journal", "x"}};
  for (const Words& more : wrong) {
    const ProcessResult result = run_tool(joined(base, more));
    EXPECT_EQ(result.exit_code, 2) << more.front();
    EXPECT_FALSE(fs::exists(out_)) << more.front();
  }
  EXPECT_EQ(run_tool({"bake-all", "-o", out_}).exit_code, 2);
  expect_failure(run_tool(joined(base, {"--slurm", "-p", "long"})), {"--slurm -- -p"}, 2);
  expect_error(run_tool(joined(base, {"--cache", "studio.example:8080/plants"})), {"http://", "studio.example:8080/plants"});
}

}  // namespace coppice::test::bake_all_test
