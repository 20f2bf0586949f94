#include <cmath>
#include <limits>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "evaluate.h"
#include "report.h"
#include "test_foliage.h"

namespace coppice::bake {
namespace {

EvaluationReport evaluate_crown(const EvaluateOptions& options, std::uint32_t leaf_count = 60) {
  auto report = evaluate_foliage("crown", test::ball_crown(leaf_count, 2), test::plain_materials(), {}, options, {});
  EXPECT_TRUE(report) << report.error().message();
  return *report;
}

std::set<std::string> keys(const nlohmann::json& object) {
  std::set<std::string> names;
  for (const auto& item : object.items()) names.insert(item.key());
  return names;
}

TEST(Evaluate, LevelsAreThoseOfThePaper) {
  std::vector<std::uint32_t> counts;
  for (const double fraction : kEvaluationFractions) counts.push_back(level_leaves(386, fraction));
  EXPECT_EQ(counts, (std::vector<std::uint32_t>{308, 231, 154, 77, 38, 19, 9}));
  EXPECT_EQ(level_leaves(13162, 0.025), 329u);
  EXPECT_EQ(level_leaves(100, 0.29), 29u) << "0.29 * 100 is a little less than 29";
  EXPECT_EQ(level_leaves(3, 0.025), 1u);
}

TEST(Evaluate, TheWholePlantHasNoError) {
  EvaluateOptions options;
  options.methods = {Method::mi, Method::geometric, Method::stochastic, Method::prune};
  options.fractions = {1.0};
  for (const MethodMeasures& method : evaluate_crown(options).methods) {
    const LevelMeasures& level = method.levels.at(0);
    EXPECT_EQ(level.leaves, 60u);
    EXPECT_EQ(level.triangles, 120u);
    EXPECT_EQ(level.rmse_256, 0.0) << method_name(method.method);
    EXPECT_EQ(level.rmse_16, 0.0) << method_name(method.method);
    EXPECT_EQ(level.coverage, 1.0) << method_name(method.method);
    EXPECT_EQ(level.soft_iou, 1.0) << method_name(method.method);
    EXPECT_NEAR(level.area_ratio, 1.0, 1e-12) << method_name(method.method);
    EXPECT_NEAR(level.hausdorff, 0.0, 1e-7) << method_name(method.method);
    EXPECT_NEAR(level.mean_distance, 0.0, 1e-7) << method_name(method.method);
  }
}

TEST(Evaluate, ErrorsGrowAsLeavesGo) {
  EvaluateOptions options;
  options.methods = {Method::stochastic};
  options.fractions = {0.9, 0.3, 0.05};
  const EvaluationReport report = evaluate_crown(options, 200);
  const std::vector<LevelMeasures>& levels = report.methods.at(0).levels;
  for (std::size_t i = 0; i < 3; ++i) {
    const double above = i == 0 ? 0.0 : levels[i - 1].rmse_256, mean_above = i == 0 ? 0.0 : levels[i - 1].mean_distance;
    EXPECT_GT(levels[i].rmse_256, above);
    EXPECT_GT(levels[i].mean_distance, mean_above);
    EXPECT_LT(levels[i].rmse_64, levels[i].rmse_256);
    EXPECT_LT(levels[i].rmse_16, levels[i].rmse_64);
  }
}

TEST(Evaluate, FiguresDoNotDependOnThreads) {
  EvaluateOptions options;
  options.fractions = {0.5, 0.1};
  options.thread_count = 1;
  const std::string one = evaluation_json(evaluate_crown(options));
  options.thread_count = 2;
  EXPECT_EQ(evaluation_json(evaluate_crown(options)), one);
}

TEST(Evaluate, RefusesWhatCannotBeMeasured) {
  const auto refused = [](const Foliage& foliage, const EvaluateOptions& options) {
    const auto report = evaluate_foliage("plant", foliage, test::plain_materials(), {}, options, {});
    return !report && report.error().status == Status::invalid_argument;
  };
  const Foliage crown = test::ball_crown(5, 2);
  EvaluateOptions options;
  options.methods = {Method::stochastic};
  EXPECT_FALSE(refused(crown, options));
  EXPECT_TRUE(refused({}, options));
  EXPECT_TRUE(refused(test::plain_foliage({Quad{}}), options));
  for (const double fraction : {0.0, -0.5, 1.5, std::nan("")}) {
    options.fractions = {fraction};
    EXPECT_TRUE(refused(crown, options)) << fraction;
  }
  options.fractions = {};
  EXPECT_TRUE(refused(crown, options));
  options = {};
  options.methods = {};
  EXPECT_TRUE(refused(crown, options));
}

TEST(EvaluationReport, JsonHasTheKeysOfTheContract) {
  EvaluateOptions options;
  options.methods = {Method::geometric, Method::meshopt_sloppy};
  options.fractions = {0.5, 0.1};
  const auto json = nlohmann::json::parse(evaluation_json(evaluate_crown(options)));
  EXPECT_EQ(keys(json), (std::set<std::string>{"plant", "source_leaves", "methods"}));
  EXPECT_EQ(json["plant"], "crown");
  EXPECT_EQ(json["source_leaves"], 60);
  ASSERT_EQ(json["methods"].size(), 2u);
  EXPECT_EQ(json["methods"][1]["name"], "meshopt_sloppy");
  for (const auto& method : json["methods"]) {
    EXPECT_EQ(keys(method), (std::set<std::string>{"name", "levels"}));
    ASSERT_EQ(method["levels"].size(), 2u);
    for (const auto& level : method["levels"])
      EXPECT_EQ(keys(level), (std::set<std::string>{"fraction", "leaves", "triangles", "rmse_256", "rmse_64", "rmse_16", "coverage",
                                                    "area_ratio", "hausdorff", "mean_distance"}));
    EXPECT_EQ(method["levels"][0]["leaves"], 30);
    EXPECT_EQ(method["levels"][1]["fraction"], 0.1);
  }
}

TEST(EvaluationReport, TableMarksTheLeastErrorAndJsonHasNullForNoNumber) {
  EvaluationReport report;
  report.plant = "two methods";
  report.source_leaves = 10;
  LevelMeasures good, bad;
  good.fraction = bad.fraction = 0.5;
  good.rmse_256 = 12.5;
  bad.rmse_256 = 40.25;
  bad.hausdorff = std::numeric_limits<double>::infinity();
  report.methods = {{Method::mi, 1.0, {good}}, {Method::meshopt, 2.0, {bad}}};
  const std::string table = evaluation_table(report);
  EXPECT_NE(table.find("two methods: 10 leaves"), std::string::npos) << table;
  EXPECT_NE(table.find("12.50*"), std::string::npos) << table;
  EXPECT_NE(table.find("40.25 "), std::string::npos) << table;
  EXPECT_TRUE(nlohmann::json::parse(evaluation_json(report))["methods"][1]["levels"][0]["hausdorff"].is_null());
}

}  // namespace
}  // namespace coppice::bake
