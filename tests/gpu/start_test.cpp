// A context starts at once: its pipelines are built by jobs, only those that something needs, and until they are there what they would draw
// is left out.

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "context_fixture.h"
#include "fake_hooks.h"
#include "mentions.h"
#include "replaced_functions.h"

namespace coppice::test::start_test {

constexpr std::uint32_t kSidePx = 128;

/// The cache that each pipeline of a context was created with.
std::vector<VkPipelineCache>& caches() {
  static std::vector<VkPipelineCache> of_test;
  return of_test;
}

template <auto& real, class Info>
VKAPI_ATTR VkResult VKAPI_CALL create_pipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count, const Info* infos,
                                                const VkAllocationCallbacks* callbacks, VkPipeline* out) {
  caches().push_back(cache);
  return real(device, cache, count, infos, callbacks, out);
}

class StartTest : public ContextTest {
 protected:
  void SetUp() override {
    ContextTest::SetUp();
    plant_path_ = temporary_plant({.leaf_count = 3000, .seed = 5, .leaf_mesh_count = 2}, "start_test");
  }
  void TearDown() override {
    jobs_.finish();
    std::filesystem::remove(plant_path_);
    ContextTest::TearDown();
  }

  /// Pipelines by jobs, which the test holds back.
  ContextDesc held_back(VkBool32 compute_raster) {
    ContextDesc with = desc();
    with.blocking_pipelines = VK_FALSE;
    with.compute_raster = compute_raster;
    with.hooks.jobs = jobs_.hook();
    jobs_.deferred = true;
    return with;
  }

  void plant() { add(open(plant_path_), placement_at()); }

  bool ready() {
    VkBool32 ready = VK_FALSE;
    EXPECT_EQ(coppice_pipelines_ready(context_, &ready), COPPICE_OK);
    const coppice_stats now = stats();
    EXPECT_EQ(ready == VK_TRUE, now.pipelines_built == now.pipelines_wanted);
    return ready == VK_TRUE;
  }

  static Shot view_of(float eye_z_m) { return make_view({.eye_m = {0.0f, 0.3f, eye_z_m}, .width_px = kSidePx}); }

  FakeJobs jobs_;
  std::string plant_path_;
};

TEST_F(StartTest, NothingIsDrawnUntilThePipelinesAreThere) {
  for (const VkBool32 compute_raster : {VK_FALSE, VK_TRUE}) {
    create(held_back(compute_raster));
    EXPECT_FALSE(ready());
    EXPECT_EQ(stats().pipelines_built, 0u);
    plant();
    const Shot view = view_of(5.0f);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(drawn_pixels(frame(view)), 0u);
    EXPECT_EQ(view_stats().drawn_leaf_count, 0u);
    EXPECT_EQ(view_stats().visible_instance_count, 0u);
    jobs_.run_all();
    EXPECT_TRUE(ready());
    EXPECT_GT(drawn_pixels(frame(view)), 0u);
    frame(view);
    EXPECT_GT(view_stats().drawn_leaf_count, 0u);
    jobs_.finish();
    destroy();
  }
  EXPECT_EQ(log_, "");
}

// Jobs run in the order in which they were submitted, so what the hardware needs is there first.
TEST_F(StartTest, TheHardwareDrawsUntilTheRasteriserIsThere) {
  create(held_back(VK_TRUE));
  plant();
  Shot view = view_of(20.0f);
  frame(view);
  const std::uint32_t all = stats().pipelines_wanted;
  const auto draws = [&] {
    const bool drawn = drawn_pixels(frame(view)) > 0;
    frame(view);
    return drawn;
  };
  std::uint32_t built = 0;
  bool drawn = false;
  while (!jobs_.waiting.empty()) {
    jobs_.run_one();
    EXPECT_GE(stats().pipelines_built, built);
    built = stats().pipelines_built;
    const bool now = draws();
    EXPECT_TRUE(now || !drawn) << "what was drawn is gone with pipeline " << built;
    EXPECT_TRUE(drawn || !now || built < all) << "all was waited for";
    drawn = now;
  }
  EXPECT_TRUE(drawn);
  EXPECT_TRUE(ready());
}

TEST_F(StartTest, WithoutOnePipelineOfTheRasteriserTheHardwareDraws) {
  create(held_back(VK_TRUE));
  plant();
  const auto held = jobs_.waiting.begin() + 8;  // the first three are the hardware's
  const coppice_job last = *held;
  jobs_.waiting.erase(held);
  jobs_.run_all();
  const Shot view = view_of(20.0f);
  EXPECT_GT(drawn_pixels(frame(view)), 0u);
  jobs_.run_all();
  EXPECT_EQ(stats().pipelines_built + 1, stats().pipelines_wanted);
  EXPECT_GT(drawn_pixels(frame(view)), 0u);
  last.function(last.argument);
  EXPECT_TRUE(ready());
  EXPECT_GT(drawn_pixels(frame(view)), 0u);
}

TEST_F(StartTest, WhatHasNoTextureIsDrawnByThePipelineForTexturesUntilItsOwnIsThere) {
  std::filesystem::remove(plant_path_);
  // One page and one wood LoD: nothing streams in between the pictures.
  plant_path_ =
      temporary_plant({.leaf_count = 300, .seed = 5, .wood_lod_count = 1, .texture_side = 0, .looks = Looks::noise}, "start_test");
  create(held_back(VK_FALSE));
  jobs_.run_all();
  const std::uint32_t with_textures = stats().pipelines_built;
  plant();
  const Shot view = view_of(5.0f);
  const Picture before = frame(view);
  EXPECT_EQ(stats().pipelines_built, with_textures);
  EXPECT_EQ(stats().pipelines_wanted, with_textures + 2) << "leaves and wood without a texture";
  EXPECT_GT(drawn_pixels(before), 0u);
  jobs_.run_all();
  EXPECT_TRUE(ready());
  EXPECT_EQ(frame(view).rgba, before.rgba);
}

TEST_F(StartTest, StatisticsSayHowLongPipelinesTook) {
  create(held_back(VK_FALSE));
  EXPECT_EQ(stats().pipelines_ms, 0.0);
  EXPECT_EQ(stats().longest_pipeline_ms, 0.0f);
  EXPECT_EQ(stats().longest_pipeline, nullptr);
  EXPECT_STREQ(stats().missing_pipeline, "cull.comp");
  jobs_.run_one();
  const coppice_stats one = stats();
  EXPECT_GT(one.pipelines_ms, 0.0);
  EXPECT_FLOAT_EQ(one.longest_pipeline_ms, static_cast<float>(one.pipelines_ms));
  EXPECT_STREQ(one.longest_pipeline, "cull.comp");
  jobs_.run_all();
  const coppice_stats all = stats();
  EXPECT_EQ(all.missing_pipeline, nullptr);
  EXPECT_GT(all.pipelines_built, 1u);
  EXPECT_GT(all.pipelines_ms, one.pipelines_ms);
  EXPECT_GE(all.longest_pipeline_ms, one.longest_pipeline_ms);
  EXPECT_LT(all.longest_pipeline_ms, all.pipelines_ms);
  EXPECT_GT(1.001 * all.longest_pipeline_ms * all.pipelines_built, all.pipelines_ms);
}

// What a driver keeps in a cache is its own affair.
TEST_F(StartTest, PipelinesAreCreatedWithTheEnginesCache) {
  VkPipelineCache cache = VK_NULL_HANDLE;
  const VkPipelineCacheCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  check_vk(vkCreatePipelineCache(gpu().device, &info, nullptr, &cache), "vkCreatePipelineCache");
  std::vector<Picture> pictures;
  for (const VkPipelineCache given : {VkPipelineCache{}, cache, cache}) {
    ContextDesc with = desc();
    with.pipeline_cache = given;
    replace_functions(with,
                      {replacing("vkCreateComputePipelines", create_pipelines<vkCreateComputePipelines, VkComputePipelineCreateInfo>),
                       replacing("vkCreateGraphicsPipelines", create_pipelines<vkCreateGraphicsPipelines, VkGraphicsPipelineCreateInfo>)});
    caches().clear();
    create(with);
    plant();
    pictures.push_back(frame(view_of(5.0f)));
    EXPECT_EQ(caches(), std::vector(stats().pipelines_built, given));
    EXPECT_EQ(pictures.back().rgba, pictures.front().rgba);
    destroy();
  }
  EXPECT_GT(drawn_pixels(pictures.front()), 0u);
  vkDestroyPipelineCache(gpu().device, cache, nullptr);
}

TEST_F(StartTest, WhatIsNeverDrawnIsNeverBuilt) {
  ContextDesc with = held_back(VK_TRUE);
  jobs_.deferred = false;  // they run inside submit: everything is there at once
  create(with);
  EXPECT_TRUE(ready()) << "after creation";
  const std::uint32_t at_start = stats().pipelines_wanted;
  EXPECT_LT(at_start, 20u);
  plant();
  Shot view = view_of(40.0f);
  settle(view);
  const std::uint32_t far = stats().pipelines_wanted;
  EXPECT_LE(far, at_start + 2) << "those without a texture";
  view.debug_view = COPPICE_DEBUG_OVERDRAW;
  frame(view);
  const std::uint32_t debugged = stats().pipelines_wanted;
  EXPECT_EQ(debugged, far + 5) << "two for culling, three that count";
  view.debug_view = COPPICE_DEBUG_LOD;
  frame(view);
  EXPECT_EQ(stats().pipelines_wanted, debugged);
  const coppice_view map = create_view(COPPICE_OUTPUT_DEPTH);
  EXPECT_NE(map, 0u);
  EXPECT_GT(stats().pipelines_wanted, debugged);
  EXPECT_TRUE(ready());
}

TEST_F(StartTest, ADebugViewIsShownAsAnyOtherUntilItIsThere) {
  create(held_back(VK_TRUE));
  plant();
  jobs_.run_all();
  Shot view = view_of(5.0f);
  frame(view);
  jobs_.run_all();
  const Picture plain = frame(view);
  view.debug_view = COPPICE_DEBUG_PATH;
  EXPECT_EQ(frame(view).rgba, plain.rgba);
  jobs_.run_all();
  EXPECT_NE(frame(view).rgba, plain.rgba);
}

TEST_F(StartTest, AContextCanBeDestroyedWhileItsPipelinesAreBuilt) {
  ContextDesc with = desc();
  with.blocking_pipelines = VK_FALSE;
  with.compute_raster = VK_TRUE;
  create(with);  // the default threads
  destroy();
  create(with);
  plant();
  frame(view_of(5.0f));
  for (int i = 0; i < 120000 && !ready(); ++i) usleep(1000);  // a busy machine takes its time
  EXPECT_TRUE(ready());
  frame(view_of(5.0f));
  EXPECT_GT(drawn_pixels(settle(view_of(5.0f))), 0u);
}

TEST_F(StartTest, TheCostIsWhatAContextCounts) {
  struct Size {
    std::uint32_t max_instances, max_plants;
    std::uint64_t budget_bytes;
  };
  for (const VkBool32 compute_raster : {VK_FALSE, VK_TRUE})
    for (const auto& [max_instances, max_plants, budget_bytes] :
         {Size{4096, 64, 256ull << 20}, {1, 1, 64ull << 20}, {1000003, 300, 1ull << 30}, {131072, 64, 8ull << 30}}) {
      ContextDesc with = desc();
      with.compute_raster = compute_raster;
      with.pass_times = compute_raster;
      with.max_instances = max_instances;
      with.max_plants = max_plants;
      with.memory_budget_bytes = budget_bytes;
      std::uint64_t cost = 0;
      ASSERT_EQ(context_cost(with, &cost), COPPICE_OK) << log_;
      ASSERT_EQ(create_context(with, &context_), COPPICE_OK) << log_;
      EXPECT_EQ(cost, stats().memory_bytes) << max_instances;
      destroy();
    }
}

TEST_F(StartTest, LimitsCostNothing) {
  ContextDesc with = desc(), plain = default_desc();
  with.compute_raster = VK_TRUE;
  std::uint64_t of_few = 0, of_many = 0;
  with.max_instances = 1024;
  with.max_plants = 64;
  ASSERT_EQ(context_cost(with, &of_few), COPPICE_OK) << log_;
  with.max_instances = plain.max_instances;
  with.max_plants = plain.max_plants;
  ASSERT_EQ(context_cost(with, &of_many), COPPICE_OK) << log_;
  EXPECT_EQ(of_few, of_many);
  EXPECT_LT(of_many, 17ull << 20) << "8 MiB are for staging, 8 a block of device memory";
}

TEST_F(StartTest, AskingForTheCostTakesNothing) {
  ContextDesc with = desc();
  FakeAllocator allocator;
  FakeIo io;
  with.hooks.allocator = allocator.hook();
  with.hooks.io = io.hook();
  with.hooks.jobs = jobs_.hook();
  with.memory_budget_bytes = 1;
  jobs_.deferred = true;
  static std::size_t allocations;
  allocations = 0;
  const PFN_vkAllocateMemory allocate = [](VkDevice of, const VkMemoryAllocateInfo* info, const VkAllocationCallbacks* callbacks,
                                           VkDeviceMemory* memory) {
    ++allocations;
    return vkAllocateMemory(of, info, callbacks, memory);
  };
  replace_functions(with, {replacing("vkAllocateMemory", allocate)});
  std::uint64_t cost = 0;
  ASSERT_EQ(context_cost(with, &cost), COPPICE_OK) << log_;
  EXPECT_EQ(allocations, 0u);
  EXPECT_EQ(allocator.calls, 0u);
  EXPECT_TRUE(jobs_.waiting.empty());
  with.memory_budget_bytes = 256ull << 20;
  jobs_.deferred = false;
  create(with);
  EXPECT_GE(allocations, 3u);
  destroy();

  const auto refused = [&](coppice_status status, std::initializer_list<std::string_view> names) {
    std::uint64_t bytes = 1;
    EXPECT_EQ(context_cost(with, &bytes), status) << log_;
    EXPECT_EQ(bytes, 0u);
    EXPECT_TRUE(mentions(log_, names));
    log_.clear();
    with = desc();
  };
  with.device = VK_NULL_HANDLE;
  refused(COPPICE_ERROR_INVALID_ARGUMENT, {"vulkan.device", "null"});
  with.physical_device = VK_NULL_HANDLE;
  refused(COPPICE_ERROR_INVALID_ARGUMENT, {"vulkan.physical_device", "null"});
  replace_functions(with, {{"vkGetPhysicalDeviceFeatures2", nullptr}});
  refused(COPPICE_ERROR_UNSUPPORTED, {"vkGetPhysicalDeviceFeatures2"});
  with.hooks.io.open = io.hook().open;
  refused(COPPICE_ERROR_INVALID_ARGUMENT, {"desc.io"});
  static_cast<coppice_context_desc&>(with).struct_size = 2;
  refused(COPPICE_ERROR_INVALID_ARGUMENT, {});
  EXPECT_TRUE(mentions(coppice_last_error(nullptr), {"coppice_vulkan_context_cost: desc.struct_size", "2"}));
  EXPECT_EQ(coppice_vulkan_context_cost(nullptr, &with, &cost), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(context_cost(with, nullptr), COPPICE_ERROR_INVALID_ARGUMENT);
}

}  // namespace coppice::test::start_test
