// The n-th call of every hook, and of every Vulkan function that can fail, fails: while a context is created, while a plant is opened, and
// while frames are recorded. The status says which, what is optional is gone without, and nothing is left behind.

#include <algorithm>
#include <array>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "context_fixture.h"
#include "device_memory_hook.h"
#include "failing_device.h"
#include "fake_hooks.h"
#include "functions.h"
#include "mentions.h"

namespace coppice::test::failure_test {

constexpr std::uint32_t kSidePx = 32, kMapPx = 32;
constexpr int kFrames = 60;
constexpr const char* kPath = "plant.coppice";

/// What a run's calls returned.
struct Outcome {
  coppice_status created = COPPICE_OK, opened = COPPICE_OK, added = COPPICE_OK;
  coppice_status pipelines = COPPICE_OK;
  std::vector<coppice_status> frames;  ///< the first of a frame's calls that failed, or COPPICE_OK
  coppice_stats stats{};               ///< after the last frame
  coppice_view_stats drawn{};          ///< likewise
};

/// How many calls of a hook there have to be, for something to be tested, and about how many of those of frames fail.
struct HookCalls {
  std::size_t least_of_creation, least_of_frames, failing_of_frames;
};

/// Files, jobs and memory that the test holds, so that every run makes the same calls in the same order.
class FailureTest : public ContextTest {
 protected:
  static void TearDownTestSuite() { destroy_shared_pipelines(); }

  void SetUp() override {
    ContextTest::SetUp();
    reset_device_faults();
  }

  /// Everything that creates something is on.
  ContextDesc full_desc() {
    ContextDesc full = desc();
    full.compute_raster = VK_TRUE;
    full.shader_int64_atomics = gpu().int64_atomics ? VK_TRUE : VK_FALSE;
    full.pass_times = VK_TRUE;
    full.max_instances = 256;
    full.max_plants = 4;
    full.streaming_ms = std::numeric_limits<float>::infinity();
    full.hooks.allocator = memory_.hook();
    full.hooks.jobs = jobs_.hook();
    full.hooks.io = io_.hook();
    if (device_memory_.gpu != nullptr) full.hooks.device_memory = device_memory_.hook();
    fail_with_device_faults(full);
    return full;
  }

  /// A context from its creation to its end. Where a call fails the run goes on as an engine would that does not give up.
  Outcome run() {
    io_.files = {{kPath, plant_bytes_}};
    io_.handles.clear();
    io_.log.clear();
    log_.clear();
    Outcome outcome;
    const ContextDesc full = full_desc();
    outcome.created = create_context(full, &context_);
    EXPECT_EQ(outcome.created == COPPICE_OK, context_ != nullptr);
    if (outcome.created == COPPICE_OK) outcome.created = create_views();
    if (outcome.created == COPPICE_OK) run_frames(outcome);
    destroy();
    EXPECT_EQ(memory_.live_count, 0u) << "memory of the allocator hook is left";
    EXPECT_EQ(device_memory_.live_count, 0u) << "device memory is left";
    EXPECT_EQ(device_memory_.misuse, "");
    EXPECT_EQ(io_.open_count, 0u) << "files are left open";
    EXPECT_EQ(device_faults().live_objects, 0) << "Vulkan objects are left";
    EXPECT_EQ(validation_messages(), std::vector<std::string>{});
    return outcome;
  }

  /// Without a fault and without frames.
  void create_and_destroy() {
    ASSERT_EQ(create_context(full_desc(), &context_), COPPICE_OK) << log_;
    ASSERT_EQ(create_views(), COPPICE_OK) << log_;
    destroy();
  }

  coppice_status create_views() {
    const coppice_status status = test::create_view(context_, &view_);
    EXPECT_EQ(status == COPPICE_OK, view_ != 0);
    return status == COPPICE_OK ? test::create_view(context_, &map_view_, COPPICE_OUTPUT_DEPTH) : status;
  }

  template <class Hook>
  void fail_each_call(Hook& hook, const HookCalls& wanted, std::initializer_list<std::string_view> names);

  FakeAllocator memory_;
  DeviceMemoryHook device_memory_;  ///< without a device: Coppice allocates
  FakeJobs jobs_;
  FakeIo io_;
  const std::vector<std::uint8_t> plant_bytes_ = plant_bytes({.leaf_count = 1300, .seed = 5, .leaf_mesh_count = 2});

 private:
  void run_frames(Outcome& outcome) {
    coppice_plant plant = 0;
    outcome.opened = coppice_plant_open(context_, kPath, &plant);
    EXPECT_EQ(outcome.opened == COPPICE_OK, plant != 0);
    outcome.added = add_instance(plant);
    for (int i = 0; i < kFrames; ++i) {
      // A plant that could not be opened or reloaded is tried again, and so is its instance.
      if (plant == 0 && i % 20 == 10) (void)coppice_plant_open(context_, kPath, &plant);
      if (i % 20 == 10 && stats().instance_count == 0) (void)add_instance(plant);
      if (plant != 0 && i == 15) (void)coppice_plant_reload(context_, plant, nullptr);
      outcome.frames.push_back(record_frame(i < 8 ? kSidePx : 2 * kSidePx));
    }
    outcome.stats = stats();
    outcome.drawn = view_stats();
    VkBool32 ready = VK_FALSE;
    outcome.pipelines = coppice_pipelines_ready(context_, &ready);
    EXPECT_EQ(ready == VK_TRUE, outcome.pipelines == COPPICE_OK);
    EXPECT_EQ(outcome.stats.pipelines_built == outcome.stats.pipelines_wanted, outcome.pipelines == COPPICE_OK);
  }

  coppice_status add_instance(coppice_plant plant) {
    if (plant == 0) return COPPICE_OK;
    coppice_instance instance = 0;
    const std::uint32_t before = stats().instance_count;
    const coppice_status status = try_add(plant, std::array{placement_at()}, &instance);
    EXPECT_EQ(status == COPPICE_OK, instance != 0);
    EXPECT_EQ(stats().instance_count, before + (status == COPPICE_OK ? 1 : 0));
    return status;
  }

  coppice_status record_frame(std::uint32_t side_px) {
    Shot view = make_view({.eye_m = {0.0f, 0.3f, 5.0f}, .width_px = side_px, .error_px = 0.01f});
    auto frame = defaults(coppice_frame_init);
    frame.frame_number = ++frame_number_;
    frame.completed_number = frame_number_ - 1;
    const coppice_camera sun = sun_of(view);
    view.view = view_;
    const coppice_camera cameras[2] = {view, sun};
    frame.cameras = cameras;
    frame.camera_count = 2;
    coppice_status status = coppice_frame_begin(context_, &frame);
    const auto note = [&](coppice_status next) {
      if (status == COPPICE_OK) status = next;
    };
    submit(gpu(), [&](VkCommandBuffer cmd) {
      if (status != COPPICE_ERROR_DEVICE_LOST) note(coppice_record_upload(context_, cmd));
      note(coppice_record_cull(context_, cmd, sun.view, nullptr));
      draw(cmd, sun, {.depth = &map_});
      change_layout(cmd, map_, map_.attachment_layout(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
      coppice_shadow_map map{.image = map_.view(), .clip_from_world = {}};
      const glm::dmat4 clip_from_world = glm::dmat4(glm::make_mat4(sun.clip_from_view)) * glm::make_mat4(sun.view_from_world);
      std::copy_n(glm::value_ptr(clip_from_world), 16, map.clip_from_world);
      view.light.shadow_maps = &map;
      view.light.shadow_map_count = 1;
      note(coppice_record_cull(context_, cmd, view.view, &view.light));
      draw(cmd, view, {.colors = {&color_}, .depth = &depth_});
    });
    return status;
  }

  coppice_camera sun_of(const Shot& view) {
    auto square = defaults(coppice_sun_desc_init);
    std::copy_n(view.light.sun_direction, 3, square.sun_direction);
    square.radius_m = 3.0f;
    square.size_px = kMapPx;
    auto sun = defaults(coppice_camera_init);
    EXPECT_EQ(coppice_sun_camera(context_, map_view_, &square, &sun), COPPICE_OK) << log_;
    return sun;
  }

  void draw(VkCommandBuffer cmd, const coppice_camera& view, const Attachments& attachments) {
    begin_rendering(cmd, attachments);
    (void)coppice_record_draw(context_, cmd, view.view, 0);
    vkCmdEndRendering(cmd);
  }

  coppice_view map_view_ = 0;
  Image color_{gpu(), color_attachment(2 * kSidePx, 2 * kSidePx)}, depth_{gpu(), depth_attachment(2 * kSidePx, 2 * kSidePx)};
  Image map_{gpu(), depth_attachment(kMapPx, kMapPx)};
};

/// Whether every call of frames fails too, not one in some: that takes minutes more.
bool is_every_call_wanted() {
  return std::getenv("COPPICE_EVERY_CALL") != nullptr;
}

/// Which calls fail: each creation_step-th of a context's creation, then about max_each of each function.
struct Choice {
  std::uint64_t creation_step = 1, max_each = 1;
};

std::vector<std::uint64_t> failing_calls(std::span<const std::string> names, std::uint64_t of_creation, const Choice& choice) {
  std::map<std::string, std::uint64_t> counts, met;
  for (const std::string& name : names.subspan(of_creation)) ++counts[name];
  std::vector<std::uint64_t> calls;
  for (std::uint64_t n = 0; n < names.size(); ++n) {
    const std::uint64_t step = is_every_call_wanted() ? 1 : std::max<std::uint64_t>(counts[names[n]] / choice.max_each, 1);
    const std::uint64_t creation_step = is_every_call_wanted() ? 1 : choice.creation_step;
    if (n < of_creation ? n % creation_step == 0 : met[names[n]]++ % step == 0) calls.push_back(n);
  }
  return calls;
}

/// Nothing but success and what the fault means.
void expect_statuses(const Outcome& outcome, coppice_status expected) {
  for (const coppice_status status : {outcome.created, outcome.opened, outcome.added})
    EXPECT_TRUE(status == COPPICE_OK || status == expected) << coppice_status_text(status);
  for (std::size_t i = 0; i < outcome.frames.size(); ++i)
    EXPECT_TRUE(outcome.frames[i] == COPPICE_OK || outcome.frames[i] == expected)
        << "frame " << i << ": " << coppice_status_text(outcome.frames[i]);
}

class VulkanFailureTest : public FailureTest {
 protected:
  /// Without a fault: how many calls a run makes, and those of the creation.
  void SetUp() override {
    FailureTest::SetUp();
    create_and_destroy();
    creation_calls_ = device_faults().calls.size();
    reset_device_faults();
    const Outcome clean = run();
    calls_ = device_faults().calls;
    EXPECT_EQ(clean.created, COPPICE_OK) << log_;
    expect_statuses(clean, COPPICE_OK);
    EXPECT_EQ(log_, "");
    leaves_ = clean.drawn.drawn_leaf_count;
    EXPECT_GT(clean.drawn.leaf_mesh_instance_count + leaves_, 0u);
    ASSERT_GT(creation_calls_, 50u);
    ASSERT_GT(calls_.size(), creation_calls_ + 30) << "frames create nothing: nothing was tested";
  }

  /// The n-th call returns `result`.
  Outcome run_with(std::uint64_t n, VkResult result) {
    reset_device_faults();
    device_faults().fail_at = n;
    device_faults().result = result;
    const Outcome outcome = run();
    EXPECT_NE(device_faults().failed_call, "") << "call " << n << " was not reached";
    EXPECT_NE(log_, "") << "a failure that nobody is told of";
    return outcome;
  }

  /// What a pipeline is built by: the context lives without.
  static bool failed_a_pipeline() {
    const std::string& call = device_faults().failed_call;
    return call == "vkCreateShaderModule" || call == "vkCreateComputePipelines" || call == "vkCreateGraphicsPipelines";
  }

  std::vector<std::string> calls_;  ///< what a run without a fault calls
  std::uint64_t creation_calls_ = 0, leaves_ = 0;
};

/// Every fourth of the calls that fail.
class OneInFour : public VulkanFailureTest, public testing::WithParamInterface<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Calls, OneInFour, testing::Range<std::size_t>(0, 4));

TEST_P(OneInFour, OutOfMemoryIsSaidAndGoneWithout) {
  const std::vector<std::uint64_t> calls = failing_calls(calls_, creation_calls_, {.creation_step = 1, .max_each = 8});
  for (std::size_t i = GetParam(); i < calls.size(); i += 4) {
    const std::uint64_t n = calls[i];
    const Outcome outcome = run_with(n, n % 2 == 0 ? VK_ERROR_OUT_OF_DEVICE_MEMORY : VK_ERROR_OUT_OF_HOST_MEMORY);
    SCOPED_TRACE(std::to_string(n) + ": " + device_faults().failed_call + "\n" + log_);
    expect_statuses(outcome, COPPICE_ERROR_OUT_OF_MEMORY);
    if (failed_a_pipeline()) {
      EXPECT_EQ(outcome.created, COPPICE_OK);
      EXPECT_EQ(outcome.pipelines, COPPICE_ERROR_OUT_OF_MEMORY);
      EXPECT_TRUE(std::ranges::all_of(outcome.frames, [](coppice_status status) { return status == COPPICE_OK; }));
      EXPECT_EQ(std::ranges::count(log_, '\n'), 1) << "said once";
    } else if (n < creation_calls_) {
      EXPECT_EQ(outcome.created, COPPICE_ERROR_OUT_OF_MEMORY);
    } else {
      ASSERT_EQ(outcome.created, COPPICE_OK);
      EXPECT_EQ(outcome.frames.back(), COPPICE_OK);
      EXPECT_EQ(outcome.drawn.drawn_leaf_count, leaves_) << "what failed once is there in the end";
    }
    if (HasFailure()) return;
  }
}

TEST_F(VulkanFailureTest, AnUnknownErrorEndsNoMoreThanWhatItIsAbout) {
  for (const std::uint64_t n : failing_calls(calls_, creation_calls_, {.creation_step = 5, .max_each = 1})) {
    const Outcome outcome = run_with(n, VK_ERROR_UNKNOWN);
    SCOPED_TRACE(std::to_string(n) + ": " + device_faults().failed_call + "\n" + log_);
    expect_statuses(outcome, COPPICE_ERROR_INTERNAL);
    EXPECT_EQ(outcome.pipelines, failed_a_pipeline() ? COPPICE_ERROR_INTERNAL : COPPICE_OK);
    if (n < creation_calls_ && !failed_a_pipeline())
      EXPECT_EQ(outcome.created, COPPICE_ERROR_INTERNAL);
    else
      EXPECT_EQ(outcome.frames.back(), COPPICE_OK);
    if (HasFailure()) return;
  }
}

TEST_F(VulkanFailureTest, ALostDeviceIsSaidAndStaysLost) {
  for (const std::uint64_t n : failing_calls(calls_, creation_calls_, {.creation_step = 4, .max_each = 3})) {
    const Outcome outcome = run_with(n, VK_ERROR_DEVICE_LOST);
    SCOPED_TRACE(std::to_string(n) + ": " + device_faults().failed_call + "\n" + log_);
    expect_statuses(outcome, COPPICE_ERROR_DEVICE_LOST);
    EXPECT_EQ(std::ranges::count(log_, '\n'), 1) << "said once";
    EXPECT_TRUE(mentions(log_, {device_faults().failed_call, "VK_ERROR_DEVICE_LOST"}));
    if (n < creation_calls_) {
      EXPECT_EQ(outcome.created, COPPICE_ERROR_DEVICE_LOST);
    } else {
      ASSERT_EQ(outcome.frames.size(), static_cast<std::size_t>(kFrames));
      const auto lost = std::ranges::find(outcome.frames, COPPICE_ERROR_DEVICE_LOST);
      EXPECT_NE(lost, outcome.frames.end());
      EXPECT_TRUE(std::all_of(lost, outcome.frames.end(), [](coppice_status status) { return status == COPPICE_ERROR_DEVICE_LOST; }));
    }
    if (HasFailure()) return;
  }
}

/// From the n-th allocation on there is no memory at all.
TEST_F(VulkanFailureTest, FramesGoOnWithoutAnyMoreMemory) {
  for (std::uint64_t n = creation_calls_; n < calls_.size(); n += is_every_call_wanted() ? 3u : 23u) {
    reset_device_faults();
    device_faults().for_good = true;
    device_faults().fail_at = n;
    device_faults().result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    const Outcome outcome = run();
    SCOPED_TRACE(std::to_string(n) + ": " + device_faults().failed_call + "\n" + log_);
    expect_statuses(outcome, COPPICE_ERROR_OUT_OF_MEMORY);
    if (HasFailure()) return;
  }
}

TEST_F(VulkanFailureTest, AFunctionThatTheLoaderLacksIsNamed) {
  for (const char* name : {
#define COPPICE_NAME(name) #name,
           COPPICE_INSTANCE_FUNCTIONS(COPPICE_NAME) COPPICE_DEVICE_FUNCTIONS(COPPICE_NAME)
#undef COPPICE_NAME
       }) {
    reset_device_faults();
    device_faults().missing = name;
    EXPECT_EQ(run().created, COPPICE_ERROR_UNSUPPORTED) << name;
    EXPECT_TRUE(mentions(log_, {name}));
  }
}

/// Each call of a creation fails once, and some of the frames'. names: what the log says of it
template <class Hook>
void FailureTest::fail_each_call(Hook& hook, const HookCalls& wanted, std::initializer_list<std::string_view> names) {
  create_and_destroy();
  const std::size_t of_creation = hook.calls;
  hook.calls = 0;
  const std::uint64_t leaves = run().drawn.drawn_leaf_count;
  const std::size_t all = hook.calls;
  ASSERT_GE(of_creation, wanted.least_of_creation);
  ASSERT_GE(all, of_creation + wanted.least_of_frames);
  const std::size_t step = is_every_call_wanted() ? 1 : std::max<std::size_t>((all - of_creation) / wanted.failing_of_frames, 1);
  for (std::size_t n = 0; n < all; n += n < of_creation ? 1 : step) {
    hook.calls = 0;
    hook.fail_at = n;
    const Outcome outcome = run();
    SCOPED_TRACE(std::to_string(n) + " of " + std::to_string(all) + "\n" + log_);
    expect_statuses(outcome, COPPICE_ERROR_OUT_OF_MEMORY);
    EXPECT_EQ(outcome.created, n < of_creation ? COPPICE_ERROR_OUT_OF_MEMORY : COPPICE_OK);
    if (n >= of_creation) {
      EXPECT_EQ(outcome.frames.back(), COPPICE_OK);
      EXPECT_EQ(outcome.drawn.drawn_leaf_count, leaves) << "what failed once is there in the end";
    }
    EXPECT_NE(log_, "");
    EXPECT_TRUE(mentions(log_, names));
    if (HasFailure()) return;
  }
}

TEST_F(FailureTest, TheAllocatorHookFailsAtEveryCall) {
  fail_each_call(memory_, {.least_of_creation = 6, .least_of_frames = 21, .failing_of_frames = 12}, {});
}

TEST_F(FailureTest, TheDeviceMemoryHookFailsAtEveryCall) {
  device_memory_.gpu = &gpu();
  fail_each_call(device_memory_, {.least_of_creation = 3, .least_of_frames = 10, .failing_of_frames = SIZE_MAX},
                 {"device_memory.allocate", "VK_ERROR_OUT_OF_DEVICE_MEMORY"});
}

TEST_F(FailureTest, EveryReadFailsComesShortOrIsWrong) {
  (void)run();
  const std::size_t reads = io_.answered;
  ASSERT_GT(reads, 4u);
  for (const ReadFault fault : {ReadFault::fails, ReadFault::comes_short, ReadFault::returns_wrong_bytes})
    for (std::size_t n = 0; n < reads; ++n) {
      io_.fault = fault;
      io_.fault_at = n;
      io_.answered = 0;
      const Outcome outcome = run();
      SCOPED_TRACE("read " + std::to_string(n) + "\n" + log_);
      EXPECT_EQ(outcome.created, COPPICE_OK);
      EXPECT_TRUE(outcome.opened == COPPICE_OK || outcome.opened == COPPICE_ERROR_IO || outcome.opened == COPPICE_ERROR_BAD_FILE);
      expect_statuses({.frames = outcome.frames}, COPPICE_OK);
      if (HasFailure()) return;
    }
}

TEST_F(FailureTest, AHookIsGivenAsAWholeOrNotAtAll) {
  struct Case {
    const char* name;
    void (*take_away)(HookStructs&);
  };
  for (const auto& [name, take_away] : {Case{"allocator", [](HookStructs& hooks) { hooks.allocator.allocate = nullptr; }},
                                        {"allocator", [](HookStructs& hooks) { hooks.allocator.free = nullptr; }},
                                        {"device_memory", [](HookStructs& hooks) { hooks.device_memory.allocate = nullptr; }},
                                        {"device_memory", [](HookStructs& hooks) { hooks.device_memory.free = nullptr; }},
                                        {"io", [](HookStructs& hooks) { hooks.io.open = nullptr; }},
                                        {"io", [](HookStructs& hooks) { hooks.io.close = nullptr; }},
                                        {"io", [](HookStructs& hooks) { hooks.io.read = nullptr; }}}) {
    device_memory_.gpu = std::string_view(name) == "device_memory" ? &gpu() : nullptr;
    ContextDesc partly = full_desc();
    take_away(partly.hooks);
    log_.clear();
    EXPECT_EQ(create_context(partly, &context_), COPPICE_ERROR_INVALID_ARGUMENT) << name;
    EXPECT_EQ(context_, nullptr);
    EXPECT_TRUE(mentions(log_, {name}));
  }
  device_memory_.gpu = nullptr;
  // Without a jobs hook, a log and a trace there are the defaults.
  ContextDesc bare = full_desc();
  bare.hooks.jobs = default_desc().hooks.jobs;
  bare.hooks.log = default_desc().hooks.log;
  ASSERT_EQ(create_context(bare, &context_), COPPICE_OK);
}

}  // namespace coppice::test::failure_test
