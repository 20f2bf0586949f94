#include "stage.h"

#include <algorithm>
#include <cstring>

#include "context_desc.h"
#include "failure.h"
#include "trial.h"
#include "vk_struct.h"

namespace forest {
namespace {

constexpr VkExtent2D kExtent = {kPictureSide_px, kPictureSide_px};
constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

struct Content {
  coppice_content content;
  VkFormat format;
};

std::vector<Content> contents_of(coppice_output output) {
  if (output == COPPICE_OUTPUT_LIT) return {{COPPICE_CONTENT_LIT, VK_FORMAT_R8G8B8A8_UNORM}};
  if (output == COPPICE_OUTPUT_DEPTH) return {};
  return {{COPPICE_CONTENT_ALBEDO, VK_FORMAT_R8G8B8A8_UNORM},
          {COPPICE_CONTENT_NORMAL, VK_FORMAT_R8G8B8A8_UNORM},
          {COPPICE_CONTENT_LIGHT, VK_FORMAT_R8G8B8A8_UNORM},
          {COPPICE_CONTENT_VELOCITY, VK_FORMAT_R16G16B16A16_SFLOAT}};
}

void note(void* user, coppice_log_level level, const char* text) {
  auto& notes = *static_cast<Notes*>(user);
  const std::lock_guard lock(notes.mutex);
  if (level == COPPICE_LOG_ERROR) notes.errors.emplace_back(text);
  if (level == COPPICE_LOG_WARNING) notes.warnings.emplace_back(text);
}

coppice_context* create_context(const Device& device, Notes& notes, bool compute) {
  coppice_log log;
  coppice_log_init(&log);
  log.user = &notes;
  log.write = note;
  coppice_context_desc desc;
  coppice_context_desc_init(&desc);
  desc.log = &log;
  coppice_vulkan_desc vulkan = desc_of(device);
  vulkan.compute_raster = compute ? VK_TRUE : VK_FALSE;
  vulkan.blocking_pipelines = VK_TRUE;
  coppice_context* context = nullptr;
  check(nullptr, coppice_vulkan_context_create(&desc, &vulkan, &context), "coppice_vulkan_context_create");
  return context;
}

coppice_view create_view(const Stage& stage) {
  coppice_view_desc desc;
  coppice_view_desc_init(&desc);
  desc.output = stage.output;
  coppice_vulkan_view_desc formats;
  coppice_vulkan_view_desc_init(&formats);
  std::size_t count = 0;
  for (const Content& content : contents_of(stage.output)) {
    formats.contents[count] = content.content;
    formats.color_formats[count++] = content.format;
  }
  formats.depth_format = kDepthFormat;
  coppice_view view = 0;
  check(stage.context.get(), coppice_vulkan_view_create(stage.context.get(), &desc, &formats, &view), "coppice_vulkan_view_create");
  return view;
}

VkRenderingAttachmentInfo attachment(const Image& image) {
  VkRenderingAttachmentInfo info = vk_struct<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
  info.imageView = image.view;
  info.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
  info.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;  // to 0: nothing, far away
  info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  return info;
}

void record_draw(Stage& stage, VkCommandBuffer commands) {
  std::vector<VkRenderingAttachmentInfo> colors;
  for (const Image& color : stage.colors) {
    record_barrier(commands, to_attachment(color, VK_PIPELINE_STAGE_2_NONE));
    colors.push_back(attachment(color));
  }
  record_barrier(commands, to_depth_attachment(stage.depth, VK_PIPELINE_STAGE_2_NONE));
  const VkRenderingAttachmentInfo depth = attachment(stage.depth);
  VkRenderingInfo info = vk_struct<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  info.renderArea.extent = kExtent;
  info.layerCount = 1;
  info.colorAttachmentCount = static_cast<std::uint32_t>(colors.size());
  info.pColorAttachments = colors.data();
  info.pDepthAttachment = &depth;
  vkCmdBeginRendering(commands, &info);
  check(stage.context.get(), coppice_record_draw(stage.context.get(), commands, stage.camera.view, 0), "coppice_record_draw");
  vkCmdEndRendering(commands);
}

/// The whole image, 4 bytes a pixel.
std::vector<std::uint32_t> read_image(const Stage& stage, const Image& image, VkImageAspectFlags aspect) {
  std::vector<std::uint32_t> pixels(std::size_t{kPictureSide_px} * kPictureSide_px);
  const Buffer buffer = create_host_buffer(stage.device, pixels.size() * sizeof pixels[0], VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  submit_and_wait(stage.device, [&](VkCommandBuffer commands) {
    // The frame has been waited for.
    ImageBarrier barrier;
    barrier.image = image.image;
    barrier.aspect = aspect;
    barrier.from_layout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
    barrier.to_stage = VK_PIPELINE_STAGE_2_COPY_BIT;
    barrier.to_access = VK_ACCESS_2_TRANSFER_READ_BIT;
    barrier.to_layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    record_barrier(commands, barrier);
    VkBufferImageCopy region{};
    region.imageSubresource = {aspect, 0, 0, 1};
    region.imageExtent = {kPictureSide_px, kPictureSide_px, 1};
    vkCmdCopyImageToBuffer(commands, image.image, barrier.to_layout, buffer.buffer, 1, &region);
    record_to_host(commands);
    std::swap(barrier.from_layout, barrier.to_layout);
    barrier.from_stage = VK_PIPELINE_STAGE_2_COPY_BIT;
    barrier.from_access = VK_ACCESS_2_NONE;
    record_barrier(commands, barrier);
  });
  std::memcpy(pixels.data(), buffer.mapped, buffer.bytes);
  return pixels;
}

}  // namespace

Stage::Stage(const Device& device_in, const Stand& stand, const StageDesc& desc)
    : device(device_in), camera(stand.camera), output(desc.output) {
  at("creating the context");
  context.reset(create_context(device, notes, desc.compute));
  at("creating the view");
  camera.view = create_view(*this);
  coppice_plant plant = 0;
  at("opening the plant");
  check(context.get(), coppice_plant_open_memory(context.get(), hazel().data, hazel().size, "hazel", &plant), "coppice_plant_open_memory");
  check(context.get(),
        coppice_instances_add(context.get(), plant, stand.plants.data(), sizeof(coppice_placement),
                              static_cast<std::uint32_t>(stand.plants.size()), nullptr),
        "coppice_instances_add");
  for (const Content& content : contents_of(output))
    colors.push_back(
        create_image(device, {content.format, kExtent, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT}));
  depth = create_image(device, {kDepthFormat, kExtent, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
}

void draw_frame(Stage& stage, Until until) {
  coppice_context* context = stage.context.get();
  coppice_frame frame;
  coppice_frame_init(&frame);
  frame.frame_number = ++stage.frame;
  frame.completed_number = stage.frame - 1;
  frame.cameras = &stage.camera;
  frame.camera_count = 1;
  check(context, coppice_frame_begin(context, &frame), "coppice_frame_begin");
  const std::string name = "frame " + std::to_string(stage.frame);
  submit_and_wait(stage.device, [&](VkCommandBuffer commands) {
    at("recording " + name + " and building its pipelines");
    check(context, coppice_record_upload(context, commands), "coppice_record_upload");
    if (until != Until::uploaded) check(context, coppice_record_cull(context, commands, stage.camera.view, nullptr), "coppice_record_cull");
    if (until == Until::drawn) record_draw(stage, commands);
    at("waiting for the GPU's " + name);
  });
}

void draw_until_settled(Stage& stage, Until until) {
  coppice_view_stats stats;
  coppice_view_stats_init(&stats);
  // What hides plants is known from the frames before: a few more.
  constexpr int kQuietFrames = 4;
  for (int quiet = 0; quiet < kQuietFrames;) {
    draw_frame(stage, until);
    std::uint32_t settled = COPPICE_FALSE;
    check(stage.context.get(), coppice_is_settled(stage.context.get(), stage.camera.view, &settled), "coppice_is_settled");
    check(stage.context.get(), coppice_get_view_stats(stage.context.get(), stage.camera.view, &stats), "coppice_get_view_stats");
    quiet = settled && (until == Until::uploaded || stats.gpu_frame_number > 0) ? quiet + 1 : 0;
  }
}

Picture read_picture(const Stage& stage) {
  Picture picture;
  const std::vector<std::uint32_t> depth = read_image(stage, stage.depth, VK_IMAGE_ASPECT_DEPTH_BIT);
  std::memcpy(picture.depth.data(), depth.data(), depth.size() * sizeof depth[0]);
  if (stage.colors.empty()) return picture;
  const std::vector<std::uint32_t> colors = read_image(stage, stage.colors[0], VK_IMAGE_ASPECT_COLOR_BIT);
  std::ranges::transform(colors, picture.color.begin(),
                         [](std::uint32_t rgba) { return glm::vec3(rgba & 0xff, rgba >> 8 & 0xff, rgba >> 16 & 0xff) / 255.0f; });
  return picture;
}

}  // namespace forest
