#include "temporal.h"

#include <algorithm>
#include <utility>

#include "failure.h"
#include "fullscreen_vert.h"
#include "pipelines.h"
#include "temporal_frag.h"
#include "vk_struct.h"

namespace forest {
namespace {

constexpr std::uint32_t kJitterPoints = 64;
// An exponential mean with weight 1/32 has the noise of a plain mean of 63.
constexpr float kMaxAveraged = 32;
// A moving camera's: what is looked up between pixels loses sharpness every time, so that more would show less.
constexpr float kMaxAveragedMoving = 10;
// What a picture that moved is worth once it stands still, so that what it shows wrong is soon gone.
constexpr float kWorthAfterMoving = 4;
constexpr float kSpread = 1.25f;
constexpr float kAnySpread = 1e4f;

struct Push {
  glm::mat4 before_from_clip;
  glm::vec2 moved_by, moved_by_before;
  glm::vec2 drawn_px, blends_px, past_px;
  float newest;
  float spread;
};

/// The i-th point of the van der Corput sequence, in [0, 1).
float radical_inverse(std::uint32_t i, std::uint32_t base) {
  float value = 0, digit = 1;
  for (; i > 0; i /= base) {
    digit /= static_cast<float>(base);
    value += digit * static_cast<float>(i % base);
  }
  return value;
}

void allocate_sets(Temporal& temporal) {
  constexpr std::uint32_t kSets = 2;
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 4 * kSets};
  VkDescriptorPoolCreateInfo info = vk_struct<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  info.maxSets = kSets;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  check(vkCreateDescriptorPool(temporal.device.handle, &info, nullptr, &pool), "vkCreateDescriptorPool");
  temporal.descriptor_pool = {temporal.device.handle, pool, vkDestroyDescriptorPool};
  const std::array<VkDescriptorSetLayout, kSets> layouts = {temporal.set_layout, temporal.set_layout};
  VkDescriptorSetAllocateInfo allocation = vk_struct<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  allocation.descriptorPool = pool;
  allocation.descriptorSetCount = kSets;
  allocation.pSetLayouts = layouts.data();
  check(vkAllocateDescriptorSets(temporal.device.handle, &allocation, temporal.sets.data()), "vkAllocateDescriptorSets");
}

void write_set(const Temporal& temporal, std::size_t written, const Image& toned, const Image& depth, const Image& velocity) {
  constexpr VkImageLayout kRead = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  const std::array<VkDescriptorImageInfo, 4> images = {{{temporal.texel_sampler, toned.view, kRead},
                                                        {temporal.texel_sampler, depth.view, kRead},
                                                        {temporal.sampler, temporal.history[1 - written].view, kRead},
                                                        {temporal.texel_sampler, velocity.view ? velocity.view : depth.view, kRead}}};
  VkWriteDescriptorSet write = vk_struct<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
  write.dstSet = temporal.sets[written];
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    write.dstBinding = i;
    write.pImageInfo = &images[i];
    vkUpdateDescriptorSets(temporal.device.handle, 1, &write, 0, nullptr);
  }
}

VkRenderingAttachmentInfo attachment(const Image& image) {
  VkRenderingAttachmentInfo info = vk_struct<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
  info.imageView = image.view;
  info.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
  info.loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  return info;
}

/// What the shader needs to know; the frame's place among those averaged goes on with it.
Push advance(Temporal& temporal, const TemporalView& view) {
  const bool still = view.unchanged && view.clip_from_world == temporal.clip_from_world;
  Push push{};
  push.drawn_px = size_px(view.drawn);
  push.blends_px = size_px(view.blends);
  push.past_px = size_px(std::exchange(temporal.written_to, view.blends));
  push.moved_by = 2.0f * view.jitter_px / push.drawn_px;
  push.moved_by_before = std::exchange(temporal.moved_by, push.moved_by);
  // In double precision: it is near the identity, and what it is made of is kilometres large.
  glm::dmat4 moved(1);
  moved[3][0] = static_cast<double>(push.moved_by.x);
  moved[3][1] = static_cast<double>(push.moved_by.y);
  push.before_from_clip = glm::dmat4(temporal.clip_from_world) * glm::inverse(moved * glm::dmat4(view.clip_from_world));
  if (still && temporal.moving) temporal.averaged = std::min(temporal.averaged, kWorthAfterMoving);
  temporal.moving = !still;
  temporal.averaged = std::min(temporal.averaged, (still ? kMaxAveraged : kMaxAveragedMoving) - 1);
  push.newest = 1 / (temporal.averaged + 1);
  push.spread = still ? kAnySpread : kSpread;
  ++temporal.averaged;
  ++temporal.frame;
  temporal.clip_from_world = view.clip_from_world;
  return push;
}

}  // namespace

Temporal::Temporal(const Device& device_in, VkFormat blended_format, bool velocity) : device(device_in) {
  sampler = create_sampler(device, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
  texel_sampler = create_sampler(device, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE, VK_FILTER_NEAREST);  // depth need not be filterable
  constexpr VkDescriptorType kSampled = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  set_layout = create_set_layout(device, std::array{kSampled, kSampled, kSampled, kSampled});
  pipeline_layout = create_pipeline_layout(device, set_layout, sizeof(Push), VK_SHADER_STAGE_FRAGMENT_BIT);
  allocate_sets(*this);
  PipelineDesc desc;
  desc.layout = pipeline_layout;
  desc.vertex_spirv = fullscreen_vert_spirv;
  desc.fragment_spirv = temporal_frag_spirv;
  desc.color_format = kHistoryFormat;
  desc.second_color_format = blended_format;
  constexpr std::uint32_t kEnlarges = 1, kSharp = 2, kHasVelocity = 4;  // kHow of temporal.frag
  if (!device.software) desc.fragment_constant |= kSharp;
  if (velocity) desc.fragment_constant |= kHasVelocity;
  pipeline = create_pipeline(device, desc);
  desc.fragment_constant |= kEnlarges;
  enlarging_pipeline = create_pipeline(device, desc);
}

void resize_temporal(Temporal& temporal, const Image& toned, const Image& depth, const Image& velocity) {
  ImageDesc desc;
  desc.extent = toned.extent;
  desc.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  desc.format = Temporal::kHistoryFormat;
  for (Image& image : temporal.history) image = create_image(temporal.device, desc);
  for (std::size_t i = 0; i < temporal.sets.size(); ++i) write_set(temporal, i, toned, depth, velocity);
  temporal.averaged = 0;
  submit_and_wait(temporal.device, [&](VkCommandBuffer commands) {
    for (const Image& image : temporal.history) {
      ImageBarrier barrier;
      barrier.image = image.image;
      barrier.to_stage = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
      barrier.to_access = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
      barrier.to_layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
      record_barrier(commands, barrier);
    }
  });
}

glm::vec2 temporal_jitter_px(const Temporal& temporal) {
  const std::uint32_t point = temporal.frame % kJitterPoints + 1;
  return glm::vec2(radical_inverse(point, 2), radical_inverse(point, 3)) - 0.5f;
}

void record_temporal(Temporal& temporal, VkCommandBuffer commands, const TemporalView& view, const TemporalImages& images) {
  const Push push = advance(temporal, view);
  const bool enlarges = !same_extent(view.drawn, view.blends);
  temporal.written = 1 - temporal.written;
  const Image& history = temporal.history[temporal.written];
  constexpr VkPipelineStageFlags2 kRead = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
  constexpr VkImageLayout kReadLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  for (const Image* image : {&images.toned, &images.velocity})
    if (image->image) record_barrier(commands, from_attachment(*image, kRead, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, kReadLayout));
  record_barrier(commands, from_depth_attachment(images.depth, kRead));
  record_barrier(commands, to_attachment(history, kRead));
  record_barrier(commands, to_attachment(images.blended, kRead | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT));

  const std::array attachments = {attachment(history), attachment(images.blended)};
  VkRenderingInfo info = vk_struct<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  info.renderArea = {{0, 0}, view.blends};
  info.layerCount = 1;
  info.colorAttachmentCount = static_cast<std::uint32_t>(attachments.size());
  info.pColorAttachments = attachments.data();
  vkCmdBeginRendering(commands, &info);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, enlarges ? temporal.enlarging_pipeline : temporal.pipeline);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, temporal.pipeline_layout, 0, 1, &temporal.sets[temporal.written], 0,
                          nullptr);
  vkCmdPushConstants(commands, temporal.pipeline_layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push, &push);
  record_viewport(commands, view.blends);
  vkCmdDraw(commands, 3, 1, 0, 0);
  vkCmdEndRendering(commands);
  record_barrier(commands, from_attachment(history, kRead, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, kReadLayout));
}

}  // namespace forest
