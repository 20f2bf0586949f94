#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>

#include "report.h"

namespace coppice::bake {
namespace {

struct Measure {
  std::string where;
  std::function<double(const LevelMeasures&)> value;
  const char* lowest;
  const char* lower;
};

std::array<Measure, 5> measures(std::uint32_t size_px) {
  const std::array<std::string, 3> rmse = rmse_names(size_px);
  const auto worst_full = [](const LevelMeasures& level) { return worst_lighting(level).rmse_full; };
  const auto worst_sixteenth = [](const LevelMeasures& level) { return worst_lighting(level).rmse_sixteenth; };
  return {
      {{"Seen close up (" + rmse[0] + ")", &LevelMeasures::rmse_full, "the least error", "is better"},
       {"Seen from afar (" + rmse[2] + ")", &LevelMeasures::rmse_sixteenth, "the least error", "is better"},
       {"At its worst light and ground close up (" + lighting_names(size_px)[2] + ")", worst_full, "the least error", "is better"},
       {"At its worst light and ground from afar (" + lighting_names(size_px)[3] + ")", worst_sixteenth, "the least error", "is better"},
       {"On the surface (Hausdorff)", &LevelMeasures::hausdorff, "the smallest distance", "is nearer"}}};
}

std::string percent(double share) {
  char text[32];
  static_cast<void>(std::snprintf(text, sizeof text, "%.3g%%", 100.0 * share));
  return text;
}

std::string whole_percent(double share) {
  if (share > 0.0 && share < 0.005) return "under 1%";
  return std::to_string(std::lround(100.0 * share)) + "%";
}

/// Joins items: "a", "a and b", "a, b and c".
std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) text += (i == 0 ? "" : i + 1 == items.size() ? " and " : ", ") + items[i];
  return text;
}

/// By what share `less` is below `more`; both >= 0, infinite allowed.
double share_below(double less, double more) {
  if (!(less < more)) return 0.0;
  return std::isinf(more) ? 1.0 : 1.0 - less / more;
}

const MethodMeasures& best_other(const EvaluationReport& report, const MethodMeasures& subject, std::size_t level, const Measure& measure) {
  const MethodMeasures* best = nullptr;
  for (const MethodMeasures& method : report.methods)
    if (&method != &subject && (best == nullptr || measure.value(method.levels[level]) < measure.value(best->levels[level])))
      best = &method;
  return *best;
}

struct Loss {
  std::string to;
  std::vector<std::string> levels;  ///< "80% (by 9%)"
};

struct Standing {
  std::vector<std::string> won;  ///< levels
  std::vector<Loss> lost;        ///< by the better method
  double smallest_margin = 1.0, largest_margin = 0.0;
};

void add_loss(std::vector<Loss>& losses, const std::string& to, const std::string& level) {
  auto loss = std::ranges::find(losses, to, &Loss::to);
  if (loss == losses.end()) loss = losses.insert(losses.end(), Loss{to, {}});
  loss->levels.push_back(level);
}

Standing standing(const EvaluationReport& report, const MethodMeasures& subject, const Measure& measure) {
  Standing result;
  for (std::size_t level = 0; level < subject.levels.size(); ++level) {
    const MethodMeasures& other = best_other(report, subject, level, measure);
    const double mine = measure.value(subject.levels[level]), theirs = measure.value(other.levels[level]);
    const std::string fraction = percent(subject.levels[level].fraction);
    if (mine <= theirs) {
      result.won.push_back(fraction);
      result.smallest_margin = std::min(result.smallest_margin, share_below(mine, theirs));
      result.largest_margin = std::max(result.largest_margin, share_below(mine, theirs));
    } else {
      add_loss(result.lost, other.name, fraction + " (by " + whole_percent(share_below(theirs, mine)) + ")");
    }
  }
  return result;
}

std::string losses_text(const std::vector<Loss>& losses, const Measure& measure) {
  std::string text;
  for (const Loss& loss : losses) text += (text.empty() ? "" : "; ") + loss.to + " " + measure.lower + " at " + listed(loss.levels);
  return text + ".";
}

std::string measure_sentence(const EvaluationReport& report, const MethodMeasures& subject, const Measure& measure) {
  const Standing result = standing(report, subject, measure);
  const std::string start = measure.where + ", " + subject.name;
  if (result.won.empty()) return start + " never has " + measure.lowest + ": " + losses_text(result.lost, measure);
  const std::string low = whole_percent(result.smallest_margin), high = whole_percent(result.largest_margin);
  const std::string margin = (low == high ? low : low + " to " + high) + " below the next best";
  if (result.lost.empty()) return start + " has " + measure.lowest + " at every level, " + margin + ".";
  return start + " has " + measure.lowest + " at " + listed(result.won) + " of the leaves, " + margin + "; " +
         losses_text(result.lost, measure);
}

std::string coverage_sentence(const MethodMeasures& subject) {
  const auto [lowest, highest] = std::ranges::minmax(subject.levels, {}, [](const LevelMeasures& level) { return level.coverage; });
  const std::string low = whole_percent(lowest.coverage), high = whole_percent(highest.coverage);
  return "Coverage: " + subject.name + " shows " + (low == high ? low : low + " to " + high) + " of the source's foliage pixels.";
}

std::string luminance_sentence(const MethodMeasures& subject) {
  const auto luminance = [](const LevelMeasures& level) { return worst_lighting(level).luminance; };
  const auto [lowest, highest] = std::ranges::minmax(subject.levels, {}, luminance);
  const std::string low = percent(luminance(lowest)), high = percent(luminance(highest));
  return "Luminance: leaves of " + subject.name + " have " + (low == high ? low : low + " to " + high) + " of the source's.";
}

std::string seconds_text(double seconds) {
  if (seconds < 0.05) return "under 0.1 s";
  char text[32];
  static_cast<void>(std::snprintf(text, sizeof text, seconds < 10.0 ? "%.1f s" : "%.0f s", seconds));
  return text;
}

std::string time_sentence(const EvaluationReport& report, const MethodMeasures& subject) {
  std::vector<std::string> others;
  for (const MethodMeasures& method : report.methods)
    if (&method != &subject) others.push_back(method.name + " " + seconds_text(method.seconds));
  std::string text = "Time: " + subject.name + " took " + seconds_text(subject.seconds) + " for all levels";
  return text + (others.empty() ? "." : "; " + listed(others) + ".");
}

}  // namespace

std::vector<std::string> evaluation_headline(const EvaluationReport& report) {
  if (report.methods.empty() || report.methods.front().levels.empty()) return {};
  const auto found = std::ranges::find(report.methods, method_name(Method::default_metric), &MethodMeasures::name);
  const MethodMeasures& subject = found != report.methods.end() ? *found : report.methods.front();
  std::vector<std::string> sentences;
  if (report.methods.size() > 1)
    for (const Measure& measure : measures(report.size_px)) sentences.push_back(measure_sentence(report, subject, measure));
  sentences.push_back(coverage_sentence(subject));
  sentences.push_back(luminance_sentence(subject));
  sentences.push_back(time_sentence(report, subject));
  return sentences;
}

}  // namespace coppice::bake
