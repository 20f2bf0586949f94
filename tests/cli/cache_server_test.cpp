// A cache on a server: a server of ours that does wrong on purpose, and nginx as bake/README.md sets it up. What a cache may cost is
// measured elsewhere (tests/bench/results); here a fault must neither fail a plant nor hang.

#include <sys/mount.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bake_cache.h"
#include "documents.h"
#include "gltf_builder.h"
#include "servers.h"
#include "tool.h"

namespace coppice::test::cache_server_test {

namespace fs = std::filesystem;

/// What a batch that succeeds prints, reports and writes.
struct Batch {
  std::string out, err;
  nlohmann::json report, cache;  ///< the report, and its part "cache"
  BatchCounts counts;
  std::map<std::string, std::string> files;
  std::uint64_t peak_rss_bytes = 0;  ///< of the largest of its processes
};

/// A batch that takes longer hangs, also on a machine that is busy elsewhere.
constexpr std::chrono::seconds kHangs(1200);

/// Small plants that bake in a moment.
class CacheServer : public testing::Test {
 protected:
  void SetUp() override {
    for (const int number : {1, 2, 3}) write_plant("plant" + std::to_string(number), number);
  }
  /// Plants of other sizes.
  void write_plant(const std::string& name, double scale) {
    GltfBuilder builder = small_plant();
    builder.json["nodes"][0]["scale"] = {scale, scale, scale};
    fs::create_directories(plants_);
    write_file(plants_ / (name + ".glb"), builder.glb());
  }
  /// Runs a batch of its own, as on another machine.
  ProcessResult run_batch(const std::string& out, const Words& more, const Words& environment = {}) {
    const Words arguments{"bake-all", plants_, "-o", folder_ / out.c_str(), "--views", "2", "--resolution", "16"};
    return run_tool(joined(arguments, more), {.kill_after = kHangs, .environment = environment});
  }
  Batch bake_all(const std::string& out, const Words& more, const Words& environment = {}) {
    const fs::path report = folder_ / (out + ".json").c_str();
    const ProcessResult result = run_batch(out, joined({"--report", report}, more), environment);
    EXPECT_EQ(result.exit_code, 0) << out << ": " << result.err;
    const nlohmann::json json = read_json(report);
    return {
        result.out,           result.err, json, json.value("cache", nlohmann::json()), counts_in(report), outputs(folder_ / out.c_str()),
        result.peak_rss_bytes};
  }
  /// Makes a folder that holds 4 kB, until TearDown. False where that may not be.
  bool make_full(const fs::path& folder) {
    fs::create_directories(folder);
    if (::mount("coppice-test", folder.c_str(), "tmpfs", 0, "size=4k") != 0) return false;
    full_ = folder;
    return true;
  }
  void TearDown() override { EXPECT_TRUE(full_.empty() || ::umount(full_.c_str()) == 0); }
  /// What all plants are without any cache.
  std::map<std::string, std::string> expected() {
    const Batch batch = bake_all("expected", {"--no-cache"});
    EXPECT_FALSE(fs::exists(folder_ / "expected" / ".coppice-cache"));
    return batch.files;
  }
  static ProcessResult cache(const Words& arguments) { return run_tool(joined({"cache"}, arguments)); }

  TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants", full_;
};

class BadServer : public CacheServer, public testing::WithParamInterface<ServerFault> {};

/// Every answer, whole or not, costs no plant, and no more memory than an entry may have. What hangs fails.
TEST_P(BadServer, CostsLittleAndHarmsNothing) {
  const ServerFault& fault = GetParam();
  const fs::path objects = folder_ / "objects";
  const auto plants = bake_all("filling", {"--cache", FaultyServer(objects).url()}).files;
  fs::remove(objects / "requests.log");
  const FaultyServer server(objects, fault);
  const auto start = std::chrono::steady_clock::now();
  const Batch batch = bake_all("out", {"--cache", server.url()}, {"COPPICE_CACHE_CREDENTIALS=ann:sesame"});
  const auto time = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(batch.files, plants);
  EXPECT_EQ(batch.counts, fault.is_found ? (BatchCounts{0, 3, 0}) : (BatchCounts{3, 0, 0}));
  EXPECT_EQ(lines_that_name(batch.err, fault.told) > 0, !fault.told.empty()) << batch.err;
  // A machine that is busy elsewhere takes the server's whole time to tell three answers wrong, and a fourth line says that.
  const bool has_run_out = fault.lines == 3 && time > std::chrono::seconds(10) && batch.cache["gave_up"];
  EXPECT_EQ(lines_that_name(batch.err, server.url()), fault.lines + (has_run_out ? 1 : 0)) << batch.err;
  EXPECT_EQ(count_of(server.requests(), "/elsewhere"), 0u);
  EXPECT_EQ(count_of(batch.out + batch.err, "sesame"), 0u);
  EXPECT_LT(batch.peak_rss_bytes, std::uint64_t{400} << 20);
}

INSTANTIATE_TEST_SUITE_P(All, BadServer, testing::ValuesIn(all_server_faults()),
                         [](const testing::TestParamInfo<ServerFault>& fault) { return fault.param.name; });

/// Whoever may write there makes entries whose checksums are right.
TEST_F(CacheServer, AnEntryIsCheckedAsAStrangersFile) {
  fs::rename(plants_ / "plant2.glb", plants_ / "other.glb");
  const fs::path objects = folder_ / "objects";
  const FaultyServer server(objects);
  const Batch first = bake_all("one", {"--cache", server.url()});
  std::map<std::string, std::string> keys;
  for (const nlohmann::json& plant : first.report["plants"])
    keys[fs::path(plant["input"].get<std::string>()).stem().string()] = plant["key"];
  const std::string key = keys["plant1"];
  const auto entry_of = [&](const char* name) { return bake::peek_cached(objects, keys[name]); };
  const auto good = *entry_of("plant1"), other = *entry_of("other");

  std::vector<bake::CachedBake> spoiled(4, good);
  spoiled[0].bytes = other.bytes;                  // another plant, under the right record
  spoiled[1] = other;                              // another's entry
  spoiled[2].bytes.assign(1000, 0);                // no plant at all
  spoiled[3].bytes.resize(good.bytes.size() / 2);  // half of one
  for (std::size_t i = 0; i < spoiled.size(); ++i) {
    ASSERT_TRUE(bake::store_cached(objects, key, spoiled[i]));
    const Batch batch = bake_all("out " + std::to_string(i), {"--cache", server.url()});
    EXPECT_EQ(batch.counts, (BatchCounts{1, 2, 0})) << i;
    EXPECT_TRUE(batch.files == first.files) << i;
    EXPECT_EQ(lines_that_name(batch.err, server.url() + "/" + key), 1u) << batch.err;
    EXPECT_TRUE(entry_of("plant1")->bytes == good.bytes) << "replaced";
  }
}

TEST_F(CacheServer, ADeadOneCostsNoPlant) {
  const auto plants = expected();
  const Batch batch = bake_all("out", {"--cache", dead_url()});
  EXPECT_EQ(batch.files, plants);
  EXPECT_EQ(batch.cache["unsent"], 3);
  EXPECT_EQ(count_of(batch.err, "\n"), 1u) << batch.err;
}

/// A server that refuses, or whose right answers take longer than they are worth, is asked a few times and no more, however many plants
/// there are.
TEST_F(CacheServer, OneOfNoUseIsAskedAFewTimes) {
  for (int i = 4; i <= 40; ++i) fs::copy(plants_ / "plant1.glb", plants_ / ("plant" + std::to_string(i) + ".glb"));
  for (const ServerFault& fault : {all_server_faults().front(), late_server()}) {
    const FaultyServer server(folder_ / fault.name.c_str(), fault);
    const Batch batch = bake_all("out of " + fault.name, {"--cache", server.url()});
    EXPECT_TRUE(batch.cache["gave_up"]);
    EXPECT_EQ(batch.cache["lacking"], 40);
    EXPECT_LE(count_of(server.requests(), "\n"), 8u * 3 + 8);  // three of each process that looks up plants, and what is sent
  }
}

TEST_F(CacheServer, OneOfAHundredPoisonedIsBakedNamedAndReplaced) {
  constexpr std::size_t kCount = 100;  // nearly all of the time is for baking them once
  plants_ = folder_ / "many";
  for (std::size_t i = 0; i < kCount; ++i) write_plant("plant" + std::to_string(100 + i), 1.0 + 0.01 * static_cast<double>(i));
  const FaultyServer server(folder_ / "objects");
  const Words shared{"--cache", server.url()};
  const Batch first = bake_all("one", shared);
  ASSERT_EQ(first.cache["sent"], kCount);
  ASSERT_EQ(first.files.size(), kCount);

  struct Poison {
    const char* name;
    std::size_t plant;
    std::function<void(std::string& bytes)> apply;
  };
  for (const Poison& poison : {Poison{"wrong bytes", 17, [](std::string& bytes) { bytes[bytes.size() / 2] ^= 4; }},
                               Poison{"truncated", 67, [](std::string& bytes) { bytes.resize(bytes.size() / 2); }}}) {
    const nlohmann::json& plant = first.report["plants"][poison.plant];
    const fs::path object = folder_ / "objects" / (plant["key"].get<std::string>() + ".coppice");
    const std::string good = read_text(object);
    std::string bytes = good;
    poison.apply(bytes);
    write_text(object, bytes);
    const Batch batch = bake_all(poison.name, shared);
    EXPECT_EQ(batch.counts, (BatchCounts{1, kCount - 1, 0}));
    EXPECT_EQ(batch.cache["sent"], 1);
    EXPECT_TRUE(batch.files == first.files);
    EXPECT_EQ(lines_that_name(batch.err, fs::path(plant["input"].get<std::string>()).filename().string()), 1u) << batch.err;
    EXPECT_EQ(count_of(batch.err, "\n"), 1u) << batch.err;
    EXPECT_EQ(read_text(object), good) << "replaced";
  }
  const Batch last = bake_all("last", shared);
  EXPECT_EQ(last.err, "");
  EXPECT_EQ(last.counts, (BatchCounts{0, kCount, 0}));
  EXPECT_TRUE(last.files == first.files);
}

TEST_F(CacheServer, AFullFolderFailsNoPlant) {
  if (!make_full(folder_ / "full")) GTEST_SKIP() << "no tmpfs may be mounted here";
  const Batch batch = bake_all("out", {"--cache", full_});
  EXPECT_EQ(batch.files, expected());
  EXPECT_TRUE(mentions(batch.err, {full_.string(), std::strerror(ENOSPC), "3"}));
  EXPECT_TRUE(fs::is_empty(full_)) << "halves";
}

/// With a server the folder beside the outputs is another cache: what is wrong with one is not the other's fault.
TEST_F(CacheServer, AFullFolderIsNotTheServersFault) {
  if (!make_full(folder_ / "out" / ".coppice-cache")) GTEST_SKIP() << "no tmpfs may be mounted here";
  const FaultyServer server(folder_ / "objects");
  const Batch batch = bake_all("out", {"--cache", server.url()});
  EXPECT_TRUE(mentions(batch.err, {full_.string(), std::strerror(ENOSPC)}));
  EXPECT_EQ(count_of(batch.err, "\n"), 1u) << batch.err;
  EXPECT_EQ(batch.cache["sent"], 3);
  EXPECT_EQ(batch.cache["unsent"], 0);
  EXPECT_FALSE(batch.cache["gave_up"]);
  EXPECT_EQ(bake_all("other", {"--cache", server.url()}).counts, (BatchCounts{0, 3, 0}));
}

TEST_F(CacheServer, AFolderIsSharedOrOnlyRead) {
  constexpr BatchCounts kBaked{3, 0, 0}, kCached{0, 3, 0};
  const fs::path shared = folder_ / "shared", none = folder_ / "file" / "cache";
  const auto has_own_cache = [&](const char* out) { return fs::exists(folder_ / out / ".coppice-cache"); };
  const Words only_read{"--cache", shared, "--cache-mode", "read"};
  EXPECT_EQ(bake_all("one", {"--cache", shared}).counts, kBaked);
  EXPECT_FALSE(has_own_cache("one"));
  EXPECT_EQ(bake_all("two", {}, {"COPPICE_CACHE=" + shared.string()}).counts, kCached);
  EXPECT_EQ(bake_all("three", only_read).counts, kCached);
  const auto before = std::distance(fs::directory_iterator(shared), {});
  EXPECT_EQ(bake_all("four", joined(only_read, {"--metric", "mi"})).counts, kBaked);
  EXPECT_EQ(std::distance(fs::directory_iterator(shared), {}), before);
  EXPECT_TRUE(has_own_cache("four"));
  // One that cannot be made is a warning, and the folder beside the outputs serves.
  write_text(none.parent_path(), "");
  EXPECT_TRUE(mentions(bake_all("five", {"--cache", none}).err, {none.string()}));
  EXPECT_TRUE(has_own_cache("five"));
}

TEST_F(CacheServer, ExplainSaysWhatDiffers) {
  const auto reason = [](const Batch& batch, std::size_t plant) {
    const nlohmann::json& because = batch.report["plants"][plant]["because"];
    EXPECT_EQ(because.size(), 1u);
    const std::string text = because.empty() ? "" : because[0];
    EXPECT_NE(batch.out.find(text), std::string::npos) << batch.out;
    return text;
  };
  EXPECT_NE(reason(bake_all("out", {"--explain"}), 0), "");
  write_plant("plant2", 7);
  const Batch changed = bake_all("out", {"--explain"});
  EXPECT_EQ(changed.counts, (BatchCounts{1, 2, 0}));
  EXPECT_FALSE(mentions(reason(changed, 1), {"option"}));
  EXPECT_EQ(changed.report["plants"][0]["because"], nlohmann::json::array());
  const Batch option = bake_all("out", {"--explain", "--metric", "mi"});
  EXPECT_TRUE(mentions(reason(option, 2), {"metric", "mi", "default"}));
  EXPECT_TRUE(mentions(option.out, {"plant3"}));
}

TEST_F(CacheServer, SecretsInAnAddressAreRefusedAndNotRepeated) {
  for (const std::string where : {"https://ann:sesame@host/x", "https://host/x?key=sesame", "ann:sesame@host/x"})
    for (const ProcessResult& result : {run_batch("out", {}, {"COPPICE_CACHE=" + where}), cache({"stats", where})}) {
      EXPECT_EQ(result.exit_code, 1);
      EXPECT_EQ((result.out + result.err).find("sesame"), std::string::npos) << result.err;
      EXPECT_TRUE(mentions(result.err, {"host"}));
    }
}

/// Neither that of an address that is not used.
TEST_F(CacheServer, TasksOfAClusterAreToldNoAddressThatIsNotUsed) {
  const ProcessResult printed = run_batch("out", {"--no-cache", "--slurm", "--print"}, {"COPPICE_CACHE=https://ann:sesame@host/x"});
  EXPECT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_TRUE(mentions(printed.out, {"'--no-cache'"}));
  EXPECT_EQ(printed.out.find("sesame"), std::string::npos) << printed.out;
  for (const auto& [name, text] : outputs(folder_ / "out")) EXPECT_EQ(text.find("sesame"), std::string::npos) << name;
}

/// The server block of bake/README.md, with what stands for a studio's network changed to everybody.
std::string server_block() {
  const std::string readme = source_text("bake/README.md"), fence = "```nginx\n";
  const std::size_t begin = readme.find(fence) + fence.size();
  return std::regex_replace(readme.substr(begin, readme.find("```", begin) - begin), std::regex("allow [0-9./]+;"), "allow 127.0.0.1;");
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
  const Batch first = bake_all("one", {"--cache", url});
  EXPECT_EQ(first.err, "");
  EXPECT_EQ(first.cache["sent"], 3);
  const Batch second = bake_all("two", {}, {"COPPICE_CACHE=" + url + "/"});
  EXPECT_EQ(second.counts, (BatchCounts{0, 3, 0}));
  EXPECT_EQ(second.cache["found"], 3);
  EXPECT_EQ(second.files, first.files);
  const std::size_t before = nginx.request_count();
  EXPECT_EQ(bake_all("two", {"--cache", url}).err, "");
  EXPECT_EQ(nginx.request_count(), before) << "all is in its folder now";
  // The server's owner looks after it as after any folder.
  const std::string folder = nginx.root() / "plants";
  EXPECT_EQ(nlohmann::json::parse(cache({"stats", "--json", folder}).out)["entries"], 3);
  EXPECT_EQ(cache({"verify", folder}).exit_code, 0);
  EXPECT_EQ(cache({"prune", "--max-gb", "0", folder}).exit_code, 0);
  EXPECT_EQ(bake_all("three", {"--cache", url}).cache["sent"], 3);
  expect_error(cache({"stats", url}), {url});
}

TEST_F(NginxCache, TakesCredentialsOfTheEnvironmentAndOfNetrc) {
  write_text(folder_ / "passwords", "ann:{PLAIN}sesame\n");
  const std::string authentication = "location / { auth_basic plants; auth_basic_user_file " + (folder_ / "passwords").string() + ";";
  const Nginx nginx(folder_ / "nginx", std::regex_replace(server_block(), std::regex(R"(location / \{)"), authentication));
  const Words shared{"--cache", nginx.url()}, home{"HOME=" + folder_.path().string()};
  const Batch without = bake_all("none", shared, home);
  EXPECT_TRUE(mentions(without.err, {"401"}));
  const Batch sent = bake_all("one", shared, {"COPPICE_CACHE_CREDENTIALS=ann:sesame"});
  EXPECT_EQ(sent.err, "");
  EXPECT_EQ(sent.cache["sent"], 3);
  write_text(folder_ / ".netrc", "machine 127.0.0.1 login ann password sesame\n");
  const Batch found = bake_all("two", shared, home);
  EXPECT_EQ(found.counts, (BatchCounts{0, 3, 0})) << found.err;
  const Batch wrong = bake_all("three", shared, {"COPPICE_CACHE_CREDENTIALS=ann:opensesame"});
  EXPECT_TRUE(mentions(wrong.err, {"401"}));
  for (const Batch& batch : {without, sent, found, wrong})
    EXPECT_EQ((batch.out + batch.err + batch.report.dump()).find("sesame"), std::string::npos) << batch.out << batch.err;
}

}  // namespace coppice::test::cache_server_test
