// The default metric on real plants, held against the committed table tests/quality/PLANT.csv: one row per method and level, the figures of
// `coppice evaluate`. A plant may get better; a figure of `default` that gets worse than its row by more than the tolerance below fails.
// COPPICE_UPDATE_QUALITY=1 writes the rows of `default` anew, =all measures every method (an hour); look at the difference before you
// commit it. Pictures are single frames, in which a leaf of opacity o shows in o of its pixels; the last two columns are of the mean of 16.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "evaluate.h"
#include "generate_plant.h"
#include "leaf_cards.h"
#include "places.h"
#include "plants_folder.h"

namespace coppice::bake {
namespace quality_test {

// Another libm or compiler rounds differently and a greedy search may then take another way: seen to move a figure by up to 2 %.
constexpr double kRelativeTolerance = 0.04;
constexpr double kRmseTolerance = 0.05;       ///< where white is 255
constexpr double kCoverageTolerance = 0.015;  ///< how much the distance to 1 may grow
constexpr double kHausdorffTolerance = 0.15;  ///< relative; a single leaf decides it

struct QualityPlant {
  const char* name;
  const char* file;  ///< third-party; nullptr: `coppice plant NAME`
};

void PrintTo(const QualityPlant& each, std::ostream* out) {
  *out << each.name;
}

std::string test_name(const testing::TestParamInfo<QualityPlant>& info) {
  return info.param.name;
}

std::filesystem::path table_path(const std::string& plant) {
  return std::filesystem::path(test::kTestFolder) / "quality" / (plant + ".csv");
}

constexpr const char* kHeader =
    "method,fraction,leaves,triangles,rmse_256,rmse_64,rmse_16,coverage,area_ratio,hausdorff,mean_distance,"
    "frames_256,frames_16";

/// The rows of methods that the report does not have, as they are.
std::vector<std::string> other_rows(const EvaluationReport& report) {
  std::vector<std::string> rows;
  std::ifstream file(table_path(report.plant));
  std::string line;
  std::getline(file, line);  // the header
  const auto is_in_report = [&](const MethodMeasures& method) { return line.starts_with(method.name + ","); };
  while (std::getline(file, line))
    if (std::ranges::none_of(report.methods, is_in_report)) rows.push_back(line);
  return rows;
}

void write_table(const EvaluationReport& report) {
  const std::vector<std::string> others = other_rows(report);
  std::ofstream file(table_path(report.plant));
  file << kHeader << "\n";
  for (const MethodMeasures& method : report.methods)
    for (const LevelMeasures& l : method.levels) {
      std::array<char, 256> line;
      const int length =
          std::snprintf(line.data(), line.size(), "%s,%g,%u,%u,%.3f,%.3f,%.3f,%.4f,%.4f,%.5f,%.5f,%.3f,%.3f\n", method.name.c_str(),
                        l.fraction, l.leaves, l.triangles, l.rmse_full, l.rmse_quarter, l.rmse_sixteenth, l.coverage, l.area_ratio,
                        l.hausdorff, l.mean_distance, l.lit->frames_full, l.lit->frames_sixteenth);
      file.write(line.data(), length);
    }
  for (const std::string& row : others) file << row << "\n";
}

/// The rows of the default metric. LevelMeasures as far as the table has them.
std::vector<LevelMeasures> read_default_rows(const std::string& plant) {
  std::ifstream file(table_path(plant));
  std::vector<LevelMeasures> rows;
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, kHeader) << table_path(plant);
  while (std::getline(file, line)) {
    if (!line.starts_with("default,")) continue;
    std::istringstream cells(line.substr(8));
    LevelMeasures row;
    LevelMeasures::Lit lit;
    char comma = 0;
    cells >> row.fraction >> comma >> row.leaves >> comma >> row.triangles >> comma >> row.rmse_full >> comma >> row.rmse_quarter >>
        comma >> row.rmse_sixteenth >> comma >> row.coverage >> comma >> row.area_ratio >> comma >> row.hausdorff >> comma >>
        row.mean_distance >> comma >> lit.frames_full >> comma >> lit.frames_sixteenth;
    row.lit = lit;
    EXPECT_FALSE(cells.fail()) << line;
    rows.push_back(row);
  }
  return rows;
}

Result<Plant> load(const QualityPlant& plant) {
  if (plant.file == nullptr) return generate_plant(plant.name, 1);
  return import_gltf(test::plants_folder() / plant.file, {});
}

class Quality : public testing::TestWithParam<QualityPlant> {};

TEST_P(Quality, DefaultIsAsGoodAsItsTable) {
  if (GetParam().file != nullptr) {
    COPPICE_PLANT_OR_SKIP(path, GetParam().file);
  }
  auto plant = load(GetParam());
  ASSERT_TRUE(plant) << plant.error().message();
  const auto foliage = card_foliage(*plant);
  ASSERT_TRUE(foliage) << foliage.error().message();
  const char* update = std::getenv("COPPICE_UPDATE_QUALITY");
  EvaluateOptions options;
  if (update == nullptr || std::string(update) != "all") options.methods = {Method::default_metric};
  const auto report = evaluate_foliage(GetParam().name, {*foliage, plant->materials, plant->images}, options, {});
  ASSERT_TRUE(report) << report.error().message();
  if (update != nullptr) write_table(*report);

  const std::vector<LevelMeasures> rows = read_default_rows(GetParam().name);
  const std::vector<LevelMeasures>& levels = report->methods.front().levels;
  ASSERT_EQ(rows.size(), levels.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    SCOPED_TRACE("level " + std::to_string(rows[i].fraction));
    EXPECT_EQ(levels[i].leaves, rows[i].leaves);
    EXPECT_LE(levels[i].rmse_full, rows[i].rmse_full * (1 + kRelativeTolerance) + kRmseTolerance);
    EXPECT_LE(levels[i].rmse_quarter, rows[i].rmse_quarter * (1 + kRelativeTolerance) + kRmseTolerance);
    EXPECT_LE(levels[i].rmse_sixteenth, rows[i].rmse_sixteenth * (1 + 2 * kRelativeTolerance) + kRmseTolerance);
    EXPECT_LE(levels[i].lit->frames_full, rows[i].lit->frames_full * (1 + kRelativeTolerance) + kRmseTolerance);
    EXPECT_LE(levels[i].lit->frames_sixteenth, rows[i].lit->frames_sixteenth * (1 + 2 * kRelativeTolerance) + kRmseTolerance);
    EXPECT_LE(std::abs(levels[i].coverage - 1), std::abs(rows[i].coverage - 1) + kCoverageTolerance);
    EXPECT_LE(levels[i].hausdorff, rows[i].hausdorff * (1 + kHausdorffTolerance));
  }
}

INSTANTIATE_TEST_SUITE_P(Plants, Quality,
                         testing::Values(QualityPlant{"corylus", nullptr}, QualityPlant{"willow", nullptr},
                                         QualityPlant{"juniper", nullptr}, QualityPlant{"scopia_poplar", "scopia_poplar.glb"},
                                         QualityPlant{"eztree_oak_medium", "eztree_oak_medium.glb"},
                                         QualityPlant{"eztree_pine_large", "eztree_pine_large.glb"}, QualityPlant{"coffee", "coffee.glb"},
                                         QualityPlant{"scopia_bush", "scopia_bush.glb"}, QualityPlant{"scopia_bonsai", "scopia_bonsai.glb"},
                                         QualityPlant{"scopia_coconut", "scopia_coconut.glb"}),
                         test_name);

}  // namespace quality_test
}  // namespace coppice::bake
