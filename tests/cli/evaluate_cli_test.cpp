// coppice evaluate from outside.

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "documents.h"
#include "mentions.h"
#include "places.h"
#include "process.h"

namespace evaluate_cli_test {

namespace fs = std::filesystem;
using coppice::test::mentions;
using coppice::test::ProcessResult;
using coppice::test::run_process;
using coppice::test::TemporaryFolder;

coppice::test::Table table_of_keys() {
  return coppice::test::table_after(coppice::test::source_text("bake/lab/README.md"), "`--write-source Q.glb`");
}

TEST(EvaluateCommand, WritesATableAndAFile) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", json = folder / "hazel.json";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  const ProcessResult result =
      run_process(coppice::test::kTool, {"evaluate", plant, "--methods", "geometric,stochastic", "--levels", ".2,.05", "--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_TRUE(mentions(result.out, {"hazel", "386", "0.200", "77", "0.050", "19", "geometric", "stochastic", "rmse_16"}));
  EXPECT_EQ(result.out.find("meshopt"), std::string::npos) << result.out;
  const auto parsed = nlohmann::json::parse(std::ifstream(json));
  EXPECT_EQ(parsed["methods"].size(), 2u);
  EXPECT_EQ(parsed["methods"][0]["levels"][0]["leaves"], 77);
}

TEST(EvaluateCommand, ComparesWithTheMeshesAtAnySize) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", json = folder / "hazel.json", html = folder / "hazel.html";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  const ProcessResult result = run_process(coppice::test::kTool, {"evaluate", plant, "--methods", "stochastic", "--levels", "1,.2",
                                                                  "--reference", "meshes", "--size", "64", "--json", json, "--html", html});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"64", "1.000", "386", "rmse_64", "rmse_4", ".coppice"}));
  const auto parsed = nlohmann::json::parse(std::ifstream(json));
  EXPECT_EQ(parsed["reference"], "meshes");
  EXPECT_EQ(parsed["size_px"], 64);
  const coppice::test::Table table = table_of_keys();
  for (const auto& [key, value] : parsed.items()) EXPECT_TRUE(coppice::test::column_spans(table, 0).contains(key)) << key;
  const auto& levels = parsed["methods"][0]["levels"];
  EXPECT_GT(levels[0]["rmse_64"], 0.0) << "quads are not the leaves that they stand for";
  EXPECT_LT(levels[0]["rmse_64"], levels[1]["rmse_64"]);
  EXPECT_EQ(parsed["stored"]["leaf_meshes"], true);
  EXPECT_LT(parsed["stored"]["rmse_64"], 0.2 * levels[0]["rmse_64"].get<double>()) << "a file holds the leaves as they were modelled";
  std::ifstream file(html, std::ios::binary);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(page.find("\"reference\":\"meshes\""), std::string::npos);
}

TEST(EvaluateCommand, ErrorsAreOneLineAndUsageExitsWith2) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", json = folder / "hazel.json";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  for (const auto& [option, value] : {std::pair{"--methods", "beauty"},
                                      {"--levels", "1.5"},
                                      {"--levels", "few"},
                                      {"--levels", "0"},
                                      {"--reference", "wood"},
                                      {"--size", "100"},
                                      {"--size", "0"},
                                      {"--size", "wide"}})
    EXPECT_EQ(run_process(coppice::test::kTool, {"evaluate", plant, option, value, "--json", json}).exit_code, 2) << option << " " << value;
  const ProcessResult missing = run_process(coppice::test::kTool, {"evaluate", folder / "nowhere.glb", "--json", json});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_TRUE(mentions(missing.err, {"nowhere.glb"}));
  const ProcessResult no_leaves = run_process(coppice::test::kTool, {"evaluate", plant, "--leaf-material", "^petals$", "--json", json});
  EXPECT_EQ(no_leaves.exit_code, 1);
  EXPECT_TRUE(mentions(no_leaves.err, {"--leaf-material", "'wood'"}));
  EXPECT_FALSE(fs::exists(json));
  const auto plant_bytes = fs::file_size(plant);
  EXPECT_EQ(run_process(coppice::test::kTool, {"evaluate", plant, "--methods", "stochastic", "--json", plant}).exit_code, 1);
  EXPECT_EQ(fs::file_size(plant), plant_bytes) << "the input was overwritten";
  const ProcessResult nowhere =
      run_process(coppice::test::kTool, {"evaluate", plant, "--methods", "stochastic", "--json", "/proc/no/such.json"});
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_EQ(nowhere.out, "") << "it measured before it looked whether it can write";
}

TEST(EvaluateCommand, WritesAReportThatIsOneFile) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", html = folder / "hazel.html";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  const ProcessResult result =
      run_process(coppice::test::kTool, {"evaluate", plant, "--methods", "stochastic", "--levels", ".1", "--html", html});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::ifstream file(html, std::ios::binary);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(page.find("<!doctype html>"), 0u);
  EXPECT_NE(page.find("data:image/png;base64,iVBOR"), std::string::npos) << "no pictures";
  for (const std::string load : {" src=", "href=", "@import"}) EXPECT_EQ(page.find(load), std::string::npos) << load;
}

TEST(EvaluateCommand, AHostilePlantNameStaysText) {
  const TemporaryFolder folder;
  // The slash of "</script>" parts folders: the name itself is "script><img src=x onerror=alert(1)>".
  fs::create_directory(folder / "<");
  const fs::path plant = folder / "</script><img src=x onerror=alert(1)>.glb", html = folder / "report.html";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  const ProcessResult result =
      run_process(coppice::test::kTool, {"evaluate", plant, "--methods", "stochastic", "--levels", ".1", "--html", html});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::ifstream file(html, std::ios::binary);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(page.find("<img"), std::string::npos);
  EXPECT_NE(page.find("\\u003cimg"), std::string::npos);
}

TEST(EvaluateCommand, RefusesAReportOverOneOfItsFiles) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", both = folder / "hazel.out";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  const auto plant_bytes = fs::file_size(plant);
  for (const auto& [json, html] :
       {std::pair{folder / "hazel.json", plant}, {both, both}, {folder / "hazel.json", fs::path("/proc/no/such.html")}}) {
    const ProcessResult result =
        run_process(coppice::test::kTool, {"evaluate", plant, "--methods", "stochastic", "--json", json, "--html", html});
    EXPECT_EQ(result.exit_code, 1) << html;
    EXPECT_EQ(result.out, "") << "it measured before it looked whether it can write";
    EXPECT_FALSE(fs::exists(json)) << json;
  }
  EXPECT_EQ(fs::file_size(plant), plant_bytes);
}

TEST(EvaluateCommand, ThePapersSetUpNeedsNoPlant) {
  const TemporaryFolder folder;
  const fs::path json = folder / "paper.json", html = folder / "paper.html";
  const ProcessResult result = run_process(coppice::test::kTool, {"evaluate", "--paper", "--methods", "geometric", "--levels", ".1",
                                                                  "--size", "16", "--json", json, "--html", html});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"juniper", "13162", "16"}));
  const auto parsed = nlohmann::json::parse(std::ifstream(json));
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

TEST(EvaluateCommand, ThePapersSetUpOfAPlantHasItsTwoMethods) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", json = folder / "hazel.json";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  const ProcessResult result = run_process(
      coppice::test::kTool, {"evaluate", plant, "--paper", "--view-distance", "5", "--levels", ".2", "--size", "32", "--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"mi", "geometric", "rmse_32"}));
  const auto parsed = nlohmann::json::parse(std::ifstream(json));
  EXPECT_EQ(parsed["view_distance"], 5.0);
  ASSERT_EQ(parsed["methods"].size(), 2u);
  EXPECT_EQ(parsed["methods"][0]["name"], "mi");
  EXPECT_EQ(parsed["methods"][1]["name"], "geometric");
}

TEST(EvaluateCommand, LevelsOfAnotherToolAreMeasuredLikeOurs) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", json = folder / "hazel.json", set = folder / "set";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  fs::create_directories(set / "good");
  fs::create_directories(set / "bad");
  // The source itself, and leaves of another plant.
  ASSERT_EQ(run_process(coppice::test::kTool, {"evaluate", plant, "--write-source", set / "good" / "1.glb"}).exit_code, 0);
  fs::copy_file(plant, set / "bad" / "1.glb");
  const ProcessResult result = run_process(coppice::test::kTool, {"evaluate", plant, "--methods", "stochastic", "--levels", "1",
                                                                  "--levels-of", "mine=" + set.string(), "--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto parsed = nlohmann::json::parse(std::ifstream(json));
  ASSERT_EQ(parsed["methods"].size(), 2u);
  EXPECT_EQ(parsed["methods"][1]["name"], "mine");
  std::set<std::string> keys = {"stored"};  // with --reference meshes
  for (const auto& object : {parsed, parsed["methods"][1], parsed["methods"][1]["levels"][0]})
    for (const auto& [key, value] : object.items()) keys.insert(key);
  std::set<std::string> told = coppice::test::column_spans(table_of_keys(), 0);
  told.merge(coppice::test::spans_of_row(table_of_keys(), "methods"));
  EXPECT_EQ(keys, told);
  const auto& level = parsed["methods"][1]["levels"][0];
  EXPECT_EQ(level["parameters"], "good") << "the best of its folders counts";
  EXPECT_EQ(level["triangles"], 2 * 386);
  EXPECT_LT(level["rmse_256"], 0.5);
  const ProcessResult missing = run_process(
      coppice::test::kTool, {"evaluate", plant, "--methods", "stochastic", "--levels", ".5", "--levels-of", "mine=" + set.string()});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_TRUE(mentions(missing.err, {"0.5.glb"}));
}

TEST(EvaluateCommand, LevelsThatAreTooLargeDoNotWin) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", json = folder / "hazel.json", set = folder / "set";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  const fs::path baked = folder / "hazel.coppice";
  ASSERT_EQ(run_process(coppice::test::kTool, {"bake", plant, "-o", baked, "--quick"}).exit_code, 0);
  fs::create_directories(set / "fits");
  fs::create_directories(set / "whole");
  ASSERT_EQ(run_process(coppice::test::kTool, {"evaluate", plant, "--write-source", set / "whole" / "0.5.glb"}).exit_code, 0);
  fs::copy_file(set / "whole" / "0.5.glb", set / "fits" / "0.5.glb");
  const std::vector<std::string> command = {
      "evaluate", plant, "--methods", "stochastic", "--levels", ".5", "--levels-of", "mine=" + set.string(), "--json", json};
  const ProcessResult large = run_process(coppice::test::kTool, command);
  ASSERT_EQ(large.exit_code, 0) << large.err;
  EXPECT_TRUE(mentions(large.err, {"mine", "772", "0.5", "386"}));
  // A level that fits is worse than the whole plant, and counts.
  fs::remove(set / "fits" / "0.5.glb");
  const fs::path cut = folder / "cut.glb";  // its leaves, without its wood
  ASSERT_EQ(run_process(coppice::test::kTool, {"export", baked, "--leaves", "100", "--solid", "-o", cut}).exit_code, 0);
  ASSERT_EQ(run_process(coppice::test::kTool, {"evaluate", cut, "--write-source", set / "fits" / "0.5.glb"}).exit_code, 0);
  const ProcessResult fits = run_process(coppice::test::kTool, command);
  ASSERT_EQ(fits.exit_code, 0) << fits.err;
  EXPECT_FALSE(mentions(fits.err, {"mine"}));
  const auto level = nlohmann::json::parse(std::ifstream(json))["methods"][1]["levels"][0];
  EXPECT_EQ(level["parameters"], "fits");
}

TEST(EvaluateCommand, IsThereOnlyWithTheLaboratory) {
  const TemporaryFolder folder;
  fs::copy(coppice::test::kTool, folder / "coppice");
  const ProcessResult missing = run_process(folder / "coppice", {"evaluate", "--help"}, {.environment = {"PATH=/nowhere"}});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_EQ(missing.out, "");
  EXPECT_TRUE(mentions(missing.err, {"coppice: evaluate", "coppice-lab", folder.path().string(), "PATH", "coppice_tools"}));
  EXPECT_EQ(std::ranges::count(missing.err, '\n'), 1) << missing.err;
  const std::string own_folder = fs::path(coppice::test::kTool).parent_path();
  const ProcessResult found = run_process(folder / "coppice", {"evaluate", "--help"}, {.environment = {"PATH=/nowhere:" + own_folder}});
  EXPECT_EQ(found.exit_code, 0) << found.err;
  EXPECT_NE(found.out.find("Usage: coppice evaluate [OPTIONS] [input]"), std::string::npos) << found.out;
}

TEST(EvaluateCommand, RefusesSetsAndSetUpsThatMeanNothing) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb";
  ASSERT_EQ(run_process(coppice::test::kTool, {"plant", "corylus", "-o", plant}).exit_code, 0);
  for (const std::string set : {"nowhere", "=x", "mine=", "default=x", "mine=/no/such/folder"}) {
    const ProcessResult result = run_process(coppice::test::kTool, {"evaluate", plant, "--methods", "stochastic", "--levels-of", set});
    EXPECT_EQ(result.exit_code, 1) << set;
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
  }
  EXPECT_EQ(run_process(coppice::test::kTool, {"evaluate"}).exit_code, 2);
  EXPECT_EQ(run_process(coppice::test::kTool, {"evaluate", "--paper", "--write-source", folder / "q.glb"}).exit_code, 2);
  EXPECT_EQ(run_process(coppice::test::kTool, {"evaluate", plant, "--paper", "--reference", "meshes"}).exit_code, 2);
  EXPECT_EQ(run_process(coppice::test::kTool, {"evaluate", plant, "--view-distance", "1"}).exit_code, 2);
}

}  // namespace evaluate_cli_test
