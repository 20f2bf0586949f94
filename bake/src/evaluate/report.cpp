#include "report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include <nlohmann/json.hpp>

#include "printable.h"

namespace coppice::bake {
namespace {

nlohmann::ordered_json level_json(const LevelMeasures& level, const std::array<std::string, 3>& rmse) {
  return {{"fraction", level.fraction},   {"leaves", level.leaves},
          {"triangles", level.triangles}, {rmse[0], level.rmse_full},
          {rmse[1], level.rmse_quarter},  {rmse[2], level.rmse_sixteenth},
          {"coverage", level.coverage},   {"area_ratio", level.area_ratio},
          {"hausdorff", level.hausdorff}, {"mean_distance", level.mean_distance}};
}

struct Column {
  std::string title;
  double LevelMeasures::*value;
  int decimals;
  bool least_is_best;
};

std::array<Column, 8> columns(std::uint32_t size_px) {
  const std::array<std::string, 3> rmse = rmse_names(size_px);
  return {{{rmse[0], &LevelMeasures::rmse_full, 2, true},
           {rmse[1], &LevelMeasures::rmse_quarter, 2, true},
           {rmse[2], &LevelMeasures::rmse_sixteenth, 2, true},
           {"coverage", &LevelMeasures::coverage, 3, false},
           {"soft IoU", &LevelMeasures::soft_iou, 3, false},
           {"area", &LevelMeasures::area_ratio, 3, false},
           {"hausdorff", &LevelMeasures::hausdorff, 4, true},
           {"mean dist", &LevelMeasures::mean_distance, 5, true}}};
}

std::string number(double value, int decimals) {
  char text[32];
  static_cast<void>(std::snprintf(text, sizeof text, "%.*f", decimals, value));
  return text;
}

std::string padded(const std::string& text, std::size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

/// As printed, so that methods that look equal are all marked.
std::string least(const EvaluationReport& report, std::size_t level, const Column& column) {
  double best = std::numeric_limits<double>::infinity();
  for (const MethodMeasures& method : report.methods) best = std::min(best, method.levels[level].*column.value);
  return number(best, column.decimals);
}

std::string level_block(const EvaluationReport& report, std::size_t level) {
  const LevelMeasures& first = report.methods.front().levels[level];
  std::string text = "\nlevel " + number(first.fraction, 3) + ": " + std::to_string(first.leaves) + " leaves\n  method          triangles";
  const std::array<Column, 8> shown = columns(report.size_px);
  for (const Column& column : shown) text += padded(column.title, 11);
  text += "\n";
  for (const MethodMeasures& method : report.methods) {
    const std::string name = method_name(method.method);
    text += "  " + name + padded(std::to_string(method.levels[level].triangles), 25 - name.size());
    for (const Column& column : shown) {
      const std::string value = number(method.levels[level].*column.value, column.decimals);
      text += padded(value, 10) + (column.least_is_best && value == least(report, level, column) ? "*" : " ");
    }
    while (text.back() == ' ') text.pop_back();
    text += "\n";
  }
  return text;
}

}  // namespace

std::string evaluation_json(const EvaluationReport& report) {
  const std::array<std::string, 3> rmse = rmse_names(report.size_px);
  nlohmann::ordered_json methods = nlohmann::ordered_json::array();
  for (const MethodMeasures& method : report.methods) {
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    for (const LevelMeasures& level : method.levels) levels.push_back(level_json(level, rmse));
    methods.push_back({{"name", method_name(method.method)}, {"levels", levels}});
  }
  nlohmann::ordered_json root = {{"plant", report.plant},
                                 {"source_leaves", report.source_leaves},
                                 {"reference", reference_name(report.reference)},
                                 {"size_px", report.size_px},
                                 {"methods", methods}};
  if (report.stored) {
    root["stored"] = level_json(report.stored->level, rmse);
    root["stored"]["leaf_meshes"] = report.stored->is_leaf_meshes;
  }
  return root.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string evaluation_table(const EvaluationReport& report) {
  const std::string size = std::to_string(report.size_px);
  std::string text = printable(report.plant) + ": " + std::to_string(report.source_leaves) + " leaves; compared with its leaf " +
                     reference_name(report.reference) + ", " + size + " x " + size + " px\n";
  if (report.methods.empty()) return text;
  for (std::size_t level = 0; level < report.methods.front().levels.size(); ++level) text += level_block(report, level);
  if (report.stored) {
    const LevelMeasures& level = report.stored->level;
    text += "\nfinest level of a .coppice file: ";
    text += report.stored->is_leaf_meshes ? "leaf meshes\n" : "all quads\n";
    text += "  stored" + padded(std::to_string(level.triangles), 19);
    for (const Column& column : columns(report.size_px)) text += padded(number(level.*column.value, column.decimals), 10) + " ";
    while (text.back() == ' ') text.pop_back();
    text += "\n";
  }
  text += "\nseconds to simplify:";
  for (const MethodMeasures& method : report.methods)
    text += std::string(" ") + method_name(method.method) + " " + number(method.seconds, 1);
  return text + "\n";
}

}  // namespace coppice::bake
