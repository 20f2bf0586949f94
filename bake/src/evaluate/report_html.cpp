// The page is report_page/, embedded at build time (see report_page/embed.cmake); here it meets the data.

#include "report_html.h"

#include <array>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "report_headline.h"
#include "report_page.h"

namespace coppice::bake {
namespace {

std::string base64(std::span<const std::uint8_t> bytes) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t j = 0; j < 3; ++j) group = group << 8 | (j < count ? bytes[i + j] : 0u);
    for (std::size_t j = 0; j < 4; ++j) text += j <= count ? kDigits[group >> (18 - 6 * j) & 63] : '=';
  }
  return text;
}

nlohmann::ordered_json picture_json(const std::vector<std::uint8_t>& png) {
  if (png.empty()) return nullptr;
  return "data:image/png;base64," + base64(png);
}

nlohmann::ordered_json level_json(const LevelMeasures& level, std::uint32_t size_px) {
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

/// The keys of suns and frames; none where they were not measured.
nlohmann::ordered_json lit_json(const EvaluationReport& report) {
  const bool has_levels = !report.methods.empty() && !report.methods.front().levels.empty();
  if (!has_levels || !report.methods.front().levels.front().lit) return nlohmann::ordered_json::array();
  return lit_names(report.size_px);
}

nlohmann::ordered_json report_json(const EvaluationReport& report) {
  const std::array<std::string, 3> rmse = rmse_names(report.size_px);
  nlohmann::ordered_json methods = nlohmann::ordered_json::array();
  for (const MethodMeasures& method : report.methods) {
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    for (const LevelMeasures& level : method.levels) levels.push_back(level_json(level, report.size_px));
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

/// JSON that cannot end the script element that holds it: strings alone have '<', and there it can be written as an escape.
std::string json_for_script(const nlohmann::ordered_json& json) {
  std::string text;
  for (const char letter : json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace))
    if (letter == '<')
      text += "\\u003c";
    else
      text += letter;
  return text;
}

}  // namespace

std::string evaluation_html(const EvaluationReport& report) {
  const std::string data = json_for_script(report_json(report));
  const std::pair<std::string_view, std::string_view> parts[] = {{"{{library_licence}}", report_page::kLibraryLicence},
                                                                 {"{{library_style}}", report_page::kLibraryStyle},
                                                                 {"{{style}}", report_page::kStyle},
                                                                 {"{{data}}", data},
                                                                 {"{{library_script}}", report_page::kLibraryScript},
                                                                 {"{{script}}", report_page::kScript}};
  // In the order of the page, so that what was put in is never searched.
  std::string page;
  std::string_view rest = report_page::kPage;
  for (const auto& [name, text] : parts) {
    const std::size_t at = rest.find(name);
    page.append(rest.substr(0, at)).append(text);
    rest.remove_prefix(at + name.size());
  }
  return page.append(rest);
}

}  // namespace coppice::bake
