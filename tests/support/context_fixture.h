#pragma once

// The runtime through coppice.h on the tests' device, a frame at a time.

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "context_desc.h"
#include "coppice/vulkan.h"
#include "pack.h"
#include "random_tree.h"
#include "renderer_scene.h"
#include "shot.h"
#include "text_files.h"
#include "vulkan_device.h"

namespace coppice::test {

/// A random plant as a file has it.
inline std::vector<std::uint8_t> plant_bytes(const RandomPlantOptions& options, bake::TextureCoding textures = bake::TextureCoding::bc) {
  bake::BakedPlant plant = random_plant(options);
  plant.sphere = {glm::vec3(0.0f), 1.6f};
  bake::PackSizes sizes;
  auto bytes = bake::pack(plant, sizes, textures);
  if (!bytes) throw std::runtime_error(bytes.error().message());
  return *std::move(bytes);
}

inline void write_plant(const std::filesystem::path& path, const RandomPlantOptions& options,
                        bake::TextureCoding textures = bake::TextureCoding::bc) {
  write_file(path, plant_bytes(options, textures));
}

/// In the temporary folder; of this process.
inline std::string temporary_plant(const RandomPlantOptions& options, const char* name,
                                   bake::TextureCoding textures = bake::TextureCoding::bc) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / (std::string(name) + std::to_string(getpid()) + ".coppice");
  write_plant(path, options, textures);
  return path.string();
}

class ContextTest : public VulkanTest {
 protected:
  void TearDown() override {
    destroy();
    VulkanTest::TearDown();
  }

  ContextDesc desc() {
    ContextDesc desc = context_desc(gpu());
    desc.max_instances = 4096;
    desc.hooks.log = {sizeof(coppice_log), &log_,
                      [](void* user, coppice_log_level, const char* line) { static_cast<std::string*>(user)->append(line).append("\n"); }};
    return desc;
  }

  /// The context, and a view to draw with.
  void create(const ContextDesc& with) {
    ASSERT_EQ(create_context(with, &context_), COPPICE_OK) << log_;
    view_ = create_view();
  }

  /// The next context begins with frame 1.
  void destroy() {
    coppice_context_destroy(std::exchange(context_, nullptr));
    frame_number_ = 0;
  }

  coppice_view create_view(coppice_output output = COPPICE_OUTPUT_LIT) {
    coppice_view view = 0;
    EXPECT_EQ(test::create_view(context_, &view, output), COPPICE_OK) << log_;
    return view;
  }

  coppice_view create_view(const coppice_vulkan_view_desc& formats, coppice_output output = COPPICE_OUTPUT_LIT) {
    auto desc = defaults(coppice_view_desc_init);
    desc.output = output;
    coppice_view view = 0;
    EXPECT_EQ(coppice_vulkan_view_create(context_, &desc, &formats, &view), COPPICE_OK) << log_;
    return view;
  }

  coppice_plant open(const std::string& path) {
    coppice_plant plant = 0;
    EXPECT_EQ(coppice_plant_open(context_, path.c_str(), &plant), COPPICE_OK) << log_;
    return plant;
  }

  /// A random plant, whose file is gone once it is open.
  coppice_plant open_random(const RandomPlantOptions& options) {
    const std::string path = temporary_plant(options, "context_test");
    const coppice_plant plant = open(path);
    std::filesystem::remove(path);
    return plant;
  }

  /// instances: where the handles go; null: nowhere
  coppice_status try_add(coppice_plant plant, std::span<const coppice_placement> placements, coppice_instance* instances = nullptr) {
    return coppice_instances_add(context_, plant, placements.data(), sizeof(coppice_placement),
                                 static_cast<std::uint32_t>(placements.size()), instances);
  }
  std::vector<coppice_instance> add(coppice_plant plant, std::span<const coppice_placement> placements) {
    std::vector<coppice_instance> instances(placements.size());
    EXPECT_EQ(try_add(plant, placements, instances.data()), COPPICE_OK) << log_;
    return instances;
  }
  coppice_instance add(coppice_plant plant, const coppice_placement& placement) { return add(plant, std::span(&placement, 1))[0]; }
  void move(coppice_instance instance, const coppice_placement& placement) {
    EXPECT_EQ(coppice_instances_move(context_, &instance, &placement, sizeof placement, 1), COPPICE_OK) << log_;
  }

  void remove(std::span<const coppice_instance> instances) {
    EXPECT_EQ(coppice_instances_remove(context_, instances.data(), static_cast<std::uint32_t>(instances.size())), COPPICE_OK) << log_;
  }

  /// The shot's view, or where it says none the test's own.
  [[nodiscard]] coppice_view view_of_shot(const Shot& shot) const { return shot.view != 0 ? shot.view : view_; }

  coppice_status try_begin(std::span<const Shot> shots) {
    std::vector<coppice_camera> cameras;
    for (const Shot& shot : shots) {
      cameras.push_back(shot);
      cameras.back().view = view_of_shot(shot);
    }
    auto frame = defaults(coppice_frame_init);
    frame.frame_number = ++frame_number_;
    frame.completed_number = frame_number_ - 1 - std::min(frames_behind_, frame_number_ - 1);
    frame.cameras = cameras.data();
    frame.camera_count = static_cast<std::uint32_t>(cameras.size());
    frame.wind = wind_;
    return coppice_frame_begin(context_, &frame);
  }
  void begin(std::span<const Shot> shots) { EXPECT_EQ(try_begin(shots), COPPICE_OK) << log_; }
  void begin(const Shot& shot) { begin({&shot, 1}); }

  void record_upload(VkCommandBuffer cmd) { EXPECT_EQ(coppice_record_upload(context_, cmd), COPPICE_OK) << log_; }
  void record_cull(VkCommandBuffer cmd, const Shot& shot) {
    EXPECT_EQ(coppice_record_cull(context_, cmd, view_of_shot(shot), &shot.light), COPPICE_OK) << log_;
  }
  void record_draw(VkCommandBuffer cmd, const Shot& shot, std::uint32_t eye = 0) {
    EXPECT_EQ(coppice_record_draw(context_, cmd, view_of_shot(shot), eye), COPPICE_OK) << log_;
  }

  /// One frame on white, waited for. others: shown beside it; before: recorded between the upload and the view's cull
  Picture frame(const Shot& shot, const std::function<void(VkCommandBuffer)>& before = {}, std::span<const Shot> others = {}) {
    std::vector<Shot> shots(others.begin(), others.end());
    shots.push_back(shot);
    begin(shots);
    return draw_on_white(
        gpu(), shot,
        [&](VkCommandBuffer cmd) {
          record_upload(cmd);
          if (before) before(cmd);
          record_cull(cmd, shot);
        },
        [&](VkCommandBuffer cmd) { record_draw(cmd, shot); });
  }

  /// One frame of all shots. draw: records what follows their culling
  void frame_with(
      std::span<const Shot> shots, const std::function<void(VkCommandBuffer)>& draw = [](VkCommandBuffer) {}) {
    begin(shots);
    submit(gpu(), [&](VkCommandBuffer cmd) {
      record_upload(cmd);
      for (const Shot& shot : shots) record_cull(cmd, shot);
      draw(cmd);
    });
  }
  void frame_with(const Shot& shot, const std::function<void(VkCommandBuffer)>& draw) { frame_with({&shot, 1}, draw); }

  /// One frame of streaming: uploads and culls, draws nothing.
  void pump(const Shot& view) {
    frame_with({&view, 1});
    usleep(1000);
  }

  coppice_stats stats() {
    auto stats = defaults(coppice_stats_init);
    EXPECT_EQ(coppice_get_stats(context_, &stats), COPPICE_OK);
    return stats;
  }

  coppice_streamed_stats streamed() { return stats().streamed[COPPICE_STREAMED_ALL]; }

  coppice_view_stats view_stats(coppice_view view) {
    auto stats = defaults(coppice_view_stats_init);
    EXPECT_EQ(coppice_get_view_stats(context_, view, &stats), COPPICE_OK) << log_;
    return stats;
  }
  coppice_view_stats view_stats() { return view_stats(view_); }

  coppice_plant_info info(coppice_plant plant) {
    auto info = defaults(coppice_plant_info_init);
    EXPECT_EQ(coppice_plant_get_info(context_, plant, &info), COPPICE_OK) << log_;
    return info;
  }

  bool is_settled(coppice_view view) {
    std::uint32_t settled = COPPICE_FALSE;
    EXPECT_EQ(coppice_is_settled(context_, view, &settled), COPPICE_OK) << log_;
    return settled != COPPICE_FALSE;
  }

  /// Streams until the shot's view has all that it wants.
  void pump_until_settled(const Shot& shot) {
    for (int i = 0; i < 400 && (i < 3 || !is_settled(view_of_shot(shot))); ++i) pump(shot);
    EXPECT_TRUE(is_settled(view_of_shot(shot)));
  }

  /// Frames until the view of `view` has all that it wants and nothing is under way.
  Picture settle(const Shot& view) {
    Picture picture;
    for (int i = 0; i < 400; ++i) {
      picture = frame(view);
      if (i > 2 && is_settled(view_of_shot(view)) && streamed().in_flight == 0) break;
      usleep(2000);
    }
    return picture;
  }

  coppice_context* context_ = nullptr;
  coppice_view view_ = 0;
  const coppice_wind* wind_ = nullptr;  ///< what frames begin with
  std::uint64_t frame_number_ = 0;
  std::uint64_t frames_behind_ = 0;  ///< how many frames the GPU has not finished when one begins
  std::string log_;
};

}  // namespace coppice::test
