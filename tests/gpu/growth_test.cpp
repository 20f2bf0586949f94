// Instances and plants come at run time, far more than there is room for at first: what is drawn, what it takes, and what happens where
// there is no memory for it.

#include <cmath>
#include <string>
#include <vector>

#include "context_fixture.h"
#include "counted_memory.h"
#include "device_memory_hook.h"
#include "fake_hooks.h"
#include "replaced_functions.h"

namespace coppice::test::growth_test {

constexpr std::uint32_t kSidePx = 96;

/// Few stand before the camera, beside each other, the others far behind it.
std::vector<coppice_placement> placements_of(std::uint32_t count, std::uint32_t first = 0) {
  std::vector<coppice_placement> placements;
  for (std::uint32_t i = first; i < first + count; ++i) {
    coppice_placement placement = placement_at({0, 0, 300.0f + std::fmod(0.1f * static_cast<float>(i), 500.0f)}, 0.3f);
    if (i % 7000 == 0 || (i < 2000 && i % 250 == 0)) {
      const std::uint32_t place = i < 2000 ? i / 250 : 7 + i / 7000;
      placement.position[0] = 0.7f * (static_cast<float>(place % 8) - 3.5f);
      placement.position[1] = 0.8f * (static_cast<float>(place / 8) - 2.5f);
      placement.position[2] = 0.0f;
    }
    placements.push_back(placement);
  }
  return placements;
}

class GrowthTest : public ContextTest {
 protected:
  ContextDesc desc() {
    ContextDesc with = ContextTest::desc(), plain = default_desc();
    with.max_instances = plain.max_instances;
    with.max_plants = plain.max_plants;
    with.compute_raster = VK_TRUE;
    with.memory_budget_bytes = 512ull << 20;
    with.streaming_ms = 1000.0f;
    return with;
  }

  coppice_plant open(const std::vector<std::uint8_t>& bytes) {
    coppice_plant plant = 0;
    EXPECT_EQ(coppice_plant_open_memory(context_, bytes.data(), bytes.size(), "plant", &plant), COPPICE_OK) << log_;
    return plant;
  }

  Shot view_ = make_view({.eye_m = {0.0f, 0.6f, 5.0f}, .width_px = kSidePx});
  const std::vector<std::uint8_t> crown_ = plant_bytes({.leaf_count = 900, .seed = 5});
};

TEST_F(GrowthTest, ThePictureIsThatOfAContextThatHadAllInstancesFromTheStart) {
  constexpr std::uint32_t kCounts[] = {3, 40, 2000, 30000, 300000};
  for (const VkBool32 compute_raster : {VK_TRUE, VK_FALSE}) {
    ContextDesc with = desc();
    with.compute_raster = compute_raster;
    std::vector<Picture> grown;
    create(with);
    coppice_plant plant = open(crown_);
    std::vector<coppice_instance> handles;
    std::uint32_t there = 0;
    for (const std::uint32_t count : kCounts) {
      handles.resize(count);
      ASSERT_EQ(try_add(plant, placements_of(count - there, there), handles.data() + there), COPPICE_OK) << log_;
      there = count;
      frame(view_);
      grown.push_back(settle(view_));
      EXPECT_LE(stats().memory_peak_bytes, stats().memory_budget_bytes);
    }
    EXPECT_EQ(stats().instance_count, 300000u);
    // Handles of before a growth name what they named.
    const coppice_placement away = placements_of(1, 1)[0];
    for (const std::uint32_t i : {0u, 1500u, 28000u}) move(handles[i], away);
    const Picture moved = frame(view_);
    EXPECT_NE(moved.rgba, grown.back().rgba);
    destroy();

    for (std::size_t i = 0; i < grown.size(); ++i) {
      create(with);
      plant = open(crown_);
      add(plant, placements_of(kCounts[i]));
      EXPECT_TRUE(settle(view_).rgba == grown[i].rgba) << kCounts[i] << " instances, compute shaders: " << compute_raster;
      if (i + 1 < grown.size()) destroy();
    }
    std::vector<coppice_placement> placements = placements_of(300000);
    for (const std::uint32_t i : {0u, 1500u, 28000u}) placements[i] = away;
    destroy();
    create(with);
    plant = open(crown_);
    add(plant, placements);
    EXPECT_TRUE(settle(view_).rgba == moved.rgba);
    destroy();
  }
}

/// What an engine does between the calls of a frame takes effect with the next.
TEST_F(GrowthTest, InstancesThatComeWithinAFrameAreDrawnInTheNext) {
  create(desc());
  const coppice_plant plant = open(crown_);
  add(plant, placements_of(10));
  const Picture few = settle(view_);
  for (std::uint32_t there = 10; there < 100000; there += 30000) {
    const Picture before = frame(view_);
    const Picture during = frame(view_, [&](VkCommandBuffer) {
      add(plant, placements_of(20000, there));
      add(plant, placements_of(10000, there + 20000));
    });
    EXPECT_TRUE(during.rgba == before.rgba) << there;
  }
  const Picture many = frame(view_);
  EXPECT_NE(many.rgba, few.rgba);
  destroy();
  create(desc());
  add(open(crown_), placements_of(120010));
  EXPECT_TRUE(settle(view_).rgba == many.rgba);
}

TEST_F(GrowthTest, TenThousandPlantsAreOpenedAtRunTime) {
  constexpr std::size_t kPlants = 10000;
  const std::vector<std::uint8_t> leaf = plant_bytes({.leaf_count = 1, .seed = 2, .card_count = 1, .wood_lod_count = 0, .texture_side = 0});
  ContextDesc with = desc();
  with.memory_budget_bytes = 1024ull << 20;
  Picture grown;
  for (const std::size_t frames : {20u, 1u}) {
    create(with);
    std::vector<coppice_plant> plants;
    const std::vector<coppice_placement> placements = placements_of(2000);
    for (std::size_t i = 0; i < kPlants; ++i) {
      const bool shown = i % 250 == 7;
      plants.push_back(open(shown ? crown_ : leaf));
      ASSERT_NE(plants.back(), 0u) << i;
      if (shown) add(plants.back(), placements[i / 250 * 50]);
      if (i % (kPlants / frames) == kPlants / frames / 2) frame(view_);
    }
    const Picture picture = settle(view_);
    EXPECT_LE(stats().memory_peak_bytes, stats().memory_budget_bytes);
    EXPECT_EQ(stats().source_leaf_count, 40u * 900);
    EXPECT_EQ(info(plants[7]).leaf_count, 900u) << "handles of before a growth name what they named";
    EXPECT_EQ(info(plants[6]).leaf_count, 1u);
    if (grown.rgba.empty())
      grown = picture;
    else
      EXPECT_TRUE(picture.rgba == grown.rgba);
    destroy();
  }
}

/// Memory is missing at each call of a growth once: nothing has changed, and the next try works.
TEST_F(GrowthTest, AGrowthWithoutMemoryChangesNothing) {
  DeviceMemoryHook device_memory{.gpu = &gpu()};
  FakeAllocator memory;
  FakeJobs jobs;
  ContextDesc with = desc();
  with.hooks.device_memory = device_memory.hook();
  with.hooks.allocator = memory.hook();
  with.hooks.jobs = jobs.hook();
  create(with);
  const coppice_plant plant = open(crown_);
  add(plant, placements_of(1000));
  const Picture before = settle(view_);
  const coppice_stats of_before = stats();
  const std::size_t live = device_memory.live_count, live_bytes = memory.live_bytes;
  const auto expect_unchanged = [&](const char* hook, std::size_t call) {
    EXPECT_EQ(stats().instance_count, 1000u) << hook << call;
    EXPECT_EQ(stats().memory_bytes, of_before.memory_bytes) << hook << call;
    EXPECT_EQ(device_memory.live_count, live) << hook << call;
    EXPECT_EQ(memory.live_bytes, live_bytes) << hook << call;
    EXPECT_TRUE(frame(view_).rgba == before.rgba) << hook << call;
  };
  const std::vector<coppice_placement> more = placements_of(20000, 1000);
  constexpr std::size_t kArrays = 11, kBuffers = 9;
  for (std::size_t n = 0; n < kArrays + kBuffers; ++n) {
    const bool of_device = n >= kArrays;
    memory.fail_at = of_device ? SIZE_MAX : memory.calls + n;
    device_memory.fail_at = of_device ? device_memory.calls + n - kArrays : SIZE_MAX;
    std::vector<coppice_instance> handles(more.size());
    EXPECT_EQ(try_add(plant, more, handles.data()), COPPICE_ERROR_OUT_OF_MEMORY) << n;
    EXPECT_EQ(handles[0], 0u);
    memory.fail_at = device_memory.fail_at = SIZE_MAX;
    expect_unchanged(of_device ? "device_memory " : "allocator ", n);
    if (HasFailure()) return;
  }
  const std::size_t device_calls = device_memory.calls, calls = memory.calls;
  add(plant, more);
  EXPECT_EQ(device_memory.calls, device_calls + kBuffers) << "each was tried";
  EXPECT_EQ(memory.calls, calls + kArrays);
  const Picture after = settle(view_);

  // The renderer has room for 16 plants at first, in four buffers.
  for (int i = 1; i < 16; ++i) open(crown_);
  for (std::size_t call = 0; call < 4; ++call) {
    device_memory.fail_at = device_memory.calls + call;
    coppice_plant refused = 1;
    EXPECT_EQ(call % 2 == 0 ? coppice_plant_open_memory(context_, crown_.data(), crown_.size(), "plant", &refused)
                            : coppice_plant_open_async(context_, "plant", &refused),
              COPPICE_ERROR_OUT_OF_MEMORY)
        << call;
    EXPECT_EQ(refused, 0u);
    device_memory.fail_at = SIZE_MAX;
  }
  open(crown_);
  EXPECT_TRUE(settle(view_).rgba == after.rgba);
  destroy();
  EXPECT_EQ(device_memory.live_count, 0u);
  EXPECT_EQ(device_memory.misuse, "");
  EXPECT_EQ(memory.live_count, 0u);
}

/// Counted by who gives the memory: whatever comes in whatever portions is refused before it is too much, and all else is drawn.
TEST_F(GrowthTest, TheBudgetIsNeverExceeded) {
  for (const std::uint32_t portion : {700u, 9000u, 60000u}) {
    ContextDesc with = desc();
    with.memory_budget_bytes = 48ull << 20;
    count_memory(with);
    create(with);
    const coppice_plant plant = open(crown_);
    add(plant, placements_of(150));
    const auto budget_bytes = with.memory_budget_bytes;
    int refused = 0;
    for (int i = 0; i < 120 && refused < 10; ++i) {
      const coppice_status status = try_add(plant, placements_of(portion, 150 + portion * static_cast<std::uint32_t>(i)));
      if (status != COPPICE_OK) {
        ASSERT_EQ(status, COPPICE_ERROR_OUT_OF_MEMORY) << log_;
        ++refused;
      }
      if (i % 4 == 0) coppice_plant_close(context_, open(crown_));
      ASSERT_LE(counted_bytes(), budget_bytes) << portion << ", " << i;
      frame(view_);
      ASSERT_LE(counted_bytes(), budget_bytes) << portion << ", frame " << i;
      ASSERT_LE(stats().memory_peak_bytes, budget_bytes) << portion << ", frame " << i;
      ASSERT_GT(view_stats().drawn_leaf_count + (i == 0 ? 1 : 0), 0u);
    }
    if (portion > 700) {
      EXPECT_GT(refused, 0) << "the budget is not tight: nothing was tested";
      EXPECT_GT(stats().instance_count, 40000u) << portion;
    }
    // With more memory there is room for more.
    ASSERT_EQ(coppice_set_memory_budget(context_, 200ull << 20), COPPICE_OK);
    frame(view_);
    add(plant, placements_of(portion));
    frame(view_);
    destroy();
  }
}

/// The device's properties, but for what one dispatch culls.
VKAPI_ATTR void VKAPI_CALL properties_of_a_small_device(VkPhysicalDevice device, VkPhysicalDeviceProperties* properties) {
  vkGetPhysicalDeviceProperties(device, properties);
  properties->limits.maxComputeWorkGroupCount[0] = 40;
}

TEST_F(GrowthTest, ASmallDeviceHoldsFewer) {
  ContextDesc with = desc();
  with.max_instances = (1u << 28) - 1;
  replace_functions(with, {replacing("vkGetPhysicalDeviceProperties", properties_of_a_small_device)});
  create(with);
  const coppice_plant plant = open(crown_);
  add(plant, placements_of(1000));
  EXPECT_EQ(try_add(plant, placements_of(281)), COPPICE_ERROR_OUT_OF_MEMORY);
  EXPECT_NE(log_.find("1280"), std::string::npos) << "40 groups of 32\n" << log_;
  add(plant, placements_of(280));
  settle(view_);
  EXPECT_GT(view_stats().drawn_leaf_count, 0u);
}

TEST_F(GrowthTest, LimitsHoldWhereTheDeviceBindsMore) {
  ContextDesc with = desc();
  with.max_instances = 1100;
  with.max_plants = 18;
  create(with);
  std::vector<coppice_plant> plants;
  for (int i = 0; i < 18; ++i) plants.push_back(open(crown_));
  coppice_plant refused = 1;
  EXPECT_EQ(coppice_plant_open_memory(context_, crown_.data(), crown_.size(), "plant", &refused), COPPICE_ERROR_OUT_OF_MEMORY);
  EXPECT_EQ(coppice_plant_open_async(context_, "plant", &refused), COPPICE_ERROR_OUT_OF_MEMORY);
  add(plants[0], placements_of(1100));
  EXPECT_EQ(try_add(plants[0], placements_of(1)), COPPICE_ERROR_OUT_OF_MEMORY);
  EXPECT_NE(log_.find("1100"), std::string::npos) << log_;
  settle(view_);
  EXPECT_GT(view_stats().drawn_leaf_count, 0u);
  EXPECT_EQ(coppice_plant_reload_memory(context_, plants[1], crown_.data(), crown_.size(), "plant"), COPPICE_OK) << log_;
  for (const coppice_plant plant : plants) EXPECT_EQ(coppice_plant_close(context_, plant), COPPICE_OK);
  for (int i = 0; i < 5; ++i) frame(view_);
  add(open(crown_), placements_of(1100));
}

}  // namespace coppice::test::growth_test
