#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cache_location.h"
#include "cache_upkeep.h"
#include "commands.h"
#include "output.h"
#include "printable.h"
#include "progress_bar.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::ordered_json;

struct CacheCommand {
  std::string action, where;
  double max_gb = -1.0;
  bool remove_damaged = false, json = false;
};

/// What a command says: for a machine and for a person.
struct Said {  // NOLINT(bugprone-exception-escape): that of moved JSON is taken to throw
  Json json;
  std::string text;
  int exit_code = 0;
};

/// "2026-11-26 22:07"
std::string date_text(std::int64_t seconds) {
  const auto time = static_cast<std::time_t>(seconds);
  std::tm date{};
  std::array<char, 32> text{};
  if (::gmtime_r(&time, &date) == nullptr) return "unknown";
  static_cast<void>(std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M", &date));
  return text.data();
}

std::string entries_text(std::uint64_t entries, std::uint64_t bytes) {
  return std::to_string(entries) + (entries == 1 ? " entry, " : " entries, ") + readable_bytes(bytes);
}

Result<Said> stats(const std::filesystem::path& folder) {
  COPPICE_TRY(stats, cache_stats(folder));
  Said said;
  said.json = {{"entries", stats.entries},   {"bytes", stats.bytes},       {"oldest_s", stats.oldest_s},
               {"newest_s", stats.newest_s}, {"versions", stats.versions}, {"stray_files", stats.stray_files}};
  said.text = entries_text(stats.entries, stats.bytes) + (stats.entries > 0 ? "\n" : ": empty, or no cache\n");
  if (stats.newest_s > 0) said.text += "last used between " + date_text(stats.oldest_s) + " and " + date_text(stats.newest_s) + " UTC\n";
  for (const auto& [version, count] : stats.versions)
    said.text += std::to_string(count) + " by version " + printable(version) + " of the baker\n";
  if (stats.stray_files > 0) said.text += std::to_string(stats.stray_files) + " files of no entry, which prune removes after an hour\n";
  return said;
}

Result<Said> verify(const std::filesystem::path& folder, bool remove_damaged) {
  ProgressBar bar(ProgressBar::Visibility::on_terminal);
  COPPICE_TRY(found, verify_cache(folder, remove_damaged, [&bar](std::uint64_t done, std::uint64_t of) {
                bar.show("verify", static_cast<double>(done) / static_cast<double>(of));
              }));
  bar.clear();
  Said said;
  said.json = {{"entries", found.entries},       {"bytes", found.bytes},         {"damaged", found.damaged},
               {"unreadable", found.unreadable}, {"too_large", found.too_large}, {"removed", found.removed}};
  for (const std::string& key : found.damaged) said.text += key + ": damaged" + (remove_damaged ? ", removed" : "") + "\n";
  for (const std::string& key : found.unreadable) said.text += key + ": cannot be read\n";
  for (const std::string& key : found.too_large) said.text += key + ": not read, as bakes take no file over 1 GiB\n";
  said.text += entries_text(found.entries, found.bytes) + ": " + std::to_string(found.damaged.size()) + " damaged, " +
               std::to_string(found.unreadable.size()) + " unreadable\n";
  said.exit_code = found.damaged.size() > found.removed || !found.unreadable.empty() ? 1 : 0;
  return said;
}

Result<Said> prune(const std::filesystem::path& folder, double max_gb) {
  COPPICE_TRY(pruning, prune_cache(folder, static_cast<std::uint64_t>(max_gb * 1e9)));
  Said said;
  said.json = {{"entries", pruning.entries},
               {"bytes", pruning.bytes},
               {"removed_entries", pruning.removed_entries},
               {"removed_bytes", pruning.removed_bytes}};
  said.text = "removed " + entries_text(pruning.removed_entries, pruning.removed_bytes) + "; " +
              entries_text(pruning.entries, pruning.bytes) + " stay\n";
  return said;
}

Result<Said> act(const CacheCommand& arguments) {
  COPPICE_TRY(location, parse_cache_location(arguments.where));
  if (!location.url.empty())
    return Error{Status::invalid_argument, "a server's cache is looked after on the server, in its folder", Error::kNoOffset, location.url};
  if (arguments.action == "verify") return verify(location.folder, arguments.remove_damaged);
  return arguments.action == "prune" ? prune(location.folder, arguments.max_gb) : stats(location.folder);
}

int run(const CacheCommand& arguments) {
  const auto said = act(arguments);
  if (!said) return report_failure("cache", said.error());
  const std::string text = arguments.json ? json_file(said->json) : said->text;
  std::fputs(text.c_str(), stdout);
  return said->exit_code;
}

}  // namespace

void add_cache_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<CacheCommand>();
  CLI::App* command = app.add_subcommand("cache", "Look after a cache of bake-all: what is in it, whether it is whole, less of it");
  command->footer(
      "stats says how much there is, verify reads every entry and compares checksums (exit code 1 if any is damaged), and prune removes "
      "the entries that were used longest ago. All are safe beside running bakes: an entry that is gone is baked again.\n"
      "The cache of a server is looked after there, in its folder.\n"
      "  coppice cache stats baked/.coppice-cache\n"
      "  coppice cache prune --max-gb 50 /mnt/studio/coppice-cache");
  command->add_option("action", arguments->action, "What to do")
      ->required()
      ->check(CLI::IsMember({"stats", "verify", "prune"}))
      ->type_name("stats|verify|prune");
  command->add_option("where", arguments->where, "The cache; without it that of COPPICE_CACHE")
      ->type_name("FOLDER")
      ->envname(kCacheVariable);
  command->add_option("--max-gb", arguments->max_gb, "prune: leave at most so many gigabytes, 10^9 bytes each")
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("N");
  command->add_flag("--remove-damaged", arguments->remove_damaged, "verify: remove what is damaged");
  command->add_flag("--json", arguments->json, "As JSON");
  command->callback([arguments, exit_code] {
    if (arguments->where.empty()) throw CLI::ValidationError("where", "name a folder, or set COPPICE_CACHE");
    if (arguments->action == "prune" && arguments->max_gb < 0.0) throw CLI::ValidationError("--max-gb", "prune needs it");
    *exit_code = run(*arguments);
  });
}

}  // namespace coppice::bake
