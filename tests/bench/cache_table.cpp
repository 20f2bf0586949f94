// Prints what a shared cache costs: a request to nginx on the loopback address, and what a batch loses to each fault of a server.
//   cache_table            the table of tests/bench/results/cache.md

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>

#include "bake_cache.h"
#include "http_cache.h"
#include "servers.h"
#include "stopwatch.h"
#include "tool.h"

namespace {

namespace fs = std::filesystem;
using namespace coppice::bake;
using namespace coppice::test;

void print_request_cost(const fs::path& folder, std::size_t count, std::size_t bytes) {
  const Nginx nginx(folder, "server { listen 8080; root /srv/coppice-cache; client_max_body_size 1g; location / { dav_methods PUT; } }");
  HttpCache cache(nginx.url(), {}, 60.0);
  const auto microseconds_each = [&](auto use) {
    const Stopwatch watch;
    for (std::size_t i = 0; i < count; ++i) {
      CachedBake entry;
      entry.bytes.assign(bytes, static_cast<std::uint8_t>(i));
      entry.parts = {{"name", "", std::to_string(i)}};
      if (!use(key_of(entry.parts), entry)) std::abort();
    }
    return watch.seconds() / static_cast<double>(count) * 1e6;
  };
  const double send =
      microseconds_each([&](const std::string& key, const CachedBake& entry) { return static_cast<bool>(cache.put(key, entry, {})); });
  const double fetch = microseconds_each([&](const std::string& key, const CachedBake&) {
    const auto found = cache.get(key, {});
    return found && *found;
  });
  std::printf("%zu entries of %zu bytes: send %.0f us each, fetch %.0f us each, one at a time over one connection\n", count, bytes, send,
              fetch);
}

/// Bakes six hazels with a cache's options, and prints the seconds of wall time and the first line on stderr.
void print_row(const fs::path& plants, const std::string& name, const Words& cache) {
  const TemporaryFolder out;
  const Stopwatch watch;
  const auto result = run_tool(joined({"bake-all", plants, "-o", out.path(), "--views", "2", "--resolution", "64"}, cache));
  const double seconds = watch.seconds();
  const std::string said = (result.exit_code == 0 ? "" : "FAILED: ") + result.err;
  std::printf("%-40s %5.2f s  %s\n", name.c_str(), seconds, said.substr(0, said.find('\n')).c_str());
}

void print_faults(const fs::path& folder) {
  const fs::path plants = folder / "plants";
  fs::create_directories(plants);
  for (const std::string seed : {"1", "2", "3", "4", "5", "6"})
    run_tool({"plant", "corylus", "--seed", seed, "-o", plants / ("hazel" + seed + ".glb")});
  print_row(plants, "no cache", {"--no-cache"});
  const TemporaryFolder objects;
  for (const char* const name : {"none, empty", "none, all there"})
    print_row(plants, name, {"--cache", FaultyServer(objects.path()).url()});
  std::vector<ServerFault> all = all_server_faults();
  all.push_back(late_server());
  for (const ServerFault& fault : all) print_row(plants, fault.name, {"--cache", FaultyServer(objects.path(), fault).url()});
  print_row(plants, "nobody listens", {"--cache", dead_url()});
}

}  // namespace

int main() {
  static_cast<void>(std::setvbuf(stdout, nullptr, _IOLBF, 0));
  try {
    const TemporaryFolder folder;
    if (Nginx::is_there()) {
      print_request_cost(folder / "small", 500, 1'000);
      print_request_cost(folder / "medium", 100, 300'000);
    }
    print_faults(folder.path());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cache_table: %s\n", error.what());
    return 1;
  }
}
