// Inserts the data into the page in report_page/, which is embedded at build time (core/embed_texts.cmake).

#include "report_html.h"

#include <array>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "html_page.h"
#include "report_headline.h"
#include "report_page.h"

namespace coppice::bake {
namespace {

nlohmann::ordered_json picture_json(const std::vector<std::uint8_t>& png) {
  if (png.empty()) return nullptr;
  return data_url("image/png", png);
}

nlohmann::ordered_json level_data(const LevelMeasures& level, std::uint32_t size_px) {
  const std::array<std::string, 3> rmse = rmse_names(size_px);
  nlohmann::ordered_json json = {{"fraction", level.fraction},
                                 {"leaves", level.leaves},
                                 {"triangles", level.triangles},
                                 {rmse[0], level.rmse_full},
                                 {rmse[1], level.rmse_quarter},
                                 {rmse[2], level.rmse_sixteenth},
                                 {"coverage", level.coverage},
                                 {"soft_iou", level.soft_iou},
                                 {"area_ratio", level.area_ratio},
                                 {"hausdorff", level.hausdorff},
                                 {"mean_distance", level.mean_distance},
                                 {"parameters", level.parameters},
                                 {"picture", picture_json(level.picture_png)}};
  if (!level.lit) return json;
  const std::array<std::string, 4> lit = lit_names(size_px);
  json[lit[0]] = level.lit->suns_full;
  json[lit[1]] = level.lit->suns_sixteenth;
  json[lit[2]] = level.lit->frames_full;
  json[lit[3]] = level.lit->frames_sixteenth;
  return json;
}

/// The keys of suns and frames; none if they were not measured.
nlohmann::ordered_json lit_json(const EvaluationReport& report) {
  const bool has_levels = !report.methods.empty() && !report.methods.front().levels.empty();
  if (!has_levels || !report.methods.front().levels.front().lit) return nlohmann::ordered_json::array();
  return lit_names(report.size_px);
}

nlohmann::ordered_json report_data(const EvaluationReport& report) {
  const std::array<std::string, 3> rmse = rmse_names(report.size_px);
  nlohmann::ordered_json methods = nlohmann::ordered_json::array();
  for (const MethodMeasures& method : report.methods) {
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    for (const LevelMeasures& level : method.levels) levels.push_back(level_data(level, report.size_px));
    methods.push_back({{"name", method.name}, {"seconds", method.seconds}, {"levels", std::move(levels)}});
  }
  return {{"plant", report.plant},
          {"source_leaves", report.source_leaves},
          {"reference", reference_name(report.reference)},
          {"size_px", report.size_px},
          {"rmse", rmse},
          {"lit", lit_json(report)},
          {"setup", setup_name(report.setup)},
          {"view_distance", report.view_distance_radii},
          {"source_triangles", report.source_triangles},
          {"source_picture", picture_json(report.source_picture_png)},
          {"headline", evaluation_headline(report)},
          {"warnings", report.warnings},
          {"methods", std::move(methods)}};
}

}  // namespace

std::string evaluation_html(const EvaluationReport& report) {
  const std::string data = json_for_script(report_data(report).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  const std::pair<std::string_view, std::string_view> parts[] = {{"{{library_licence}}", report_page::kLibraryLicence},
                                                                 {"{{library_style}}", report_page::kLibraryStyle},
                                                                 {"{{style}}", report_page::kStyle},
                                                                 {"{{data}}", data},
                                                                 {"{{library_script}}", report_page::kLibraryScript},
                                                                 {"{{script}}", report_page::kScript}};
  return filled_page(report_page::kPage, parts);
}

}  // namespace coppice::bake
