// Prints what a shared cache costs: a request to nginx on the loopback address, and what a batch loses to each fault of a server.
//   cache_table            the table of tests/bench/results/cache.md

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake_cache.h"
#include "cache_courier.h"
#include "cache_server.h"
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

/// The entries that are not sent in time are sent by the next batch, as with a real one.
void print_request_cost(const fs::path& folder, std::size_t count, std::size_t bytes) {
  const coppice::test::Nginx nginx(folder / "nginx",
                                   "server { listen 8080; root /srv/coppice-cache; client_max_body_size 1g; location / { dav_methods PUT; "
                                   "create_full_put_path on; autoindex on; autoindex_format json; } }");
  const fs::path local = folder / "local";
  fs::create_directories(local);
  std::vector<std::string> keys;
  for (std::size_t i = 0; i < count; ++i) {
    const CachedBake entry = entry_of(i, bytes);
    keys.push_back(key_of(entry.parts));
    if (!store_cached(local, keys.back(), entry)) std::abort();
  }
  const auto start_courier = [&] { return *CacheCourier::start({nginx.url(), {}, CacheMode::read_write, local, 1}); };
  auto start = Clock::now();
  CacheReport sending;
  do {
    CacheCourier courier = start_courier();
    for (const std::string& key : keys) courier.line().offer(key);
    sending = courier.finish();
  } while (sending.unsent > 0);
  const double send_s = seconds_since(start);
  start = Clock::now();
  CacheCourier courier = start_courier();
  std::size_t found = 0;
  for (const std::string& key : keys) {
    const auto bundle = courier.line().fetch(key, {60.0, std::uint64_t{1} << 30});
    found += bundle && read_bundle(*bundle, key) ? 1u : 0u;
  }
  const double fetch_s = seconds_since(start);
  const CacheReport report = courier.finish();
  start = Clock::now();
  CacheCourier warm = start_courier();
  for (const std::string& key : keys) warm.line().offer(key);
  const std::uint64_t questions = warm.finish().requests;
  std::printf(
      "%zu entries of %zu bytes: send %.0f us each (HEAD, PUT, record), fetch %.0f us each, one at a time (%zu found, %llu "
      "requests); all there: %llu question, %.3f s\n",
      count, bytes, send_s / static_cast<double>(count) * 1e6, fetch_s / static_cast<double>(count) * 1e6, found,
      static_cast<unsigned long long>(report.requests), static_cast<unsigned long long>(questions), seconds_since(start));
  fs::remove_all(folder);
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
  /// Bakes everything. lost_s: of the batch's report  returns  the first line on stderr
  std::string bake(const std::vector<std::string>& more, double& lost_s) {
    const fs::path out = folder_ / ("out" + std::to_string(++count_)).c_str();
    const fs::path report = folder_ / "report.json";
    std::vector<std::string> arguments{"bake-all", plants_, "-o", out, "--views", "2", "--resolution", "64", "--report", report};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = coppice::test::run_process(coppice::test::kTool, arguments);
    std::ifstream file(report);
    const nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
    lost_s = json.is_object() ? json["cache"]["lost_seconds"].get<double>() : -1.0;
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
  std::printf("six hazels; lost: seconds of the batch's wall time\n");
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
    double lost_s = 0.0;
    if (fault.is_filled) {
      const FaultyServer server(objects);
      batches.bake({"--cache", server.url()}, lost_s);
    }
    const FaultyServer server(objects, fault.faults);
    const std::string says = batches.bake({"--cache", server.url()}, lost_s);
    std::printf("%-16s %4.2f s  %s\n", fault.name, lost_s, says.c_str());
    fs::remove_all(objects);
  }
  double lost_s = 0.0;
  const std::string says = batches.bake({"--cache", coppice::test::dead_url()}, lost_s);
  std::printf("%-16s %4.2f s  %s\n", "nobody listens", lost_s, says.c_str());
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
