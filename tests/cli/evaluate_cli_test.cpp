// coppice evaluate from outside.

#include <array>
#include <filesystem>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "baked_corylus.h"
#include "documents.h"
#include "made_once.h"
#include "tool.h"

namespace coppice::test::evaluate_cli_test {

namespace fs = std::filesystem;

Table table_of_keys() {
  return table_after(source_text("bake/lab/README.md"), "`--write-source Q.glb`");
}

class EvaluateCommand : public testing::Test {
 protected:
  void SetUp() override { fs::copy(corylus_glb(), plant_); }

  /// Measures the plant with these options.
  [[nodiscard]] ProcessResult evaluate(const Words& options) const { return run_tool(joined({"evaluate", plant_}, options)); }

  TemporaryFolder folder_;
  fs::path plant_ = folder_ / "hazel.glb", json_ = folder_ / "hazel.json", html_ = folder_ / "hazel.html", set_ = folder_ / "set";
};

TEST_F(EvaluateCommand, WritesATableAndAFile) {
  const ProcessResult result = evaluate({"--methods", "geometric,stochastic", "--levels", ".2,.05", "--json", json_});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_TRUE(mentions(result.out, {"hazel", "386", "0.200", "77", "0.050", "19", "geometric", "stochastic", "rmse_16"}));
  EXPECT_EQ(result.out.find("meshopt"), std::string::npos) << result.out;
  const auto parsed = read_json(json_);
  EXPECT_EQ(parsed["methods"].size(), 2u);
  EXPECT_EQ(parsed["methods"][0]["levels"][0]["leaves"], 77);
  EXPECT_EQ(parsed["methods"][0]["levels"][0]["lightings"].size(), 6u);
  const std::set<std::string> told = spans_of_row(table_of_keys(), "lightings");
  for (const std::string& key : keys_of(parsed["methods"][0]["levels"][0]["lightings"][0])) EXPECT_TRUE(told.contains(key)) << key;
}

TEST_F(EvaluateCommand, ComparesWithTheMeshesAtAnySize) {
  const ProcessResult result =
      evaluate({"--methods", "stochastic", "--levels", "1,.2", "--reference", "meshes", "--size", "64", "--json", json_, "--html", html_});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"64", "1.000", "386", "rmse_64", "rmse_4", ".coppice"}));
  const auto parsed = read_json(json_);
  EXPECT_EQ(parsed["reference"], "meshes");
  EXPECT_EQ(parsed["size_px"], 64);
  for (const std::string& key : keys_of(parsed)) EXPECT_TRUE(column_spans(table_of_keys(), 0).contains(key)) << key;
  const auto& levels = parsed["methods"][0]["levels"];
  EXPECT_GT(levels[0]["rmse_64"], 0.0) << "quads are not the leaves that they stand for";
  EXPECT_LT(levels[0]["rmse_64"], levels[1]["rmse_64"]);
  EXPECT_EQ(parsed["stored"]["leaf_meshes"], true);
  EXPECT_LT(parsed["stored"]["rmse_64"], 0.2 * levels[0]["rmse_64"].get<double>()) << "a file holds the leaves as they were modelled";
  EXPECT_NE(read_text(html_).find("\"reference\":\"meshes\""), std::string::npos);
}

TEST_F(EvaluateCommand, ErrorsAreOneLineAndUsageExitsWith2) {
  for (const Words& usage : {Words{"--methods", "beauty"},
                             {"--levels", "1.5"},
                             {"--levels", "few"},
                             {"--levels", "0"},
                             {"--reference", "wood"},
                             {"--size", "100"},
                             {"--size", "0"},
                             {"--size", "wide"},
                             {"--paper", "--reference", "meshes"},
                             {"--view-distance", "1"}})
    EXPECT_EQ(evaluate(joined(usage, {"--json", json_})).exit_code, 2) << usage[0] << " " << usage[1];
  EXPECT_EQ(run_tool({"evaluate"}).exit_code, 2);
  EXPECT_EQ(run_tool({"evaluate", "--paper", "--write-source", folder_ / "q.glb"}).exit_code, 2);
  expect_one_line_error(run_tool({"evaluate", folder_ / "nowhere.glb", "--json", json_}), {"nowhere.glb"});
  expect_one_line_error(evaluate({"--leaf-material", "^petals$", "--json", json_}), {"--leaf-material", "'wood'"});
  for (const std::string set : {"nowhere", "=x", "mine=", "default=x", "mine=/no/such/folder"})
    expect_one_line_error(evaluate({"--methods", "stochastic", "--levels-of", set}), {}, set);
  EXPECT_FALSE(fs::exists(json_));
}

TEST_F(EvaluateCommand, RefusesOutputsBeforeItMeasures) {
  const std::string both = folder_ / "hazel.out", before = read_text(plant_);
  for (const Words& outputs : {Words{"--json", plant_},
                               {"--json", "/proc/no/such.json"},
                               {"--json", json_, "--html", plant_},
                               {"--json", both, "--html", both},
                               {"--json", json_, "--html", "/proc/no/such.html"}})
    expect_one_line_error(evaluate(joined({"--methods", "stochastic"}, outputs)), {}, testing::PrintToString(outputs));
  EXPECT_FALSE(fs::exists(json_));
  EXPECT_FALSE(fs::exists(both));
  EXPECT_EQ(read_text(plant_), before);
}

TEST_F(EvaluateCommand, WritesAReportThatIsOneFileInWhichAHostileNameStaysText) {
  // The slash of "</script>" parts folders: the name itself is "script><img src=x onerror=alert(1)>".
  const fs::path hostile = folder_ / "</script><img src=x onerror=alert(1)>.glb";
  fs::create_directory(hostile.parent_path());
  for (const fs::path& plant : {plant_, hostile}) {
    if (plant != plant_) fs::rename(plant_, plant);
    const ProcessResult result = run_tool({"evaluate", plant, "--methods", "stochastic", "--levels", ".1", "--html", html_});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::string page = read_text(html_);
    EXPECT_EQ(page.find("<!doctype html>"), 0u);
    EXPECT_NE(page.find("data:image/png;base64,iVBOR"), std::string::npos) << "no pictures";
    EXPECT_EQ(page.find("<img"), std::string::npos);
    if (plant == hostile) {
      EXPECT_NE(page.find("\\u003cimg"), std::string::npos);
      continue;
    }
    for (const std::string load : {" src=", "href=", "@import"}) EXPECT_EQ(page.find(load), std::string::npos) << load;
  }
}

TEST_F(EvaluateCommand, ThePapersSetUpNeedsNoPlant) {
  const fs::path html = folder_ / "paper.html";
  const ProcessResult result =
      run_tool({"evaluate", "--paper", "--methods", "geometric", "--levels", ".1", "--size", "16", "--json", json_, "--html", html});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"juniper", "13162", "16"}));
  const auto parsed = read_json(json_);
  ASSERT_EQ(parsed["plants"].size(), 3u);
  const std::array<std::pair<const char*, int>, 3> expected{{{"corylus", 38}, {"willow", 445}, {"juniper", 1316}}};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(parsed["plants"][i]["plant"], expected[i].first);
    EXPECT_EQ(parsed["plants"][i]["setup"], "paper");
    EXPECT_EQ(parsed["plants"][i]["methods"][0]["levels"][0]["leaves"], expected[i].second);
    EXPECT_TRUE(fs::exists(html.parent_path() / ("paper_" + std::string(expected[i].first) + ".html")));
  }
  EXPECT_FALSE(fs::exists(html));
}

TEST_F(EvaluateCommand, ThePapersSetUpOfAPlantHasItsTwoMethods) {
  const ProcessResult result = evaluate({"--paper", "--view-distance", "5", "--levels", ".2", "--size", "32", "--json", json_});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"mi", "geometric", "rmse_32"}));
  const auto parsed = read_json(json_);
  EXPECT_EQ(parsed["view_distance"], 5.0);
  ASSERT_EQ(parsed["methods"].size(), 2u);
  EXPECT_EQ(parsed["methods"][0]["name"], "mi");
  EXPECT_EQ(parsed["methods"][1]["name"], "geometric");
}

TEST_F(EvaluateCommand, LevelsOfAnotherToolAreMeasuredLikeOurs) {
  fs::create_directories(set_ / "good");
  fs::create_directories(set_ / "bad");
  // The source itself, and leaves of another plant.
  ASSERT_EQ(evaluate({"--write-source", set_ / "good" / "1.glb"}).exit_code, 0);
  fs::copy_file(plant_, set_ / "bad" / "1.glb");
  const Words measured{"--methods", "stochastic", "--levels-of", "mine=" + set_.string()};
  const ProcessResult result = evaluate(joined(measured, {"--levels", "1", "--json", json_}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto parsed = read_json(json_);
  ASSERT_EQ(parsed["methods"].size(), 2u);
  EXPECT_EQ(parsed["methods"][1]["name"], "mine");
  std::set<std::string> keys = {"stored"};  // with --reference meshes
  for (const auto& object : {parsed, parsed["methods"][1], parsed["methods"][1]["levels"][0]}) keys.merge(keys_of(object));
  std::set<std::string> told = column_spans(table_of_keys(), 0);
  told.merge(spans_of_row(table_of_keys(), "methods"));
  EXPECT_EQ(keys, told);
  const auto& level = parsed["methods"][1]["levels"][0];
  EXPECT_EQ(level["parameters"], "good") << "the best of its folders counts";
  EXPECT_EQ(level["triangles"], 2 * 386);
  EXPECT_LT(level["rmse_256"], 0.5);
  expect_one_line_error(evaluate(joined(measured, {"--levels", ".5"})), {"0.5.glb"});
}

TEST_F(EvaluateCommand, AnExportedCutIsLitAndSeenThroughAsItsFileSays) {
  const fs::path baked = bake_corylus(folder_), lit = set_ / "lit" / "0.2.glb", solid = set_ / "solid" / "0.2.glb";
  for (const fs::path& cut : {lit, solid}) {
    fs::create_directories(cut.parent_path());
    const Words options = cut == solid ? Words{"--solid"} : Words{};
    ASSERT_EQ(run_tool(joined({"export", baked, "--leaves", "77", "--part", "foliage", "-o", cut}, options)).exit_code, 0);
  }
  const ProcessResult result = evaluate({"--methods", "stochastic,geometric", "--levels", ".2", "--json", json_, "--levels-of",
                                         "mine=" + lit.parent_path().string(), "--levels-of", "solid=" + solid.parent_path().string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto methods = read_json(json_)["methods"];
  ASSERT_EQ(methods.size(), 4u);
  const auto &mine = methods[2]["levels"][0], &opaque = methods[3]["levels"][0];
  EXPECT_EQ(mine["triangles"], 2 * 77);
  EXPECT_NEAR(mine["coverage"].get<double>(), 1.0, 0.1);
  EXPECT_NEAR(mine["luminance"].get<double>(), 1.0, 0.05);
  EXPECT_NE(mine["coverage"], opaque["coverage"]);
  for (std::size_t other = 0; other < 2; ++other)
    for (const char* key : {"rmse_16_worst", "rmse_256_worst", "rmse_16_mean", "rmse_256_mean"})
      EXPECT_LT(mine[key], methods[other]["levels"][0][key]) << key << " of " << methods[other]["name"];
}

TEST_F(EvaluateCommand, LevelsThatAreTooLargeDoNotWin) {
  const fs::path baked = folder_ / "hazel.coppice", fits = set_ / "fits" / "0.5.glb", whole = set_ / "whole" / "0.5.glb";
  ASSERT_EQ(run_tool({"bake", plant_, "-o", baked, "--quick"}).exit_code, 0);
  for (const fs::path& level : {fits, whole}) {
    fs::create_directories(level.parent_path());
    ASSERT_EQ(evaluate({"--write-source", level}).exit_code, 0);
  }
  const Words measured{"--methods", "stochastic", "--levels", ".5", "--levels-of", "mine=" + set_.string(), "--json", json_};
  const ProcessResult large = evaluate(measured);
  ASSERT_EQ(large.exit_code, 0) << large.err;
  EXPECT_TRUE(mentions(large.err, {"mine", "772", "0.5", "386"}));
  // A level that fits is worse than the whole plant, and counts.
  fs::remove(fits);
  const fs::path cut = folder_ / "cut.glb";  // its leaves, without its wood
  ASSERT_EQ(run_tool({"export", baked, "--leaves", "100", "--solid", "-o", cut}).exit_code, 0);
  ASSERT_EQ(run_tool({"evaluate", cut, "--write-source", fits}).exit_code, 0);
  const ProcessResult small = evaluate(measured);
  ASSERT_EQ(small.exit_code, 0) << small.err;
  EXPECT_FALSE(mentions(small.err, {"mine"}));
  EXPECT_EQ(read_json(json_)["methods"][1]["levels"][0]["parameters"], "fits");
}

TEST_F(EvaluateCommand, IsThereOnlyWithTheLaboratory) {
  const fs::path alone = folder_ / "coppice";
  fs::copy(kTool, alone);
  expect_one_line_error(run_process(alone, {"evaluate", "--help"}, {.environment = {"PATH=/nowhere"}}),
                        {"coppice: evaluate", "coppice-lab", folder_.path().string(), "PATH", "coppice_tools"});
  const std::string own_folder = fs::path(kTool).parent_path();
  const ProcessResult found = run_process(alone, {"evaluate", "--help"}, {.environment = {"PATH=/nowhere:" + own_folder}});
  EXPECT_EQ(found.exit_code, 0) << found.err;
  EXPECT_NE(found.out.find("Usage: coppice evaluate [OPTIONS] [input]"), std::string::npos) << found.out;
}

}  // namespace coppice::test::evaluate_cli_test
