// A context used by programs that were compiled with an older or a newer header, and by programs that keep no order between their threads.

#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <string>
#include <string_view>
#include <thread>

#include "api_call.h"
#include "context_fixture.h"
#include "fake_hooks.h"
#include "mentions.h"
#include "resized.h"

namespace coppice::test::abi_runtime_test {

constexpr const char* kPath = "plant.coppice";

class AbiTest : public ContextTest {
 protected:
  /// Creates a context of the descs as they are, or says why not.
  coppice_status create_from(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan) {
    destroy();
    return coppice_vulkan_context_create(desc, vulkan, &context_);
  }

  /// names: the function and its argument, then other fields and the byte
  void expect_refused(coppice_status status, std::initializer_list<std::string_view> names) {
    EXPECT_EQ(status, COPPICE_ERROR_INVALID_ARGUMENT) << *names.begin();
    EXPECT_TRUE(log_.starts_with(*names.begin())) << *names.begin() << " is not the beginning of: " << log_;
    EXPECT_TRUE(mentions(log_, names));
    log_.clear();
  }

  coppice_camera camera() const {
    coppice_camera camera = make_view({.width_px = 32});
    camera.view = view_;
    return camera;
  }

  /// cameras: one, of camera_bytes bytes
  coppice_frame frame_of(const coppice_camera* cameras, std::size_t camera_bytes = sizeof(coppice_camera)) {
    auto frame = defaults(coppice_frame_init);
    frame.frame_number = ++frame_number_;
    frame.completed_number = frame_number_ - 1;
    frame.cameras = cameras;
    frame.camera_count = 1;
    frame.camera_bytes = static_cast<std::uint32_t>(camera_bytes);
    return frame;
  }
};

TEST_F(AbiTest, DescsAndHooksOfOtherVersions) {
  ContextDesc with = desc();
  point_at_hooks(with);
  const coppice_context_desc core = with;
  const coppice_vulkan_desc vulkan = with;

  EXPECT_EQ(create_from(Resized(core, sizeof core + 32).get(), Resized(vulkan, sizeof vulkan + 32).get()), COPPICE_OK) << log_;
  EXPECT_EQ(create_from(Resized(core, offsetof(coppice_context_desc, streaming_ms)).get(),
                        Resized(vulkan, offsetof(coppice_vulkan_desc, texture_compression_bc)).get()),
            COPPICE_OK)
      << log_;
  const std::string call = "coppice_vulkan_context_create: ";
  expect_refused(create_from(Resized(core, sizeof core + 4, 1).get(), &vulkan), {call + "desc", "byte 88"});
  EXPECT_EQ(context_, nullptr);
  expect_refused(create_from(&core, Resized(vulkan, sizeof vulkan + 4, 1).get()),
                 {call + "vulkan", "byte " + std::to_string(sizeof vulkan)});

  Resized<coppice_log> later_log(with.hooks.log, sizeof(coppice_log) + 8, 1);
  coppice_context_desc changed = core;
  changed.log = later_log.get();
  expect_refused(create_from(&changed, &vulkan), {call + "desc.log", "byte 24"});
  Resized<coppice_allocator> without_free(default_allocator(), offsetof(coppice_allocator, free));
  changed = core;
  changed.allocator = without_free.get();
  expect_refused(create_from(&changed, &vulkan), {call + "desc.allocator", "allocate", "free"});
  Resized<coppice_log> earlier_log(with.hooks.log, offsetof(coppice_log, write));
  changed = core;
  changed.log = earlier_log.get();
  EXPECT_EQ(create_from(&changed, &vulkan), COPPICE_OK) << "an older log without its function is no log";
  // The hooks were copied.
  EXPECT_EQ(create_from(&core, &vulkan), COPPICE_OK) << log_;
  with.hooks.log.write = nullptr;
  expect_refused(coppice_set_memory_budget(context_, 0), {"coppice_set_memory_budget: "});
}

TEST_F(AbiTest, CamerasAndFramesOfOtherVersions) {
  create(desc());
  const coppice_camera good = camera();
  const auto cmd = reinterpret_cast<VkCommandBuffer>(this);  // no call gets as far as that
  const std::size_t large = sizeof good + 64, small = offsetof(coppice_camera, debug_view);
  Resized<coppice_camera> larger(good, large), unknown(good, large, 1), smaller(good, small);
  for (const auto& [taken, bytes] : {std::pair{larger.get(), large}, {smaller.get(), small}}) {
    const coppice_frame frame = frame_of(taken, bytes);
    EXPECT_EQ(coppice_frame_begin(context_, &frame), COPPICE_OK) << log_;
  }
  const std::string byte = "byte " + std::to_string(sizeof good);
  coppice_frame frame = frame_of(unknown.get(), large);
  expect_refused(coppice_frame_begin(context_, &frame), {"coppice_frame_begin: frame.cameras[0]", byte});
  frame = frame_of(&good);
  expect_refused(coppice_frame_begin(context_, Resized(frame, sizeof frame + 4, 1).get()), {"coppice_frame_begin: frame", "byte 48"});
  EXPECT_EQ(coppice_frame_begin(context_, Resized(frame, sizeof frame + 4).get()), COPPICE_OK) << log_;

  auto light = defaults(coppice_light_init);
  expect_refused(coppice_record_cull(context_, cmd, view_, Resized(light, sizeof light + 8, 1).get()),
                 {"coppice_record_cull: light", "byte " + std::to_string(sizeof light)});
  auto square = defaults(coppice_sun_desc_init);
  auto sun = defaults(coppice_camera_init);
  expect_refused(coppice_sun_camera(context_, view_, Resized(square, sizeof square + 4, 1).get(), &sun),
                 {"coppice_sun_camera: desc", "byte 48"});
}

/// A function that fills a struct does so in any size, and touches nothing behind it.
template <class T, class Fill>
void expect_filled_in_any_size(const T& whole, Fill fill) {
  for (std::size_t bytes = 4; bytes <= sizeof(T) + 16; bytes += 4) {
    Resized<T> other(T{}, bytes, 0xee);
    EXPECT_EQ(fill(other.get()), COPPICE_OK);
    EXPECT_TRUE(other.has_canaries()) << bytes;
    T expected{};
    std::memcpy(static_cast<void*>(&expected), &whole, std::min(bytes, sizeof(T)));
    expected.struct_size = static_cast<std::uint32_t>(bytes);
    const T value = other.value();
    EXPECT_EQ(std::memcmp(&value, &expected, sizeof(T)), 0) << bytes;
    for (std::size_t i = sizeof(T); i < bytes; ++i) EXPECT_EQ(other.byte(i), 0) << i;
  }
}

TEST_F(AbiTest, WhatIsFilledIsFilledAsFarAsItGoes) {
  create(desc());
  const coppice_plant plant = open_random({.leaf_count = 60, .seed = 5});
  expect_filled_in_any_size(stats(), [&](coppice_stats* stats) { return coppice_get_stats(context_, stats); });
  expect_filled_in_any_size(info(plant), [&](coppice_plant_info* info) { return coppice_plant_get_info(context_, plant, info); });
  expect_filled_in_any_size(view_stats(), [&](coppice_view_stats* stats) { return coppice_get_view_stats(context_, view_, stats); });
  auto square = defaults(coppice_sun_desc_init);
  square.radius_m = 1;
  square.size_px = 32;
  auto sun = defaults(coppice_camera_init);
  ASSERT_EQ(coppice_sun_camera(context_, view_, &square, &sun), COPPICE_OK) << log_;
  expect_filled_in_any_size(sun, [&](coppice_camera* camera) { return coppice_sun_camera(context_, view_, &square, camera); });
  auto wind = defaults(coppice_wind_init);
  wind.speed = 7.0f;
  const double place[3] = {3, 1, -20};
  auto gusts = defaults(coppice_gusts_init);
  ASSERT_EQ(coppice_wind_gusts(context_, &wind, place, &gusts), COPPICE_OK) << log_;
  expect_filled_in_any_size(gusts, [&](coppice_gusts* filled) { return coppice_wind_gusts(context_, &wind, place, filled); });
}

TEST_F(AbiTest, TheLastErrorIsThatOfTheContext) {
  create(desc());
  EXPECT_STREQ(coppice_last_error(context_), "");
  coppice_plant plant = 0;
  EXPECT_EQ(coppice_plant_open(context_, "/nowhere/oak.coppice", &plant), COPPICE_ERROR_IO);
  const std::string said = coppice_last_error(context_);
  EXPECT_TRUE(said.starts_with("coppice_plant_open: /nowhere/oak.coppice: ")) << said;
  EXPECT_TRUE(said.ends_with(std::strerror(ENOENT))) << said;
  EXPECT_EQ(stats().instance_count, 0u);
  EXPECT_EQ(said, coppice_last_error(context_)) << "calls that succeed leave it";

  EXPECT_EQ(coppice_set_memory_budget(nullptr, 1), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(mentions(coppice_last_error(nullptr), {"coppice_set_memory_budget: context", "null"}));
  EXPECT_EQ(said, coppice_last_error(context_));
  std::thread([&] {
    EXPECT_STREQ(coppice_last_error(nullptr), "") << "of each thread";
    EXPECT_EQ(said, coppice_last_error(context_)) << "of the context, from any thread";
    (void)coppice_plant_close(context_, 1);
  }).join();
  EXPECT_TRUE(std::string(coppice_last_error(context_)).starts_with("coppice_plant_close: plant "));

  // Cut off between characters, and nothing that a terminal obeys.
  const std::string name = "/\x1b" + std::string(1000, 'x') + "ääääääääää";
  EXPECT_NE(coppice_plant_open(context_, name.c_str(), &plant), COPPICE_OK);
  const std::string cut = coppice_last_error(context_);
  EXPECT_TRUE(cut.size() == 1023 || cut.size() == 1022) << cut.size();
  EXPECT_TRUE(cut.starts_with("coppice_plant_open: /\\x1bxxx")) << cut;
  EXPECT_TRUE(cut.ends_with("ä") || cut.ends_with("x")) << cut;
}

/// Calls the library from inside its own hook for files, on this thread or on another.
struct CallingIo {
  coppice_context* context = nullptr;
  bool from_another_thread = false;
  coppice_status status = COPPICE_OK;

  coppice_io hook() {
    return {sizeof(coppice_io),
            this,
            [](void* user, const char*, std::uint64_t*) -> std::int64_t {
              static_cast<CallingIo*>(user)->call();
              return -ENOENT;
            },
            [](void*, std::int64_t) {},
            [](void*, std::int64_t, std::uint64_t, void*, std::size_t, void (*done)(void*, std::int64_t), void* argument) {
              done(argument, -EIO);
            },
            nullptr};
  }

 private:
  void call() {
    const auto ask = [this] {
      auto stats = defaults(coppice_stats_init);
      status = coppice_get_stats(context, &stats);
    };
    if (from_another_thread)
      std::thread(ask).join();
    else
      ask();
  }
};

TEST_F(AbiTest, CallsThatOverlapAreRefusedInDebugBuilds) {
  if (!CallGuard::kChecks) GTEST_SKIP() << "a release build";
  CallingIo io;
  ContextDesc with = desc();
  with.hooks.io = io.hook();
  create(with);
  io.context = context_;
  coppice_plant plant = 0;
  EXPECT_EQ(coppice_plant_open(context_, kPath, &plant), COPPICE_ERROR_IO);
  expect_refused(io.status, {"coppice_get_stats: ", "coppice_plant_open", "hook"});
  io.from_another_thread = true;
  EXPECT_EQ(coppice_plant_open(context_, kPath, &plant), COPPICE_ERROR_IO);
  expect_refused(io.status, {"coppice_get_stats: ", "coppice_plant_open", "thread"});
  EXPECT_EQ(coppice_set_memory_budget(context_, 256ull << 20), COPPICE_OK) << "what was refused leaves no trace\n" << log_;
}

TEST(CallGuard, ConstCallsOverlapAndOthersDoNot) {
  if (!CallGuard::kChecks) GTEST_SKIP() << "a release build";
  using Access = CallGuard::Access;
  CallGuard guard;
  ASSERT_TRUE(guard.enter("first", Access::shared));
  ASSERT_TRUE(guard.enter("second", Access::shared));
  EXPECT_FALSE(guard.enter("third", Access::exclusive));
  guard.leave(Access::shared);
  EXPECT_FALSE(guard.enter("third", Access::exclusive));
  guard.leave(Access::shared);
  ASSERT_TRUE(guard.enter("third", Access::exclusive));
  EXPECT_FALSE(guard.enter("fourth", Access::shared));
  EXPECT_FALSE(guard.enter("fifth", Access::exclusive));
  guard.leave(Access::exclusive);
  EXPECT_TRUE(guard.enter("sixth", Access::shared));
}

}  // namespace coppice::test::abi_runtime_test
