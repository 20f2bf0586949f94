#include "report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <vector>

#include <nlohmann/json.hpp>

#include "printable.h"

namespace coppice::bake {
namespace {

nlohmann::ordered_json level_json(const LevelMeasures& level, std::uint32_t size_px) {
  const std::array<std::string, 3> rmse = rmse_names(size_px);
  nlohmann::ordered_json json = {{"fraction", level.fraction},   {"leaves", level.leaves},
                                 {"triangles", level.triangles}, {rmse[0], level.rmse_full},
                                 {rmse[1], level.rmse_quarter},  {rmse[2], level.rmse_sixteenth},
                                 {"coverage", level.coverage},   {"area_ratio", level.area_ratio},
                                 {"hausdorff", level.hausdorff}, {"mean_distance", level.mean_distance}};
  if (level.lit) {
    const std::array<std::string, 4> lit = lit_names(size_px);
    json[lit[0]] = level.lit->suns_full;
    json[lit[1]] = level.lit->suns_sixteenth;
    json[lit[2]] = level.lit->frames_full;
    json[lit[3]] = level.lit->frames_sixteenth;
  }
  if (!level.parameters.empty()) json["parameters"] = level.parameters;
  return json;
}

struct Column {
  std::string title;
  std::function<double(const LevelMeasures&)> value;
  int decimals;
  bool is_lower_better;
};

std::vector<Column> columns(const EvaluationReport& report) {
  const std::array<std::string, 3> rmse = rmse_names(report.size_px);
  std::vector<Column> shown{{rmse[0], &LevelMeasures::rmse_full, 2, true},      {rmse[1], &LevelMeasures::rmse_quarter, 2, true},
                            {rmse[2], &LevelMeasures::rmse_sixteenth, 2, true}, {"coverage", &LevelMeasures::coverage, 3, false},
                            {"soft IoU", &LevelMeasures::soft_iou, 3, false},   {"area", &LevelMeasures::area_ratio, 3, false},
                            {"hausdorff", &LevelMeasures::hausdorff, 4, true},  {"mean dist", &LevelMeasures::mean_distance, 5, true}};
  const bool has_levels = !report.methods.empty() && !report.methods.front().levels.empty();
  if (!has_levels || !report.methods.front().levels.front().lit) return shown;
  const std::string full = std::to_string(report.size_px), sixteenth = std::to_string(report.size_px / 16);
  const auto lit = [&](const std::string& title, double LevelMeasures::Lit::*value) {
    shown.push_back({title, [value](const LevelMeasures& level) { return level.lit ? level.lit.value().*value : 0.0; }, 2, true});
  };
  lit("suns " + full, &LevelMeasures::Lit::suns_full);
  lit("suns " + sixteenth, &LevelMeasures::Lit::suns_sixteenth);
  lit("frames " + full, &LevelMeasures::Lit::frames_full);
  lit("frames " + sixteenth, &LevelMeasures::Lit::frames_sixteenth);
  return shown;
}

std::string number(double value, int decimals) {
  char text[32];
  static_cast<void>(std::snprintf(text, sizeof text, "%.*f", decimals, value));
  return text;
}

std::string padded(const std::string& text, std::size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

/// Compares values as they are printed, so that all methods that look equal get a mark.
std::string lowest_printed(const EvaluationReport& report, std::size_t level, const Column& column) {
  double best = std::numeric_limits<double>::infinity();
  for (const MethodMeasures& method : report.methods) best = std::min(best, column.value(method.levels[level]));
  return number(best, column.decimals);
}

std::string level_block(const EvaluationReport& report, std::size_t level) {
  const LevelMeasures& first = report.methods.front().levels[level];
  std::string text = "\nlevel " + number(first.fraction, 3) + ": " + std::to_string(first.leaves) + " leaves\n  method          triangles";
  const std::vector<Column> shown = columns(report);
  for (const Column& column : shown) text += padded(column.title, 11);
  text += "\n";
  for (const MethodMeasures& method : report.methods) {
    const std::string name = printable(method.name), triangles = std::to_string(method.levels[level].triangles);
    text += "  " + name + padded(triangles, std::max(triangles.size() + 1, 25 - std::min<std::size_t>(25, name.size())));
    for (const Column& column : shown) {
      const std::string value = number(column.value(method.levels[level]), column.decimals);
      text += padded(value, 10) + (column.is_lower_better && value == lowest_printed(report, level, column) ? "*" : " ");
    }
    const std::string& parameters = method.levels[level].parameters;
    if (!parameters.empty()) text += "  " + printable(parameters);
    while (text.back() == ' ') text.pop_back();
    text += "\n";
  }
  return text;
}

nlohmann::ordered_json report_json(const EvaluationReport& report) {
  nlohmann::ordered_json methods = nlohmann::ordered_json::array();
  for (const MethodMeasures& method : report.methods) {
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    for (const LevelMeasures& level : method.levels) levels.push_back(level_json(level, report.size_px));
    methods.push_back({{"name", method.name}, {"levels", levels}});
  }
  nlohmann::ordered_json root = {{"plant", report.plant},
                                 {"source_leaves", report.source_leaves},
                                 {"reference", reference_name(report.reference)},
                                 {"setup", setup_name(report.setup)},
                                 {"view_distance", report.view_distance_radii},
                                 {"size_px", report.size_px},
                                 {"methods", methods}};
  if (report.stored) {
    root["stored"] = level_json(report.stored->level, report.size_px);
    root["stored"]["leaf_meshes"] = report.stored->is_leaf_meshes;
  }
  return root;
}

std::string json_text(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string evaluation_json(const EvaluationReport& report) {
  return json_text(report_json(report));
}

std::string evaluations_json(const std::vector<EvaluationReport>& reports) {
  nlohmann::ordered_json plants = nlohmann::ordered_json::array();
  for (const EvaluationReport& report : reports) plants.push_back(report_json(report));
  return json_text({{"plants", std::move(plants)}});
}

std::string paper_claim(const EvaluationReport& report) {
  const auto find = [&](Method method) { return std::ranges::find(report.methods, method_name(method), &MethodMeasures::name); };
  const auto mi = find(Method::mi), geometric = find(Method::geometric);
  if (report.setup != Setup::paper || mi == report.methods.end() || geometric == report.methods.end()) return "";
  std::size_t lower = 0;
  for (std::size_t i = 0; i < mi->levels.size(); ++i)
    if (mi->levels[i].rmse_full < geometric->levels[i].rmse_full) ++lower;
  return "mi has a lower " + rmse_names(report.size_px)[0] + " than geometric at " + std::to_string(lower) + " of " +
         std::to_string(mi->levels.size()) + " levels\n";
}

std::string evaluation_table(const EvaluationReport& report) {
  const std::string size = std::to_string(report.size_px);
  std::string text = printable(report.plant) + ": " + std::to_string(report.source_leaves) + " leaves; compared with its leaf " +
                     reference_name(report.reference) + ", " + size + " x " + size + " px";
  if (report.setup == Setup::paper) text += ", the paper's set-up";
  text += "\n";
  if (report.methods.empty()) return text;
  for (std::size_t level = 0; level < report.methods.front().levels.size(); ++level) text += level_block(report, level);
  if (report.stored) {
    const LevelMeasures& level = report.stored->level;
    text += "\nfinest level of a .coppice file: ";
    text += report.stored->is_leaf_meshes ? "leaf meshes\n" : "all quads\n";
    text += "  stored" + padded(std::to_string(level.triangles), 19);
    for (const Column& column : columns(report)) text += padded(number(column.value(level), column.decimals), 10) + " ";
    while (text.back() == ' ') text.pop_back();
    text += "\n";
  }
  if (const std::string claim = paper_claim(report); !claim.empty()) text += "\n" + claim;
  text += "\nseconds to simplify:";
  for (const MethodMeasures& method : report.methods) text += " " + printable(method.name) + " " + number(method.seconds, 1);
  return text + "\n";
}

}  // namespace coppice::bake
