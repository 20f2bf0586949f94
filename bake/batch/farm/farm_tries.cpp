#include "farm_tries.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "cache_report_json.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// "001-0017.…" -> 1 and 17.
bool read_name(std::string_view name, TaskTry& made) {
  const char* const end = name.data() + name.size();
  const auto [dash, bad_submission] = std::from_chars(name.data(), end, made.submission);
  if (bad_submission != std::errc() || dash == end || *dash != '-') return false;
  const auto [dot, bad_task] = std::from_chars(dash + 1, end, made.task);
  return bad_task == std::errc() && dot != end && *dot == '.';
}

Json small_json(const fs::path& path) {
  constexpr std::uint64_t kMostBytes = 4096;
  const auto bytes = read_file(path, kMostBytes);
  return bytes ? Json::parse(bytes->begin(), bytes->end(), nullptr, false) : Json(Json::value_t::discarded);
}

std::optional<TaskTry> read_start(const fs::path& path) {
  TaskTry made;
  const Json json = small_json(path);
  if (!json.is_object() || !read_name(path.filename().native(), made)) return {};
  try {
    made.node = json.at("node").get<std::string>();
    made.job = json.at("job").get<std::string>();
    made.array_job = json.at("array_job").get<std::string>();
    made.started_s = json.at("time").get<double>();
  } catch (const Json::exception&) {
    return {};
  }
  made.log = path;
  made.log.replace_extension(".log");
  return made;
}

/// The journal's whole lines that have not been read yet. returns  whether it could be read
bool read_journal(const fs::path& path, const std::string& name, TaskTry& of, std::vector<TriedPlant>& plants) {
  const auto bytes = read_file(path);
  if (!bytes) return false;
  if (bytes->size() <= of.read_bytes) return true;
  const std::string text(bytes->begin() + static_cast<std::ptrdiff_t>(of.read_bytes), bytes->end());
  std::size_t at = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', at)) {
    if (auto entry = journal_entry(std::string_view(text).substr(at, end - at))) plants.push_back({name, *std::move(entry)});
    at = end + 1;
  }
  of.read_bytes += at;
  return true;
}

}  // namespace

std::vector<TriedPlant> read_tries(const fs::path& run_folder, Tries& tries) {
  const fs::path folder = run_folder / "tries";
  std::vector<fs::path> starts, journals, ends;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path extension = entry->path().extension();
    if (extension == ".start" && !tries.contains(entry->path().stem())) starts.push_back(entry->path());
    if (extension == ".plants") journals.push_back(entry->path());
    if (extension == ".end") ends.push_back(entry->path());
  }
  for (const fs::path& path : starts)
    if (auto made = read_start(path)) tries.emplace(path.stem(), *std::move(made));
  // Ends before journals: whoever has ended has written all of its journal.
  for (const fs::path& path : ends) {
    const auto found = tries.find(path.stem());
    if (found == tries.end() || found->second.exit_code) continue;
    const Json json = small_json(path);
    if (!json.is_object() || !json.contains("exit") || !json["exit"].is_number_integer()) continue;
    found->second.exit_code = json["exit"].get<int>();
    if (json.contains("time") && json["time"].is_number()) found->second.ended_s = json["time"].get<double>();
  }
  std::ranges::sort(journals);
  std::vector<TriedPlant> plants;
  for (const fs::path& path : journals) {
    const auto found = tries.find(path.stem());
    if (found == tries.end() || found->second.is_read) continue;
    TaskTry& of = found->second;
    // A network file system knows the size of a file that has ended growing for certain when it opens it.
    const bool has_ended = of.exit_code.has_value();
    if (has_ended || bytes_of_file(path) > of.read_bytes) of.is_read = read_journal(path, found->first, of, plants) && has_ended;
  }
  return plants;
}

void add_cache_report(CacheReport& sum, const CacheReport& of) {
  if (sum.where.empty()) sum.where = of.where;
  if (sum.trouble.empty()) sum.trouble = of.trouble;
  sum.found += of.found, sum.lacking += of.lacking, sum.sent += of.sent, sum.requests += of.requests;
  sum.unasked += of.unasked, sum.unsent += of.unsent, sum.damaged += of.damaged;
  sum.lost_seconds += of.lost_seconds;
  sum.gave_up |= of.gave_up;
}

CacheReport read_task_caches(const fs::path& run_folder, const std::string& where) {
  std::vector<fs::path> reports;
  std::error_code error;
  for (fs::directory_iterator entry(run_folder / "tries", error), end; !error && entry != end; entry.increment(error))
    if (entry->path().extension() == ".report") reports.push_back(entry->path());
  std::ranges::sort(reports);
  CacheReport sum;
  for (const fs::path& path : reports) {
    const auto bytes = read_file(path);
    const Json json = bytes ? Json::parse(bytes->begin(), bytes->end(), nullptr, false) : Json();
    if (!json.is_object() || !json.contains("cache")) continue;
    try {
      CacheReport of = json["cache"].get<CacheReport>();
      if (of.where != where) continue;
      if (!of.trouble.empty()) of.trouble += " (" + path.stem().string() + ")";
      add_cache_report(sum, of);
    } catch (const Json::exception&) {
      continue;
    }
  }
  return sum;
}

void refresh_tries(const fs::path& run_folder) {
  const fs::path path = run_folder / "tries" / "refresh";
  std::ofstream(path).close();
  std::error_code gone;
  fs::remove(path, gone);
}

std::string tail_of(const fs::path& file) {
  constexpr std::streamoff kMostBytes = 4096;
  std::ifstream text(file, std::ios::binary | std::ios::ate);
  text.seekg(-std::min<std::streamoff>(kMostBytes, text.tellg()), std::ios::end);
  return {std::istreambuf_iterator<char>(text), {}};
}

}  // namespace coppice::bake
