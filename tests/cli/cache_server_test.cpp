// A cache on a server: a server of ours that does wrong on purpose, and nginx as bake/README.md sets it up. What a cache may cost is
// measured elsewhere (tests/bench/results); here a fault must neither fail a plant nor hang.

#include <sys/mount.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bake_cache.h"
#include "cache_courier.h"
#include "cache_index.h"
#include "cache_server.h"
#include "documents.h"
#include "gltf_builder.h"
#include "mentions.h"
#include "places.h"
#include "process.h"
#include "text_bytes.h"
#include "text_files.h"

namespace cache_server_test {

namespace fs = std::filesystem;
using coppice::bake::CacheCourier;
using coppice::bake::CachedBake;
using coppice::bake::CacheReport;
using coppice::test::FaultyServer;
using coppice::test::lines_that_name;
using coppice::test::mentions;
using coppice::test::Nginx;
using coppice::test::outputs;
using coppice::test::ProcessResult;
using coppice::test::read_text;
using coppice::test::ServerFaults;
using coppice::test::TemporaryFolder;
using coppice::test::write_text;

std::size_t count_of(const std::vector<std::string>& lines, const std::string& begin) {
  return static_cast<std::size_t>(std::ranges::count_if(lines, [&](const std::string& line) { return line.starts_with(begin); }));
}

// The cache's process alone, with entries that nobody baked. It is forked: before anything here starts a thread.

CachedBake some_entry(std::size_t number) {
  CachedBake entry;
  entry.bytes.assign(1000 + number, static_cast<std::uint8_t>(number));
  entry.parts = {{"name", "", std::to_string(number)}};
  return entry;
}

constexpr coppice::bake::EntryWorth kWorth{60.0, std::uint64_t{1} << 20};

std::string key_of_entry(std::size_t number) {
  return coppice::bake::key_of(some_entry(number).parts);
}

class Courier : public testing::Test {
 protected:
  /// A folder that has entries 0 .. count - 1.
  void store(std::size_t count) {
    fs::create_directories(local_);
    for (std::size_t i = 0; i < count; ++i) ASSERT_TRUE(coppice::bake::store_cached(local_, key_of_entry(i), some_entry(i)));
  }
  CacheCourier start(const std::string& url, coppice::bake::CacheMode mode = coppice::bake::CacheMode::read_write) {
    auto courier = CacheCourier::start({url, {}, mode, local_, 2});
    if (!courier) throw std::runtime_error(courier.error().message());
    return *std::move(courier);
  }
  CacheReport send(const std::string& url, std::size_t count) {
    CacheCourier courier = start(url);
    for (std::size_t i = 0; i < count; ++i) courier.line().offer(key_of_entry(i));
    return courier.finish();
  }

  CacheReport report_;
  TemporaryFolder folder_;
  fs::path local_ = folder_ / "local", objects_ = folder_ / "objects";
};

TEST_F(Courier, OneOfAHundredEntriesPoisonedIsNoticedAndReplaced) {
  constexpr std::size_t kCount = 200;
  store(kCount);
  const FaultyServer server(objects_);
  // Short of time not all may be sent at once; what is left is sent the next time.
  for (int i = 0; i < 20 && send(server.url(), kCount).unsent > 0; ++i) {
  }
  for (const std::size_t poisoned : {17u, 117u}) {
    const fs::path object = objects_ / coppice::bake::entry_url("", key_of_entry(poisoned)).substr(1);
    std::string bytes = read_text(object);
    ASSERT_FALSE(bytes.empty());
    bytes[bytes.size() / 2] ^= 4;
    write_text(object, bytes);
  }
  const auto fetch_all = [&] {
    CacheCourier courier = start(server.url());
    for (std::size_t i = 0; i < kCount; ++i) {
      const auto bundle = courier.line().fetch(key_of_entry(i), kWorth);
      EXPECT_TRUE(bundle) << i;
      const auto entry = bundle ? coppice::bake::read_bundle(*bundle, key_of_entry(i)) : coppice::Error{};
      EXPECT_EQ(!entry, bundle && i % 100 == 17 && report_.found == 0) << i;
      if (entry) {
        EXPECT_EQ(entry->bytes, some_entry(i).bytes);
        continue;
      }
      for (int plants = 0; plants < 2; ++plants) courier.line().found_damaged(key_of_entry(i));  // of one key
      courier.line().offer(key_of_entry(i));
    }
    report_ = courier.finish();
  };
  fetch_all();
  EXPECT_EQ(report_.found, kCount - 2);
  EXPECT_EQ(report_.damaged, 2u);
  EXPECT_EQ(report_.sent, 2u);
  EXPECT_EQ(report_.unasked, 0u);
  fetch_all();
  EXPECT_EQ(report_.found, kCount);
  EXPECT_EQ(report_.damaged, 0u);
  EXPECT_EQ(report_.sent, 0u);
}

TEST_F(Courier, AnEmptyEntryIsDamagedAndReplaced) {
  store(4);
  const FaultyServer server(objects_);
  ASSERT_EQ(send(server.url(), 4).sent, 4u);
  const fs::path object = objects_ / coppice::bake::entry_url("", key_of_entry(2)).substr(1);
  write_text(object, "");
  CacheCourier courier = start(server.url());
  EXPECT_FALSE(courier.line().fetch(key_of_entry(2), kWorth));
  courier.line().offer(key_of_entry(2));
  const CacheReport report = courier.finish();
  EXPECT_EQ(report.damaged, 1u);
  EXPECT_EQ(report.found, 0u);
  EXPECT_EQ(report.sent, 1u);
  const std::string text = read_text(object);
  EXPECT_TRUE(coppice::bake::read_bundle(coppice::bake::bytes_of(text), key_of_entry(2)));
}

TEST_F(Courier, AnEntryThatIsTooLargeIsNotReadAndReplaced) {
  store(2);
  {
    const FaultyServer server(objects_);
    ASSERT_EQ(send(server.url(), 2).sent, 2u);
  }
  const FaultyServer server(objects_, {.padding_bytes = 2u << 20});
  CacheCourier courier = start(server.url());
  EXPECT_FALSE(courier.line().fetch(key_of_entry(0), kWorth)) << "a plant that is not worth it";
  EXPECT_TRUE(courier.line().fetch(key_of_entry(1), {60.0, 4u << 20}));
  courier.line().offer(key_of_entry(0));
  const CacheReport report = courier.finish();
  EXPECT_EQ(report.damaged, 1u);
  EXPECT_EQ(report.found, 1u);
  EXPECT_EQ(report.sent, 1u);
  EXPECT_FALSE(report.gave_up);
}

/// What comes is waited for as long as it would take to make it, and no longer.
TEST_F(Courier, WhatComesTooSlowlyIsNotWaitedFor) {
  store(1);
  {
    const FaultyServer server(objects_);
    ASSERT_EQ(send(server.url(), 1).sent, 1u);
  }
  const FaultyServer server(objects_, {.padding_bytes = 1u << 20, .bytes_per_s = 250e3});
  const std::uint64_t most = 2u << 20;
  CacheCourier patient = start(server.url());
  EXPECT_TRUE(patient.line().fetch(key_of_entry(0), {60.0, most}));
  CacheCourier hasty = start(server.url());
  EXPECT_FALSE(hasty.line().fetch(key_of_entry(0), {0.5, most}));
  EXPECT_FALSE(patient.finish().gave_up);
  const CacheReport report = hasty.finish();
  EXPECT_TRUE(report.gave_up);
  EXPECT_EQ(report.unasked, 1u);
  EXPECT_NE(report.trouble, "");
}

TEST_F(Courier, AsksOneQuestionWhereTheCacheHasAll) {
  store(20);
  const FaultyServer server(objects_);
  ASSERT_EQ(send(server.url(), 20).sent, 20u);
  const std::size_t before = server.requests().size();
  const CacheReport again = send(server.url(), 20);
  EXPECT_EQ(again.requests, 1u);
  EXPECT_EQ(again.sent + again.unsent, 0u);
  EXPECT_EQ(server.requests().size(), before + 1);
  EXPECT_EQ(server.requests().back(), "GET /v1/index");
}

TEST_F(Courier, TheIndexIsAHint) {
  store(6);
  const FaultyServer server(objects_);
  ASSERT_EQ(send(server.url(), 4).sent, 4u);
  const fs::path index = objects_ / "v1" / "index";
  // One that it names is gone; one that is there it lacks; then it is damaged; then it is gone.
  fs::remove(objects_ / coppice::bake::entry_url("", key_of_entry(0)).substr(1));
  coppice::bake::CacheIndex lacking;
  for (const std::size_t named : {0u, 1u, 2u}) lacking[key_of_entry(named)] = 1;
  for (const std::string& text : {coppice::bake::index_text(lacking), std::string("damaged"), std::string()}) {
    write_text(index, text);
    if (text.empty()) fs::remove(index);
    CacheCourier courier = start(server.url(), coppice::bake::CacheMode::read);
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(courier.line().fetch(key_of_entry(i), kWorth).has_value(), i >= 1 && i <= 3) << text << i;
    const CacheReport report = courier.finish();
    EXPECT_EQ(report.found, 3u);
    EXPECT_EQ(report.lacking, 2u);
    EXPECT_EQ(report.unasked + report.unsent, 0u);
    EXPECT_EQ(report.trouble.empty(), text != "damaged") << report.trouble;
  }
  // Whoever may write makes it right: with what it sent, and with what it found there.
  CacheCourier courier = start(server.url());
  EXPECT_FALSE(courier.line().fetch(key_of_entry(0), kWorth));
  EXPECT_TRUE(courier.line().fetch(key_of_entry(1), kWorth));
  for (const std::size_t offered : {0u, 2u, 5u}) courier.line().offer(key_of_entry(offered));
  EXPECT_EQ(courier.finish().sent, 2u) << "2 is there";
  const auto made = coppice::bake::read_index(read_text(index));
  ASSERT_TRUE(made);
  for (const std::size_t named : {0u, 1u, 2u, 5u}) EXPECT_TRUE(made->contains(key_of_entry(named))) << named;
}

TEST_F(Courier, AsksOnlyForWhatTheIndexNamesWhereToldSo) {
  store(3);
  const FaultyServer server(objects_);
  ASSERT_EQ(send(server.url(), 3).sent, 3u);
  coppice::bake::CacheIndex lacking;
  for (const std::size_t named : {0u, 2u}) lacking[key_of_entry(named)] = 1;
  write_text(objects_ / "v1" / "index", coppice::bake::index_text(lacking));
  auto courier = CacheCourier::start({server.url(), {}, coppice::bake::CacheMode::read, local_, 2, true});
  ASSERT_TRUE(courier);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(courier->line().fetch(key_of_entry(i), kWorth).has_value(), i != 1) << i;
  const CacheReport report = courier->finish();
  EXPECT_EQ(report.requests, 3u) << "the index and two entries";
  EXPECT_EQ(report.found, 2u);
  EXPECT_EQ(report.lacking, 1u);
}

TEST_F(Courier, WhatIsReadIsNotWritten) {
  store(2);
  const FaultyServer server(objects_);
  CacheCourier courier = start(server.url(), coppice::bake::CacheMode::read);
  courier.line().offer(key_of_entry(0));
  EXPECT_FALSE(courier.line().fetch(key_of_entry(0), kWorth));
  EXPECT_EQ(courier.finish().sent, 0u);
  EXPECT_EQ(count_of(server.requests(), "PUT"), 0u);
}

// The tool.

/// Small plants that bake in a moment.
class CacheServer : public testing::Test {
 protected:
  void SetUp() override {
    for (int scale = 1; scale <= 3; ++scale) {
      coppice::test::GltfBuilder builder = coppice::test::small_plant();
      builder.json["nodes"][0]["scale"] = {scale, scale, scale};
      const fs::path plant = plants_ / ("plant" + std::to_string(scale) + ".glb");
      fs::create_directories(plants_);
      coppice::test::write_file(plant, builder.glb());
    }
  }
  /// A batch of its own, as on another machine.
  ProcessResult bake_all(const std::string& out, std::vector<std::string> more, const std::vector<std::string>& environment = {}) {
    std::vector<std::string> arguments{"bake-all",     plants_,
                                       "-o",           folder_ / out.c_str(),
                                       "--views",      "2",
                                       "--resolution", "16",
                                       "--report",     folder_ / (out + ".json").c_str()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    coppice::test::ProcessOptions options;
    options.environment = environment;
    return coppice::test::run_process(coppice::test::kTool, arguments, options);
  }
  nlohmann::json report(const std::string& out) { return nlohmann::json::parse(read_text(folder_ / (out + ".json").c_str())); }
  /// What all plants are without any cache.
  std::map<std::string, std::string> expected() {
    EXPECT_EQ(bake_all("expected", {"--no-cache"}).exit_code, 0);
    EXPECT_FALSE(fs::exists(folder_ / "expected" / ".coppice-cache"));
    return outputs(folder_ / "expected");
  }
  ProcessResult cache(std::vector<std::string> arguments, const std::vector<std::string>& environment = {}) {
    arguments.insert(arguments.begin(), "cache");
    coppice::test::ProcessOptions options;
    options.environment = environment;
    return coppice::test::run_process(coppice::test::kTool, arguments, options);
  }

  TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants";
};

struct Fault {
  const char* name;
  ServerFaults faults;
  bool is_filled;     ///< by a batch that meets no fault
  std::string names;  ///< what its one line has to name; empty where that is the address alone
  std::size_t baked;  ///< of three
};

TEST_F(CacheServer, NoFaultOfACacheFailsAPlant) {
  const auto plants = expected();
  const std::vector<Fault> all = {
      {"503", {.get_status = 503, .put_status = 503}, false, "503", 3},
      {"403", {.get_status = 403, .put_status = 403}, false, "403", 3},
      {"401", {.get_status = 401, .put_status = 401}, false, "COPPICE_CACHE_CREDENTIALS", 3},
      {"404", {.get_status = 404, .put_status = 404}, false, "404", 3},
      {"moved", {.get_status = 301, .put_status = 301}, false, "301", 3},
      {"read only", {.put_status = 403}, false, "403", 3},
      {"full", {.put_status = 507}, false, "507", 3},
      {"too large", {.put_status = 413}, false, "client_max_body_size", 3},
      {"half bodies", {.half_bodies = true}, true, "3", 3},
      {"wrong bytes", {.wrong_bytes = true}, true, "3", 3},
      {"slow", {.delay_s = 20.0}, true, "1.5", 3},
      {"trickling", {.padding_bytes = 50'000'000, .bytes_per_s = 400e3}, true, "", 3},
  };
  for (const Fault& fault : all) {
    const fs::path objects = folder_ / (std::string("objects of ") + fault.name).c_str();
    if (fault.is_filled) {
      const FaultyServer server(objects);
      ASSERT_EQ(bake_all(std::string("filling ") + fault.name, {"--cache", server.url()}).exit_code, 0);
    }
    const FaultyServer server(objects, fault.faults);
    const ProcessResult result = bake_all(fault.name, {"--cache", server.url()});
    EXPECT_LT(report(fault.name)["cache"]["lost_seconds"], 10.0) << fault.name;
    EXPECT_EQ(result.exit_code, 0) << fault.name << result.err;
    EXPECT_EQ(outputs(folder_ / fault.name), plants) << fault.name;
    EXPECT_EQ(report(fault.name)["baked"], fault.baked) << fault.name;
    if (!fault.names.empty()) {
      EXPECT_TRUE(mentions(result.err, {fault.names})) << fault.name;
    }
    EXPECT_EQ(lines_that_name(result.err, server.url()), 1u) << fault.name << ": " << result.err;
  }
}

TEST_F(CacheServer, NobodyListeningFailsNoPlant) {
  const auto plants = expected();
  const std::string url = coppice::test::dead_url();
  const ProcessResult result = bake_all("dead", {"--cache", url});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(outputs(folder_ / "dead"), plants);
  EXPECT_TRUE(mentions(result.err, {url}));
  EXPECT_EQ(report("dead")["cache"]["unasked"], 3);
  EXPECT_EQ(report("dead")["cache"]["unsent"], 3);
}

TEST_F(CacheServer, OneOfAHundredPoisonedIsBakedNamedAndReplaced) {
  constexpr int kCount = 100;  // nearly all of the time is for baking them once
  plants_ = folder_ / "many";
  fs::create_directories(plants_);
  for (int i = 0; i < kCount; ++i) {
    coppice::test::GltfBuilder builder = coppice::test::small_plant();
    const double scale = 1.0 + 0.01 * i;
    builder.json["nodes"][0]["scale"] = {scale, scale, scale};
    coppice::test::write_file(plants_ / ("plant" + std::to_string(100 + i) + ".glb"), builder.glb());
  }
  const FaultyServer server(folder_ / "objects");
  const std::vector<std::string> shared{"--cache", server.url()};
  ASSERT_EQ(bake_all("one", shared).exit_code, 0);
  // Short of time not all may be sent at once; what is left is sent the next time.
  for (int i = 0; i < 20 && report("one")["cache"]["unsent"] > 0; ++i) ASSERT_EQ(bake_all("one", shared).exit_code, 0);
  const auto baked = outputs(folder_ / "one");
  ASSERT_EQ(baked.size(), std::size_t{kCount});
  const auto plants = report("one")["plants"];

  struct Poison {
    const char* name;
    std::size_t plant;
    std::string (*of)(std::string bytes);
  };
  const std::vector<Poison> poisons = {{"wrong bytes", 17,
                                        [](std::string bytes) {
                                          bytes[bytes.size() / 2] ^= 4;
                                          return bytes;
                                        }},
                                       {"truncated", 67, [](std::string bytes) { return bytes.substr(0, bytes.size() / 2); }}};
  for (const Poison& poison : poisons) {
    SCOPED_TRACE(poison.name);
    const fs::path object = folder_ / "objects" / coppice::bake::entry_url("", plants[poison.plant]["key"]).substr(1);
    const std::string good = read_text(object);
    write_text(object, poison.of(good));
    const ProcessResult result = bake_all(poison.name, shared);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(report(poison.name)["baked"], 1);
    EXPECT_EQ(report(poison.name)["cached"], kCount - 1);
    EXPECT_EQ(report(poison.name)["cache"]["damaged"], 1);
    EXPECT_EQ(report(poison.name)["cache"]["sent"], 1);
    EXPECT_TRUE(outputs(folder_ / poison.name) == baked);
    const std::string input = fs::path(plants[poison.plant]["input"].get<std::string>()).filename();
    EXPECT_EQ(lines_that_name(result.err, input), 1u) << result.err;
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 2) << "the plant's, and the cache's: " << result.err;
    EXPECT_EQ(read_text(object), good) << "replaced";
  }
  EXPECT_EQ(bake_all("last", shared).err, "");
  EXPECT_EQ(report("last")["cached"], kCount);
  EXPECT_TRUE(outputs(folder_ / "last") == baked);
}

TEST_F(CacheServer, AFullFolderFailsNoPlant) {
  const fs::path full = folder_ / "full";
  fs::create_directories(full);
  if (::mount("coppice-test", full.c_str(), "tmpfs", 0, "size=4k") != 0) GTEST_SKIP() << "no tmpfs may be mounted here";
  const ProcessResult result = bake_all("out", {"--cache", full});
  const std::size_t files = static_cast<std::size_t>(std::distance(fs::directory_iterator(full), {}));
  EXPECT_EQ(::umount(full.c_str()), 0);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(outputs(folder_ / "out"), expected());
  EXPECT_TRUE(mentions(result.err, {full.string(), std::strerror(ENOSPC), "3"}));
  EXPECT_EQ(files, 0u) << "halves";
}

TEST_F(CacheServer, AFolderIsSharedOrOnlyRead) {
  const fs::path shared = folder_ / "shared";
  ASSERT_EQ(bake_all("one", {"--cache", shared}).exit_code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "one" / ".coppice-cache"));
  EXPECT_EQ(bake_all("two", {}, {"COPPICE_CACHE=" + shared.string()}).exit_code, 0);
  EXPECT_EQ(report("two")["cached"], 3);
  EXPECT_EQ(bake_all("three", {"--cache", shared, "--cache-mode", "read"}).exit_code, 0);
  EXPECT_EQ(report("three")["cached"], 3);
  const auto before = std::distance(fs::directory_iterator(shared), {});
  EXPECT_EQ(bake_all("four", {"--cache", shared, "--cache-mode", "read", "--metric", "mi"}).exit_code, 0);
  EXPECT_EQ(report("four")["baked"], 3);
  EXPECT_EQ(std::distance(fs::directory_iterator(shared), {}), before);
  EXPECT_TRUE(fs::exists(folder_ / "four" / ".coppice-cache"));
  // One that cannot be made is a warning, and the folder beside the outputs serves.
  write_text(folder_ / "file", "");
  const ProcessResult none = bake_all("five", {"--cache", folder_ / "file" / "cache"});
  EXPECT_EQ(none.exit_code, 0) << none.err;
  EXPECT_TRUE(mentions(none.err, {(folder_ / "file" / "cache").string()}));
  EXPECT_TRUE(fs::exists(folder_ / "five" / ".coppice-cache"));
}

TEST_F(CacheServer, ExplainSaysWhatDiffers) {
  const std::string told = bake_all("out", {"--explain"}).out;
  ASSERT_EQ(report("out")["plants"][0]["because"].size(), 1u);
  EXPECT_NE(told.find(report("out")["plants"][0]["because"][0].get<std::string>()), std::string::npos) << told;
  coppice::test::GltfBuilder builder = coppice::test::small_plant();
  builder.json["nodes"][0]["scale"] = {7, 7, 7};
  coppice::test::write_file(plants_ / "plant2.glb", builder.glb());
  const ProcessResult changed = bake_all("out", {"--explain"});
  EXPECT_EQ(report("out")["baked"], 1);
  ASSERT_EQ(report("out")["plants"][1]["because"].size(), 1u);
  EXPECT_EQ(report("out")["plants"][0]["because"], nlohmann::json::array());
  const std::string because = report("out")["plants"][1]["because"][0];
  EXPECT_NE(changed.out.find(because), std::string::npos) << changed.out;
  EXPECT_FALSE(mentions(because, {"option"}));
  const ProcessResult option = bake_all("out", {"--explain", "--metric", "mi"});
  ASSERT_EQ(report("out")["plants"][2]["because"].size(), 1u);
  EXPECT_TRUE(mentions(report("out")["plants"][2]["because"][0].get<std::string>(), {"metric", "mi", "default"}));
  EXPECT_TRUE(mentions(option.out, {"plant3", "metric", "mi", "default"}));
}

TEST_F(CacheServer, ExplainComparesWithWhatIsOnTheServerToo) {
  const FaultyServer server(folder_ / "objects");
  ASSERT_EQ(bake_all("one", {"--cache", server.url()}).exit_code, 0);
  const ProcessResult other = bake_all("two", {"--cache", server.url(), "--explain", "--textures", "rgba8"});
  EXPECT_TRUE(mentions(other.out, {"plant1", "textures", "rgba8", "bc"})) << other.err;
}

TEST_F(CacheServer, WhereLibcurlIsMissingItsPackageIsNamedAndOnlyAddressesNeedIt) {
  write_text(folder_ / "libraries" / "libcurl.so.4", "no library");
  const std::vector<std::string> without{"LD_LIBRARY_PATH=" + (folder_ / "libraries").string()};
  for (const ProcessResult& result :
       {bake_all("out", {"--cache", "https://host/x"}, without), cache({"stats", "https://host/x"}, without)}) {
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(mentions(result.err, {"libcurl4"}));
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
  }
  EXPECT_EQ(bake_all("out", {"--cache", folder_ / "shared"}, without).exit_code, 0);
}

TEST_F(CacheServer, SecretsInAnAddressAreRefusedAndNotRepeated) {
  for (const std::string where : {"https://ann:sesame@host/x", "https://host/x?key=sesame", "ann:sesame@host/x"}) {
    for (const ProcessResult& result : {bake_all("out", {}, {"COPPICE_CACHE=" + where}), cache({"stats", where})}) {
      EXPECT_EQ(result.exit_code, 1);
      EXPECT_EQ((result.out + result.err).find("sesame"), std::string::npos) << result.err;
      EXPECT_TRUE(mentions(result.err, {"host"}));
    }
  }
}

/// Neither that of an address that is not used.
TEST_F(CacheServer, TasksOfAClusterAreToldNoAddressThatIsNotUsed) {
  const ProcessResult printed = bake_all("out", {"--no-cache", "--slurm", "--print"}, {"COPPICE_CACHE=https://ann:sesame@host/x"});
  EXPECT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_TRUE(mentions(printed.out, {"'--no-cache'"}));
  EXPECT_EQ(printed.out.find("sesame"), std::string::npos) << printed.out;
  for (const auto& [name, text] : outputs(folder_ / "out")) EXPECT_EQ(text.find("sesame"), std::string::npos) << name;
}

/// A server that goes while tasks run costs one of them time, and the next none.
TEST_F(CacheServer, OfTheTasksOfAClusterOneFindsAServerDead) {
  const fs::path out = folder_ / "out";
  auto server = std::make_unique<FaultyServer>(folder_ / "objects");
  const std::string url = server->url();
  const ProcessResult printed = bake_all("out", {"--slurm", "--print", "--cache", url});
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  server.reset();
  const fs::path run = fs::directory_iterator(out / ".coppice-farm")->path(), given_up = run / "cache-gave-up";
  EXPECT_FALSE(fs::exists(given_up)) << "it was there when it was asked first";
  for (const bool is_first : {true, false}) {
    ASSERT_EQ(coppice::test::run_process("/bin/sh", {run / "submission-001.sh", "0"}).exit_code, 0);
    EXPECT_TRUE(fs::exists(given_up));
    fs::path last;
    for (const auto& entry : fs::directory_iterator(run / "tries"))
      if (entry.path().extension() == ".report" && (last.empty() || entry.last_write_time() > fs::last_write_time(last)))
        last = entry.path();
    const auto cache = nlohmann::json::parse(read_text(last))["cache"];
    EXPECT_EQ(cache["where"], is_first ? url : (out / ".coppice-cache").string());
    EXPECT_EQ(cache["gave_up"], is_first);
  }
}

TEST_F(CacheServer, VerifyRemovesNothingThatIsOnlyHalfHeard) {
  const fs::path objects = folder_ / "objects";
  {
    const FaultyServer server(objects);
    ASSERT_EQ(bake_all("one", {"--cache", server.url()}).exit_code, 0);
    ASSERT_EQ(report("one")["cache"]["sent"], 3);
  }
  const FaultyServer server(objects, {.half_bodies = true, .lists = true});
  const ProcessResult verified = cache({"verify", server.url(), "--remove-damaged"});
  EXPECT_EQ(verified.exit_code, 1) << verified.out << verified.err;
  EXPECT_TRUE(mentions(verified.out + verified.err, {"3"}));
  const auto asked = server.requests();
  EXPECT_EQ(count_of(asked, "DELETE"), 0u);
  EXPECT_EQ(count_of(asked, "PUT /v1/index"), 1u) << "of the batch";
}

/// The server block of bake/README.md, with what stands for a studio's network changed to everybody.
std::string server_block() {
  const std::string readme = coppice::test::source_text("bake/README.md"), fence = "```nginx\n";
  const std::size_t at = readme.find(fence);
  if (at == std::string::npos) return {};
  return std::regex_replace(readme.substr(at + fence.size(), readme.find("```", at + fence.size()) - at - fence.size()),
                            std::regex(R"(allow [0-9./]+;)"), "allow 127.0.0.1;");
}

class NginxCache : public CacheServer {
 protected:
  void SetUp() override {
    if (!Nginx::is_there()) GTEST_SKIP() << "/usr/sbin/nginx is missing: Debian's package nginx";
    CacheServer::SetUp();
  }
};

TEST_F(NginxCache, IsFilledByOneMachineAndReadByOthers) {
  const Nginx nginx(folder_ / "nginx", server_block());
  const std::string url = nginx.url() + "/plants";
  const ProcessResult first = bake_all("one", {"--cache", url});
  EXPECT_EQ(first.exit_code, 0);
  EXPECT_EQ(first.err, "");
  EXPECT_EQ(report("one")["cache"]["sent"], 3);
  EXPECT_EQ(bake_all("two", {}, {"COPPICE_CACHE=" + url + "/"}).exit_code, 0);
  EXPECT_EQ(report("two")["cached"], 3);
  EXPECT_EQ(report("two")["cache"]["found"], 3);
  EXPECT_EQ(outputs(folder_ / "one"), outputs(folder_ / "two"));
  EXPECT_EQ(bake_all("two", {"--cache", url}).err, "");
  EXPECT_EQ(report("two")["cache"]["requests"], 1) << "all is there: one question";
  // Lost, the index comes back from nginx's listings, with entries that the batch does not know.
  fs::remove(nginx.root() / "plants" / "v1" / "index");
  fs::remove(plants_ / "plant1.glb");
  EXPECT_EQ(bake_all("three", {"--cache", url}).exit_code, 0);
  const auto index = coppice::bake::read_index(read_text(nginx.root() / "plants" / "v1" / "index"));
  ASSERT_TRUE(index);
  EXPECT_EQ(index->size(), 3u);
}

TEST_F(NginxCache, IsLookedAfterByTheTool) {
  const Nginx nginx(folder_ / "nginx", server_block());
  ASSERT_EQ(bake_all("one", {"--cache", nginx.url()}).exit_code, 0);
  const auto stats = nlohmann::json::parse(cache({"stats", "--json", nginx.url()}).out);
  EXPECT_EQ(stats["entries"], 3);
  EXPECT_EQ(stats["unindexed"], 0);
  EXPECT_EQ(cache({"verify", nginx.url()}).exit_code, 0);
  const std::string key = report("one")["plants"][0]["key"];
  write_text(nginx.root() / coppice::bake::entry_url("", key).substr(1), "poison");
  const ProcessResult damaged = cache({"verify"}, {"COPPICE_CACHE=" + nginx.url()});
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_EQ(lines_that_name(damaged.out, key), 1u) << damaged.out;
  EXPECT_EQ(cache({"verify", "--remove-damaged", nginx.url()}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(cache({"stats", "--json", nginx.url()}).out)["entries"], 2);
  fs::remove(nginx.root() / "v1" / "index");
  EXPECT_EQ(nlohmann::json::parse(cache({"stats", "--json", nginx.url()}).out)["unindexed"], 2);
  EXPECT_TRUE(mentions(cache({"index", nginx.url()}).out, {"2"}));
  EXPECT_EQ(nlohmann::json::parse(cache({"stats", "--json", nginx.url()}).out)["unindexed"], 0);
  const auto record_count = [&] {
    std::size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(nginx.root() / "v1" / "records")) count += entry.is_regular_file() ? 1u : 0u;
    return count;
  };
  EXPECT_EQ(record_count(), 3u) << "one of them of the entry that was removed";
  EXPECT_EQ(cache({"prune", "--max-gb", "1", nginx.url()}).exit_code, 0);
  EXPECT_EQ(record_count(), 2u);
  const auto pruned = nlohmann::json::parse(cache({"prune", "--max-gb", "0", "--json", nginx.url()}).out);
  EXPECT_EQ(pruned["removed_entries"], 2);
  EXPECT_EQ(nlohmann::json::parse(cache({"stats", "--json", nginx.url()}).out)["entries"], 0);
  EXPECT_EQ(record_count(), 0u);
  EXPECT_EQ(cache({"prune", nginx.url()}).exit_code, 2) << "how much?";
}

TEST_F(NginxCache, WhatAServerDoesNotAllowIsSaid) {
  std::string block = server_block();
  for (const std::string word : {"PUT DELETE", "autoindex on"})
    block = std::regex_replace(block, std::regex(word), word == "autoindex on" ? "autoindex off" : "PUT");
  const Nginx nginx(folder_ / "nginx", block);
  ASSERT_EQ(bake_all("one", {"--cache", nginx.url()}).exit_code, 0);
  const ProcessResult listed = cache({"stats", nginx.url()});
  EXPECT_EQ(listed.exit_code, 1);
  EXPECT_TRUE(mentions(listed.err, {"autoindex_format"}));
  EXPECT_EQ(bake_all("two", {"--cache", nginx.url()}).exit_code, 0);
  EXPECT_EQ(report("two")["cached"], 3);
}

TEST_F(NginxCache, TakesCredentialsOfTheEnvironmentAndOfNetrc) {
  write_text(folder_ / "passwords", "ann:{PLAIN}sesame\n");
  const std::string block =
      std::regex_replace(server_block(), std::regex(R"(location / \{)"),
                         "location / { auth_basic plants; auth_basic_user_file " + (folder_ / "passwords").string() + ";");
  const Nginx nginx(folder_ / "nginx", block);
  const ProcessResult without = bake_all("none", {"--cache", nginx.url()}, {"HOME=" + folder_.path().string()});
  EXPECT_EQ(without.exit_code, 0);
  EXPECT_TRUE(mentions(without.err, {"401"}));
  const ProcessResult sent = bake_all("one", {"--cache", nginx.url()}, {"COPPICE_CACHE_CREDENTIALS=ann:sesame"});
  EXPECT_EQ(sent.err, "");
  EXPECT_EQ(report("one")["cache"]["sent"], 3);
  write_text(folder_ / ".netrc", "machine 127.0.0.1 login ann password sesame\n");
  const ProcessResult found = bake_all("two", {"--cache", nginx.url()}, {"HOME=" + folder_.path().string()});
  EXPECT_EQ(report("two")["cached"], 3) << found.err;
  const ProcessResult wrong = bake_all("three", {"--cache", nginx.url()}, {"COPPICE_CACHE_CREDENTIALS=ann:opensesame"});
  EXPECT_TRUE(mentions(wrong.err, {"401"}));
  for (const ProcessResult* result : {&without, &sent, &found, &wrong})
    EXPECT_EQ((result->out + result->err).find("sesame"), std::string::npos) << result->out << result->err;
  for (const char* name : {"none", "one", "two", "three"}) EXPECT_EQ(report(name).dump().find("sesame"), std::string::npos);
}

}  // namespace cache_server_test
