#include "cache_arguments.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "printable.h"

namespace coppice::bake {

void add_cache_options(CLI::App& command, CacheArguments& arguments) {
  command
      .add_option("--cache", arguments.where,
                  "A cache that people and machines share: a folder, in place of OUT/.coppice-cache, or an address like "
                  "https://host/path, behind it; without it that of COPPICE_CACHE. Credentials are in COPPICE_CACHE_CREDENTIALS "
                  "(USER:PASSWORD or Bearer TOKEN) or "
                  "~/.netrc. A cache that is of no use costs seconds, and no plant")
      ->type_name("FOLDER|URL")
      ->envname(kCacheVariable);
  command.add_option("--cache-mode", arguments.mode, "Whether results are sent to the shared cache, or it is only read")
      ->check(CLI::IsMember({"read", "read-write"}))
      ->type_name("read|read-write")
      ->capture_default_str();
  command.add_flag("--no-cache", arguments.none, "Bake everything and keep nothing but the outputs");
  command.add_flag("--explain", arguments.explain,
                   "Say why each plant was baked: what its key differs in from the nearest entry in the cache");
}

void check_cache_arguments(const CacheArguments& arguments) {
  if (arguments.mode == "read" && arguments.where.empty())
    throw CLI::ValidationError("--cache-mode", std::string("there is no shared cache: name one with --cache or ") + kCacheVariable);
}

Result<void> set_caches(const CacheArguments& arguments, const std::filesystem::path& output, BatchOptions& options) {
  options.explain = arguments.explain;
  if (arguments.none) return {};
  options.cache = output / kOwnCache;
  if (arguments.where.empty()) return {};
  COPPICE_TRY(location, parse_cache_location(arguments.where));
  COPPICE_TRY(credentials, credentials_of_environment());
  options.shared = {std::move(location), arguments.mode == "read" ? CacheMode::read : CacheMode::read_write, std::move(credentials)};
  return {};
}

std::vector<std::string> shared_cache_options(const CacheArguments& arguments) {
  // Nothing of an address that nobody has looked at.
  if (arguments.none || arguments.where.empty()) return {};
  return {"--cache-mode", arguments.mode, "--cache", arguments.where};
}

nlohmann::ordered_json cache_json(const CacheReport& report) {
  return {{"where", report.where},   {"found", report.found},     {"lacking", report.lacking}, {"sent", report.sent},
          {"unsent", report.unsent}, {"gave_up", report.gave_up}, {"trouble", report.trouble}};
}

void print_cache_trouble(const CacheReport& report) {
  if (report.trouble.empty()) return;
  std::string lost;
  if (report.unsent > 0) lost = std::to_string(report.unsent) + (report.unsent == 1 ? " result was" : " results were") + " not kept in it";
  if (report.gave_up) lost += std::string(lost.empty() ? "" : ", ") + "it was asked no more";
  std::fprintf(stderr, "coppice: warning: cache %s: %s%s%s\n", printable(report.where).c_str(), printable(report.trouble).c_str(),
               lost.empty() ? "" : "; ", lost.c_str());
}

std::string because_text(const std::string& name, const BatchResult& result) {
  std::string text;
  for (const std::string& line : result.because) text += (text.empty() ? name + ": baked because " : "; ") + printable(line);
  return text.empty() ? text : text + "\n";
}

}  // namespace coppice::bake
