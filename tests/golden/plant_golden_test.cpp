// Pictures of one plant through the C API, at three distances, with the cut that the error table asks for and with every leaf.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "atomic_file.h"
#include "bake.h"
#include "context_desc.h"
#include "generate_plant.h"
#include "gltf_write.h"
#include "golden.h"
#include "process.h"
#include "shot.h"
#include "vulkan_device.h"

#include "coppice/vulkan.h"

namespace plant_golden_test {

using coppice::test::Image;
using coppice::test::Picture;
using coppice::test::VulkanDevice;

constexpr std::uint32_t kSidePx = 256;
constexpr VkFormat kColorFormat = VK_FORMAT_R8G8B8A8_SRGB;
constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr float kFieldOfView = 0.6f;  // radians

void check(coppice_status status, const char* call) {
  if (status != COPPICE_OK) throw std::runtime_error(std::string(call) + ": " + coppice_status_text(status));
}

/// Generates and bakes a plant; the file lies in `folder`.
std::string bake_plant(const coppice::test::TemporaryFolder& folder, const char* species) {
  const auto plant = coppice::bake::generate_plant(species, 1);
  if (!plant) throw std::runtime_error(plant.error().message());
  const auto glb = folder / "plant.glb";
  const auto written =
      coppice::bake::write_glb(glb, {{"leaves", &plant->foliage}, {"wood", &plant->wood}}, plant->materials, plant->images);
  if (!written) throw std::runtime_error(written.error().message());
  coppice::bake::BakeReport report;
  const auto bytes = coppice::bake::bake(
      glb, {}, [](const char*, double) {}, report);
  if (!bytes) throw std::runtime_error(bytes.error().message());
  const auto file = folder / "plant.coppice";
  const auto saved = coppice::bake::write_file_atomically(file, *bytes);
  if (!saved) throw std::runtime_error(saved.error().message());
  return file;
}

void print_log(void*, coppice_log_level level, const char* line) {
  if (level != COPPICE_LOG_INFO) std::printf("coppice: %s\n", line);
}

using Context = std::unique_ptr<coppice_context, decltype(&coppice_context_destroy)>;

Context create_context(const VulkanDevice& gpu, bool compute_raster) {
  coppice::test::ContextDesc desc = coppice::test::context_desc(gpu);
  desc.compute_raster = compute_raster ? VK_TRUE : VK_FALSE;
  desc.shader_int64_atomics = gpu.int64_atomics ? VK_TRUE : VK_FALSE;
  desc.memory_budget_bytes = std::uint64_t{64} << 20;
  // Inline: what is resident in which frame does not depend on the machine.
  desc.hooks.jobs.submit = [](void*, void (*function)(void*), void* argument) { function(argument); };
  desc.hooks.log.write = print_log;
  coppice_context* context = nullptr;
  check(coppice::test::create_context(desc, &context), "coppice_vulkan_context_create");
  return {context, coppice_context_destroy};
}

/// Perspective to Vulkan's clip space, y down, depth 1 at `near` and 0 at `far`.
glm::mat4 reversed_perspective(float field_of_view, float near, float far) {
  const float scale = 1.0f / std::tan(0.5f * field_of_view);
  glm::mat4 clip(0.0f);
  clip[0][0] = scale;
  clip[1][1] = -scale;
  clip[2][2] = near / (far - near);
  clip[2][3] = -1.0f;
  clip[3][2] = near * far / (far - near);
  return clip;
}

/// distance  from the sphere's centre, in radii of the sphere
coppice::test::Shot make_view(const coppice_plant_info& plant, float distance, coppice_lod_mode lod) {
  const glm::vec3 center(plant.sphere_center[0], plant.sphere_center[1], plant.sphere_center[2]);
  const glm::vec3 eye = center + glm::normalize(glm::vec3(0.6f, 0.25f, 1.0f)) * (distance * plant.sphere_radius);
  const glm::mat4 view_from_world = glm::lookAt(eye, center, glm::vec3(0, 1, 0));
  const glm::mat4 clip_from_view = reversed_perspective(kFieldOfView, 0.01f * plant.sphere_radius, 1000.0f * plant.sphere_radius);
  coppice::test::Shot view;
  coppice::test::init_shot(&view);
  std::copy_n(&view_from_world[0][0], 16, view.view_from_world);
  std::copy_n(&clip_from_view[0][0], 16, view.clip_from_view);
  view.width_px = kSidePx;
  view.height_px = kSidePx;
  view.lod = lod;
  const glm::vec3 sun = glm::normalize(glm::vec3(0.5f, 0.8f, 0.4f));
  std::copy_n(&sun[0], 3, view.light.sun_direction);
  return view;
}

class Renderer {
 public:
  Renderer(const VulkanDevice& gpu, coppice_context* context)
      : gpu_(gpu),
        context_(context),
        color_(gpu, {kSidePx, kSidePx, kColorFormat, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT}),
        depth_(gpu, {kSidePx, kSidePx, kDepthFormat, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT}) {
    static_assert(kColorFormat == VK_FORMAT_R8G8B8A8_SRGB && kDepthFormat == VK_FORMAT_D32_SFLOAT);
    check(coppice::test::create_view(context_, &view_), "coppice_vulkan_view_create");
  }

  /// Draws until everything the view wants is resident and shown, then returns the picture.
  Picture draw(const coppice::test::Shot& view) {
    constexpr int kMaxFrames = 400;
    constexpr int kQuietFrames = 3;  // what arrived last has been uploaded, drawn and counted
    int quiet = 0;
    for (int frame = 0; frame < kMaxFrames; ++frame) {
      draw_frame(view);
      std::uint32_t settled = 0;
      check(coppice_is_settled(context_, view_, &settled), "coppice_is_settled");
      quiet = settled != 0 ? quiet + 1 : 0;
      if (quiet == kQuietFrames) return coppice::test::read_picture(gpu_, color_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));  // reads are asynchronous
    }
    throw std::runtime_error("streaming does not come to rest");
  }

  [[nodiscard]] coppice_view_stats statistics() const {
    coppice_view_stats stats;
    coppice_view_stats_init(&stats);
    check(coppice_get_view_stats(context_, view_, &stats), "coppice_get_view_stats");
    return stats;
  }

 private:
  void draw_frame(const coppice::test::Shot& view) {
    coppice_frame frame;
    coppice_frame_init(&frame);
    frame.frame_number = ++frame_number_;
    frame.completed_number = frame_number_ - 1;
    coppice_camera camera = view;
    camera.view = view_;
    frame.cameras = &camera;
    frame.camera_count = 1;
    check(coppice_frame_begin(context_, &frame), "coppice_frame_begin");
    coppice::test::submit(gpu_, [&](VkCommandBuffer cmd) {
      check(coppice_record_upload(context_, cmd), "coppice_record_upload");
      check(coppice_record_cull(context_, cmd, view_, &view.light), "coppice_record_cull");
      begin_rendering(cmd);
      check(coppice_record_draw(context_, cmd, view_, 0), "coppice_record_draw");
      vkCmdEndRendering(cmd);
    });
  }

  void begin_rendering(VkCommandBuffer cmd) {
    coppice::test::change_layout(cmd, color_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    coppice::test::change_layout(cmd, depth_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    VkRenderingAttachmentInfo color{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    color.imageView = color_.view();
    color.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    color.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    color.clearValue.color = {{0.6f, 0.75f, 0.9f, 1.0f}};
    VkRenderingAttachmentInfo depth{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    depth.imageView = depth_.view();
    depth.imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
    depth.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;  // to 0, the far plane: depth is reversed
    depth.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
    info.renderArea.extent = {kSidePx, kSidePx};
    info.layerCount = 1;
    info.colorAttachmentCount = 1;
    info.pColorAttachments = &color;
    info.pDepthAttachment = &depth;
    vkCmdBeginRendering(cmd, &info);
  }

  const VulkanDevice& gpu_;
  coppice_context* context_;
  coppice_view view_ = 0;
  Image color_, depth_;
  std::uint64_t frame_number_ = 0;
};

struct Case {
  const char* name;
  float distance;  ///< radii; 3.4 just holds the sphere
};
constexpr std::array<Case, 3> kCases{{{"near", 3.5f}, {"middle", 10.0f}, {"far", 40.0f}}};

class PlantGolden : public coppice::test::VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    file_ = bake_plant(folder_, "corylus");
    open(false);
  }

  void open(bool compute_raster) {
    renderer_.reset();
    context_ = create_context(gpu(), compute_raster);
    check(coppice_plant_open(context_.get(), file_.c_str(), &plant_), "coppice_plant_open");
    coppice_plant_info_init(&info_);
    check(coppice_plant_get_info(context_.get(), plant_, &info_), "coppice_plant_get_info");
    const coppice_placement placement{{0, 0, 0}, 1, {0, 0, 0, 1}, {1, 1, 1}, 0, COPPICE_ALL_LAYERS, 0, 1};
    check(coppice_instances_add(context_.get(), plant_, &placement, sizeof(coppice_placement), 1, nullptr), "coppice_instances_add");
    renderer_ = std::make_unique<Renderer>(gpu(), context_.get());
  }

  void TearDown() override {
    renderer_.reset();
    context_.reset();
    VulkanTest::TearDown();
  }

  coppice::test::TemporaryFolder folder_;
  std::string file_;
  Context context_{nullptr, coppice_context_destroy};
  coppice_plant plant_ = 0;
  coppice_plant_info info_{};
  std::unique_ptr<Renderer> renderer_;
};

TEST_F(PlantGolden, Full) {
  for (const Case& c : kCases) {
    const Picture picture = renderer_->draw(make_view(info_, c.distance, COPPICE_LOD_FULL));
    EXPECT_EQ(renderer_->statistics().drawn_leaf_count, 386u) << c.name;
    coppice::test::expect_golden(std::string("corylus_full_") + c.name, picture, {}, gpu().driver_name);
  }
}

TEST_F(PlantGolden, Cut) {
  std::uint64_t leaves = 387;
  for (const Case& c : kCases) {
    const Picture picture = renderer_->draw(make_view(info_, c.distance, COPPICE_LOD_CUT));
    const coppice_view_stats stats = renderer_->statistics();
    const std::uint64_t drawn = stats.drawn_leaf_count;
    if (stats.leaf_mesh_instance_count > 0) {
      EXPECT_EQ(drawn, 386u) << c.name << ": leaf meshes are all leaves";
    } else {
      EXPECT_LT(drawn, leaves) << c.name << ": no fewer leaves than nearer by";
    }
    leaves = drawn;
    std::printf("%s: %u leaves\n", c.name, static_cast<unsigned>(drawn));
    coppice::test::expect_golden(std::string("corylus_cut_") + c.name, picture, {}, gpu().driver_name);
  }
  EXPECT_GE(leaves, 1u);
  EXPECT_LT(leaves, 386u) << "far away, not all of them";
}

TEST_F(PlantGolden, ComputeRaster) {
  open(true);
  for (const Case& c : kCases) {
    const Picture picture = renderer_->draw(make_view(info_, c.distance, COPPICE_LOD_CUT));
    coppice::test::expect_golden(std::string("corylus_raster_") + c.name, picture, {}, gpu().driver_name);
  }
}

}  // namespace plant_golden_test
