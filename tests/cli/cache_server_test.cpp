// A cache on a server: a server of ours that does wrong on purpose, and nginx as bake/README.md sets it up. What a cache may cost is
// measured elsewhere (tests/bench/results); here a fault must neither fail a plant nor hang.

#include <sys/mount.h>

#include <cerrno>
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

#include "cache_server.h"
#include "documents.h"
#include "gltf_builder.h"
#include "tool.h"

namespace coppice::test {
namespace cache_server_test {

namespace fs = std::filesystem;

/// Small plants that bake in a moment.
class CacheServer : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(plants_);
    for (int number = 1; number <= 3; ++number) write_plant(number, number);
  }
  /// Plants of other sizes.
  void write_plant(int number, double scale) {
    GltfBuilder builder = small_plant();
    builder.json["nodes"][0]["scale"] = {scale, scale, scale};
    write_file(plants_ / ("plant" + std::to_string(number) + ".glb"), builder.glb());
  }
  /// A batch of its own, as on another machine.
  ProcessResult bake_all(const std::string& out, const Words& more, const Words& environment = {}) {
    const Words arguments{"bake-all",     plants_, "-o",       folder_ / out.c_str(), "--views", "2",
                          "--resolution", "16",    "--report", report_file(out)};
    return run_tool(joined(arguments, more), {.environment = environment});
  }
  fs::path report_file(const std::string& out) { return folder_ / (out + ".json").c_str(); }
  nlohmann::json report(const std::string& out) { return read_json(report_file(out)); }
  /// What all plants are without any cache.
  std::map<std::string, std::string> expected() {
    EXPECT_EQ(bake_all("expected", {"--no-cache"}).exit_code, 0);
    EXPECT_FALSE(fs::exists(folder_ / "expected" / ".coppice-cache"));
    return outputs(folder_ / "expected");
  }
  static ProcessResult cache(const Words& arguments, const Words& environment = {}) {
    return run_tool(joined({"cache"}, arguments), {.environment = environment});
  }

  TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants";
};

TEST_F(CacheServer, NoFaultOfACacheFailsAPlant) {
  const auto plants = expected();
  struct Fault {
    const char* name;
    ServerFaults faults;
    std::string names;       ///< what its one line has to name; empty where that is the address alone
    bool is_filled = false;  ///< by a batch that meets no fault
  };
  const std::vector<Fault> all = {
      {"503", {.get_status = 503, .put_status = 503}, "503"},
      {"401", {.get_status = 401, .put_status = 401}, "COPPICE_CACHE_CREDENTIALS"},
      {"404", {.get_status = 404, .put_status = 404}, "404"},
      {"moved", {.get_status = 301, .put_status = 301}, "301"},
      {"read only", {.put_status = 403}, "403"},
      {"full", {.put_status = 507}, "507"},
      {"half bodies", {.half_bodies = true}, "", true},
      {"wrong bytes", {.wrong_bytes = true}, "damaged", true},
      {"slow", {.delay_s = 20.0}, "", true},
      {"trickling", {.padding_bytes = 50'000'000, .bytes_per_s = 50e3}, "", true},
  };
  for (const Fault& fault : all) {
    const fs::path objects = folder_ / (std::string("objects of ") + fault.name).c_str();
    if (fault.is_filled) {
      const FaultyServer server(objects);
      ASSERT_EQ(bake_all(std::string("filling ") + fault.name, {"--cache", server.url()}).exit_code, 0);
      ASSERT_EQ(report(std::string("filling ") + fault.name)["cache"]["sent"], 3);
    }
    const FaultyServer server(objects, fault.faults);
    const ProcessResult result = bake_all(fault.name, {"--cache", server.url()});
    EXPECT_EQ(result.exit_code, 0) << fault.name << result.err;
    EXPECT_EQ(outputs(folder_ / fault.name), plants) << fault.name;
    EXPECT_EQ(report(fault.name)["baked"], 3) << fault.name;
    if (!fault.names.empty()) {
      EXPECT_TRUE(mentions(result.err, {fault.names})) << fault.name;
    }
    const std::size_t lines = fault.faults.wrong_bytes ? 3u : 1u;  // each damaged entry is named
    EXPECT_EQ(lines_that_name(result.err, server.url()), lines) << fault.name << ": " << result.err;
  }
}

/// A server that answers nothing is asked a few times and no more, however many plants there are.
TEST_F(CacheServer, ADeadServerIsAskedAFewTimes) {
  for (int i = 4; i <= 40; ++i) fs::copy(plants_ / "plant1.glb", plants_ / ("plant" + std::to_string(i) + ".glb"));
  const FaultyServer server(folder_ / "objects", {.get_status = 503, .put_status = 503});
  const ProcessResult result = bake_all("out", {"--cache", server.url()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(report("out")["cache"]["gave_up"]);
  EXPECT_EQ(report("out")["cache"]["lacking"], 40);
  EXPECT_LE(server.requests().size(), 8u * 3 + 8);  // three of each process that looks up
}

TEST_F(CacheServer, NobodyListeningFailsNoPlant) {
  const auto plants = expected();
  const std::string url = dead_url();
  const ProcessResult result = bake_all("dead", {"--cache", url});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(outputs(folder_ / "dead"), plants);
  EXPECT_TRUE(mentions(result.err, {url}));
  EXPECT_EQ(report("dead")["cache"]["unsent"], 3);
}

TEST_F(CacheServer, OneOfAHundredPoisonedIsBakedNamedAndReplaced) {
  constexpr int kCount = 100;  // nearly all of the time is for baking them once
  plants_ = folder_ / "many";
  fs::create_directories(plants_);
  for (int i = 0; i < kCount; ++i) write_plant(100 + i, 1.0 + 0.01 * i);
  const FaultyServer server(folder_ / "objects");
  const Words shared{"--cache", server.url()};
  ASSERT_EQ(bake_all("one", shared).exit_code, 0);
  ASSERT_EQ(report("one")["cache"]["sent"], kCount);
  const auto baked = outputs(folder_ / "one");
  ASSERT_EQ(baked.size(), std::size_t{kCount});
  const auto plants = report("one")["plants"];

  const auto spoiled = [](std::string bytes) {
    bytes[bytes.size() / 2] ^= 4;
    return bytes;
  };
  const auto halved = [](const std::string& bytes) { return bytes.substr(0, bytes.size() / 2); };
  struct Poison {
    const char* name;
    std::size_t plant;
    std::function<std::string(const std::string& bytes)> of;
  };
  for (const Poison& poison : {Poison{"wrong bytes", 17, spoiled}, Poison{"truncated", 67, halved}}) {
    SCOPED_TRACE(poison.name);
    const fs::path object = folder_ / "objects" / (plants[poison.plant]["key"].get<std::string>() + ".coppice");
    const std::string good = read_text(object);
    write_text(object, poison.of(good));
    const ProcessResult result = bake_all(poison.name, shared);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(report(poison.name)["baked"], 1);
    EXPECT_EQ(report(poison.name)["cached"], kCount - 1);
    EXPECT_EQ(report(poison.name)["cache"]["sent"], 1);
    EXPECT_TRUE(outputs(folder_ / poison.name) == baked);
    const std::string input = fs::path(plants[poison.plant]["input"].get<std::string>()).filename();
    EXPECT_EQ(lines_that_name(result.err, input), 1u) << result.err;
    EXPECT_EQ(count_of(result.err, "\n"), 1u) << result.err;
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

/// With a server the folder beside the outputs is another cache: what is wrong with one is not the other's fault.
TEST_F(CacheServer, AFullFolderIsNotTheServersFault) {
  const fs::path full = folder_ / "out" / ".coppice-cache";
  fs::create_directories(full);
  if (::mount("coppice-test", full.c_str(), "tmpfs", 0, "size=4k") != 0) GTEST_SKIP() << "no tmpfs may be mounted here";
  const FaultyServer server(folder_ / "objects");
  const ProcessResult result = bake_all("out", {"--cache", server.url()});
  EXPECT_EQ(::umount(full.c_str()), 0);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.err, {full.string(), std::strerror(ENOSPC)}));
  EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
  EXPECT_EQ(report("out")["cache"]["sent"], 3);
  EXPECT_EQ(report("out")["cache"]["unsent"], 0);
  EXPECT_FALSE(report("out")["cache"]["gave_up"]);
  EXPECT_EQ(bake_all("other", {"--cache", server.url()}).exit_code, 0);
  EXPECT_EQ(report("other")["cached"], 3);
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
  write_plant(2, 7);
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

/// The server block of bake/README.md, with what stands for a studio's network changed to everybody.
std::string server_block() {
  const std::string readme = source_text("bake/README.md"), fence = "```nginx\n";
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
  const std::size_t before = nginx.requests().size();
  EXPECT_EQ(bake_all("two", {"--cache", url}).err, "");
  EXPECT_EQ(nginx.requests().size(), before) << "all is in its folder now";
  // The server's owner looks after it as after any folder.
  const std::string folder = nginx.root() / "plants";
  EXPECT_EQ(nlohmann::json::parse(cache({"stats", "--json", folder}).out)["entries"], 3);
  EXPECT_EQ(cache({"verify", folder}).exit_code, 0);
  EXPECT_EQ(cache({"prune", "--max-gb", "0", folder}).exit_code, 0);
  EXPECT_EQ(bake_all("three", {"--cache", url}).exit_code, 0);
  EXPECT_EQ(report("three")["cache"]["sent"], 3);
  expect_error(cache({"stats", url}), {url});
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
}  // namespace coppice::test
