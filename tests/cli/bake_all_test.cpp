// coppice bake-all from outside.

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "documents.h"
#include "gltf_builder.h"
#include "mentions.h"
#include "places.h"
#include "process.h"
#include "text_files.h"

namespace bake_all_test {

namespace fs = std::filesystem;
using coppice::test::lines_that_name;
using coppice::test::mentions;
using coppice::test::outputs;
using coppice::test::ProcessOptions;
using coppice::test::ProcessResult;
using coppice::test::read_text;
using coppice::test::TemporaryFolder;
using coppice::test::write_text;

ProcessResult coppice_tool(const std::vector<std::string>& arguments, const ProcessOptions& options = {}) {
  return coppice::test::run_process(coppice::test::kTool, arguments, options);
}

/// What a report counts: baked, cached, failed.
using Counts = std::array<std::size_t, 3>;

Counts counts_in(const fs::path& report) {
  const auto json = nlohmann::json::parse(read_text(report));
  return {json["baked"], json["cached"], json["failed"]};
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

const std::vector<std::string> kQuick = {"--views", "2", "--resolution", "16"};

std::vector<std::string> bake_all(const fs::path& input, const fs::path& output, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"bake-all", input, "-o", output};
  arguments.insert(arguments.end(), kQuick.begin(), kQuick.end());
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

class BakeAll : public testing::Test {
 protected:
  /// A hazel, a hazel of another seed in a folder, and the smallest plant.
  void SetUp() override {
    fs::create_directories(plants_ / "hedge");
    ASSERT_EQ(coppice_tool({"plant", "corylus", "-o", plants_ / "hazel.glb"}).exit_code, 0);
    ASSERT_EQ(coppice_tool({"plant", "corylus", "-o", plants_ / "hedge" / "hazel.glb", "--seed", "2"}).exit_code, 0);
    coppice::test::write_file(plants_ / "small.glb", coppice::test::small_plant().glb());
  }

  TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants", out_ = folder_ / "out";
};

TEST_F(BakeAll, TakesOnePlantToo) {
  const ProcessResult result = coppice_tool(bake_all(plants_ / "small.glb", out_));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(outputs(out_).size(), 1u);
  EXPECT_TRUE(fs::exists(out_ / "small.coppice"));
}

TEST_F(BakeAll, ABadFileKeepsNoneOfTheOthersFromBeingBaked) {
  write_text(plants_ / "letter.glb", "this is a letter, not a plant\n");
  const fs::path report = folder_ / "report.json";
  const ProcessResult first = coppice_tool(bake_all(plants_, out_, {"--report", report}));
  EXPECT_EQ(first.exit_code, 1);
  EXPECT_EQ(count_of(first.err, "\n"), 1u) << first.err;
  EXPECT_TRUE(mentions(first.err, {"letter.glb"}));
  for (const char* plant : {"hedge/hazel", "letter", "small"}) EXPECT_EQ(lines_that_name(first.out, plant), 1u) << first.out;
  std::vector<std::string> names;
  for (const auto& [name, bytes] : outputs(out_)) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"hazel.coppice", "hedge/hazel.coppice", "small.coppice"}));
  for (const std::string& name : names) EXPECT_EQ(coppice_tool({"verify", out_ / name}).exit_code, 0) << name;

  const auto json = nlohmann::json::parse(read_text(report));
  std::set<std::string> keys;
  const auto add_keys = [&keys](const nlohmann::json& object) {
    for (const auto& [key, value] : object.items()) keys.insert(key);
  };
  add_keys(json);
  for (const auto& plant : json["plants"]) add_keys(plant);
  const coppice::test::Table table =
      coppice::test::table_after(coppice::test::source_text("bake/README.md"), "`coppice bake-all --report F.json`");
  EXPECT_EQ(keys, coppice::test::column_spans(table, 0));
  EXPECT_EQ(json["baked"], 3);
  EXPECT_EQ(json["cached"], 0);
  EXPECT_EQ(json["failed"], 1);
  ASSERT_EQ(json["plants"].size(), 4u);
  EXPECT_EQ(json["plants"][0]["outcome"], "baked");
  EXPECT_EQ(json["plants"][0]["source_leaves"], 386);
  EXPECT_EQ(json["plants"][0]["file_bytes"], fs::file_size(out_ / "hazel.coppice"));
  EXPECT_EQ(json["plants"][0]["key"].get<std::string>().size(), 32u);
  EXPECT_GT(json["plants"][0]["bytes_per_leaf"], 4.0);
  EXPECT_EQ(json["plants"][2]["outcome"], "failed");
  EXPECT_NE(json["plants"][2]["error"], "");

  const ProcessResult second = coppice_tool(bake_all(plants_, out_, {"--report", report}));
  EXPECT_EQ(second.exit_code, 1) << "a plant that fails fails again";
  EXPECT_EQ(counts_in(report), (Counts{0, 3, 1}));
}

TEST_F(BakeAll, AFailureIsToldOnceInAtMostAHundredColumns) {
  const std::string name = "a " + std::string(120, 'x') + ".glb";
  write_text(plants_ / "hedge" / "letter.glb", "this is a letter, not a plant\n");
  write_text(plants_ / name, "nor is this\n");
  const ProcessResult result = coppice_tool(bake_all(plants_, out_, {"--leaf-material", "^leaves of another plant altogether$"}));
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
  ASSERT_EQ(coppice_tool(bake_all(plants_, out_)).exit_code, 0);
  const auto bytes = outputs(out_);
  const auto written = fs::last_write_time(out_ / "hazel.coppice");
  const fs::path report = folder_ / "report.json";
  const ProcessResult second = coppice_tool(bake_all(plants_, out_, {"--jobs", "3", "--report", report}));
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(counts_in(report), (Counts{0, 3, 0}));
  EXPECT_EQ(fs::last_write_time(out_ / "hazel.coppice"), written);
  EXPECT_TRUE(outputs(out_) == bytes);
  const ProcessResult other = coppice_tool(bake_all(plants_, out_, {"--metric", "mi", "--quiet"}));
  EXPECT_EQ(other.out + other.err, "");
  EXPECT_TRUE(outputs(out_) != bytes);
}

TEST_F(BakeAll, TheBytesAreThoseOfASingleBakeForAnyNumberOfJobs) {
  ASSERT_EQ(coppice_tool(bake_all(plants_, folder_ / "one", {"--jobs", "1"})).exit_code, 0);
  ASSERT_EQ(coppice_tool(bake_all(plants_, folder_ / "two", {"--jobs", "2"})).exit_code, 0);
  EXPECT_TRUE(outputs(folder_ / "one") == outputs(folder_ / "two"));
  std::vector<std::string> single{"bake", plants_ / "hedge" / "hazel.glb", "-o", folder_ / "hazel.coppice", "--quiet"};
  single.insert(single.end(), kQuick.begin(), kQuick.end());
  ASSERT_EQ(coppice_tool(single).exit_code, 0);
  EXPECT_TRUE(outputs(folder_ / "one")["hedge/hazel.coppice"] == read_text(folder_ / "hazel.coppice"));
}

TEST_F(BakeAll, AKilledRunGoesOnWhereItWas) {
  // Plants that cost the same are baked in their order. The second takes seconds.
  write_text(plants_ / "list.json", R"([{"input": "hazel.glb", "resolution": 256, "views": 20},
                                        {"input": "hazel.glb", "output": "slow.coppice", "resolution": 256, "views": 20, "wind_stiffness": 2}])");
  const fs::path list = plants_ / "list.json", hazel = out_ / "hazel.coppice";
  ProcessOptions options;
  options.kill_when_exists = hazel;
  const ProcessResult killed = coppice_tool(bake_all(list, out_, {"--jobs", "1"}), options);
  ASSERT_EQ(killed.signal, SIGKILL) << killed.out << killed.err;
  EXPECT_FALSE(fs::exists(out_ / "slow.coppice")) << "it was not killed in the middle";
  EXPECT_EQ(coppice_tool({"verify", hazel}).exit_code, 0);
  // What a write that was cut short leaves.
  const fs::path abandoned = out_ / ".coppice-999999999-0.tmp";
  write_text(abandoned, "half");

  const fs::path report = folder_ / "report.json";
  const ProcessResult resumed = coppice_tool(bake_all(list, out_, {"--jobs", "1", "--report", report}));
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(counts_in(report), (Counts{1, 1, 0}));
  EXPECT_EQ(coppice_tool({"verify", out_ / "slow.coppice"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(abandoned));
}

TEST_F(BakeAll, AListGivesPlantsOptionsOfTheirOwn) {
  write_text(plants_ / "list.json", R"([{"input": "hazel.glb", "metric": "geometric", "leaf_material": "^leaves$"},
                                        {"input": "hedge/hazel.glb", "classes": "rules.json"},
                                        {"input": "hazel.glb", "output": "far/hazel.coppice", "background": "off"}])");
  write_text(plants_ / "rules.json", R"({"classes": [{"material": "leaves", "class": "leaf"}]})");
  const ProcessResult result = coppice_tool(bake_all(plants_ / "list.json", out_));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto files = outputs(out_);
  ASSERT_EQ(files.size(), 3u);
  const ProcessResult inspected = coppice_tool({"inspect", out_ / "hazel.coppice"});
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
    const ProcessResult result = coppice_tool(bake_all(plants_ / "list.json", out_));
    EXPECT_EQ(result.exit_code, 1) << text;
    EXPECT_EQ(result.out, "") << text;
    EXPECT_EQ(count_of(result.err, "\n"), 1u) << text << "\n" << result.err;
    EXPECT_TRUE(mentions(result.err, {"list.json", place})) << text;
    EXPECT_FALSE(fs::exists(out_)) << text;
  }
}

TEST_F(BakeAll, WhatCannotWorkIsRefusedBeforeTheWork) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"bake-all", plants_}, {"bake-all", plants_, "-o", out_, "--jobs", "many"}, {"bake-all", plants_, "-o", out_, "--views", "0"}})
    EXPECT_EQ(coppice_tool(arguments).exit_code, 2);
  const fs::path empty = folder_ / "empty", file = plants_ / "small.glb";
  fs::create_directory(empty);
  for (const auto& arguments :
       {bake_all(empty, out_), bake_all(folder_ / "nowhere", out_), bake_all(plants_, file), bake_all(plants_, out_, {"--report", file})}) {
    const ProcessResult result = coppice_tool(arguments);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(count_of(result.err, "\n"), 1u) << result.err;
  }
  fs::copy(plants_ / "hazel.glb", plants_ / "hazel.gltf");
  const ProcessResult colliding = coppice_tool(bake_all(plants_, out_));
  EXPECT_EQ(colliding.exit_code, 1);
  EXPECT_TRUE(mentions(colliding.err, {"hazel.glb", "hazel.gltf", "hazel.coppice"}));
  EXPECT_EQ(fs::file_size(file), coppice::test::small_plant().glb().size());
}

}  // namespace bake_all_test
