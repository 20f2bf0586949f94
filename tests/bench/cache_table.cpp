// Prints what a shared cache costs: a request to nginx on the loopback address, and what a batch loses to each fault of a server.
//   cache_table            the table of tests/bench/results/cache.md

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bake_cache.h"
#include "cache_server.h"
#include "http_cache.h"
#include "places.h"
#include "process.h"

namespace {

namespace fs = std::filesystem;
using namespace coppice::bake;
using coppice::test::FaultyServer;
using coppice::test::ServerFaults;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

CachedBake entry_of(std::size_t number, std::size_t bytes) {
  CachedBake entry;
  entry.bytes.assign(bytes, static_cast<std::uint8_t>(number));
  entry.parts = {{"name", "", std::to_string(number)}};
  return entry;
}

void print_request_cost(const fs::path& folder, std::size_t count, std::size_t bytes) {
  const coppice::test::Nginx nginx(folder / "nginx",
                                   "server { listen 8080; root /srv/coppice-cache; client_max_body_size 1g; location / { dav_methods PUT; "
                                   "create_full_put_path on; } }");
  HttpCache cache(nginx.url(), {});
  auto start = Clock::now();
  for (std::size_t i = 0; i < count; ++i)
    if (const CachedBake entry = entry_of(i, bytes); !cache.put(key_of(entry.parts), entry)) std::abort();
  const double send_s = seconds_since(start);
  start = Clock::now();
  for (std::size_t i = 0; i < count; ++i)
    if (const auto found = cache.get(key_of(entry_of(i, bytes).parts), std::uint64_t{1} << 30); !found || !*found) std::abort();
  const double fetch_s = seconds_since(start);
  std::printf("%zu entries of %zu bytes: send %.0f us each, fetch %.0f us each, one at a time over one connection\n", count, bytes,
              send_s / static_cast<double>(count) * 1e6, fetch_s / static_cast<double>(count) * 1e6);
}

struct Fault {
  const char* name;
  ServerFaults faults;
  bool is_filled;
};

class Batches {
 public:
  Batches() {
    for (int seed = 1; seed <= 6; ++seed) {
      const std::string name = "hazel" + std::to_string(seed) + ".glb";
      coppice::test::run_process(coppice::test::kTool, {"plant", "corylus", "--seed", std::to_string(seed), "-o", plants_ / name});
    }
  }
  /// Bakes everything. seconds: of wall time. returns  the first line on stderr
  std::string bake(const std::vector<std::string>& more, double& seconds) {
    const fs::path out = folder_ / ("out" + std::to_string(++count_)).c_str();
    std::vector<std::string> arguments{"bake-all", plants_, "-o", out, "--views", "2", "--resolution", "64"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto start = Clock::now();
    const auto result = coppice::test::run_process(coppice::test::kTool, arguments);
    seconds = seconds_since(start);
    fs::remove_all(out);
    std::string last = result.exit_code == 0 ? result.err : "FAILED: " + result.err;
    return last.substr(0, last.find('\n'));
  }
  [[nodiscard]] fs::path folder() const { return folder_.path(); }

 private:
  coppice::test::TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants";
  int count_ = 0;
};

void print_faults() {
  Batches batches;
  double alone_s = 0.0;
  batches.bake({"--no-cache"}, alone_s);
  std::printf("six hazels; seconds of wall time, without a cache %.2f s\n", alone_s);
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
    double seconds = 0.0;
    if (fault.is_filled) {
      const FaultyServer server(objects);
      batches.bake({"--cache", server.url()}, seconds);
    }
    const FaultyServer server(objects, fault.faults);
    const std::string says = batches.bake({"--cache", server.url()}, seconds);
    std::printf("%-16s %5.2f s  %s\n", fault.name, seconds, says.c_str());
    fs::remove_all(objects);
  }
  double seconds = 0.0;
  const std::string says = batches.bake({"--cache", coppice::test::dead_url()}, seconds);
  std::printf("%-16s %5.2f s  %s\n", "nobody listens", seconds, says.c_str());
}

}  // namespace

int main() {
  static_cast<void>(std::setvbuf(stdout, nullptr, _IOLBF, 0));
  try {
    const coppice::test::TemporaryFolder folder;
    if (coppice::test::Nginx::is_there()) {
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
