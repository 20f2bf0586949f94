// Which tiles of a scene are wanted, and how they come and go.
#include "scene_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>

#include "fake_hooks.h"
#include "io_result.h"
#include "mentions.h"
#include "process.h"
#include "results.h"
#include "scene_file.h"
#include "tile_selection.h"

namespace coppice::scene_stream_test {

constexpr float kSide_m = 4000.0f;
constexpr std::size_t kPlants = 40000;

const std::vector<std::uint8_t>& scene_bytes() {
  static const std::vector<std::uint8_t> bytes = test::random_scene(kPlants, kSide_m, 11);
  return bytes;
}

SceneEye eye_at(float x, float z) {
  return {{x, 2.0f, z}, 600.0f, 0.1f};
}

float size_of(const SceneTile& tile, const SceneEye& eye) {
  return tile_size_px(tile, {&eye, 1});
}

std::vector<TileSize> gather(const SceneFile& scene, const SceneEye& eye, float floor_px) {
  std::vector<std::uint32_t> scratch(scene.tiles.size());
  std::vector<TileSize> found(scene.tiles.size());
  found.resize(gather_tiles(scene, {&eye, 1}, floor_px, scratch, found));
  return found;
}

float fit(const SceneFile& scene, std::vector<TileSize>& tiles, float min_px, std::uint32_t block_count) {
  std::vector<std::uint32_t> scratch(tiles.size());
  return fit_tiles(scene, tiles, min_px, block_count, scratch);
}

TEST(TileSelection, FindsWhatAScanFinds) {
  const auto scene = test::must(read_scene_front(scene_bytes(), scene_bytes().size()));
  for (const SceneEye& eye : {eye_at(0, 0), eye_at(1900, -1800), eye_at(9000, 0)})
    for (const float floor_px : {0.5f, 2.0f, 8.0f, 64.0f}) {
      const std::vector<TileSize> found = gather(scene, eye, floor_px);
      std::vector<std::uint32_t> scan;
      for (std::uint32_t tile = 0; tile < scene.tiles.size(); ++tile)
        if (size_of(scene.tiles[tile], eye) >= floor_px) scan.push_back(tile);
      ASSERT_EQ(found.size(), scan.size()) << floor_px << " px";
      for (std::size_t i = 0; i < scan.size(); ++i) EXPECT_EQ(found[i].tile, scan[i]);
    }
}

TEST(TileSelection, SizeIsThatOfTheLargestPlantAtTheNearestPoint) {
  SceneTile tile;
  tile.entry.max_radius = 5.0f;
  std::ranges::copy(std::array{0.0f, 0.0f, 0.0f}, tile.entry.box_min);
  std::ranges::copy(std::array{100.0f, 0.0f, 100.0f}, tile.entry.box_max);
  EXPECT_FLOAT_EQ(size_of(tile, {{-300.0f, 0.0f, 50.0f}, 600.0f, 0.1f}), 20.0f);
  EXPECT_FLOAT_EQ(size_of(tile, {{-300.0f, 0.0f, 500.0f}, 600.0f, 0.1f}), 12.0f) << "500 m from its corner";
  EXPECT_FLOAT_EQ(size_of(tile, {{50.0f, 60.0f, 50.0f}, 600.0f, 0.1f}), 100.0f) << "above it";
  EXPECT_FLOAT_EQ(size_of(tile, {{50.0f, 0.0f, 50.0f}, 600.0f, 0.5f}), 12000.0f) << "inside: the near plane";
}

TEST(TileSelection, TheThresholdRisesUntilWhatIsWantedFits) {
  const auto scene = read_scene_front(scene_bytes(), scene_bytes().size());
  std::vector<TileSize> tiles = gather(*scene, eye_at(100, 50), 1.0f);
  std::uint32_t all_blocks = 0;
  for (const TileSize& tile : tiles) all_blocks += tile_blocks(scene->tiles[tile.tile]);
  EXPECT_EQ(fit(*scene, tiles, 1.0f, all_blocks), 1.0f);
  EXPECT_TRUE(std::ranges::all_of(tiles, &TileSize::wanted));
  float last_px = 1.0f;
  for (std::uint32_t capacity = all_blocks - 1; capacity >= 32; capacity /= 2) {
    const float px = fit(*scene, tiles, 1.0f, capacity);
    std::uint32_t blocks = 0;
    float min_px = INFINITY, max_left_out_px = 0.0f;
    for (const TileSize& tile : tiles) {
      if (tile.wanted) blocks += tile_blocks(scene->tiles[tile.tile]);
      float& bound_px = tile.wanted ? min_px : max_left_out_px;
      bound_px = tile.wanted ? std::min(bound_px, tile.size_px) : std::max(bound_px, tile.size_px);
    }
    EXPECT_LE(blocks, capacity);
    EXPECT_GT(blocks + 32, capacity) << "another tile might have fitted";
    EXPECT_GE(min_px, px);
    EXPECT_LE(max_left_out_px, px * (1.0f + 1.0f / 16.0f)) << "none larger is left out";
    EXPECT_GE(px, last_px);
    last_px = px;
  }
  EXPECT_GT(fit(*scene, tiles, 1.0f, 0), 1.0f);
  EXPECT_TRUE(std::ranges::none_of(tiles, &TileSize::wanted));
}

TEST(TileSelection, OfTilesOfOneSizeThoseThatAreThereStay) {
  const auto scene = read_scene_front(scene_bytes(), scene_bytes().size());
  std::vector<TileSize> tiles;
  for (std::uint32_t tile = 0; tile < 5; ++tile) tiles.push_back({.tile = tile, .size_px = 100.0f, .kept = tile == 3});
  fit(*scene, tiles, 1.0f, 64);
  EXPECT_TRUE(tiles[3].wanted);
  EXPECT_TRUE(tiles[0].wanted) << "then the first, which is spread over the whole scene";
  EXPECT_FALSE(tiles[1].wanted || tiles[2].wanted || tiles[4].wanted);
}

/// A stream whose owner places everything and opens every species at once.
struct Owner {
  Ledger ledger;
  test::FakeAllocator allocator;
  test::FakeJobs jobs;
  test::FakeIo io;
  test::FakeLog log;
  std::unique_ptr<SceneStream> stream;
  std::set<std::uint32_t> placed;
  std::multiset<std::pair<float, float>> plants;  ///< x, z of what is there
  std::vector<std::vector<SceneInstance>> of_tile;
  std::uint32_t blocks = 0, max_blocks = 0;
  SceneStreamOptions options{.min_px = 1.0f, .max_in_flight = 8, .clock_ns = test::hurried_clock_ns};

  explicit Owner(std::vector<std::uint8_t> bytes = scene_bytes()) {
    io.files["wood/a.forest"] = std::move(bytes);
    open();
  }
  /// Opens after `prepare`.
  explicit Owner(const std::function<void(Owner&)>& prepare) {
    io.files["wood/a.forest"] = scene_bytes();
    prepare(*this);
    open();
  }
  void frame(const SceneEye& eye, std::uint32_t block_count) { frame(std::span(&eye, 1), block_count); }
  void frame(std::span<const SceneEye> eyes, std::uint32_t block_count) {
    stream->begin_frame(eyes, block_count);
    for (const std::uint32_t tile : stream->dropped()) {
      EXPECT_EQ(placed.erase(tile), 1u) << "dropped what was not there";
      blocks -= tile_blocks(stream->file().tiles[tile]);
    }
    while (const auto species = stream->next_species()) stream->species_opened(species->species, true);
    while (const auto ready = stream->next_ready()) {
      EXPECT_TRUE(placed.insert(ready->tile).second);
      of_tile[ready->tile].assign(ready->instances.begin(), ready->instances.end());
      blocks += tile_blocks(stream->file().tiles[ready->tile]);
      stream->placed(ready->tile);
    }
    max_blocks = std::max(max_blocks, blocks);
  }
  void settle(const SceneEye& eye, std::uint32_t block_count) {
    for (int i = 0; i < 100; ++i) frame(eye, block_count);
  }
  std::set<std::uint32_t> wanted(const SceneEye& eye) const {
    std::set<std::uint32_t> tiles;
    for (std::uint32_t tile = 0; tile < stream->file().tiles.size(); ++tile)
      if (size_of(stream->file().tiles[tile], eye) >= stream->stats().threshold_px) tiles.insert(tile);
    return tiles;
  }

 private:
  void open() {
    auto opened = SceneStream::open({allocator.hook(), jobs.hook(), io.hook(), log.hook()}, ledger, "wood/a.forest", options);
    if (!opened) return;
    stream = *std::move(opened);
    of_tile.resize(stream->file().tiles.size());
  }
};

constexpr std::uint32_t kPlenty = 100000;

TEST(SceneStream, BringsWhatIsWantedAndDropsWhatIsNot) {
  Owner owner;
  ASSERT_NE(owner.stream, nullptr);
  const SceneEye here = eye_at(0, 0), far = eye_at(60000, 0);
  owner.settle(here, kPlenty);
  EXPECT_EQ(owner.placed, owner.wanted(here));
  EXPECT_EQ(owner.stream->stats().missing_tiles, 0u);
  EXPECT_EQ(owner.stream->stats().threshold_px, 1.0f);
  EXPECT_GT(owner.placed.size(), 20u);
  owner.frame(far, kPlenty);
  EXPECT_TRUE(owner.placed.empty());
  EXPECT_TRUE(owner.log.lines.empty());
}

TEST(SceneStream, KeepsTheLargestWhereNotAllFit) {
  Owner owner;
  const SceneEye here = eye_at(200, 300);
  constexpr std::uint32_t kFew = 120;  // some 700 are in demand
  owner.settle(here, kFew);
  const float threshold_px = owner.stream->stats().threshold_px;
  EXPECT_GT(threshold_px, 1.0f);
  EXPECT_LE(owner.max_blocks, kFew);
  EXPECT_GT(owner.blocks + 32, kFew);
  for (std::uint32_t tile = 0; tile < owner.of_tile.size(); ++tile) {
    const float px = size_of(owner.stream->file().tiles[tile], here);
    EXPECT_TRUE(owner.placed.contains(tile) || px <= threshold_px * (1.0f + 1.0f / 16.0f)) << px;
    EXPECT_TRUE(!owner.placed.contains(tile) || px >= threshold_px) << px;
  }
  for (int step = 0; step < 60; ++step) owner.frame(eye_at(200.0f + 40.0f * static_cast<float>(step), 300), kFew);
  EXPECT_LE(owner.max_blocks, kFew) << "at no time";
  owner.settle(here, kFew / 2);
  EXPECT_EQ(owner.stream->stats().missing_tiles, 0u);
  EXPECT_LE(owner.blocks, kFew / 2) << "less room: it gives way";
}

TEST(SceneStream, WhereSomeGoTheOthersAreRemembered) {
  for (const std::uint32_t block_count : {600u, 400u, 250u, 150u}) {
    Owner owner;
    for (const float x : {-1500.0f, 1500.0f, -800.0f, 600.0f}) owner.settle(eye_at(x, 300), block_count);
    EXPECT_GT(owner.placed.size(), 1u);
    owner.frame(eye_at(60000, 0), block_count);
    EXPECT_TRUE(owner.placed.empty()) << block_count;
  }
}

TEST(SceneStream, SeveralEyesHaveWhatEachWouldHave) {
  const std::array eyes{eye_at(-1900, 0), eye_at(1900, 300)};
  std::set<std::uint32_t> each;
  for (const SceneEye& eye : eyes) {
    Owner owner;
    owner.settle(eye, kPlenty);
    each.insert(owner.placed.begin(), owner.placed.end());
  }
  Owner both;
  for (int i = 0; i < 100; ++i) both.frame(eyes, kPlenty);
  EXPECT_EQ(both.placed, each);
  EXPECT_EQ(both.stream->stats().missing_tiles, 0u);
  both.frame(std::span<const SceneEye>(), kPlenty);
  EXPECT_TRUE(both.placed.empty()) << "nobody looks";
}

TEST(SceneStream, ACameraThatComesAndGoesReadsNothingNew) {
  Owner owner;
  const SceneEye a = eye_at(0, 0), b = eye_at(30, 0);
  owner.settle(a, kPlenty);
  owner.settle(b, kPlenty);
  const std::size_t reads = owner.io.log.size();
  for (int i = 0; i < 20; ++i) owner.frame(i % 2 == 0 ? a : b, kPlenty);
  EXPECT_EQ(owner.io.log.size(), reads);
}

TEST(SceneStream, NothingBlocksAndNoMoreIsReadThanMayBe) {
  Owner owner;
  owner.io.deferred = owner.jobs.deferred = true;
  const SceneEye here = eye_at(0, 0);
  for (int i = 0; i < 5; ++i) owner.frame(here, kPlenty);
  EXPECT_EQ(owner.io.waiting.size(), 8u);
  EXPECT_TRUE(owner.placed.empty());
  // The first asked for is the largest on screen.
  const SceneFile& scene = owner.stream->file();
  float largest_px = 0.0f;
  for (const SceneTile& tile : scene.tiles) largest_px = std::max(largest_px, size_of(tile, here));
  const auto first = std::ranges::find(scene.tiles, owner.io.waiting.front().offset, &SceneTile::offset);
  ASSERT_NE(first, scene.tiles.end());
  EXPECT_EQ(size_of(*first, here), largest_px);
  owner.io.answer_all();
  owner.frame(here, kPlenty);
  EXPECT_EQ(owner.jobs.waiting.size(), 8u);
  owner.jobs.run_all();
  owner.frame(here, kPlenty);
  EXPECT_EQ(owner.placed.size(), 8u);
  // What is under way when the camera has gone is not placed.
  owner.io.answer_all();
  owner.frame(eye_at(60000, 0), kPlenty);
  owner.jobs.run_all();
  owner.frame(eye_at(60000, 0), kPlenty);
  EXPECT_TRUE(owner.placed.empty());
  owner.io.answer_all();
  owner.jobs.run_all();
}

TEST(SceneStream, PlacesTheWholeScene) {
  Owner owner;
  for (const float x : {-1500.0f, 0.0f, 1500.0f})
    for (const float z : {-1500.0f, 0.0f, 1500.0f}) owner.settle(eye_at(x, z), kPlenty);
  std::size_t plants = 0;
  for (const auto& tile : owner.of_tile) plants += tile.size();
  EXPECT_EQ(plants, kPlants) << "each in one tile";
}

std::uint64_t tile_clock_ns = 0;

TEST(SceneStream, ATileThatIsDamagedOrCannotBeReadIsToldOnceAndTheRestGoesOn) {
  const SceneEye here = eye_at(0, 0);
  for (const bool damaged : {true, false}) {
    Owner owner([](Owner& unopened) { unopened.options.clock_ns = [] { return tile_clock_ns += 50'000'000; }; });
    const std::uint64_t offset = owner.stream->file().tiles[0].offset;
    if (damaged)
      owner.io.files["wood/a.forest"][static_cast<std::size_t>(offset) + 5] ^= 1;
    else
      owner.io.fail_offset = offset;
    owner.io.failing_result = -EIO;
    owner.io.log.clear();
    owner.settle(here, kPlenty);
    ASSERT_EQ(owner.log.lines.size(), 1u);
    EXPECT_TRUE(test::mentions(
        owner.log.lines[0], {"wood/a.forest: tile 0", damaged ? "tile checksum" : std::strerror(EIO), "byte " + std::to_string(offset)}));
    EXPECT_EQ(std::ranges::count(owner.io.log, offset, &test::FakeRead::offset), std::ptrdiff_t{damaged ? 1 : kReadAttempts});
    auto wanted = owner.wanted(here);
    wanted.erase(0);
    EXPECT_EQ(owner.placed, wanted);
    EXPECT_EQ(owner.stream->stats().tiles_failed, 1u);
    EXPECT_EQ(owner.stream->stats().missing_tiles, 0u);
  }
}

TEST(SceneStream, ATileThatCouldNotBeReadIsReadAgainAfterAWhileOrWhenTheEngineSaysSo) {
  const SceneEye here = eye_at(0, 0);
  for (const bool said : {false, true}) {
    tile_clock_ns = 1;
    Owner owner([](Owner& unopened) { unopened.options.clock_ns = [] { return tile_clock_ns; }; });
    const std::uint64_t offset = owner.stream->file().tiles[0].offset;
    owner.io.fail_offset = offset;
    owner.io.failing_result = -EIO;
    const auto attempts = [&] { return std::ranges::count(owner.io.log, offset, &test::FakeRead::offset); };
    const auto wait_s = [&](double seconds) {
      tile_clock_ns += static_cast<std::uint64_t>(1e9 * seconds);
      owner.settle(here, kPlenty);
    };
    for (int i = 0; i < 4; ++i) wait_s(0.9);
    EXPECT_EQ(attempts(), std::ptrdiff_t{kReadAttempts});
    wait_s(5.0);
    wait_s(9.0);
    EXPECT_EQ(attempts(), std::ptrdiff_t{kReadAttempts} + 1) << "one at a time";
    EXPECT_EQ(owner.log.lines.size(), 1u) << "said once";
    EXPECT_EQ(owner.stream->stats().tiles_failed, 1u);
    owner.io.fail_offset = UINT64_MAX;
    if (said)
      owner.stream->retry_failed();
    else
      tile_clock_ns += 1'000'000'000;
    owner.settle(here, kPlenty);
    EXPECT_EQ(owner.placed, owner.wanted(here));
    EXPECT_EQ(owner.stream->stats().tiles_failed, 0u);
  }
}

TEST(SceneStream, AReadThatNobodyNeedsIsCancelled) {
  Owner owner([](Owner& unopened) { unopened.io.cancels = true; });
  owner.io.deferred = true;
  owner.stream->begin_frame(std::array{eye_at(0, 0)}, kPlenty);
  const std::size_t reads = owner.io.waiting.size();
  EXPECT_GT(reads, 1u);
  owner.stream->begin_frame(std::array{eye_at(60000, 0)}, kPlenty);
  EXPECT_EQ(owner.io.cancelled, reads);
  owner.stream->begin_frame(std::array{eye_at(0, 0)}, kPlenty);
  EXPECT_EQ(owner.io.waiting.size(), reads) << "it is read anew";
  owner.stream.reset();  // does not wait for what nobody answers
  EXPECT_EQ(owner.io.cancelled, 2 * reads);
  EXPECT_EQ(owner.allocator.live_count, 0u);
  EXPECT_TRUE(owner.log.lines.empty());
}

TEST(SceneStream, EveryReadMayFailAFewTimes) {
  const SceneEye here = eye_at(0, 0);
  for (const test::ReadFault fault : {test::ReadFault::fails, test::ReadFault::comes_short})
    for (std::size_t n = 0;; n += n < 4 ? 1 : 7) {
      Owner owner([&](Owner& unopened) {
        unopened.io.fault = fault;
        unopened.io.fault_at = n;
        unopened.io.fault_attempts = kReadAttempts - 1;
      });
      ASSERT_NE(owner.stream, nullptr) << n;
      owner.settle(here, kPlenty);
      EXPECT_TRUE(owner.log.lines.empty()) << n << ": " << owner.log.lines[0];
      EXPECT_EQ(owner.placed, owner.wanted(here)) << n;
      const bool reached = owner.io.answered > n;
      owner.stream.reset();
      EXPECT_EQ(owner.allocator.live_count, 0u) << n;
      if (!reached) break;
    }
}

TEST(SceneStream, ATileWhoseReadIsPausedIsForgottenWhenTheCameraGoes) {
  Owner owner([](Owner& unopened) { unopened.options.clock_ns = [] { return std::uint64_t{1}; }; });
  owner.io.fail_offset = owner.stream->file().tiles[0].offset;
  owner.settle(eye_at(0, 0), kPlenty);
  EXPECT_EQ(owner.stream->stats().missing_tiles, 1u) << "it is waited for";
  owner.settle(eye_at(60000, 0), kPlenty);
  owner.io.fail_offset = UINT64_MAX;
  owner.settle(eye_at(0, 0), kPlenty);
  EXPECT_EQ(owner.placed, owner.wanted(eye_at(0, 0))) << "asked for anew, though the clock stands still";
  EXPECT_TRUE(owner.log.lines.empty());
}

/// A scene of two plants, one of them at `path`.
std::vector<std::uint8_t> scene_with(const std::string& path) {
  std::vector<SceneSpecies> species = test::scene_species();
  species[1].path = path;
  std::vector<bake::ScenePlant> plants = test::random_scene_plants(200, 100, 3);
  return *bake::encode_scene(species, plants);
}

TEST(SceneStream, APlantOutsideTheFolderIsLeftOutAndSaidOnce) {
  for (const char* path : {"../oak.coppice", "../../../etc/passwd", "trees/../../oak.coppice"}) {
    Owner owner(scene_with(path));
    ASSERT_NE(owner.stream, nullptr);
    owner.settle(eye_at(0, 0), kPlenty);
    EXPECT_EQ(owner.stream->species_state(1), SpeciesState::failed) << path;
    EXPECT_EQ(owner.stream->stats().species_failed, 1u);
    EXPECT_EQ(owner.stream->stats().missing_tiles, 0u) << "the others come";
    ASSERT_EQ(owner.log.lines.size(), 1u) << path;
    EXPECT_TRUE(test::mentions(owner.log.lines[0], {"wood/a.forest: plant 1", path, "asset_root"}));
  }
}

TEST(SceneStream, AnAssetRootAndAPermissionLetPlantsBeElsewhere) {
  for (const AssetFolder& folder : {AssetFolder{.root = "."}, AssetFolder{.root = "wood/.."}, AssetFolder{.allow_outside = true}}) {
    Owner owner([&](Owner& unopened) {
      unopened.io.files["wood/a.forest"] = scene_with("../oak.coppice");
      unopened.options.plants = folder;
    });
    owner.settle(eye_at(0, 0), kPlenty);
    EXPECT_EQ(owner.stream->species_state(1), SpeciesState::open) << folder.root;
    EXPECT_TRUE(owner.log.lines.empty());
  }
  EXPECT_FALSE(check_species_path({.root = "wood/plants"}, "wood/a.forest", "oak.coppice"));
  EXPECT_TRUE(check_species_path({.root = "wood/plants"}, "wood/a.forest", "plants/oak.coppice"));
  EXPECT_FALSE(check_species_path({.root = "/assets"}, "wood/a.forest", "oak.coppice")) << "the letters do not say where that is";
}

TEST(SpeciesPath, FollowsLinksOfRealFiles) {
  namespace fs = std::filesystem;
  const test::TemporaryFolder temporary;
  const fs::path& base = temporary.path();
  fs::create_directories(base / "scene");
  std::ofstream(base / "scene/in.coppice") << "in";
  std::ofstream(base / "out.coppice") << "out";
  fs::create_symlink("../out.coppice", base / "scene/link.coppice");
  fs::create_directory_symlink("scene", base / "alias");
  const std::string scene = (base / "scene/a.forest").string(), alias = (base / "alias/a.forest").string();
  EXPECT_TRUE(check_species_path({.real_files = true}, scene, "in.coppice"));
  EXPECT_TRUE(check_species_path({.real_files = true}, alias, "in.coppice"));
  EXPECT_EQ(check_species_path({.real_files = true}, scene, "link.coppice").error().status, Status::invalid_argument);
  EXPECT_TRUE(check_species_path({}, scene, "link.coppice")) << "a hook's own paths";
  EXPECT_TRUE(check_species_path({.allow_outside = true, .real_files = true}, scene, "link.coppice"));
  const AssetFolder whole{.root = base.string(), .real_files = true};
  EXPECT_TRUE(check_species_path(whole, alias, "../out.coppice"));
  EXPECT_TRUE(check_species_path(whole, scene, "link.coppice"));
  EXPECT_FALSE(check_species_path(whole, scene, "../../out.coppice"));
  EXPECT_FALSE(check_species_path({.root = (base / "scene").string(), .real_files = true}, scene, "link.coppice"));
  test::expect_error(check_species_path({.real_files = true}, scene, "none.coppice"), Status::io, {"none.coppice", std::strerror(ENOENT)});
}

TEST(SceneStream, ATileWaitsForItsSpecies) {
  Owner owner;
  const SceneEye here = eye_at(0, 0);
  owner.stream->begin_frame({&here, 1}, kPlenty);
  owner.stream->begin_frame({&here, 1}, kPlenty);
  EXPECT_FALSE(owner.stream->next_ready());
  const auto first = owner.stream->next_species();
  ASSERT_TRUE(first);
  EXPECT_STREQ(first->path, "wood/shrub.coppice") << "beside the scene";
  owner.stream->species_opened(0, true);
  EXPECT_FALSE(owner.stream->next_ready()) << "the other one is in every tile";
  EXPECT_EQ(owner.stream->next_species()->species, 1u);
  owner.stream->species_opened(1, false);
  EXPECT_EQ(owner.stream->species_state(1), SpeciesState::failed);
  EXPECT_FALSE(owner.stream->next_species()) << "never again";
  EXPECT_TRUE(owner.stream->next_ready());
}

TEST(SceneStream, AnAllocatorThatFailsIsSurvivedWithoutALeak) {
  for (std::size_t n = 0;; ++n) {
    Owner owner([&](Owner& unopened) {
      unopened.options.max_in_flight = 4;
      unopened.allocator.fail_at = n;
    });
    if (owner.stream == nullptr) {
      EXPECT_EQ(owner.log.lines.size(), 1u) << n;
    } else {
      owner.settle(eye_at(0, 0), kPlenty);
      if (owner.allocator.calls <= owner.allocator.fail_at) break;  // nothing failed any more
      EXPECT_EQ(owner.placed, owner.wanted(eye_at(0, 0))) << n << ": tried again later";
    }
    owner.stream.reset();
    EXPECT_EQ(owner.allocator.live_count, 0u) << n;
    EXPECT_EQ(owner.io.open_count, 0u) << n;
    if (n > 20) n += 37;
  }
}

TEST(SceneStream, WhatIsNoSceneIsRefused) {
  Owner truncated(std::vector<std::uint8_t>(scene_bytes().begin(), scene_bytes().end() - 1));
  EXPECT_EQ(truncated.stream, nullptr);
  ASSERT_EQ(truncated.log.lines.size(), 1u);
  EXPECT_NE(truncated.log.lines[0].find("file_bytes"), std::string::npos) << truncated.log.lines[0];
  EXPECT_EQ(truncated.io.open_count, 0u) << "closed again";
  Owner empty(std::vector<std::uint8_t>{});
  EXPECT_EQ(empty.stream, nullptr);
}

}  // namespace coppice::scene_stream_test
