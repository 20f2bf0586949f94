#include "batch_report.h"

#include <algorithm>
#include <cstdio>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "batch_page.h"
#include "html_page.h"
#include "output.h"
#include "plant_pictures.h"
#include "plant_record.h"
#include "printable.h"

namespace coppice::bake {
namespace {

/// Broken between words, or within those that are longer than a line. Lines after the first are indented. text: may be printed
std::string wrapped(const std::string& text, std::size_t columns) {
  const std::string indent = "\n    ";
  std::string lines, word;
  std::size_t column = 0, word_columns = 0;
  const auto end_word = [&] {
    if (column > 0 && column + 1 + word_columns > columns)
      lines += indent, column = indent.size() - 1;
    else if (column > 0)
      lines += ' ', ++column;
    lines += std::exchange(word, "");
    column += std::exchange(word_columns, 0);
  };
  for (const char c : text) {
    const bool is_character = (static_cast<unsigned char>(c) & 0xc0u) != 0x80u;
    if (c == ' ' || (is_character && word_columns + indent.size() > columns)) end_word();
    if (c == ' ') continue;
    word += c;
    if (is_character) ++word_columns;
  }
  end_word();
  return lines;
}

/// What is wrong with a plant, without its path.
std::string told_error(const BatchPlant& plant, const BatchResult& result) {
  std::string error = result.error;
  const std::string path = plant.input.string();
  for (const std::string& place : {": " + path, path + ": ", path})
    if (const std::size_t at = error.find(place); at != std::string::npos) error.erase(at, place.size());
  return error;
}

std::string told_name(const std::filesystem::path& input, const BatchPlant& plant) {
  std::error_code unreadable;
  const bool is_folder = std::filesystem::is_directory(input, unreadable);
  const std::filesystem::path name = plant.input.lexically_relative(is_folder ? input : input.parent_path());
  return name.empty() || *name.begin() == ".." ? shown(plant.input) : shown(name);
}

nlohmann::ordered_json cache_json(const CacheReport& report) {
  return {{"where", report.where},   {"found", report.found},     {"lacking", report.lacking}, {"sent", report.sent},
          {"unsent", report.unsent}, {"gave_up", report.gave_up}, {"trouble", report.trouble}};
}

/// "oaks/large" of OUT/oaks/large.coppice
std::string plant_label(const Batch& batch, std::size_t plant) {
  std::filesystem::path name = batch.plants[plant].output.lexically_relative(batch.output_folder);
  return shown(name.replace_extension());
}

nlohmann::ordered_json batch_record(const Batch& batch) {
  nlohmann::ordered_json plants = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < batch.plants.size(); ++i) plants.push_back(plant_record(batch.plants[i], batch.results[i]));
  nlohmann::ordered_json root = {{"baked", count_of(batch, BatchOutcome::baked)},
                                 {"cached", count_of(batch, BatchOutcome::cached)},
                                 {"failed", count_of(batch, BatchOutcome::failed)},
                                 {"seconds", batch.seconds},
                                 {"jobs", batch.job_count},
                                 {"cache", cache_json(batch.cache)}};
  root["plants"] = std::move(plants);
  return root;
}

}  // namespace

void show_batch(ProgressBar& bar, const BatchStatus& status) {
  bar.show("bake-all", status.fraction, std::to_string(status.ended) + " of " + std::to_string(status.count) + "; " + status.running);
}

std::size_t count_of(const Batch& batch, BatchOutcome outcome) {
  return static_cast<std::size_t>(std::ranges::count(batch.results, outcome, &BatchResult::outcome));
}

std::string batch_json(const Batch& batch) {
  return json_file(batch_record(batch));
}

std::string batch_html(const Batch& batch) {
  nlohmann::ordered_json record = batch_record(batch);
  record["folder"] = shown(batch.output_folder);
  const std::filesystem::path pictures = picture_folder(batch.output_folder);
  for (std::size_t i = 0; i < batch.plants.size(); ++i) {
    record["plants"][i]["name"] = plant_label(batch, i);
    if (batch.results[i].outcome == BatchOutcome::failed) continue;
    if (const auto picture = read_picture(pictures, batch.results[i].key))
      record["plants"][i]["picture"] = data_url("image/webp", *picture);
  }
  const std::string data = json_for_script(json_line(record));
  const std::pair<std::string_view, std::string_view> parts[] = {
      {"{{style}}", batch_page::kStyle}, {"{{data}}", data}, {"{{script}}", batch_page::kScript}};
  return filled_page(batch_page::kPage, parts);
}

void print_batch(const Batch& batch) {
  std::size_t width = 5;
  for (std::size_t i = 0; i < batch.plants.size(); ++i) width = std::max(width, plant_label(batch, i).size());
  const int columns = static_cast<int>(width);
  std::printf("%-*s %9s %10s %7s %8s\n", columns, "plant", "leaves", "bytes", "B/leaf", "seconds");
  for (std::size_t i = 0; i < batch.plants.size(); ++i) {
    const BatchResult& result = batch.results[i];
    const std::string label = plant_label(batch, i);
    if (result.outcome == BatchOutcome::failed)
      std::printf("%-*s %9s %10s %7s %8.1f  failed\n", columns, label.c_str(), "-", "-", "-", result.seconds);  // stderr says why
    else
      std::printf("%-*s %9u %10llu %7.1f %8.1f  %s\n", columns, label.c_str(), result.source_leaves,
                  static_cast<unsigned long long>(result.file_bytes), bytes_per_leaf(result), result.seconds, outcome_name(result.outcome));
  }
  const std::string jobs = batch.job_count == 0 ? "on the cluster" : std::to_string(batch.job_count) + " at a time";
  std::printf("%zu plants in %.1f s, %s: %zu baked, %zu cached, %zu failed\n", batch.plants.size(), batch.seconds, jobs.c_str(),
              count_of(batch, BatchOutcome::baked), count_of(batch, BatchOutcome::cached), count_of(batch, BatchOutcome::failed));
}

void print_reasons(const Batch& batch) {
  for (std::size_t i = 0; i < batch.plants.size(); ++i) {
    std::string text;
    for (const std::string& line : batch.results[i].because)
      text += (text.empty() ? plant_label(batch, i) + ": baked because " : "; ") + printable(line);
    if (!text.empty()) std::printf("%s\n", text.c_str());
  }
}

void print_cache_trouble(const CacheReport& report) {
  if (report.trouble.empty()) return;
  std::string lost;
  if (report.unsent > 0) lost = std::to_string(report.unsent) + (report.unsent == 1 ? " result was" : " results were") + " not kept in it";
  if (report.gave_up) lost += std::string(lost.empty() ? "" : ", ") + "it was asked no more";
  std::fprintf(stderr, "coppice: warning: cache %s: %s%s%s\n", printable(report.where).c_str(), printable(report.trouble).c_str(),
               lost.empty() ? "" : "; ", lost.c_str());
}

void print_failures(const Batch& batch, const std::filesystem::path& input) {
  constexpr std::size_t kColumns = 100, kMostNames = 8;
  std::vector<std::pair<std::string, std::vector<std::size_t>>> failures;  // plants with one error once, together
  for (std::size_t i = 0; i < batch.plants.size(); ++i) {
    if (batch.results[i].outcome != BatchOutcome::failed) continue;
    const std::string error = told_error(batch.plants[i], batch.results[i]);
    auto found = std::ranges::find(failures, error, &std::pair<std::string, std::vector<std::size_t>>::first);
    if (found == failures.end()) found = failures.insert(failures.end(), {error, {}});
    found->second.push_back(i);
  }
  for (const auto& [error, plants] : failures) {
    std::string names;
    for (std::size_t i = 0; i < std::min(plants.size(), kMostNames); ++i)
      names += (i > 0 ? ", " : "") + told_name(input, batch.plants[plants[i]]);
    if (plants.size() > kMostNames) names += " and " + std::to_string(plants.size() - kMostNames) + " more";
    std::fprintf(stderr, "%s\n", wrapped("coppice: " + names + ": not baked: " + printable(error), kColumns).c_str());
  }
}

}  // namespace coppice::bake
