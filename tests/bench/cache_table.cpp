// Prints what a shared cache costs: a request to nginx on the loopback address, and what a batch loses to each fault of a server.
//   cache_table            the table of tests/bench/results/cache.md

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bake_cache.h"
#include "cache_server.h"
#include "http_cache.h"
#include "stopwatch.h"
#include "tool.h"

namespace {

namespace fs = std::filesystem;
using namespace coppice::bake;
using namespace coppice::test;

CachedBake entry_of(std::size_t number, std::size_t bytes) {
  CachedBake entry;
  entry.bytes.assign(bytes, static_cast<std::uint8_t>(number));
  entry.parts = {{"name", "", std::to_string(number)}};
  return entry;
}

void print_request_cost(const fs::path& folder, std::size_t count, std::size_t bytes) {
  const Nginx nginx(folder / "nginx",
                    "server { listen 8080; root /srv/coppice-cache; client_max_body_size 1g; location / { dav_methods PUT; "
                    "create_full_put_path on; } }");
  HttpCache cache(nginx.url(), {});
  Stopwatch watch;
  for (std::size_t i = 0; i < count; ++i)
    if (const CachedBake entry = entry_of(i, bytes); !cache.put(key_of(entry.parts), entry)) std::abort();
  const double send_s = watch.seconds();
  watch = {};
  for (std::size_t i = 0; i < count; ++i)
    if (const auto found = cache.get(key_of(entry_of(i, bytes).parts), std::uint64_t{1} << 30); !found || !*found) std::abort();
  const double fetch_s = watch.seconds();
  std::printf("%zu entries of %zu bytes: send %.0f us each, fetch %.0f us each, one at a time over one connection\n", count, bytes,
              send_s / static_cast<double>(count) * 1e6, fetch_s / static_cast<double>(count) * 1e6);
}

class Batches {
 public:
  Batches() {
    for (const std::string seed : {"1", "2", "3", "4", "5", "6"})
      run_tool({"plant", "corylus", "--seed", seed, "-o", plants_ / ("hazel" + seed + ".glb")});
  }
  /// Bakes everything. returns  seconds of wall time, and the first line on stderr
  std::pair<double, std::string> bake(const Words& more) {
    const fs::path out = folder_ / ("out" + std::to_string(++count_)).c_str();
    const Stopwatch watch;
    const auto result = run_tool(joined({"bake-all", plants_, "-o", out, "--views", "2", "--resolution", "64"}, more));
    const double seconds = watch.seconds();
    fs::remove_all(out);
    const std::string said = result.exit_code == 0 ? result.err : "FAILED: " + result.err;
    return {seconds, said.substr(0, said.find('\n'))};
  }
  void print_row(const char* name, const std::string& url) {
    const auto [seconds, says] = bake({"--cache", url});
    std::printf("%-16s %5.2f s  %s\n", name, seconds, says.c_str());
  }
  [[nodiscard]] fs::path folder() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants";
  int count_ = 0;
};

void print_faults() {
  Batches batches;
  std::printf("six hazels; seconds of wall time, without a cache %.2f s\n", batches.bake({"--no-cache"}).first);
  struct Fault {
    const char* name;
    ServerFaults faults;
    bool is_filled;
  };
  const std::vector<Fault> faults = {{"none, empty", {}, false},
                                     {"none, all there", {}, true},
                                     {"503", {.get_status = 503, .put_status = 503}, false},
                                     {"403", {.get_status = 403, .put_status = 403}, false},
                                     {"404 to all", {.get_status = 404, .put_status = 404}, false},
                                     {"full: 507", {.put_status = 507}, false},
                                     {"half a body", {.half_bodies = true}, true},
                                     {"wrong bytes", {.wrong_bytes = true}, true},
                                     {"20 s of delay", {.delay_s = 20.0}, true},
                                     {"1 s of delay", {.delay_s = 1.0}, false}};
  for (const Fault& fault : faults) {
    const fs::path objects = batches.folder() / "objects";
    if (fault.is_filled) {
      const FaultyServer server(objects);
      batches.bake({"--cache", server.url()});
    }
    const FaultyServer server(objects, fault.faults);
    batches.print_row(fault.name, server.url());
    fs::remove_all(objects);
  }
  batches.print_row("nobody listens", dead_url());
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
    print_faults();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cache_table: %s\n", error.what());
    return 1;
  }
}
