#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cache_arguments.h"
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

Result<Said> stats(const CachePlace& place) {
  COPPICE_TRY(stats, cache_stats(place));
  const bool is_server = !place.location.url.empty();
  Said said;
  said.json = {{"entries", stats.entries}, {"bytes", stats.bytes}, {"oldest_s", stats.oldest_s}, {"newest_s", stats.newest_s}};
  said.text = entries_text(stats.entries, stats.bytes) + (stats.entries > 0 ? "\n" : ": empty, or no cache\n");
  if (stats.newest_s > 0)
    said.text += std::string(is_server ? "sent" : "last used") + " between " + date_text(stats.oldest_s) + " and " +
                 date_text(stats.newest_s) + " UTC\n";
  if (is_server) {
    said.json.update({{"has_index", stats.has_index}, {"unindexed", stats.unindexed}, {"misindexed", stats.misindexed}});
    if (!stats.has_index)
      said.text += "there is no index: coppice cache index makes one\n";
    else if (stats.unindexed > 0 || stats.misindexed > 0)
      said.text += "the index lacks " + std::to_string(stats.unindexed) + " of them, and names " + std::to_string(stats.misindexed) +
                   " that are not there\n";
    else
      said.text += "the index is complete\n";
    return said;
  }
  said.json.update({{"versions", stats.versions}, {"stray_files", stats.stray_files}});
  for (const auto& [version, count] : stats.versions)
    said.text += std::to_string(count) + " by version " + printable(version) + " of the baker\n";
  if (stats.stray_files > 0) said.text += std::to_string(stats.stray_files) + " files of no entry, which prune removes after an hour\n";
  return said;
}

Result<Said> verify(const CachePlace& place, bool remove_damaged) {
  ProgressBar bar(ProgressBar::Visibility::on_terminal);
  COPPICE_TRY(found, verify_cache(place, remove_damaged, [&bar](std::uint64_t done, std::uint64_t of) {
                bar.show("verify", static_cast<double>(done) / static_cast<double>(of));
              }));
  bar.clear();
  Said said;
  said.json = {{"entries", found.entries},
               {"bytes", found.bytes},
               {"damaged", found.damaged},
               {"unreadable", found.unreadable},
               {"removed", found.removed}};
  for (const std::string& key : found.damaged) said.text += key + ": damaged" + (remove_damaged ? ", removed" : "") + "\n";
  for (const std::string& key : found.unreadable) said.text += key + ": cannot be read\n";
  said.text += entries_text(found.entries, found.bytes) + ": " + std::to_string(found.damaged.size()) + " damaged, " +
               std::to_string(found.unreadable.size()) + " unreadable\n";
  said.exit_code = found.damaged.size() > found.removed || !found.unreadable.empty() ? 1 : 0;
  return said;
}

Result<Said> prune(const CachePlace& place, double max_gb) {
  COPPICE_TRY(pruning, prune_cache(place, static_cast<std::uint64_t>(max_gb * 1e9)));
  Said said;
  said.json = {{"entries", pruning.entries},
               {"bytes", pruning.bytes},
               {"removed_entries", pruning.removed_entries},
               {"removed_bytes", pruning.removed_bytes}};
  said.text = "removed " + entries_text(pruning.removed_entries, pruning.removed_bytes) + "; " +
              entries_text(pruning.entries, pruning.bytes) + " stay\n";
  return said;
}

Result<Said> index(const CachePlace& place) {
  COPPICE_TRY(entries, rebuild_index(place));
  return Said{{{"entries", entries}}, "the index has " + std::to_string(entries) + (entries == 1 ? " entry\n" : " entries\n")};
}

Result<Said> act(const CacheCommand& arguments) {
  COPPICE_TRY(location, parse_cache_location(arguments.where));
  COPPICE_TRY(credentials, credentials_of_environment());
  const CachePlace place{std::move(location), std::move(credentials)};
  if (arguments.action == "verify") return verify(place, arguments.remove_damaged);
  if (arguments.action == "prune") return prune(place, arguments.max_gb);
  return arguments.action == "index" ? index(place) : stats(place);
}

int run(const CacheCommand& arguments) {
  const auto said = act(arguments);
  if (!said) return report_failure("cache", said.error());
  const std::string text = arguments.json ? said->json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n" : said->text;
  std::fputs(text.c_str(), stdout);
  return said->exit_code;
}

}  // namespace

void add_cache_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<CacheCommand>();
  CLI::App* command = app.add_subcommand("cache", "Look after a cache of bake-all: what is in it, whether it is whole, less of it");
  command->footer(
      "stats says how much there is, verify reads every entry and compares checksums (exit code 1 if any is damaged), prune removes the "
      "entries that were used longest ago, and index writes the index of a server anew. All are safe beside running bakes: an entry that "
      "is gone is baked again.\n"
      "A server must list its folders (nginx: autoindex on; autoindex_format json;) and, for prune and --remove-damaged, take DELETE. It "
      "does not know when entries were used: there prune removes those sent longest ago.\n"
      "  coppice cache stats baked/.coppice-cache\n"
      "  coppice cache prune --max-gb 50 /mnt/studio/coppice-cache\n"
      "  coppice cache verify --json https://cache.studio.example/coppice");
  command->add_option("action", arguments->action, "What to do")
      ->required()
      ->check(CLI::IsMember({"stats", "verify", "prune", "index"}))
      ->type_name("stats|verify|prune|index");
  command->add_option("where", arguments->where, "The cache; without it that of COPPICE_CACHE")
      ->type_name("FOLDER|URL")
      ->envname(kCacheVariable);
  command->add_option("--max-gb", arguments->max_gb, "prune: leave at most so many gigabytes, 10^9 bytes each")
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("N");
  command->add_flag("--remove-damaged", arguments->remove_damaged, "verify: remove what is damaged");
  command->add_flag("--json", arguments->json, "As JSON");
  command->callback([arguments, exit_code] {
    if (arguments->where.empty()) throw CLI::ValidationError("where", "name a folder or an address, or set COPPICE_CACHE");
    if (arguments->action == "prune" && arguments->max_gb < 0.0) throw CLI::ValidationError("--max-gb", "prune needs it");
    *exit_code = run(*arguments);
  });
}

}  // namespace coppice::bake
