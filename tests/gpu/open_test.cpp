// Plants that are opened without waiting, and plants in memory, through coppice.h.

#include <initializer_list>
#include <string>
#include <string_view>

#include "context_fixture.h"
#include "fake_hooks.h"
#include "mentions.h"

namespace coppice::test::open_test {

constexpr std::uint32_t kSidePx = 96;
constexpr const char* kPath = "plant.coppice";
const coppice_placement kHere = placement_at(), kBeside = placement_at({0.5, 0, 0});

class OpenTest : public ContextTest {
 protected:
  void SetUp() override {
    ContextTest::SetUp();
    io_.files[kPath] = plant_bytes({.leaf_count = 2000, .seed = 5});
  }
  void TearDown() override {
    run_all();
    ContextTest::TearDown();
    EXPECT_EQ(io_.open_count, 0u) << "files are left open";
  }

  /// Reads and jobs wait until the test says so.
  void create_held_back() {
    ContextDesc with = desc();
    with.hooks.io = io_.hook();
    with.hooks.jobs = jobs_.hook();
    create(with);
    io_.deferred = jobs_.deferred = true;
  }
  void run_all() {
    io_.deferred = jobs_.deferred = false;
    io_.answer_all();
    jobs_.run_all();
  }

  coppice_plant start(const char* path) {
    coppice_plant plant = 0;
    EXPECT_EQ(coppice_plant_open_async(context_, path, &plant), COPPICE_OK) << log_;
    return plant;
  }

  Shot view_ = make_view({.eye_m = {0.0f, 0.3f, 5.0f}, .width_px = kSidePx});
  FakeIo io_;
  FakeJobs jobs_;
};

TEST_F(OpenTest, InstancesAreThereOnceThePlantIs) {
  create_held_back();
  const coppice_plant plant = start(kPath);
  ASSERT_NE(plant, 0u);
  EXPECT_EQ(info(plant).state, COPPICE_PLANT_OPENING);
  EXPECT_EQ(info(plant).leaf_count, 0u);
  const std::vector<coppice_instance> instances = add(plant, std::vector(3, kHere));
  move(instances[1], kBeside);
  remove({&instances[2], 1});
  EXPECT_EQ(coppice_plant_reload(context_, plant, nullptr), COPPICE_ERROR_INVALID_ARGUMENT) << "not ready";
  for (int i = 0; i < 8 && info(plant).state == COPPICE_PLANT_OPENING; ++i) {
    const bool drawn = drawn_pixels(frame(view_)) > 0;
    const bool ready = info(plant).state == COPPICE_PLANT_READY;
    EXPECT_EQ(drawn, ready) << "frame " << i;
    EXPECT_EQ(stats().instance_count, 2u);
    EXPECT_EQ(stats().source_leaf_count, ready ? 4000u : 0u);
    if (i % 2 == 0) io_.answer_all();
    if (i % 2 == 1) jobs_.run_all();
  }
  EXPECT_EQ(info(plant).state, COPPICE_PLANT_READY);
  run_all();
  EXPECT_GT(drawn_pixels(settle(view_)), 0u);
  frame(view_);
  EXPECT_EQ(view_stats().visible_instance_count, 2u);
  EXPECT_EQ(info(plant).leaf_count, 2000u);
  EXPECT_EQ(stats().source_leaf_count, 4000u);
  remove(std::span(instances).first(2));
  EXPECT_EQ(drawn_pixels(frame(view_)), 0u);
}

TEST_F(OpenTest, ItLooksAsOneThatWasWaitedFor) {
  const auto picture = [&](bool async) {
    ContextDesc with = desc();
    with.hooks.io = io_.hook();
    create(with);
    coppice_plant plant = async ? start(kPath) : open(kPath);
    add(plant, kHere);
    for (int i = 0; i < 500 && info(plant).state == COPPICE_PLANT_OPENING; ++i) pump(view_);
    const Picture settled = settle(view_);
    destroy();
    return settled;
  };
  const Picture waited = picture(false);
  EXPECT_GT(drawn_pixels(waited), 0u);
  EXPECT_EQ(picture(true).rgba, waited.rgba);
}

TEST_F(OpenTest, APlantIsClosedAtAnyMomentOfItsOpening) {
  create_held_back();
  for (int frames = 0; frames < 7; ++frames) {
    io_.deferred = jobs_.deferred = true;
    const coppice_plant plant = start(kPath);
    const coppice_instance instance = add(plant, kHere);
    for (int i = 0; i < frames; ++i) {
      frame(view_);
      if (i + 1 < frames && i % 2 == 0) io_.answer_all();
      if (i + 1 < frames && i % 2 == 1) jobs_.run_all();
    }
    ASSERT_EQ(coppice_plant_close(context_, plant), COPPICE_OK) << log_;
    EXPECT_EQ(coppice_plant_close(context_, plant), COPPICE_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(coppice_instances_move(context_, &instance, &kHere, sizeof(coppice_placement), 1), COPPICE_ERROR_INVALID_ARGUMENT)
        << "it went with the plant";
    EXPECT_EQ(drawn_pixels(frame(view_)), 0u);
    EXPECT_EQ(stats().instance_count, 0u);
    run_all();
    for (int i = 0; i < 4; ++i) frame(view_);
    EXPECT_EQ(io_.open_count, 0u) << frames;
  }
}

TEST_F(OpenTest, AContextIsDestroyedWhilePlantsAreOpened) {
  for (const bool read : {false, true}) {
    create_held_back();
    for (int i = 0; i < 10; ++i) (void)start(kPath);
    frame(view_);
    if (read) {
      io_.answer_all();
      frame(view_);
    }
    run_all();
    destroy();
    EXPECT_EQ(io_.open_count, 0u);
  }
}

TEST_F(OpenTest, AFailureIsSaidOnceAndTheHandleStaysUntilItIsClosed) {
  io_.files["cut.coppice"] = io_.files[kPath];
  io_.files["cut.coppice"].pop_back();
  io_.files["unread.coppice"] = io_.files[kPath];
  ContextDesc with = desc();
  with.hooks.io = io_.hook();
  with.max_plants = 3;
  create(with);
  struct Case {
    const char* path;
    coppice_status status;
  };
  std::vector<coppice_plant> plants;
  for (const auto& [path, status] :
       {Case{"missing.coppice", COPPICE_ERROR_IO}, {"cut.coppice", COPPICE_ERROR_BAD_FILE}, {"unread.coppice", COPPICE_ERROR_IO}}) {
    io_.fail_offset = std::string(path) == "unread.coppice" ? 0 : UINT64_MAX;
    log_.clear();
    const coppice_plant plant = start(path);
    add(plant, kHere);
    for (int i = 0; i < 3000 && info(plant).state == COPPICE_PLANT_OPENING; ++i) pump(view_);
    EXPECT_EQ(info(plant).state, COPPICE_PLANT_FAILED) << path;
    EXPECT_EQ(info(plant).failure, status) << path;
    EXPECT_EQ(stats().instance_count, 0u);
    EXPECT_EQ(std::ranges::count(log_, '\n'), 1) << log_;
    EXPECT_EQ(log_.rfind(path, 0), 0u) << log_;
    EXPECT_EQ(try_add(plant, std::span(&kHere, 1)), COPPICE_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(coppice_plant_reload(context_, plant, kPath), COPPICE_ERROR_INVALID_ARGUMENT);
    plants.push_back(plant);
  }
  io_.fail_offset = UINT64_MAX;
  coppice_plant another = 1;
  EXPECT_EQ(coppice_plant_open_async(context_, kPath, &another), COPPICE_ERROR_OUT_OF_MEMORY) << "those that failed count";
  EXPECT_EQ(another, 0u);
  for (const coppice_plant plant : plants) EXPECT_EQ(coppice_plant_close(context_, plant), COPPICE_OK);
  frame(view_);
  EXPECT_NE(open(kPath), 0u);
}

TEST_F(OpenTest, APlantInMemoryIsDrawnAndReloaded) {
  const std::vector<std::uint8_t> first = plant_bytes({.leaf_count = 2000, .seed = 5}),
                                  second = plant_bytes({.leaf_count = 3000, .seed = 5});
  ContextDesc with = desc();
  with.hooks.io = io_.hook();
  create(with);
  coppice_plant plant = 0;
  ASSERT_EQ(coppice_plant_open_memory(context_, first.data(), first.size(), "pack:oak", &plant), COPPICE_OK) << log_;
  add(plant, kHere);
  view_.lod = COPPICE_LOD_FULL;
  const auto settled_leaves = [&] {
    for (int i = 0; i < 300 && info(plant).reloading == VK_TRUE; ++i) pump(view_);
    EXPECT_GT(drawn_pixels(settle(view_)), 0u);
    return info(plant).resident_leaf_count;
  };
  EXPECT_EQ(settled_leaves(), 2000u);
  ASSERT_EQ(coppice_plant_reload_memory(context_, plant, second.data(), second.size(), "pack:oak"), COPPICE_OK) << log_;
  EXPECT_EQ(info(plant).reloading, VK_TRUE);
  EXPECT_EQ(settled_leaves(), 3000u);
  ASSERT_EQ(coppice_plant_reload(context_, plant, nullptr), COPPICE_OK) << log_;
  EXPECT_EQ(settled_leaves(), 3000u) << "the same memory again";
  EXPECT_TRUE(io_.log.empty()) << "the io hook has been called";
  ASSERT_EQ(coppice_plant_reload(context_, plant, kPath), COPPICE_OK) << log_;
  EXPECT_EQ(settled_leaves(), 2000u);
  EXPECT_FALSE(io_.log.empty());
  ASSERT_EQ(coppice_plant_reload_memory(context_, plant, second.data(), second.size(), "pack:oak"), COPPICE_OK) << log_;
  EXPECT_EQ(settled_leaves(), 3000u);
}

TEST_F(OpenTest, BadMemoryIsRefusedAsAFileIs) {
  create(desc());
  std::vector<std::uint8_t> bytes = plant_bytes({.leaf_count = 100, .seed = 5});
  coppice_plant plant = 1;
  const auto expect_refused = [&](coppice_status actual, coppice_status expected, std::initializer_list<std::string_view> names) {
    EXPECT_EQ(actual, expected);
    EXPECT_TRUE(mentions(log_, names));
    log_.clear();
  };
  const auto open_memory = [&](const void* from, std::size_t size, const char* name, coppice_plant* out) {
    return coppice_plant_open_memory(context_, from, size, name, out);
  };
  const auto bad = COPPICE_ERROR_BAD_FILE, invalid = COPPICE_ERROR_INVALID_ARGUMENT;
  expect_refused(open_memory(bytes.data(), 10, "pack:short", &plant), bad, {"pack:short: "});
  EXPECT_EQ(plant, 0u);
  bytes[0] ^= 1;
  expect_refused(open_memory(bytes.data(), bytes.size(), "pack:odd", &plant), bad, {"pack:odd: "});
  bytes[0] ^= 1;
  expect_refused(open_memory(nullptr, 10, "pack", &plant), invalid, {": bytes", "null"});
  expect_refused(open_memory(bytes.data(), 0, "pack", &plant), invalid, {": size", "0"});
  expect_refused(open_memory(bytes.data(), 10, nullptr, &plant), invalid, {": name", "null"});
  expect_refused(open_memory(bytes.data(), 10, "pack", nullptr), invalid, {": plant", "null"});
  expect_refused(coppice_plant_open_async(context_, nullptr, &plant), invalid, {": path", "null"});
  expect_refused(coppice_plant_open_async(context_, "a", nullptr), invalid, {": plant", "null"});
  for (const coppice_status status :
       {coppice_plant_open_async(nullptr, "a", &plant), coppice_plant_open_memory(nullptr, "a", 1, "a", &plant),
        coppice_plant_reload_memory(nullptr, plant, "a", 1, "a")})
    EXPECT_EQ(status, invalid);
  ASSERT_EQ(open_memory(bytes.data(), bytes.size(), "pack:good", &plant), COPPICE_OK) << log_;
  expect_refused(coppice_plant_reload_memory(context_, plant, bytes.data(), 10, "pack:short"), bad, {"pack:short: "});
  EXPECT_EQ(info(plant).reloading, VK_FALSE);
  expect_refused(coppice_plant_reload_memory(context_, plant, bytes.data(), 0, "pack"), invalid, {": size", "0"});
}

}  // namespace coppice::test::open_test
