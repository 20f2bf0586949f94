// Entries, keys and what tells two of them apart, addresses; upkeep of folders. Servers: cache_server_test.

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <initializer_list>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "atomic_file.h"
#include "bake_cache.h"
#include "cache_location.h"
#include "cache_upkeep.h"
#include "gltf_builder.h"
#include "key_parts.h"
#include "mentions.h"
#include "process.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace shared_cache_test {

namespace fs = std::filesystem;
using Lines = std::vector<std::string>;

std::vector<KeyPart> oak_parts() {
  return {{"baker", "", "25"},     {"format", "", "13"}, {"option", "metric", "default"}, {"option", "views", "42"},
          {"name", "", "oak.glb"}, {"input", "", "aa"},  {"file", "bark.png", "bb"}};
}

CachedBake entry_of(const std::string& name, std::size_t bytes = 1000) {
  CachedBake entry;
  for (std::size_t i = 0; i < bytes; ++i) entry.bytes.push_back(static_cast<std::uint8_t>(i));
  entry.source_leaves = 12;
  entry.foliage_bytes = 3;
  entry.warnings = {"a \"warning\"", "another\n"};
  entry.parts = oak_parts();
  entry.parts[4].value = name;
  return entry;
}

/// Stores it under its key, and says which that is.
std::string store(const fs::path& folder, const CachedBake& entry) {
  const std::string key = key_of(entry.parts);
  EXPECT_TRUE(store_cached(folder, key, entry));
  return key;
}

TEST(KeyParts, EveryPartCountsAndWhereOneEnds) {
  const std::vector<KeyPart> parts = oak_parts();
  EXPECT_TRUE(is_key(key_of(parts)));
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::string KeyPart::*text : {&KeyPart::kind, &KeyPart::name, &KeyPart::value}) {
      std::vector<KeyPart> changed = parts;
      changed[i].*text += "x";
      EXPECT_NE(key_of(changed), key_of(parts));
    }
  EXPECT_NE(key_of(std::vector<KeyPart>{{"a", "bc", "d"}}), key_of(std::vector<KeyPart>{{"ab", "c", "d"}}));
  EXPECT_FALSE(is_key("../../etc/passwd"));
  EXPECT_FALSE(is_key(std::string(31, 'a')));
  EXPECT_FALSE(is_key(std::string(32, 'A')));
}

TEST(KeyParts, NamesThatAreNoTextStayApart) {
  EXPECT_EQ(portable_text("h\xc3\xa4sel.glb"), "h\xc3\xa4sel.glb");
  EXPECT_EQ(portable_text("\xff\x01"),
            "\xef\xbf\xbd"
            "ff01");
  EXPECT_NE(portable_text("\xef\xbf\xbd"
                          "ff01"),
            portable_text("\xff\x01"));
}

TEST(CacheEntry, ComesBackAsItWasStoredAndEveryChangeIsNoticed) {
  const test::TemporaryFolder folder;
  const CachedBake entry = entry_of("oak.glb", 50);
  const std::string key = key_of(entry.parts);
  EXPECT_EQ(load_cached(folder.path(), key).error().status, Status::io);
  store(folder.path(), entry);
  const auto loaded = load_cached(folder.path(), key);
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->bytes, entry.bytes);
  EXPECT_EQ(loaded->source_leaves, 12u);
  EXPECT_EQ(loaded->foliage_bytes, 3u);
  EXPECT_EQ(loaded->parts, entry.parts);
  EXPECT_EQ(loaded->warnings, entry.warnings);
  EXPECT_FALSE(load_cached(folder.path(), "abd"));

  const fs::path bytes_file = cached_file(folder.path(), key), record_path = record_file(folder.path(), key);
  for (const fs::path& file : {bytes_file, record_path}) {
    const std::vector<std::uint8_t> whole = *read_file(file);
    const auto peek = [&](const std::vector<std::uint8_t>& bytes) {
      test::write_file(file, bytes);
      return peek_cached(folder.path(), key);
    };
    const auto is_noticed = [&](const std::vector<std::uint8_t>& bytes) {
      const auto found = peek(bytes);
      return !found && found.error().status == Status::bad_file;
    };
    for (std::size_t i = 0; i < whole.size(); ++i) {
      std::vector<std::uint8_t> flipped = whole;
      flipped[i] ^= 1;
      EXPECT_TRUE(is_noticed(flipped)) << file << " byte " << i;
      const std::vector<std::uint8_t> shorter(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(i));
      // Only the line's end may go missing from a record: it says nothing.
      const bool lacks_end = file == record_path && i + 1 == whole.size();
      EXPECT_TRUE(lacks_end ? static_cast<bool>(peek(shorter)) : is_noticed(shorter)) << file << ", " << i << " bytes";
    }
    std::vector<std::uint8_t> longer = whole;
    longer.push_back(7);
    EXPECT_TRUE(file == record_path || is_noticed(longer));
    test::write_file(file, whole);
  }
  fs::remove(bytes_file);
  EXPECT_EQ(load_cached(folder.path(), key).error().status, Status::io);
}

/// A server could fill the memory of whoever parses what it sends.
TEST(CacheEntry, ARecordThatIsTooLongIsNotParsed) {
  const CachedBake entry = entry_of("a");
  const std::string key = key_of(entry.parts);
  std::string record = record_text(entry);
  record.resize(kMaxRecordBytes, ' ');
  EXPECT_TRUE(read_entry(bytes_of(record), entry.bytes, key));
  EXPECT_FALSE(read_entry(bytes_of(record += ' '), entry.bytes, key));
}

TEST(WhyBaked, NamesWhatDiffersFromTheNearestEntry) {
  const auto reasons = [](auto change) {
    std::vector<KeyPart> parts = oak_parts();
    change(parts);
    std::vector<KeyPart> far = oak_parts();
    far[0].value = "24";
    far[3].value = "7";
    far[5].value = "ff";
    return why_baked(parts, std::vector<KnownKey>{{"1", 5, far}, {"2", 1, oak_parts()}});
  };
  std::set<std::string> told;
  const auto expect_one = [&](auto change, std::initializer_list<std::string_view> names) {
    const Lines lines = reasons(change);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_TRUE(test::mentions(lines[0], names));
    EXPECT_TRUE(told.insert(lines[0]).second) << "this reason is that of another difference too: " << lines[0];
  };
  expect_one([](auto& parts) { parts[0].value = "26"; }, {"26", "25"});
  expect_one([](auto& parts) { parts[1].value = "14"; }, {"14", "13"});
  expect_one([](auto& parts) { parts[3].value = "20"; }, {"views", "20", "42"});
  expect_one([](auto& parts) { parts.push_back({"option", "node", "oak_LOD1"}); }, {"node", "oak_LOD1"});
  expect_one([](auto& parts) { parts[4].value = "elm.glb"; }, {"elm.glb", "oak.glb"});
  expect_one([](auto& parts) { parts[5].value = "cc"; }, {});
  expect_one([](auto& parts) { parts[6].value = "cc"; }, {"bark.png"});
  expect_one([](auto& parts) { parts[6].value = "missing"; }, {"bark.png"});
  expect_one([](auto& parts) { parts.pop_back(); }, {"bark.png"});
  expect_one([](auto& parts) { parts.push_back({"device", "", "llvmpipe"}); }, {"llvmpipe"});
  expect_one([](auto&) {}, {});
  expect_one([](auto& parts) { parts[4].value = "elm.glb", parts[5].value = "cc"; }, {});
  const Lines two = reasons([](auto& parts) { parts[2].value = "mi", parts[3].value = "20"; });
  ASSERT_EQ(two.size(), 2u);
  EXPECT_TRUE(test::mentions(two[0], {"metric", "mi", "default"}));
  EXPECT_TRUE(test::mentions(two[1], {"views", "20", "42"}));
}

TEST(WhyBaked, ReadsTheKeysOfAFolder) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(known_keys(folder / "nowhere").empty());
  const std::string key = store(folder.path(), entry_of("oak.glb"));
  test::write_file(folder / (std::string(32, 'a') + ".record").c_str(), std::vector<std::uint8_t>(5));
  const std::vector<KnownKey> known = known_keys(folder.path());
  ASSERT_EQ(known.size(), 1u);
  EXPECT_EQ(known[0].key, key);
  EXPECT_EQ(known[0].parts, oak_parts());
}

TEST(CacheLocation, TellsFoldersFromAddressesAndRefusesSecrets) {
  EXPECT_EQ(parse_cache_location("/mnt/cache")->folder, "/mnt/cache");
  EXPECT_EQ(parse_cache_location("cache")->url, "");
  EXPECT_EQ(parse_cache_location("https://host/plants//")->url, "https://host/plants");
  for (const char* bad : {"", "ftp://host/x", "https://", "https://ann:secret@host/x", "https://secret@host/x", "https://host/x?secret=1",
                          "https://host/x#secret", "http://ho st:secret/"}) {
    const auto location = parse_cache_location(bad);
    ASSERT_FALSE(location) << bad;
    EXPECT_EQ(location.error().message().find("secret"), std::string::npos) << location.error().message();
  }
}

TEST(CacheLocation, CredentialsAreAPasswordOrAToken) {
  const auto with = [](const char* value) {
    ::setenv(kCredentialsVariable, value, 1);
    return credentials_of_environment();
  };
  EXPECT_EQ(with("")->user, "");
  EXPECT_EQ(with("ann:se:cret")->user, "ann");
  EXPECT_EQ(with("ann:se:cret")->password, "se:cret");
  EXPECT_EQ(with("Bearer abc")->token, "abc");
  for (const char* bad : {"secret", ":secret", "Bearer secret\nX: y"}) {
    const auto credentials = with(bad);
    ASSERT_FALSE(credentials) << bad;
    EXPECT_EQ(credentials.error().message().find("secret"), std::string::npos);
  }
  ::unsetenv(kCredentialsVariable);
}

class FolderUpkeep : public testing::Test {
 protected:
  /// An entry that was used so long ago.
  std::string old_entry(const std::string& name, std::int64_t age_s) {
    std::string key = store(folder_.path(), entry_of(name));
    set_age(record_file(folder_.path(), key), age_s);
    return key;
  }
  static void set_age(const fs::path& path, std::int64_t age_s) {
    const timespec time{std::time(nullptr) - age_s, 0};
    const timespec times[2] = {time, time};
    ASSERT_EQ(::utimensat(AT_FDCWD, path.c_str(), times, 0), 0);
  }
  [[nodiscard]] bool has(const std::string& key) const { return static_cast<bool>(peek_cached(folder_.path(), key)); }

  test::TemporaryFolder folder_;
};

TEST_F(FolderUpkeep, AnEntryUnderAnotherKeyIsDamaged) {
  const std::string one = store(folder_.path(), entry_of("a")), other = store(folder_.path(), entry_of("b"));
  for (const auto& file : {cached_file, record_file})
    fs::copy_file(file(folder_.path(), one), file(folder_.path(), other), fs::copy_options::overwrite_existing);
  const auto found = peek_cached(folder_.path(), other);
  ASSERT_FALSE(found) << "one plant's bytes as another's";
  EXPECT_EQ(found.error().status, Status::bad_file);
  EXPECT_EQ(verify_cache(folder_.path(), false, [](std::uint64_t, std::uint64_t) {})->damaged, Lines{other});
}

TEST_F(FolderUpkeep, WhatWasUsedLongestAgoIsPrunedFirst) {
  const std::string oldest = old_entry("a", 300), used = old_entry("b", 200), newest = old_entry("c", 100);
  const std::uint64_t all = cache_stats(folder_.path())->bytes;
  EXPECT_EQ(cache_stats(folder_.path())->entries, 3u);
  EXPECT_EQ(cache_stats(folder_.path())->versions.at("25"), 3u);
  EXPECT_EQ(prune_cache(folder_.path(), all)->removed_entries, 0u);
  ASSERT_TRUE(load_cached(folder_.path(), oldest)) << "a use";
  const auto pruned = prune_cache(folder_.path(), all - 1);
  ASSERT_TRUE(pruned) << pruned.error().message();
  EXPECT_EQ(pruned->removed_entries, 1u);
  EXPECT_EQ(pruned->entries, 2u);
  EXPECT_TRUE(has(oldest));
  EXPECT_FALSE(has(used));
  EXPECT_TRUE(has(newest));
  EXPECT_EQ(prune_cache(folder_.path(), 0)->bytes, 0u);
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(FolderUpkeep, FilesOfWritersThatMayStillRunStay) {
  const fs::path stray = cached_file(folder_.path(), std::string(32, 'a')), old_stray = cached_file(folder_.path(), std::string(32, 'b'));
  const fs::path others = folder_ / ".coppice-999999999-0-00000000.tmp", old_others = folder_ / ".coppice-999999999-1-00000000.tmp",
                 abandoned = folder_ / ".coppice-999999999-0.tmp";
  for (const fs::path& file : {stray, old_stray, others, old_others, abandoned}) test::write_file(file, std::vector<std::uint8_t>(5));
  set_age(old_stray, 4000);
  set_age(old_others, 4000);
  EXPECT_EQ(cache_stats(folder_.path())->stray_files, 2u);
  ASSERT_TRUE(prune_cache(folder_.path(), 0));
  EXPECT_TRUE(fs::exists(stray)) << "a record may follow";
  EXPECT_FALSE(fs::exists(old_stray));
  EXPECT_TRUE(fs::exists(others)) << "another machine may be writing it";
  EXPECT_FALSE(fs::exists(old_others));
  EXPECT_FALSE(fs::exists(abandoned));
}

TEST_F(FolderUpkeep, VerifyFindsWhatIsDamagedAndRemovesItWhenAsked) {
  const std::string good = store(folder_.path(), entry_of("a")), bad = store(folder_.path(), entry_of("b"));
  test::write_file(cached_file(folder_.path(), bad), std::vector<std::uint8_t>(1000));
  std::uint64_t steps = 0;
  const auto count = [&steps](std::uint64_t done, std::uint64_t of) { steps += done <= of ? 1 : 0; };
  for (const bool remove : {false, true}) {
    const auto found = verify_cache(folder_.path(), remove, count);
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_EQ(found->entries, 2u);
    EXPECT_EQ(found->damaged, Lines{bad});
    EXPECT_EQ(found->removed, remove ? 1u : 0u);
  }
  EXPECT_EQ(steps, 4u);
  EXPECT_TRUE(verify_cache(folder_.path(), false, count)->damaged.empty());
  EXPECT_TRUE(has(good));
  EXPECT_FALSE(cache_stats(folder_ / "nowhere"));
}

}  // namespace shared_cache_test
}  // namespace coppice::bake
