// Several views of one context: each is drawn as it is alone, whatever the order, and each has what it wants streamed.

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <thread>

#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "mentions.h"
#include "path_fixture.h"

namespace coppice::test::views_test {

constexpr std::uint32_t kSidePx = 128;

std::uint32_t eye_count_of(const coppice_camera& camera) {
  return camera.second_eye == nullptr ? 1 : 2;
}

constexpr std::uint8_t kStencil = 7;  ///< that stencils are cleared to

/// What a view is drawn to: two eyes side by side.
struct Target {
  std::unique_ptr<Image> color;  ///< null: depth alone
  Image depth;

  Target(const VulkanDevice& gpu, const coppice_camera& camera, VkFormat color_format, VkFormat depth_format = VK_FORMAT_D32_SFLOAT)
      : depth(gpu, depth_attachment(eye_count_of(camera) * camera.width_px, camera.height_px, depth_format)) {
    if (color_format == VK_FORMAT_UNDEFINED) return;
    color = std::make_unique<Image>(gpu, color_attachment(depth.desc().width_px, depth.desc().height_px, color_format));
  }

  /// clear: what was there before goes
  void begin(VkCommandBuffer cmd, bool clear) const {
    Attachments all{.depth = &depth, .farthest = {0.0f, kStencil}};
    if (color) all.colors = {color.get()};
    if (!clear) {
      all.colors_from = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
      all.depth_from = depth.attachment_layout();
    }
    begin_rendering(cmd, all);
  }
};

/// What a target shows that has been drawn to.
struct Drawn {
  Picture picture;           ///< empty with depth alone
  std::vector<float> depth;  ///< empty with colour

  bool operator==(const Drawn& other) const { return picture.rgba == other.picture.rgba && depth == other.depth; }
};

Drawn read(const VulkanDevice& gpu, const Target& target) {
  if (target.color) return {read_picture(gpu, *target.color), {}};
  return {{}, read_floats(gpu, target.depth)};
}

/// Pixels that show something.
std::size_t covered(const Drawn& drawn) {
  const std::size_t count = count_pixels(drawn.picture, [](const std::uint8_t* rgb) { return rgb[1] < 250; });
  return count + static_cast<std::size_t>(std::ranges::count_if(drawn.depth, [](float depth) { return depth > 0.0f; }));
}

/// A command pool with one command buffer, for a thread of its own.
class Recorder {
 public:
  explicit Recorder(const VulkanDevice& gpu) : gpu_(gpu) {
    const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = gpu.queue_family};
    check_vk(vkCreateCommandPool(gpu.device, &pool, nullptr, &pool_), "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                               .commandPool = pool_,
                                               .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                               .commandBufferCount = 1};
    check_vk(vkAllocateCommandBuffers(gpu.device, &allocate, &cmd), "vkAllocateCommandBuffers");
    const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    check_vk(vkBeginCommandBuffer(cmd, &begin), "vkBeginCommandBuffer");
  }
  ~Recorder() { vkDestroyCommandPool(gpu_.device, pool_, nullptr); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  VkCommandBuffer cmd = VK_NULL_HANDLE;

 private:
  const VulkanDevice& gpu_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
};

Shot view_from(const glm::vec3& eye_m) {
  return make_view({.eye_m = eye_m, .width_px = kSidePx});
}

class ViewsTest : public PathTest<ContextTest> {
 protected:
  void place(const std::vector<glm::vec3>& places) {
    for (const glm::vec3& at : places) add(plant_, placement_at(at));
  }
  /// shot: becomes the first eye of a pair, whose pictures are side by side.
  void add_eye(Shot& shot, double apart_m, double turn_rad) {
    second_eye_ = eye_beside(shot, apart_m, turn_rad);
    // As displays on a head have them: each reaches farther to its own side.
    shot.clip_from_view[8] -= 0.15f;
    second_eye_.clip_from_view[8] += 0.15f;
    second_eye_.x_px = static_cast<std::int32_t>(shot.width_px);
    shot.second_eye = &second_eye_;
  }
  /// One of a pair's eyes, as a view of its own.
  static Shot single_eye(const Shot& pair, std::uint32_t eye) {
    Shot single = pair;
    single.second_eye = nullptr;
    if (eye == 0) return single;
    std::copy_n(pair.second_eye->view_from_world, 16, single.view_from_world);
    std::copy_n(pair.second_eye->clip_from_view, 16, single.clip_from_view);
    return single;
  }

  /// A camera from the front, its mirror image from below, a sun's, and a stereo pair from behind that is closer and finer.
  std::vector<Shot> four_views() {
    Shot front = view_from({0.0f, 1.0f, 6.0f});
    Shot mirrored = front;
    const glm::mat4 mirror = glm::scale(glm::translate(glm::mat4(1.0f), glm::vec3(0, -4, 0)), glm::vec3(1, -1, 1));
    const glm::dmat4 below = glm::make_mat4(front.view_from_world) * glm::dmat4(mirror);
    std::copy_n(glm::value_ptr(below), 16, mirrored.view_from_world);
    Shot behind = view_from({-3.0f, 0.5f, -16.0f});
    behind.error_px = 0.5f;
    add_eye(behind, 0.065, 0.0);
    auto desc = defaults(coppice_sun_desc_init);
    std::copy_n(front.light.sun_direction, 3, desc.sun_direction);
    desc.radius_m = 12.0f;
    desc.size_px = kSidePx;
    Shot sun = front;
    front.view = view_;
    mirrored.view = create_view();
    behind.view = create_view();
    const coppice_view map = create_view(COPPICE_OUTPUT_DEPTH);
    EXPECT_EQ(coppice_sun_camera(context_, map, &desc, &sun), COPPICE_OK) << log_;
    depth_view_ = map;
    return {front, mirrored, behind, sun};
  }

  /// Frames with all of them until each has what it wants.
  void settle_all(const std::vector<Shot>& shots) {
    for (int i = 0; i < 400; ++i) {
      begin(shots);
      submit(gpu(), [&](VkCommandBuffer cmd) { record_upload(cmd); });
      if (i > 2 && std::ranges::all_of(shots, [&](const Shot& shot) { return is_settled(view_of_shot(shot)); })) return;
      usleep(2000);
    }
    ADD_FAILURE() << "streaming does not come to rest";
  }

  /// The rows from the front, all of which is there.
  Shot settled_rows() {
    add(plant_, rows());
    Shot shot = view_from({0, 1, 6});
    shot.view = view_;
    settle_all({shot});
    return shot;
  }

  [[nodiscard]] std::unique_ptr<Target> target_of(const Shot& shot) {
    return std::make_unique<Target>(gpu(), shot, shot.view == depth_view_ ? VK_FORMAT_UNDEFINED : VK_FORMAT_R8G8B8A8_SRGB);
  }

  [[nodiscard]] std::vector<std::unique_ptr<Target>> targets_of(const std::vector<Shot>& shots) {
    std::vector<std::unique_ptr<Target>> targets;
    for (const Shot& shot : shots) targets.push_back(target_of(shot));
    return targets;
  }

  void record_one_draw(VkCommandBuffer cmd, const Shot& shot, const Target& target, bool clear = true) {
    target.begin(cmd, clear);
    for (std::uint32_t eye = 0; eye < eye_count_of(shot); ++eye) record_draw(cmd, shot, eye);
    vkCmdEndRendering(cmd);
  }

  /// A frame with this view alone.
  void draw_alone(const Shot& shot, const Target& target) {
    frame_with(shot, [&](VkCommandBuffer cmd) { record_one_draw(cmd, shot, target); });
  }
  Drawn alone(const Shot& shot) {
    const auto target = target_of(shot);
    draw_alone(shot, *target);
    return read(gpu(), *target);
  }
  std::vector<Drawn> each_alone(const std::vector<Shot>& shots) {
    std::vector<Drawn> drawn;
    for (const Shot& shot : shots) drawn.push_back(alone(shot));
    return drawn;
  }

  coppice_view depth_view_ = 0;
  coppice_eye second_eye_{};
};

TEST_P(ViewsTest, CullsAndDrawsInAnyOrderAreEachViewDrawnAlone) {
  add(plant_, rows());
  const std::vector<Shot> shots = four_views();
  settle_all(shots);
  const std::vector<Drawn> expected = each_alone(shots);
  for (const Drawn& drawn : expected) EXPECT_GT(covered(drawn), 500u);
  EXPECT_FALSE(expected[0] == expected[1]);
  std::mt19937 random(7);
  for (int turn = 0; turn < 8; ++turn) {
    // Twice each view: the first time it comes it is culled, the second time drawn.
    std::vector<std::size_t> order{0, 1, 2, 3, 0, 1, 2, 3};
    std::ranges::shuffle(order, random);
    const auto targets = targets_of(shots);
    begin(shots);
    submit(gpu(), [&](VkCommandBuffer cmd) {
      record_upload(cmd);
      std::array<bool, 4> culled{};
      for (const std::size_t i : order) {
        if (std::exchange(culled[i], true))
          record_one_draw(cmd, shots[i], *targets[i]);
        else
          record_cull(cmd, shots[i]);
      }
    });
    for (std::size_t i = 0; i < shots.size(); ++i) EXPECT_TRUE(read(gpu(), *targets[i]) == expected[i]) << "turn " << turn << " view " << i;
  }
}

TEST_P(ViewsTest, AViewIsCulledAndDrawnAgainInOneFrame) {
  add(plant_, rows());
  const std::vector<Shot> shots = four_views();
  settle_all(shots);
  for (const Shot& shot : shots) {
    const Drawn expected = alone(shot);
    const std::array targets{target_of(shot), target_of(shot), target_of(shot)};
    frame_with(shot, [&](VkCommandBuffer cmd) {
      record_one_draw(cmd, shot, *targets[0]);
      record_cull(cmd, shot);
      record_one_draw(cmd, shot, *targets[1]);
      record_one_draw(cmd, shot, *targets[2]);
    });
    for (const auto& target : targets) EXPECT_TRUE(read(gpu(), *target) == expected);
  }
}

/// Pixels that show something in one of two pictures alone, of those that show something in the second.
double differing_coverage(const Picture& a, const Picture& b) {
  std::size_t differing = 0;
  for (std::size_t i = 1; i < b.rgba.size(); i += 4) differing += (a.rgba[i] < 250) != (b.rgba[i] < 250);
  return static_cast<double>(differing) / static_cast<double>(covered({b, {}}));
}

/// Eyes of a head, and eyes that see nothing in common. Alone an eye has its cuts at sizes from its own place, not from the middle.
TEST_P(ViewsTest, EachEyeOfAPairShowsWhatItSeesAlone) {
  add(plant_, rows());
  struct Pair {
    double apart_m, turn_rad;
    float error_px;
  };
  for (const Pair& pair : {Pair{0.065, 0.0, 2.0f}, Pair{0.065, 0.1, 0.05f}, Pair{0.1, 2.8, 0.05f}}) {
    Shot shot = make_view(
        {.eye_m = {-1.0f, 1.0f, -7.5f}, .target_m = {-1.0f, 1.0f, -20.0f}, .width_px = kSidePx, .error_px = pair.error_px, .view = view_});
    add_eye(shot, pair.apart_m, pair.turn_rad);
    settle_all({shot});
    const Drawn both = alone(shot);
    for (const std::uint32_t eye : {0u, 1u}) {
      const Shot single = single_eye(shot, eye);
      settle_all({single});
      const Drawn one = alone(single);
      EXPECT_GT(covered(one), 1000u);
      EXPECT_LT(differing_coverage(half_of(both.picture, eye), one.picture), 0.02)
          << pair.apart_m << " m apart, turned by " << pair.turn_rad << ", eye " << eye;
      EXPECT_LT(rmse(half_of(both.picture, eye), one.picture), 10.0);
    }
    EXPECT_GT(differing_coverage(half_of(both.picture, 0), half_of(both.picture, 1)), 0.1);
  }
}

TEST_P(ViewsTest, ViewsAreRecordedByThreadsOfTheirOwn) {
  add(plant_, rows());
  const std::vector<Shot> shots = four_views();
  settle_all(shots);
  const std::vector<Drawn> expected = each_alone(shots);
  for (int turn = 0; turn < 4; ++turn) {
    const auto targets = targets_of(shots);
    begin(shots);
    submit(gpu(), [&](VkCommandBuffer cmd) { record_upload(cmd); });
    std::vector<std::unique_ptr<Recorder>> recorders;
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < shots.size(); ++i) recorders.push_back(std::make_unique<Recorder>(gpu()));
    for (std::size_t i = 0; i < shots.size(); ++i)
      threads.emplace_back([&, i] {
        record_cull(recorders[i]->cmd, shots[i]);
        record_one_draw(recorders[i]->cmd, shots[i], *targets[i]);
      });
    for (std::thread& thread : threads) thread.join();
    std::vector<VkCommandBuffer> commands;
    for (const auto& recorder : recorders) {
      check_vk(vkEndCommandBuffer(recorder->cmd), "vkEndCommandBuffer");
      commands.push_back(recorder->cmd);
    }
    std::rotate(commands.begin(), commands.begin() + turn, commands.end());
    const VkSubmitInfo info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                            .commandBufferCount = static_cast<std::uint32_t>(commands.size()),
                            .pCommandBuffers = commands.data()};
    check_vk(vkQueueSubmit(gpu().queue, 1, &info, VK_NULL_HANDLE), "vkQueueSubmit");
    check_vk(vkQueueWaitIdle(gpu().queue), "vkQueueWaitIdle");
    for (std::size_t i = 0; i < shots.size(); ++i) EXPECT_TRUE(read(gpu(), *targets[i]) == expected[i]) << "turn " << turn << " view " << i;
  }
}

TEST_P(ViewsTest, ASecondCameraStreamsToItsOwnFullDetail) {
  place({{0, 0, 0}, {500, 0, 0}});
  Shot far = view_from({0, 0.3f, 60});
  far.view = view_;
  settle_all({far});
  EXPECT_LT(info(plant_).resident_leaf_count, 3000u);
  Shot near = make_view({.eye_m = {500, 0.3f, 4}, .target_m = {500, 0, 0}, .width_px = kSidePx, .error_px = 0.01f, .view = create_view()});
  settle_all({far, near});
  EXPECT_EQ(info(plant_).resident_leaf_count, 3000u);
  for (int i = 0; i < 3; ++i) frame_with(std::array{near, far});
  EXPECT_GT(view_stats(near.view).drawn_leaf_count, 2900u);
  EXPECT_EQ(view_stats(near.view).threshold_px, 0.01f);
  EXPECT_LT(view_stats(far.view).drawn_leaf_count, 1000u);
  EXPECT_EQ(view_stats(far.view).threshold_px, 2.0f);
}

TEST_P(ViewsTest, ALeafBudgetIsOfOneView) {
  add(plant_, rows());
  Shot front = view_from({0, 1, 6});
  front.view = view_;
  front.error_px = 0.5f;
  Shot limited = front;
  limited.view = create_view();
  settle_all({front, limited});
  const std::vector<Drawn> expected = each_alone({front});
  const std::uint64_t leaves = [&] {
    alone(front);
    alone(front);
    return view_stats(front.view).drawn_leaf_count;
  }();
  limited.leaf_budget = static_cast<std::uint32_t>(leaves / 4);
  const auto target = target_of(front);
  for (int i = 0; i < 80; ++i) frame_with(std::array{front, limited}, [&](VkCommandBuffer cmd) { record_one_draw(cmd, front, *target); });
  EXPECT_TRUE(read(gpu(), *target) == expected[0]);
  EXPECT_LE(view_stats(limited.view).drawn_leaf_count, limited.leaf_budget);
  EXPECT_EQ(view_stats(front.view).drawn_leaf_count, leaves);
}

TEST_P(ViewsTest, ViewsSideBySideInOneAttachment) {
  add(plant_, rows());
  std::vector<Shot> shots;
  for (const float x_m : {-4.0f, 0.0f, 5.0f}) {
    shots.push_back(view_from({x_m, 1.0f, 6.0f}));
    shots.back().view = shots.size() == 1 ? view_ : create_view();
  }
  settle_all(shots);
  const std::vector<Drawn> expected = each_alone(shots);
  Shot whole = shots[0];
  whole.width_px = 3 * kSidePx + 20;
  whole.height_px = kSidePx + 7;
  const auto target = target_of(whole);
  for (std::size_t i = 0; i < shots.size(); ++i) {
    shots[i].x_px = static_cast<std::int32_t>(i * (kSidePx + 10));
    shots[i].y_px = static_cast<std::int32_t>(3 * i);
  }
  frame_with(shots, [&](VkCommandBuffer cmd) {
    for (const Shot& shot : shots) record_one_draw(cmd, shot, *target, &shot == shots.data());
  });
  const Picture picture = read(gpu(), *target).picture;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    std::size_t different = 0;
    for (std::uint32_t y = 0; y < kSidePx; ++y)
      for (std::uint32_t x = 0; x < kSidePx; ++x) {
        const std::size_t at = 4 * ((y + static_cast<std::uint32_t>(shots[i].y_px)) * std::size_t{whole.width_px} + x +
                                    static_cast<std::uint32_t>(shots[i].x_px));
        different += !std::equal(&picture.rgba[at], &picture.rgba[at] + 4, &expected[i].picture.rgba[4 * (y * kSidePx + x)]);
      }
    // Where a triangle's edge runs close to the middle of a pixel, a viewport elsewhere may round it to the other side.
    EXPECT_LE(different, kSidePx * kSidePx / 100) << i;
  }
}

TEST_P(ViewsTest, WhatWasNotCulledIsNotDrawn) {
  place({{0, 0, 0}});
  Shot shown = make_view({.width_px = kSidePx, .view = view_});
  Shot other = shown;
  other.view = create_view();
  begin(shown);
  submit(gpu(), [&](VkCommandBuffer cmd) {
    record_upload(cmd);
    EXPECT_EQ(coppice_record_draw(context_, cmd, shown.view, 0), COPPICE_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(mentions(log_, {"coppice_record_draw", "coppice_record_cull"}));
    EXPECT_EQ(coppice_record_cull(context_, cmd, other.view, nullptr), COPPICE_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(mentions(log_, {"coppice_record_cull: view"}));
    record_cull(cmd, shown);
    EXPECT_EQ(coppice_record_draw(context_, cmd, other.view, 0), COPPICE_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(coppice_record_draw(context_, cmd, shown.view, 1), COPPICE_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(mentions(log_, {": eye", "1"}));
  });
  begin(shown);
  submit(gpu(), [&](VkCommandBuffer cmd) {
    record_upload(cmd);
    EXPECT_EQ(coppice_record_draw(context_, cmd, shown.view, 0), COPPICE_ERROR_INVALID_ARGUMENT) << "the frame before culled it";
  });
  begin(std::span<const Shot>());
  submit(gpu(), [&](VkCommandBuffer cmd) { record_upload(cmd); });
}

/// With the engine's stencil bound, which stays as it is: the picture is that without.
TEST_P(ViewsTest, AStencilAttachmentMayBeBound) {
  Shot shot = settled_rows();
  const Drawn expected = alone(shot);
  auto formats = defaults(coppice_vulkan_view_desc_init);
  formats.color_formats[0] = VK_FORMAT_R8G8B8A8_SRGB;
  formats.depth_format = VK_FORMAT_D32_SFLOAT_S8_UINT;
  formats.has_stencil = VK_TRUE;
  shot.view = create_view(formats);
  const Target target(gpu(), shot, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_D32_SFLOAT_S8_UINT);
  draw_alone(shot, target);
  EXPECT_TRUE(read(gpu(), target) == expected);
  const std::vector<std::uint8_t> stencil = read_bytes(gpu(), target.depth, 1, {}, VK_IMAGE_ASPECT_STENCIL_BIT);
  EXPECT_EQ(std::ranges::count(stencil, kStencil), static_cast<std::ptrdiff_t>(stencil.size()));
}

/// HDR in, HDR out: a hundred times the light is a hundred times the picture, near by the hardware and far by compute shaders alike.
TEST_P(ViewsTest, BrightLightIsAsBrightFarAsNear) {
  add(plant_, rows());
  auto formats = defaults(coppice_vulkan_view_desc_init);
  formats.color_formats[0] = VK_FORMAT_R32_SFLOAT;
  formats.depth_format = VK_FORMAT_D32_SFLOAT;
  const coppice_view view = create_view(formats);
  for (const float distance_m : {4.0f, 30.0f}) {
    Shot shot = view_from({0, 1, distance_m});
    shot.view = view;
    settle_all({shot});
    const auto picture = [&](float times) {
      Shot lit = shot;
      for (float* color : {lit.light.sun_color, lit.light.sky_color, lit.light.ground_color})
        for (std::size_t i = 0; i < 3; ++i) color[i] *= times;
      const Target target(gpu(), lit, VK_FORMAT_R32_SFLOAT);
      draw_alone(lit, target);
      return read_floats(gpu(), *target.color);
    };
    const std::vector<float> dim = picture(1.0f), bright = picture(1000.0f);
    std::size_t lit = 0;
    for (std::size_t i = 0; i < dim.size(); ++i) {
      if (dim[i] == 1.0f) continue;  // the background
      ++lit;
      EXPECT_NEAR(bright[i], 1000.0f * dim[i], 5.0f + 8.0f * dim[i]) << distance_m << " m, pixel " << i;
    }
    EXPECT_GT(lit, 100u);
    EXPECT_GT(*std::ranges::max_element(bright), 60.0f) << "beyond 16, where it once ended";
  }
}

TEST_P(ViewsTest, ViewsComeAndGoAndLeaveNothing) {
  Shot shot = settled_rows();
  const Drawn expected = alone(shot);
  Shot other = shot;
  std::uint64_t bytes = 0;
  for (int i = 0; i < 12; ++i) {
    other.view = create_view(i % 3 == 2 ? COPPICE_OUTPUT_DEPTH : COPPICE_OUTPUT_LIT);
    // Instances come while it is there, so that its buffers grow.
    if (i == 4) place(std::vector<glm::vec3>(2000, glm::vec3(0, 0, 900)));
    depth_view_ = i % 3 == 2 ? other.view : 0;
    const std::vector<Shot> both{shot, other};
    const auto target = target_of(shot), other_target = target_of(other);
    frame_with(both, [&](VkCommandBuffer cmd) {
      record_one_draw(cmd, other, *other_target);
      record_one_draw(cmd, shot, *target);
    });
    EXPECT_TRUE(read(gpu(), *target) == expected) << i;
    ASSERT_EQ(coppice_view_destroy(context_, other.view), COPPICE_OK) << log_;
    EXPECT_EQ(coppice_view_destroy(context_, other.view), COPPICE_ERROR_INVALID_ARGUMENT);
    depth_view_ = 0;
    for (int j = 0; j < 3; ++j) alone(shot);
    if (i == 6) bytes = stats().memory_bytes;
    EXPECT_TRUE(i <= 6 || stats().memory_bytes == bytes) << i << ": " << stats().memory_bytes << ", not " << bytes;
  }
}

INSTANTIATE_TEST_SUITE_P(Paths, ViewsTest, testing::Values(kHardwarePath, kComputePath, kTwoPassPath), path_name);

}  // namespace coppice::test::views_test
