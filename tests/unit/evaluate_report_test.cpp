#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "evaluate.h"
#include "evaluation_render.h"
#include "gltf_write.h"
#include "leaf_cards.h"
#include "mentions.h"
#include "normal_sum.h"
#include "polygons.h"
#include "process.h"
#include "report.h"
#include "results.h"
#include "test_foliage.h"

namespace coppice::bake::evaluate_report_test {

using Json = nlohmann::json;
using Words = std::set<std::string>;

EvaluationReport evaluate_crown(const EvaluateOptions& options, std::uint32_t leaf_count = 60) {
  return test::must(evaluate_foliage("crown", {test::ball_crown(leaf_count, 2), test::plain_materials(), {}}, options, {}));
}

/// The first level of the first method.
LevelMeasures first_level(const EvaluationReport& report) {
  return report.methods.at(0).levels.at(0);
}

Json json_of(const EvaluationReport& report) {
  return Json::parse(evaluation_json(report));
}

Json first_level(const Json& report) {
  return report["methods"][0]["levels"][0];
}

Words keys(const Json& object) {
  Words names;
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
  EvaluateOptions options{.methods = {Method::mi, Method::geometric, Method::stochastic, Method::prune}, .fractions = {1.0}};
  for (const MethodMeasures& method : evaluate_crown(options).methods) {
    const LevelMeasures& level = method.levels.at(0);
    EXPECT_EQ(level.leaves, 60u);
    EXPECT_EQ(level.triangles, 120u);
    ASSERT_TRUE(level.lit);
    double error = level.rmse_full + level.rmse_sixteenth + level.lit->suns_full + level.lit->frames_full;
    for (const LevelMeasures::Lighting& lighting : level.lightings) {
      error += lighting.rmse_full + lighting.rmse_sixteenth;
      EXPECT_EQ(lighting.luminance, 1.0) << method.name;
    }
    EXPECT_EQ(error, 0.0) << method.name;
    EXPECT_EQ(level.coverage, 1.0) << method.name;
    EXPECT_EQ(level.soft_iou, 1.0) << method.name;
    EXPECT_NEAR(level.area_ratio, 1.0, 1e-12) << method.name;
    EXPECT_NEAR(level.hausdorff + level.mean_distance, 0.0, 1e-7) << method.name;
  }
}

TEST(Evaluate, ErrorsGrowAsLeavesGo) {
  EvaluateOptions options{.methods = {Method::stochastic}, .fractions = {0.9, 0.3, 0.05}};
  LevelMeasures above;
  for (const LevelMeasures& level : evaluate_crown(options, 200).methods.at(0).levels) {
    EXPECT_GT(level.rmse_full, above.rmse_full);
    EXPECT_GT(level.mean_distance, above.mean_distance);
    EXPECT_LT(level.rmse_quarter, level.rmse_full);
    EXPECT_LT(level.rmse_sixteenth, level.rmse_quarter);
    above = level;
  }
}

TEST(Evaluate, FiguresDoNotDependOnThreads) {
  EvaluateOptions options{.fractions = {0.5, 0.1}, .thread_count = 1};
  const std::string one = evaluation_json(evaluate_crown(options));
  options.thread_count = 2;
  EXPECT_EQ(evaluation_json(evaluate_crown(options)), one);
}

/// Black equilateral triangles, a leaf each, side by side and turned this way and that.
Plant triangle_plant() {
  Plant plant;
  plant.name = "trefoil";
  plant.materials = test::plain_materials();
  plant.materials[0].base_color = {0, 0, 0, 1};
  for (std::uint32_t leaf = 0; leaf < 4; ++leaf) {
    const float angle = 0.7f * static_cast<float>(leaf);
    const glm::vec3 corner(1.5f * static_cast<float>(leaf), 0, 0), along(std::cos(angle), 0, std::sin(angle));
    test::add_polygon(plant.foliage, std::array{corner, corner + along, corner + 0.5f * along + glm::vec3(0, std::sqrt(0.75f), 0)});
    plant.leaves.push_back({leaf, 1});
  }
  return plant;
}

/// Pixels that a mesh covers in the evaluation's pictures of `framed`.
double covered_pixels(const Mesh& mesh, const Mesh& framed, const Plant& plant) {
  double count = 0.0;
  for (const glm::dvec3& direction : evaluation_directions(kEvaluationCameraCount)) {
    const EvaluationCamera camera = evaluation_camera(direction, evaluation_sphere(framed));
    for (const std::uint8_t covered : render_evaluation(mesh, *surface_looks(plant.materials, plant.images), camera, 256).coverage)
      count += covered;
  }
  return count;
}

TEST(Evaluate, AgainstMeshesTheCardOfATriangleHasItsOutline) {
  const Plant plant = triangle_plant();
  EvaluateOptions options{.methods = {Method::geometric}, .fractions = {1.0}};
  const auto by_quads = test::must(evaluate_plant(plant, options, {}));
  EXPECT_EQ(first_level(by_quads).rmse_full, 0.0);
  EXPECT_EQ(by_quads.source_triangles, 8u);

  options.reference = ReferenceKind::meshes;
  const auto by_meshes = test::must(evaluate_plant(plant, options, {}));
  EXPECT_EQ(by_meshes.source_triangles, 4u);
  const LevelMeasures level = first_level(by_meshes);
  EXPECT_EQ(level.leaves, 4u);
  // A rectangle on a side of a triangle and as high as it has twice its area; half of that are holes.
  EXPECT_NEAR(level.area_ratio, 2.0, 1e-5);
  Plant carded = plant;
  const Mesh quads = foliage_mesh(*card_foliage(carded));
  const double on_meshes = covered_pixels(plant.foliage, plant.foliage, plant), on_quads = covered_pixels(quads, plant.foliage, carded);
  EXPECT_NEAR(level.coverage, on_quads / on_meshes, 1e-12);
  EXPECT_NEAR(level.coverage, 1.0, 0.02);
  // A rectangle without holes would be wrong in as many pixels as the triangle has.
  EXPECT_LT(level.rmse_full, 0.3 * 255.0 * std::sqrt(on_meshes / (24.0 * 256.0 * 256.0)));
}

TEST(Evaluate, ALeafThatIsAQuadHasNoErrorAgainstItsMeshTextureIncluded) {
  const Mesh mesh = foliage_mesh(
      test::plain_foliage({test::rectangle({0, 0, 0}, {2, 0, 0}, {0, 1, 0}), test::rectangle({0, 2, 1}, {0, 0, 2}, {1, 0, 0})}));
  Plant plant;
  plant.foliage = mesh;
  plant.leaves = {{0, 2}, {2, 2}};
  plant.materials = test::plain_materials();
  plant.materials[0].image = 0;
  plant.images = {Image{2, 1, {255, 255, 255, 255, 40, 80, 20, 255}}};
  EvaluateOptions options{.methods = {Method::geometric}, .fractions = {1.0, 0.5}};
  options.reference = ReferenceKind::meshes;
  const auto levels = test::must(evaluate_plant(plant, options, {})).methods[0].levels;
  EXPECT_EQ(levels[0].rmse_full, 0.0);
  EXPECT_NEAR(levels[0].hausdorff, 0.0, 1e-7);
  EXPECT_GT(levels[1].rmse_full, 10.0);
}

TEST(Evaluate, ErrorsOfFilteredPicturesOfTwoSizesAgree) {
  EvaluateOptions options{.methods = {Method::stochastic}, .fractions = {0.3}};
  const double at_256 = first_level(evaluate_crown(options)).rmse_quarter;
  options.size_px = 512;
  const EvaluationReport report = evaluate_crown(options);
  EXPECT_EQ(report.size_px, 512u);
  EXPECT_EQ(rmse_names(512), (std::array<std::string, 3>{"rmse_512", "rmse_128", "rmse_32"}));
  const LevelMeasures level = first_level(report);
  // Between the errors at 128 and at 32 px lies that at 64, which 256 px give.
  EXPECT_LT(at_256, level.rmse_quarter);
  EXPECT_GT(at_256, level.rmse_sixteenth);
  const Json json = first_level(json_of(report));
  EXPECT_EQ(json["rmse_512"], level.rmse_full);
  EXPECT_FALSE(json.contains("rmse_256"));
  EXPECT_NE(evaluation_table(report).find("rmse_128"), std::string::npos);
}

TEST(Evaluate, RefusesWhatCannotBeMeasured) {
  const auto refused = [](const Foliage& foliage, const EvaluateOptions& options) {
    const auto report = evaluate_foliage("plant", {foliage, test::plain_materials(), {}}, options, {});
    return !report && report.error().status == Status::invalid_argument;
  };
  const Foliage crown = test::ball_crown(5, 2);
  EXPECT_FALSE(refused(crown, {.methods = {Method::stochastic}}));
  EXPECT_TRUE(refused({}, {.methods = {Method::stochastic}}));
  EXPECT_TRUE(refused(test::plain_foliage({Quad{}}), {.methods = {Method::stochastic}}));
  for (const double fraction : {0.0, -0.5, 1.5, std::nan("")})
    EXPECT_TRUE(refused(crown, {.methods = {Method::stochastic}, .fractions = {fraction}})) << fraction;
  EXPECT_TRUE(refused(crown, {.methods = {Method::stochastic}, .fractions = {}}));
  EXPECT_TRUE(refused(crown, {.methods = {}}));
  EvaluateOptions options;
  options.reference = ReferenceKind::meshes;
  EXPECT_TRUE(refused(crown, options)) << "quads have no meshes";
  for (const std::uint32_t size_px : {0u, 100u, 8192u}) {
    options = {};
    options.size_px = size_px;
    EXPECT_TRUE(refused(crown, options)) << size_px;
  }
}

TEST(EvaluationReport, JsonHasTheKeysOfTheContract) {
  EvaluateOptions options{.methods = {Method::geometric, Method::meshopt_sloppy}, .fractions = {0.5, 0.1}};
  const Json json = json_of(evaluate_crown(options));
  EXPECT_EQ(keys(json), (Words{"plant", "source_leaves", "reference", "setup", "view_distance", "size_px", "methods"}));
  EXPECT_EQ(json["plant"], "crown");
  EXPECT_EQ(json["source_leaves"], 60);
  EXPECT_EQ(json["reference"], "quads");
  EXPECT_EQ(json["size_px"], 256);
  EXPECT_EQ(json["setup"], "ours");
  EXPECT_EQ(json["view_distance"], 3.0);
  ASSERT_EQ(json["methods"].size(), 2u);
  EXPECT_EQ(json["methods"][1]["name"], "meshopt_sloppy");
  for (const Json& method : json["methods"]) {
    EXPECT_EQ(keys(method), (Words{"name", "levels"}));
    ASSERT_EQ(method["levels"].size(), 2u);
    EXPECT_EQ(method["levels"][0]["leaves"], 30);
    EXPECT_EQ(method["levels"][1]["fraction"], 0.1);
    for (const Json& level : method["levels"])
      EXPECT_EQ(keys(level), (Words{"fraction",      "leaves",         "triangles",       "rmse_256",       "rmse_64",
                                    "rmse_16",       "coverage",       "area_ratio",      "hausdorff",      "mean_distance",
                                    "rmse_256_suns", "rmse_16_suns",   "rmse_256_frames", "rmse_16_frames", "rmse_256_mean",
                                    "rmse_16_mean",  "rmse_256_worst", "rmse_16_worst",   "luminance",      "lightings"}));
  }
}

TEST(Evaluate, MeasuresSunsAndFramesUnlessToldNotTo) {
  EvaluateOptions options{.methods = {Method::stochastic}, .fractions = {0.3}};
  const EvaluationReport with = evaluate_crown(options);
  options.suns_and_frames = false;
  const EvaluationReport without = evaluate_crown(options);
  const LevelMeasures lit = first_level(with), plain = first_level(without);
  EXPECT_EQ(lit.rmse_full, plain.rmse_full);
  EXPECT_FALSE(plain.lit);
  ASSERT_TRUE(lit.lit);
  EXPECT_GT(lit.lit->suns_full, lit.lit->suns_sixteenth);
  EXPECT_GT(lit.lit->suns_sixteenth, 0.0);
  EXPECT_LT(lit.lit->frames_full, lit.rmse_full) << "means are smoother";
  EXPECT_GT(lit.lit->frames_sixteenth, 0.0);
  EXPECT_TRUE(test::mentions(evaluation_table(with), {"frames"}));
  EXPECT_FALSE(test::mentions(evaluation_table(without), {"frames"}));
}

TEST(Evaluate, SixPairsOfLightAndGroundAreMeasured) {
  EvaluateOptions options{.methods = {Method::stochastic}, .fractions = {0.3}, .suns_and_frames = false};
  const EvaluationReport report = evaluate_crown(options);
  const LevelMeasures level = first_level(report);
  const Json json = first_level(json_of(report));
  ASSERT_EQ(json["lightings"].size(), 6u);
  std::set<std::pair<std::string, double>> pairs;
  double largest = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < 6; ++i) {
    const Json& lighting = json["lightings"][i];
    EXPECT_EQ(keys(lighting), (Words{"light", "ground", "rmse_256", "rmse_16", "luminance"}));
    pairs.emplace(lighting["light"].get<std::string>(), lighting["ground"].get<double>());
    EXPECT_EQ(lighting["rmse_16"], level.lightings[i].rmse_sixteenth);
    EXPECT_GT(level.lightings[i].rmse_full, level.lightings[i].rmse_sixteenth);
    EXPECT_GT(level.lightings[i].rmse_sixteenth, 0.0);
    largest = std::max(largest, level.lightings[i].rmse_full);
    sum += level.lightings[i].rmse_full;
  }
  EXPECT_EQ(pairs.size(), 6u);
  EXPECT_TRUE(pairs.contains({"one-sided", 0.0}) && pairs.contains({"shining through", 0.3}) && pairs.contains({"shining through", 1.0}));
  EXPECT_EQ(json["rmse_256_worst"], largest);
  EXPECT_NEAR(json["rmse_256_mean"].get<double>(), sum / 6.0, 1e-9);
  EXPECT_LT(level.lightings[1].rmse_full, level.lightings[2].rmse_full) << "an outline before white is more than one before grey";
  EXPECT_TRUE(test::mentions(evaluation_table(report), {"worst", "mean", "luminance"}));
}

/// Leaves in the plane z = 0, all facing +Z, whose normals lie as they are told to.
Foliage wall(std::uint16_t normals) {
  std::vector<Quad> quads;
  for (int x = 0; x < 6; ++x)
    for (int y = 0; y < 6; ++y) quads.push_back(test::rectangle({x, y, 0}, {1, 0, 0}, {0, 1, 0}));
  Foliage foliage = test::plain_foliage(std::move(quads));
  if (normals != kFlatNormals) foliage.normals.assign(36, normals);
  return foliage;
}

TEST(Evaluate, AnArtistsNormalsAreTheReferencesAndStayThoseOfKeptLeaves) {
  EvaluateOptions options{.methods = {Method::stochastic}, .fractions = {1.0, 0.9}, .suns_and_frames = false};
  const std::uint16_t up = node_normals(normal_sum({0, 1, 0}, 1.0, true));
  const auto measured = [&](const Foliage& foliage) {
    return test::must(evaluate_foliage("wall", {foliage, test::plain_materials(), {}}, options, {})).methods.at(0).levels;
  };
  const auto flat = measured(wall(kFlatNormals)), sided = measured(wall(up));
  for (const auto& levels : {flat, sided}) EXPECT_EQ(worst_lighting(levels[0]).rmse_full, 0.0) << "the reference itself";
  // The wall faces the horizon, its normals the sky: sun shows more of it. Leaves that are kept and grow keep them.
  EXPECT_NEAR(sided[1].lightings[0].luminance, 1.0, 1e-5);
  EXPECT_NE(sided[1].rmse_full, flat[1].rmse_full);
}

/// Measures a file of the leaves as a level of the wall.
LevelMeasures as_level_of_wall(const Foliage& foliage) {
  const test::TemporaryFolder folder;
  const Mesh mesh = foliage_mesh(foliage);
  EXPECT_TRUE(write_glb(folder / "1.glb", {{"leaves", &mesh}}, test::plain_materials(), {}));
  EvaluateOptions options{.methods = {}, .level_sets = {{"mine", folder.path()}}, .fractions = {1.0}, .suns_and_frames = false};
  return first_level(test::must(evaluate_foliage("wall", {wall(kFlatNormals), test::plain_materials(), {}}, options, {})));
}

TEST(Evaluate, AFilesSpreadAndOpacityCount) {
  EXPECT_LT(as_level_of_wall(wall(kFlatNormals)).rmse_full, 1e-3);
  const LevelMeasures up = as_level_of_wall(wall(node_normals(normal_sum({0, 1, 0}, 1.0, true))));
  EXPECT_GT(up.rmse_full, 5.0);
  EXPECT_GT(up.lightings[0].luminance, 1.2) << "half of the cameras see the dark side of a wall, but no dark side of the sky";
  EXPECT_EQ(up.coverage, 1.0);
  Foliage spread = wall(node_normals(normal_sum({0, 1, 0}, 1.0) + normal_sum({1, 0, 0}, 1.0) + normal_sum({0, 0, 1}, 1.0)));
  EXPECT_GT(as_level_of_wall(spread).rmse_full, 1.0);
  spread.opacities.assign(36, 8);
  EXPECT_NEAR(as_level_of_wall(spread).coverage, 0.5, 0.02);
}

TEST(Evaluate, OfASweepTheBestCounts) {
  EvaluateOptions options{.methods = {Method::fsa}, .fractions = {0.5}, .suns_and_frames = false};
  const EvaluationReport report = evaluate_crown(options);
  const std::string parameters = first_level(report).parameters;
  EXPECT_FALSE(parameters.empty());
  EXPECT_EQ(first_level(json_of(report))["parameters"], parameters);
  EXPECT_NE(evaluation_table(report).find(parameters), std::string::npos);
}

TEST(Evaluate, FartherCamerasSeeTheCrownFromFarther) {
  EvaluateOptions options{.methods = {Method::stochastic}, .fractions = {0.3}, .suns_and_frames = false};
  const double near = first_level(evaluate_crown(options)).rmse_full;
  options.view_distance_radii = 30.0;
  EXPECT_NE(first_level(evaluate_crown(options)).rmse_full, near);
  const Foliage foliage = test::ball_crown(5, 2);
  for (const double distance : {1.0, 0.0, 1e9, std::nan("")}) {
    options.view_distance_radii = distance;
    EXPECT_FALSE(evaluate_foliage("crown", {foliage, test::plain_materials(), {}}, options, {})) << distance;
  }
}

TEST(Evaluate, ThePapersQuadsAreOpaqueRectangles) {
  Plant plant = triangle_plant();
  plant.materials[0].base_color = {1, 1, 1, 0.9f};
  plant.materials[0].alpha_cutoff = 0.5f;
  plant.materials[0].image = 0;
  plant.images = {Image{2, 1, {255, 255, 255, 255, 0, 0, 0, 0}}};
  const auto foliage = test::must(source_foliage(plant, Setup::paper));
  EXPECT_EQ(foliage.leaf_count(), 4u);
  EXPECT_EQ(plant.materials.size(), 1u) << "no cards";
  EXPECT_EQ(plant.materials[0].image, kNone);
  EXPECT_EQ(plant.materials[0].alpha_cutoff, 0.0f);
  EXPECT_EQ(plant.materials[0].base_color, glm::vec4(1.0f)) << "the mean of what is no hole";

  EvaluateOptions options{.methods = {Method::mi, Method::geometric}, .fractions = {1.0, 0.5}};
  options.setup = Setup::paper;
  const auto report = test::must(evaluate_plant(triangle_plant(), options, {}));
  EXPECT_EQ(first_level(report).rmse_full, 0.0);
  EXPECT_TRUE(test::mentions(paper_claim(report), {"mi", "rmse_256", "geometric", "2"}));
  EXPECT_EQ(json_of(report)["setup"], "paper");
  const Json both = Json::parse(evaluations_json({report, report}));
  EXPECT_EQ(both["plants"].size(), 2u);
  EXPECT_EQ(both["plants"][1]["plant"], "trefoil");
}

TEST(EvaluationReport, CountsWhereThePapersClaimHolds) {
  EvaluationReport report;
  report.setup = Setup::paper;
  LevelMeasures low, high;
  low.rmse_full = 10;
  high.rmse_full = 20;
  report.methods = {{"mi", 1.0, {low, high, low}}, {"geometric", 1.0, {high, low, low}}};
  EXPECT_TRUE(test::mentions(paper_claim(report), {"mi", "rmse_256", "geometric", "1", "3"}));
  report.setup = Setup::ours;
  EXPECT_EQ(paper_claim(report), "");
  report.setup = Setup::paper;
  report.methods.pop_back();
  EXPECT_EQ(paper_claim(report), "");
}

TEST(EvaluationReport, TableMarksTheLeastErrorAndJsonHasNullForNoNumber) {
  EvaluationReport report;
  report.plant = "two methods";
  report.source_leaves = 10;
  LevelMeasures good, bad;
  good.fraction = bad.fraction = 0.5;
  good.rmse_full = 12.5;
  bad.rmse_full = 40.25;
  bad.hausdorff = std::numeric_limits<double>::infinity();
  report.methods = {{"mi", 1.0, {good}}, {"meshopt", 2.0, {bad}}};
  const std::string table = evaluation_table(report);
  EXPECT_TRUE(test::mentions(table, {"two methods", "10"}));
  EXPECT_NE(table.find("12.50*"), std::string::npos) << table;
  EXPECT_NE(table.find("40.25 "), std::string::npos) << table;
  EXPECT_TRUE(json_of(report)["methods"][1]["levels"][0]["hausdorff"].is_null());
}

}  // namespace coppice::bake::evaluate_report_test
