// The cache of finished bakes: what makes two bakes the same, keys and what tells two of them apart, entries, upkeep of folders, addresses.
// Servers: cache_server_test.

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <initializer_list>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "atomic_file.h"
#include "bake_cache.h"
#include "bake_key.h"
#include "batch_manifest.h"
#include "cache_location.h"
#include "cache_upkeep.h"
#include "generate_plant.h"
#include "gltf_builder.h"
#include "gltf_write.h"
#include "key_parts.h"
#include "mentions.h"
#include "process.h"
#include "text_bytes.h"

namespace coppice::bake::cache_test {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;
using Lines = std::vector<std::string>;

std::string key_of_file(const fs::path& input, const BakeOptions& options = {}) {
  const auto key = bake_key(input, options);
  EXPECT_TRUE(key) << key.error().message();
  return key ? *key : "";
}

/// A .gltf whose buffer and image are files beside it, one of them with a name that a URI cannot hold as it is.
struct PlantOfFiles {
  test::TemporaryFolder folder;
  fs::path gltf = folder / "plant.gltf", buffer = folder / "leaves of it.bin", image = folder / "leaf.png";

  PlantOfFiles() {
    test::GltfBuilder builder = test::small_plant();
    builder.json["images"] = {{{"uri", "leaf.png"}}};
    builder.json["textures"] = {{{"source", 0}}};
    test::write_file(gltf, builder.gltf_beside("leaves%20of%20it.bin"));
    test::write_file(buffer, builder.bin);
    test::write_file(image, test::png(2, 2, {10, 200, 10, 255}));
  }
};

TEST(BakeKey, EveryFileTheInputRefersToCounts) {
  const PlantOfFiles plant;
  const std::vector<GltfReference> referred = referred_files(*read_file(plant.gltf));
  ASSERT_EQ(referred.size(), 2u);
  EXPECT_EQ(referred[0].place(), "buffers[0].uri");
  EXPECT_EQ(percent_decoded(referred[0].uri), plant.buffer.filename());
  EXPECT_EQ(referred[1].place(), "images[0].uri");
  const std::string before = key_of_file(plant.gltf);
  EXPECT_TRUE(is_key(before));
  EXPECT_EQ(key_of_file(plant.gltf), before);
  std::set<std::string> keys{before};
  for (const fs::path& file : {plant.gltf, plant.buffer, plant.image}) {
    const Bytes bytes = *read_file(file);
    Bytes changed = bytes;
    changed.back() = changed.back() == ' ' ? '\n' : ' ';
    test::write_file(file, changed);
    EXPECT_TRUE(keys.insert(key_of_file(plant.gltf)).second) << file << " changed";
    test::write_file(file, bytes);
    EXPECT_EQ(key_of_file(plant.gltf), before) << file << " changed back";
  }
  fs::remove(plant.image);
  EXPECT_TRUE(keys.insert(key_of_file(plant.gltf)).second) << "the image is gone";
  test::write_file(plant.image, Bytes());
  EXPECT_TRUE(keys.insert(key_of_file(plant.gltf)).second) << "the image is empty";
}

/// Every option that changes a bake counts in its key, and is in the list that a task of a cluster gets.
TEST(BakeKey, NamesAndEveryOptionCountThreadsDoNot) {
  const PlantOfFiles plant;
  const fs::path list = plant.folder / "list.json", out = plant.folder / "out";
  const std::vector<std::function<void(BakeOptions&)>> changes = {
      [](BakeOptions&) {},
      [](BakeOptions& options) { options.metric = Metric::mi; },
      [](BakeOptions& options) { options.metric = Metric::geometric; },
      [](BakeOptions& options) { options.view_count = 20; },
      [](BakeOptions& options) { options.import.leaf_material = ""; },
      [](BakeOptions& options) { options.import.leaf_material = "^le\"a[f]$"; },
      [](BakeOptions& options) { options.import.wood_material = "^le\"a[f]$"; },
      [](BakeOptions& options) { options.import.classes = {{.material = "leaves"}}; },
      [](BakeOptions& options) { options.import.classes = {{.material = "leaves", .part = PlantPart::dropped}}; },
      [](BakeOptions& options) { options.import.classes = {{.material = "leaves", .max_triangles = 7}}; },
      [](BakeOptions& options) {
        options.import.classes = {{"^x$", PlantPart::dropped, 3, 9}, {"y", PlantPart::wood, 0, 5}};
      },
      [](BakeOptions& options) { options.import.plant.node = "oak_LOD1"; },
      [](BakeOptions& options) { options.import.plant.variant = 2; },
      [](BakeOptions& options) { options.import.plant.whole = true; },
      [](BakeOptions& options) { options.import.up = UpAxis::z; },
      [](BakeOptions& options) { options.import.origin = Origin::keep; },
      [](BakeOptions& options) { options.import.origin = Origin::foot; },
      [](BakeOptions& options) { options.import.metres_per_unit = 1e-8; },
      [](BakeOptions& options) { options.import.metres_per_unit = 0.0254; },
      [](BakeOptions& options) { options.collapse.resolution_px = 99; },
      [](BakeOptions& options) { options.collapse.count_background = false; },
      [](BakeOptions& options) { options.collapse.candidate_count = 9; },
      [](BakeOptions& options) { options.textures = TextureCoding::rgba8; },
      [](BakeOptions& options) { options.crown_normals = 0.3f; },
      [](BakeOptions& options) { options.leaf_meshes = false; },
      [](BakeOptions& options) { options.wind.moves = false; },
      [](BakeOptions& options) { options.wind.stiffness = 1.7f; },
      [](BakeOptions& options) { options.import.wind_color_set = 0; },
      [](BakeOptions& options) { options.import.wind_color_set = 1; },
  };
  std::set<std::string> keys;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    SCOPED_TRACE("change " + std::to_string(i));
    BakeOptions options;
    changes[i](options);
    options.import.outside_files = i % 2 == 0 ? OutsideFiles::allowed : OutsideFiles::refused;
    options.import.max_source_triangles = i % 2 == 0 ? 0 : 1000;
    const std::string key = key_of_file(plant.gltf, options);
    EXPECT_TRUE(keys.insert(key).second);
    const auto entry = manifest_entry({plant.gltf, out / "a/b.coppice", options}, out);
    ASSERT_TRUE(entry);
    test::write_text(list, "[" + *entry + "]");
    const auto listed = plants_of_manifest(list, out, {});
    ASSERT_TRUE(listed) << listed.error().message();
    EXPECT_EQ(listed->front().input, plant.gltf);
    EXPECT_EQ(listed->front().output, out / "a/b.coppice");
    EXPECT_EQ(listed->front().options.import.outside_files, options.import.outside_files);
    EXPECT_EQ(listed->front().options.import.max_source_triangles, options.import.max_source_triangles);
    EXPECT_EQ(key_of_file(plant.gltf, listed->front().options), key);
  }
  BakeOptions options;
  options.thread_count = 7;
  options.import.max_source_triangles = 1000;
  EXPECT_FALSE(keys.insert(key_of_file(plant.gltf, options)).second);
  fs::copy(plant.gltf, plant.folder / "other.gltf");
  EXPECT_TRUE(keys.insert(key_of_file(plant.folder / "other.gltf")).second) << "the file keeps the plant's name";
}

/// The key itself holds the device too, which a test of Vulkan's looks at.
TEST(BakeKey, WhoMeasuresAreasIsAnOption) {
  BakeOptions options;
  options.metric = Metric::mi;
  const std::vector<KeyPart> by_item_buffers = option_parts(options);
  options.areas = Areas::vulkan;
  EXPECT_NE(option_parts(options), by_item_buffers);
}

TEST(BakeKey, OfALargeFileOnlyWhatTheBufferTakesIsRead) {
  const PlantOfFiles plant;
  const std::string before = key_of_file(plant.gltf);
  fs::resize_file(plant.buffer, std::uintmax_t{20} << 30);  // takes no room on the disk; read whole it would not fit the memory
  EXPECT_EQ(key_of_file(plant.gltf), before);
}

TEST(BakeKey, AFileOutsideTheFolderHasAnErrorUnlessItIsAllowed) {
  const PlantOfFiles plant;
  const fs::path inner = plant.folder / "inner";
  fs::create_directories(inner);
  fs::copy(plant.gltf, inner);
  fs::copy(plant.buffer, inner);
  fs::create_symlink(plant.image, inner / "leaf.png");
  const auto key = bake_key(inner / "plant.gltf", {});
  ASSERT_FALSE(key) << "nothing outside is read";
  EXPECT_EQ(key.error().status, Status::invalid_argument);
  EXPECT_TRUE(test::mentions(key.error().message(), {"images[0].uri", "leaf.png", "--allow-outside"}));
  BakeOptions options;
  options.import.outside_files = OutsideFiles::allowed;
  EXPECT_EQ(key_of_file(inner / "plant.gltf", options), key_of_file(plant.gltf));
}

TEST(BakeKey, AnythingHasOneAndWhatCannotBeReadHasAnError) {
  const test::TemporaryFolder folder;
  std::set<std::string> keys;
  const std::string cut_short("glTF\2\0\0\0\xff\xff\xff\xff\xff\xff\xff\xffJSON", 20);
  // A device is not read.
  for (const std::string& bytes :
       Lines{"", "glTF", cut_short, "{", R"([{"uri":"any.glb"}])", R"({"uri":7})", R"({"a":{"uri":"/dev/zero"}})"}) {
    test::write_text(folder / "any.glb", bytes);
    EXPECT_TRUE(keys.insert(key_of_file(folder / "any.glb")).second) << bytes;
  }
  EXPECT_FALSE(bake_key(folder / "nowhere.glb", {}));
  EXPECT_FALSE(bake_key(folder.path(), {}));
}

TEST(BakeVersion, IsRaisedWhenABakeGivesOtherBytes) {
  const std::map<Metric, std::string> expected = {{Metric::default_metric, "a12973d0503bd0d16828411f653b28fe"},
                                                  {Metric::mi, "050655588fb84105514763c101cf6686"}};
  const std::uint32_t expected_at_version = 31;

  const test::TemporaryFolder folder;
  const auto plant = generate_plant("corylus", 1);
  ASSERT_TRUE(plant) << plant.error().message();
  const fs::path input = folder / "corylus.glb";
  ASSERT_TRUE(write_glb(input, {{"leaves", &plant->foliage}, {"wood", &plant->wood}}, plant->materials, plant->images));
  for (const auto& [metric, checksum_text] : expected) {
    BakeOptions options;
    options.metric = metric;
    options.view_count = 6;
    options.collapse.resolution_px = 64;
    BakeReport report;
    const StageProgress progress = [](const char*, double) {};
    const auto bytes = bake(input, options, progress, report);
    ASSERT_TRUE(bytes) << bytes.error().message();
    EXPECT_EQ(checksum_of(std::array{as_text(*bytes)}), checksum_text)
        << "A bake gives other bytes than at version " << expected_at_version
        << " of the baker. If that is meant, raise kBakeVersion in bake_key.h, so that caches bake "
           "again, and put version and checksum here.";
  }
  EXPECT_EQ(kBakeVersion, expected_at_version) << "put the new version here";
}

std::vector<KeyPart> oak_parts() {
  return {{"baker", "", "25"},     {"format", "", "13"}, {"option", "metric", "default"}, {"option", "views", "42"},
          {"name", "", "oak.glb"}, {"input", "", "aa"},  {"file", "bark.png", "bb"}};
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
  for (const std::string& other : Lines{"../../etc/passwd", std::string(31, 'a'), std::string(32, 'A')}) EXPECT_FALSE(is_key(other));
}

TEST(KeyParts, NamesThatAreNoTextStayApart) {
  const std::string replaced = std::string("\xef\xbf\xbd") + "ff01";
  EXPECT_EQ(portable_text("h\xc3\xa4sel.glb"), "h\xc3\xa4sel.glb");
  EXPECT_EQ(portable_text("\xff\x01"), replaced);
  EXPECT_NE(portable_text(replaced), replaced);
}

TEST(WhyBaked, NamesWhatDiffersFromTheNearestEntry) {
  const auto reasons = [](auto change) {
    std::vector<KeyPart> parts = oak_parts(), far = oak_parts();
    change(parts);
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

Status status_of(const Result<CachedBake>& entry) {
  return entry ? Status::ok : entry.error().status;
}

TEST(CacheEntry, ComesBackAsItWasStoredAndEveryChangeIsNoticed) {
  const test::TemporaryFolder folder;
  const CachedBake entry = entry_of("oak.glb", 50);
  EXPECT_EQ(status_of(load_cached(folder.path(), key_of(entry.parts))), Status::io);
  const std::string key = store(folder.path(), entry);
  const auto loaded = load_cached(folder.path(), key);
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->bytes, entry.bytes);
  EXPECT_EQ(loaded->source_leaves, 12u);
  EXPECT_EQ(loaded->foliage_bytes, 3u);
  EXPECT_EQ(loaded->parts, entry.parts);
  EXPECT_EQ(loaded->warnings, entry.warnings);
  EXPECT_FALSE(load_cached(folder.path(), "abd"));

  const fs::path bytes_file = cached_file(folder.path(), key), record = record_file(folder.path(), key);
  for (const fs::path& file : {bytes_file, record}) {
    const Bytes whole = *read_file(file);
    const auto status_with = [&](const Bytes& bytes) {
      test::write_file(file, bytes);
      return status_of(peek_cached(folder.path(), key));
    };
    for (std::size_t i = 0; i < whole.size(); ++i) {
      Bytes flipped = whole;
      flipped[i] ^= 1;
      EXPECT_EQ(status_with(flipped), Status::bad_file) << file << " byte " << i;
      // Only the line's end may go missing from a record: it says nothing.
      const bool lacks_end = file == record && i + 1 == whole.size();
      const Bytes shorter(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(i));
      EXPECT_EQ(status_with(shorter), lacks_end ? Status::ok : Status::bad_file) << file << ", " << i << " bytes";
    }
    Bytes longer = whole;
    longer.push_back(7);
    EXPECT_EQ(status_with(longer), Status::bad_file) << file;
    test::write_file(file, whole);
  }
  fs::remove(bytes_file);
  EXPECT_EQ(status_of(load_cached(folder.path(), key)), Status::io);
}

TEST(CacheEntry, LinksAreNeitherReadNorWrittenThrough) {
  const test::TemporaryFolder folder;
  const CachedBake entry = entry_of("oak.glb");
  const std::string key = store(folder.path(), entry);
  for (const fs::path& file : {cached_file(folder.path(), key), record_file(folder.path(), key)}) {
    const fs::path target = folder / "target";
    fs::rename(file, target);
    fs::create_symlink(target, file);
    const Bytes before = *read_file(target);
    EXPECT_EQ(status_of(peek_cached(folder.path(), key)), Status::bad_file) << file;
    EXPECT_EQ(verify_cache(folder.path(), false, [](std::uint64_t, std::uint64_t) {})->damaged, Lines{key});
    ASSERT_TRUE(store_cached(folder.path(), key, entry_of("oak.glb", 7)));
    EXPECT_EQ(*read_file(target), before) << file;
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(file)));
    store(folder.path(), entry);
  }
  EXPECT_EQ(status_of(load_cached(folder.path(), key)), Status::ok);
}

TEST(CacheEntry, OneThatIsTooLargeIsNeitherReadNorCalledDamaged) {
  const test::TemporaryFolder folder;
  const CachedBake entry = entry_of("oak.glb");
  const std::string key = store(folder.path(), entry);
  EXPECT_EQ(status_of(peek_cached(folder.path(), key, entry.bytes.size())), Status::ok);
  EXPECT_EQ(status_of(peek_cached(folder.path(), key, entry.bytes.size() - 2)), Status::unsupported);
  const fs::path file = cached_file(folder.path(), key);
  fs::resize_file(file, std::uintmax_t{1} << 43);  // 8 TB that are not there
  EXPECT_EQ(status_of(load_cached(folder.path(), key, DamagedEntry::is_removed, 5000)), Status::unsupported);
  const auto found = verify_cache(folder.path(), true, [](std::uint64_t, std::uint64_t) {});
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_EQ(found->too_large, Lines{key});
  EXPECT_TRUE(found->damaged.empty() && found->unreadable.empty() && found->removed == 0);
  EXPECT_TRUE(fs::exists(file) && fs::exists(record_file(folder.path(), key)));
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

class FolderUpkeep : public testing::Test {
 protected:
  /// Stores an entry that was used so long ago, and returns its key.
  std::string stored(const std::string& name, std::int64_t age_s = 0) {
    std::string key = store(root_, entry_of(name));
    set_age(record_file(root_, key), age_s);
    return key;
  }
  static void set_age(const fs::path& path, std::int64_t age_s) {
    const timespec time{std::time(nullptr) - age_s, 0};
    const timespec times[2] = {time, time};
    ASSERT_EQ(::utimensat(AT_FDCWD, path.c_str(), times, 0), 0);
  }
  [[nodiscard]] bool has(const std::string& key) const { return static_cast<bool>(peek_cached(root_, key)); }

  test::TemporaryFolder folder_;
  fs::path root_ = folder_.path();
};

TEST_F(FolderUpkeep, KeysOfAFolderAreRead) {
  EXPECT_TRUE(known_keys(root_ / "nowhere").empty());
  const std::string key = stored("oak.glb");
  test::write_file(record_file(root_, std::string(32, 'a')), Bytes(5));
  const std::vector<KnownKey> known = known_keys(root_);
  ASSERT_EQ(known.size(), 1u);
  EXPECT_EQ(known[0].key, key);
  EXPECT_EQ(known[0].parts, oak_parts());
}

TEST_F(FolderUpkeep, AnEntryUnderAnotherKeyIsDamaged) {
  const std::string one = stored("a"), other = stored("b");
  for (const auto& file : {cached_file, record_file})
    fs::copy_file(file(root_, one), file(root_, other), fs::copy_options::overwrite_existing);
  EXPECT_EQ(status_of(peek_cached(root_, other)), Status::bad_file) << "one plant's bytes as another's";
  EXPECT_EQ(verify_cache(root_, false, [](std::uint64_t, std::uint64_t) {})->damaged, Lines{other});
}

TEST_F(FolderUpkeep, WhatWasUsedLongestAgoIsPrunedFirst) {
  const std::string oldest = stored("a", 300), used = stored("b", 200), newest = stored("c", 100);
  const auto stats = cache_stats(root_);
  EXPECT_EQ(stats->entries, 3u);
  EXPECT_EQ(stats->versions.at("25"), 3u);
  EXPECT_EQ(prune_cache(root_, stats->bytes)->removed_entries, 0u);
  ASSERT_TRUE(load_cached(root_, oldest)) << "a use";
  const auto pruned = prune_cache(root_, stats->bytes - 1);
  ASSERT_TRUE(pruned) << pruned.error().message();
  EXPECT_EQ(pruned->removed_entries, 1u);
  EXPECT_EQ(pruned->entries, 2u);
  EXPECT_TRUE(has(oldest));
  EXPECT_FALSE(has(used));
  EXPECT_TRUE(has(newest));
  EXPECT_EQ(prune_cache(root_, 0)->bytes, 0u);
  EXPECT_TRUE(fs::is_empty(root_));
}

TEST_F(FolderUpkeep, FilesOfWritersThatMayStillRunStay) {
  struct Stray {
    fs::path file;
    std::int64_t age_s;
    bool stays;
    const char* why = "";
  };
  const std::vector<Stray> strays = {{cached_file(root_, std::string(32, 'a')), 0, true, "a record may follow"},
                                     {cached_file(root_, std::string(32, 'b')), 4000, false},
                                     {root_ / ".coppice-999999999-0-00000000.tmp", 0, true, "another machine may be writing it"},
                                     {root_ / ".coppice-999999999-1-00000000.tmp", 4000, false},
                                     {root_ / ".coppice-999999999-0.tmp", 0, false}};
  for (const Stray& stray : strays) set_age(test::write_file(stray.file, Bytes(5)), stray.age_s);
  EXPECT_EQ(cache_stats(root_)->stray_files, 2u);
  ASSERT_TRUE(prune_cache(root_, 0));
  for (const Stray& stray : strays) EXPECT_EQ(fs::exists(stray.file), stray.stays) << stray.file << " " << stray.why;
}

TEST_F(FolderUpkeep, VerifyFindsWhatIsDamagedAndRemovesItWhenAsked) {
  const std::string good = stored("a"), bad = stored("b");
  test::write_file(cached_file(root_, bad), Bytes(1000));
  std::uint64_t steps = 0;
  const auto count = [&steps](std::uint64_t done, std::uint64_t of) { steps += done <= of ? 1 : 0; };
  for (const bool remove : {false, true}) {
    const auto found = verify_cache(root_, remove, count);
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_EQ(found->entries, 2u);
    EXPECT_EQ(found->damaged, Lines{bad});
    EXPECT_EQ(found->removed, remove ? 1u : 0u);
  }
  EXPECT_EQ(steps, 4u);
  EXPECT_TRUE(verify_cache(root_, false, count)->damaged.empty());
  EXPECT_TRUE(has(good));
  EXPECT_FALSE(cache_stats(root_ / "nowhere"));
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

}  // namespace coppice::bake::cache_test
