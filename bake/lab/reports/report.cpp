#include "report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <limits>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "html_page.h"
#include "printable.h"
#include "report_page.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::ordered_json;

/// In the order of lit_names.
constexpr std::array kLit{&LevelMeasures::Lit::suns_full, &LevelMeasures::Lit::suns_sixteenth, &LevelMeasures::Lit::frames_full,
                          &LevelMeasures::Lit::frames_sixteenth};

bool has_lit(const EvaluationReport& report) {
  return !report.methods.empty() && !report.methods.front().levels.empty() && report.methods.front().levels.front().lit.has_value();
}

/// A figure of all of a level's lightings together.
struct LightingColumn {
  std::string name, title;
  double (*value)(const LevelMeasures&);
  int decimals;
};

std::array<LightingColumn, 5> lighting_columns(std::uint32_t size_px) {
  const auto [mean_full, mean_sixteenth, worst_full, worst_sixteenth] = lighting_names(size_px);
  const std::string full = std::to_string(size_px), sixteenth = std::to_string(size_px / 16);
  return {{{mean_full, "mean " + full, [](const LevelMeasures& level) { return mean_lighting(level).rmse_full; }, 2},
           {mean_sixteenth, "mean " + sixteenth, [](const LevelMeasures& level) { return mean_lighting(level).rmse_sixteenth; }, 2},
           {worst_full, "worst " + full, [](const LevelMeasures& level) { return worst_lighting(level).rmse_full; }, 2},
           {worst_sixteenth, "worst " + sixteenth, [](const LevelMeasures& level) { return worst_lighting(level).rmse_sixteenth; }, 2},
           {"luminance", "luminance", [](const LevelMeasures& level) { return worst_lighting(level).luminance; }, 3}}};
}

/// The figures of each light before each ground.
Json lightings_json(const LevelMeasures& level, std::uint32_t size_px) {
  const std::array<std::string, 3> rmse = rmse_names(size_px);
  Json lightings = Json::array();
  for (std::size_t i = 0; i < kLightingCount; ++i) {
    const LevelMeasures::Lighting& figures = level.lightings[i];
    lightings.push_back({{"light", kEvaluationLights[i / kEvaluationGrounds.size()].name},
                         {"ground", kEvaluationGrounds[i % kEvaluationGrounds.size()]},
                         {rmse[0], figures.rmse_full},
                         {rmse[2], figures.rmse_sixteenth},
                         {"luminance", figures.luminance}});
  }
  return lightings;
}

Json level_json(const LevelMeasures& level, std::uint32_t size_px) {
  const std::array<std::string, 3> rmse = rmse_names(size_px);
  Json json = {{"fraction", level.fraction},   {"leaves", level.leaves},
               {"triangles", level.triangles}, {rmse[0], level.rmse_full},
               {rmse[1], level.rmse_quarter},  {rmse[2], level.rmse_sixteenth},
               {"coverage", level.coverage},   {"area_ratio", level.area_ratio},
               {"hausdorff", level.hausdorff}, {"mean_distance", level.mean_distance}};
  for (const LightingColumn& column : lighting_columns(size_px)) json[column.name] = column.value(level);
  json["lightings"] = lightings_json(level, size_px);
  if (level.lit)
    for (std::size_t i = 0; i < kLit.size(); ++i) json[lit_names(size_px)[i]] = (*level.lit).*kLit[i];
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
  for (const LightingColumn& column : lighting_columns(report.size_px))
    shown.push_back({column.title, column.value, column.decimals, column.name != "luminance"});
  if (!has_lit(report)) return shown;
  const std::string full = std::to_string(report.size_px), sixteenth = std::to_string(report.size_px / 16);
  const std::array titles{"suns " + full, "suns " + sixteenth, "frames " + full, "frames " + sixteenth};
  for (std::size_t i = 0; i < kLit.size(); ++i)
    shown.push_back({titles[i], [i](const LevelMeasures& level) { return level.lit ? level.lit.value().*kLit[i] : 0.0; }, 2, true});
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

/// A report without its methods.
Json head_json(const EvaluationReport& report) {
  return {{"plant", report.plant},
          {"source_leaves", report.source_leaves},
          {"reference", reference_name(report.reference)},
          {"setup", setup_name(report.setup)},
          {"view_distance", report.view_distance_radii},
          {"size_px", report.size_px}};
}

Json report_json(const EvaluationReport& report) {
  Json methods = Json::array();
  for (const MethodMeasures& method : report.methods) {
    Json levels = Json::array();
    for (const LevelMeasures& level : method.levels) levels.push_back(level_json(level, report.size_px));
    methods.push_back({{"name", method.name}, {"levels", levels}});
  }
  Json root = head_json(report);
  root["methods"] = std::move(methods);
  if (report.stored) {
    root["stored"] = level_json(report.stored->level, report.size_px);
    root["stored"]["leaf_meshes"] = report.stored->is_leaf_meshes;
  }
  return root;
}

/// indent  -1: all in one line
std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json picture_json(const std::vector<std::uint8_t>& png) {
  return png.empty() ? Json() : Json(data_url("image/png", png));
}

/// What the page shows.
Json page_data(const EvaluationReport& report) {
  Json methods = Json::array();
  for (const MethodMeasures& method : report.methods) {
    Json levels = Json::array();
    for (const LevelMeasures& level : method.levels) {
      Json& data = levels.emplace_back(level_json(level, report.size_px));
      data["soft_iou"] = level.soft_iou;
      data["parameters"] = level.parameters;
      data["picture"] = picture_json(level.picture_png);
    }
    methods.push_back({{"name", method.name}, {"seconds", method.seconds}, {"levels", std::move(levels)}});
  }
  Json data = head_json(report);
  data["rmse"] = rmse_names(report.size_px);
  data["lightings"] = lighting_names(report.size_px);
  data["lit"] = has_lit(report) ? Json(lit_names(report.size_px)) : Json::array();
  data["source_triangles"] = report.source_triangles;
  data["source_picture"] = picture_json(report.source_picture_png);
  data["headline"] = evaluation_headline(report);
  data["warnings"] = report.warnings;
  data["methods"] = std::move(methods);
  return data;
}

}  // namespace

std::string evaluation_json(const EvaluationReport& report) {
  return json_text(report_json(report), 2) + "\n";
}

std::string evaluations_json(const std::vector<EvaluationReport>& reports) {
  Json plants = Json::array();
  for (const EvaluationReport& report : reports) plants.push_back(report_json(report));
  return json_text({{"plants", std::move(plants)}}, 2) + "\n";
}

std::string evaluation_html(const EvaluationReport& report) {
  const std::string data = json_for_script(json_text(page_data(report), -1));
  // The page in report_page/ is embedded at build time (core/embed_texts.cmake).
  const std::pair<std::string_view, std::string_view> parts[] = {{"{{library_licence}}", report_page::kLibraryLicence},
                                                                 {"{{library_style}}", report_page::kLibraryStyle},
                                                                 {"{{style}}", report_page::kStyle},
                                                                 {"{{data}}", data},
                                                                 {"{{library_script}}", report_page::kLibraryScript},
                                                                 {"{{script}}", report_page::kScript}};
  return filled_page(report_page::kPage, parts);
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
