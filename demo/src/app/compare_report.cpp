#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "compare.h"

namespace forest {
namespace {

template <class... Values>
std::string line(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

constexpr double kWidth = 640, kHeight = 400, kLeft = 64, kRight = 24, kTop = 44, kBottom = 52;

/// The plot's axes.
struct Axes {
  double max_rmse = 1, min_log_ms = 0, max_log_ms = 1;

  explicit Axes(const Comparison& comparison) {
    min_log_ms = 1e9;
    for (const ComparedMode& mode : comparison.modes) {
      max_rmse = std::max(max_rmse, 1.1 * static_cast<double>(mode.rmse));
      min_log_ms = std::min(min_log_ms, std::floor(std::log10(static_cast<double>(mode.frame_ms))));
      max_log_ms = std::max(max_log_ms, std::ceil(std::log10(static_cast<double>(mode.frame_ms))));
    }
  }
  [[nodiscard]] double x(double rmse) const { return kLeft + (kWidth - kLeft - kRight) * rmse / max_rmse; }
  [[nodiscard]] double y(double ms) const {
    return kHeight - kBottom - (kHeight - kTop - kBottom) * (std::log10(ms) - min_log_ms) / (max_log_ms - min_log_ms);
  }
};

std::string grid(const Axes& axes) {
  std::string svg;
  for (int power = static_cast<int>(axes.min_log_ms); power <= static_cast<int>(axes.max_log_ms); ++power) {
    const double ms = std::pow(10.0, power), y = axes.y(ms);
    svg += line("<line x1=\"%.0f\" y1=\"%.1f\" x2=\"%.0f\" y2=\"%.1f\" stroke=\"#ddd\"/>\n", kLeft, y, kWidth - kRight, y);
    svg += line("<text x=\"%.0f\" y=\"%.1f\" text-anchor=\"end\">%g</text>\n", kLeft - 8, y + 4, ms);
  }
  const int step = axes.max_rmse > 12 ? 5 : axes.max_rmse > 5 ? 2 : 1;
  for (int rmse = 0; rmse <= static_cast<int>(axes.max_rmse); rmse += step)
    svg += line("<text x=\"%.1f\" y=\"%.0f\" text-anchor=\"middle\">%d</text>\n", axes.x(rmse), kHeight - kBottom + 18, rmse);
  svg += line("<text x=\"%.0f\" y=\"%.0f\" text-anchor=\"middle\">RMSE against full detail, of 255</text>\n",
              0.5 * (kLeft + kWidth - kRight), kHeight - 12);
  return svg + line("<text x=\"16\" y=\"%.0f\">frame time, ms</text>\n", kTop - 24);
}

std::string curve(const Axes& axes, const Comparison& comparison, LodMode lod, const char* color) {
  std::string points, dots;
  double last_x = 0, last_y = 0;
  for (const ComparedMode& mode : comparison.modes) {
    if (mode.lod != lod) continue;
    last_x = axes.x(static_cast<double>(mode.rmse));
    last_y = axes.y(static_cast<double>(mode.frame_ms));
    points += line("%.1f,%.1f ", last_x, last_y);
    dots += line("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"%s\"/>\n", last_x, last_y, color);
  }
  return line("<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"2\" points=\"", color) + points + "\"/>\n" + dots +
         line("<text x=\"%.1f\" y=\"%.1f\" fill=\"%s\">%s</text>\n", std::min(last_x + 8, kWidth - 70), last_y - 8, color, mode_name(lod));
}

}  // namespace

std::string comparison_table(const Comparison& comparison) {
  std::string text = line("%u plants, %u x %u, %u poses, %s\n", comparison.plants, comparison.width_px, comparison.height_px,
                          comparison.poses, comparison.device.c_str());
  text += "mode      error px   frame ms      leaves  wood tri.  mesh tri.  MiB    RMSE  popping mean   max  switching block";
  text += comparison.wind_mps > 0 ? line("  popping in %g m/s   max\n", static_cast<double>(comparison.wind_mps)) : "\n";
  for (const ComparedMode& mode : comparison.modes) {
    text += line("%-9s %8.2f %10.1f %11llu %10llu %10llu %4.0f %7.2f %13.2f %5.2f %10.2f %5.1f", mode_name(mode.lod),
                 static_cast<double>(mode.error_px), static_cast<double>(mode.frame_ms), static_cast<unsigned long long>(mode.leaves),
                 static_cast<unsigned long long>(mode.wood_triangles), static_cast<unsigned long long>(mode.leaf_mesh_triangles),
                 static_cast<double>(mode.memory_bytes) / (1 << 20), static_cast<double>(mode.rmse), static_cast<double>(mode.popping_mean),
                 static_cast<double>(mode.popping_max), static_cast<double>(mode.switching_rmse),
                 static_cast<double>(mode.switching_block_max));
    if (comparison.wind_mps > 0)
      text += line("%18.2f %5.2f", static_cast<double>(mode.wind_popping_mean), static_cast<double>(mode.wind_popping_max));
    text += "\n";
  }
  return text;
}

std::string comparison_json(const Comparison& comparison) {
  nlohmann::ordered_json json;
  json["device"] = comparison.device;
  json["plants"] = comparison.plants;
  json["width_px"] = comparison.width_px;
  json["height_px"] = comparison.height_px;
  json["poses"] = comparison.poses;
  json["wind_mps"] = comparison.wind_mps;
  for (const ComparedMode& mode : comparison.modes)
    json["modes"].push_back({{"lod", mode_name(mode.lod)},
                             {"error_px", mode.error_px},
                             {"frame_ms", mode.frame_ms},
                             {"leaves", mode.leaves},
                             {"wood_triangles", mode.wood_triangles},
                             {"leaf_mesh_triangles", mode.leaf_mesh_triangles},
                             {"memory_bytes", mode.memory_bytes},
                             {"rmse", mode.rmse},
                             {"popping_mean", mode.popping_mean},
                             {"popping_max", mode.popping_max},
                             {"wind_popping_mean", mode.wind_popping_mean},
                             {"wind_popping_max", mode.wind_popping_max},
                             {"switching_rmse", mode.switching_rmse},
                             {"switching_block_max", mode.switching_block_max}});
  return json.dump(2) + "\n";
}

std::string comparison_svg(const Comparison& comparison) {
  const Axes axes(comparison);
  std::string svg =
      line("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" font-family=\"sans-serif\" font-size=\"12\">\n",
           kWidth, kHeight);
  svg += "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n" + grid(axes);
  svg += curve(axes, comparison, LodMode::cut, "#2c7a2c") + curve(axes, comparison, LodMode::discrete, "#b3541e") +
         curve(axes, comparison, LodMode::full, "#555");
  return svg + "</svg>\n";
}

}  // namespace forest
