#include "looks_stage.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>

#include <glm/gtc/matrix_transform.hpp>

#include "context_desc.h"
#include "srgb.h"

namespace coppice::test {
namespace {

// A lens of 60 degrees on 1280 x 720 has 623; a longer one shows the plant as it is from farther away, with less perspective.
constexpr float kFocalPx = 1200.0f;
constexpr std::uint32_t kFrames = 16;
// Between what is lit and what is shaded, as a meadow is; its alpha is 0, that of all that is drawn 1.
constexpr VkClearColorValue kBackground{{0.2f, 0.2f, 0.2f, 0.0f}};

void check(coppice_status status, const char* call) {
  if (status != COPPICE_OK) throw std::runtime_error(std::string(call) + ": " + coppice_status_text(status));
}

void print_log(void*, coppice_log_level level, const char* line) {
  if (level != COPPICE_LOG_INFO) std::printf("coppice: %s\n", line);
}

/// To Vulkan's clip space, y down, depth 1 at `near` and 0 infinitely far away.
glm::mat4 reversed_perspective(float side_px, float near) {
  const float scale = 2.0f * kFocalPx / side_px;
  glm::mat4 clip(0.0f);
  clip[0][0] = scale;
  clip[1][1] = -scale;
  clip[2][3] = -1.0f;
  clip[3][2] = near;
  return clip;
}

/// A point of the Halton sequence, which covers 0..1 evenly from the first points on.
float halton(std::uint32_t index, std::uint32_t base) {
  float value = 0, digit = 1;
  for (; index > 0; index /= base) {
    digit /= static_cast<float>(base);
    value += digit * static_cast<float>(index % base);
  }
  return value;
}

void add_to_mean(const Picture& frame, bool of_light, MeanPicture& mean) {
  for (std::size_t i = 0; i < mean.texels.size(); ++i) {
    const std::uint8_t* texel = &frame.rgba[4 * i];
    glm::vec4 value(texel[0], texel[1], texel[2], static_cast<float>(texel[3]) / 255.0f);
    if (of_light) value = {linear_from_srgb8(texel[0]), linear_from_srgb8(texel[1]), linear_from_srgb8(texel[2]), value.a};
    mean.texels[i] += value / static_cast<float>(kFrames);
  }
}

void display(MeanPicture& mean) {
  for (glm::vec4& texel : mean.texels) texel = glm::vec4(displayed(texel), texel.a);
}

Shot make_view(const LooksView& wanted) {
  const float distance_m = 2.0f * wanted.sphere.radius * kFocalPx / wanted.size_px;
  const glm::vec3 eye = wanted.sphere.center + glm::normalize(wanted.from) * distance_m;
  const glm::mat4 view_from_world = glm::lookAt(eye, wanted.sphere.center, glm::vec3(0, 1, 0));
  // Perspective makes the near half of a sphere larger than the sphere's middle; whole blocks.
  const auto side_px = static_cast<std::uint32_t>(std::ceil((1.15f * wanted.size_px + 8.0f) / 8.0f)) * 8;
  glm::mat4 clip_from_view = reversed_perspective(static_cast<float>(side_px), 0.01f * wanted.sphere.radius);
  if (wanted.y_up) clip_from_view[1][1] *= -1.0f;
  Shot view;
  init_shot(&view);
  std::copy_n(&view_from_world[0][0], 16, view.view_from_world);
  std::copy_n(&clip_from_view[0][0], 16, view.clip_from_view);
  view.width_px = view.height_px = side_px;
  view.lod = wanted.lod;
  view.error_px = wanted.error_px;
  const glm::vec3 sun = glm::normalize(wanted.sun);
  std::copy_n(&sun[0], 3, view.light.sun_direction);
  return view;
}

}  // namespace

LooksStage::LooksStage(const VulkanDevice& gpu, const std::filesystem::path& plant, LooksPath path) : gpu_(gpu) {
  ContextDesc desc = context_desc(gpu);
  desc.compute_raster = path == LooksPath::compute ? VK_TRUE : VK_FALSE;
  desc.shader_int64_atomics = gpu.int64_atomics ? VK_TRUE : VK_FALSE;
  // Inline: what is there in which frame does not depend on the machine.
  desc.hooks.jobs.submit = [](void*, const coppice_job* job) { job->function(job->argument); };
  desc.hooks.log.write = print_log;
  coppice_context* context = nullptr;
  check(create_context(desc, &context), "coppice_vulkan_context_create");
  context_.reset(context);
  check(create_view(context, &view_), "coppice_vulkan_view_create");
  coppice_plant handle = 0;
  check(coppice_plant_open(context, plant.c_str(), &handle), "coppice_plant_open");
  coppice_plant_info_init(&info_);
  check(coppice_plant_get_info(context, handle, &info_), "coppice_plant_get_info");
  const coppice_placement placement = placement_at();
  check(coppice_instances_add(context, handle, &placement, sizeof(coppice_placement), 1, nullptr), "coppice_instances_add");
}

LooksSphere LooksStage::sphere() const {
  return {{info_.sphere_center[0], info_.sphere_center[1], info_.sphere_center[2]}, info_.sphere_radius};
}

void LooksStage::begin_frame(const Shot& view) {
  auto frame = defaults(coppice_frame_init);
  frame.frame_number = ++frame_number_;
  frame.completed_number = frame_number_ - 1;
  coppice_camera camera = view;
  camera.view = view_;
  frame.cameras = &camera;
  frame.camera_count = 1;
  check(coppice_frame_begin(context_.get(), &frame), "coppice_frame_begin");
}

void LooksStage::settle(const Shot& view) {
  constexpr int kMaxFrames = 2000;
  constexpr int kQuietFrames = 4;  // what arrived last has been uploaded, sorted into lists and counted
  int quiet = 0;
  for (int frame = 0; frame < kMaxFrames && quiet < kQuietFrames; ++frame) {
    begin_frame(view);
    submit(gpu_, [&](VkCommandBuffer cmd) { record_cull(cmd, view); });
    std::uint32_t settled = 0;
    check(coppice_is_settled(context_.get(), view_, &settled), "coppice_is_settled");
    quiet = settled != 0 ? quiet + 1 : 0;
    if (quiet == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // reads are asynchronous
  }
  if (quiet < kQuietFrames) throw std::runtime_error("streaming does not come to rest");
}

void LooksStage::record_cull(VkCommandBuffer cmd, const Shot& view) {
  check(coppice_record_upload(context_.get(), cmd), "coppice_record_upload");
  check(coppice_record_cull(context_.get(), cmd, view_, &view.light), "coppice_record_cull");
}

Picture LooksStage::draw_frame(const Shot& view, const Attachments& attachments) {
  begin_frame(view);
  submit(gpu_, [&](VkCommandBuffer cmd) {
    record_cull(cmd, view);
    begin_rendering(cmd, attachments);
    check(coppice_record_draw(context_.get(), cmd, view_, 0), "coppice_record_draw");
    vkCmdEndRendering(cmd);
  });
  return read_picture(gpu_, *attachments.colors[0]);
}

Picture LooksStage::draw_still(const Shot& view, const VkClearColorValue& background) {
  settle(view);
  const Image color(gpu_, color_attachment(view.width_px, view.height_px)), depth(gpu_, depth_attachment(view.width_px, view.height_px));
  return draw_frame(view, {.colors = {&color}, .depth = &depth, .background = background});
}

coppice_view_stats LooksStage::stats() const {
  auto stats = defaults(coppice_view_stats_init);
  check(coppice_get_view_stats(context_.get(), view_, &stats), "coppice_get_view_stats");
  return stats;
}

MeanPicture LooksStage::draw(const LooksView& wanted) {
  const Shot view = make_view(wanted);
  settle(view);
  const Image color(gpu_, color_attachment(view.width_px, view.height_px)), depth(gpu_, depth_attachment(view.width_px, view.height_px));
  const Attachments attachments{.colors = {&color}, .depth = &depth, .background = kBackground};
  MeanPicture mean{view.width_px, view.height_px, std::vector<glm::vec4>(std::size_t{view.width_px} * view.height_px)};
  for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
    Shot moved = view;
    const auto side_px = static_cast<float>(view.width_px);
    moved.clip_from_view[8] -= 2.0f * (halton(frame + 1, 2) - 0.5f) / side_px;
    moved.clip_from_view[9] -= 2.0f * (halton(frame + 1, 3) - 0.5f) / side_px;
    moved.temporal_frame = frame + 1;
    add_to_mean(draw_frame(moved, attachments), wanted.mean_of_light, mean);
  }
  if (wanted.mean_of_light) display(mean);
  return mean;
}

}  // namespace coppice::test
