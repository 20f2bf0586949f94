#include "renderer.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "enlarge_frag.h"
#include "failure.h"
#include "fullscreen_vert.h"
#include "light_frag.h"
#include "pipelines.h"
#include "sky_frag.h"
#include "terrain_frag.h"
#include "terrain_vert.h"
#include "tone_map_frag.h"
#include "tufts.h"
#include "tufts_frag.h"
#include "tufts_vert.h"
#include "vk_struct.h"

namespace forest {
namespace {

constexpr std::uint32_t kImageCount = 14;
/// frame.glsl's: the uniforms, then images.
constexpr auto kBindingTypes = [] {
  std::array<VkDescriptorType, 1 + kImageCount> types;
  types.fill(VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER);
  types[0] = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  return types;
}();

Image upload_heights(const Device& device, const std::vector<std::uint16_t>& heights) {
  ImageDesc desc;
  desc.format = VK_FORMAT_R16_SFLOAT;
  desc.extent = {kHeightSide_px, kHeightSide_px};
  return create_texture(device, desc, std::as_bytes(std::span(heights)), sizeof heights.front());
}

Image upload(const Device& device, const Texture& texture) {
  ImageDesc desc;
  desc.format = VK_FORMAT_R8G8B8A8_UNORM;
  desc.extent = {texture.side_px, texture.side_px};
  desc.mip_count = texture.mip_count;
  return create_texture(device, desc, texture.texels, 4);
}

void allocate_sets(Renderer& renderer) {
  constexpr auto kSets = static_cast<std::uint32_t>(FrameRing::kSlots * kMaxPanes);
  const std::array<VkDescriptorPoolSize, 2> sizes = {
      {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, kSets}, {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kImageCount * kSets}}};
  VkDescriptorPoolCreateInfo info = vk_struct<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  info.maxSets = kSets;
  info.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  info.pPoolSizes = sizes.data();
  VkDescriptorPool pool = VK_NULL_HANDLE;
  check(vkCreateDescriptorPool(renderer.device.handle, &info, nullptr, &pool), "vkCreateDescriptorPool");
  renderer.descriptor_pool = {renderer.device.handle, pool, vkDestroyDescriptorPool};
  std::array<VkDescriptorSetLayout, kSets> layouts;
  layouts.fill(renderer.set_layout);
  VkDescriptorSetAllocateInfo allocation = vk_struct<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  allocation.descriptorPool = pool;
  allocation.descriptorSetCount = kSets;
  allocation.pSetLayouts = layouts.data();
  std::array<VkDescriptorSet, kSets> sets{};
  check(vkAllocateDescriptorSets(renderer.device.handle, &allocation, sets.data()), "vkAllocateDescriptorSets");
  auto next = sets.begin();
  for (auto& panes : renderer.panes)
    for (Renderer::PaneSet& pane : panes) pane.set = *next++;
}

void write_set(const Renderer& renderer, const Renderer::PaneSet& pane) {
  const VkDescriptorBufferInfo buffer{pane.uniforms.buffer, 0, sizeof(FrameUniforms)};
  constexpr VkImageLayout kRead = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  // What is not there has a binding all the same, which no shader reads.
  const auto image = [&](const Handle<VkSampler>& sampler, const Image& of) {
    return VkDescriptorImageInfo{sampler, of.view ? of.view : renderer.ground_map_image.view, kRead};
  };
  const auto map = [&](std::size_t index) {
    const bool there = renderer.shadows && index < renderer.shadows->cascades.size();
    return image(renderer.map_sampler, there ? renderer.shadows->cascades[index].map : renderer.ground_map_image);
  };
  const std::array<VkDescriptorImageInfo, kImageCount> images = {image(renderer.clamp_sampler, renderer.ground_map_image),
                                                                 image(renderer.repeat_sampler, renderer.ground_detail_image),
                                                                 image(renderer.clamp_sampler, renderer.scene),
                                                                 map(0),
                                                                 map(1),
                                                                 map(2),
                                                                 image(renderer.clamp_sampler, renderer.blended),
                                                                 map(Shadows::kSkyMap),
                                                                 image(renderer.map_sampler, renderer.albedo),
                                                                 image(renderer.map_sampler, renderer.normal),
                                                                 image(renderer.map_sampler, renderer.light),
                                                                 image(renderer.map_sampler, renderer.depth),
                                                                 image(renderer.clamp_sampler, renderer.ground_height_image),
                                                                 image(renderer.repeat_sampler, renderer.ground_litter_image)};
  std::array<VkWriteDescriptorSet, kBindingTypes.size()> writes{};
  for (std::uint32_t i = 0; i < writes.size(); ++i) {
    writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    writes[i].dstSet = pane.set;
    writes[i].dstBinding = i;
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = kBindingTypes[i];
    writes[i].pBufferInfo = i == 0 ? &buffer : nullptr;
    writes[i].pImageInfo = i == 0 ? nullptr : &images[i - 1];
  }
  vkUpdateDescriptorSets(renderer.device.handle, static_cast<std::uint32_t>(writes.size()), writes.data(), 0, nullptr);
}

void write_sets(const Renderer& renderer) {
  for (const auto& panes : renderer.panes)
    for (const Renderer::PaneSet& pane : panes) write_set(renderer, pane);
}

/// Makes the pipeline of a draw to the scene.
PipelineDesc scene_desc(const Renderer& renderer) {
  constexpr std::uint32_t kHasSkyMap = 4, kIsDeferred = 8;
  PipelineDesc desc;
  desc.layout = renderer.pipeline_layout;
  desc.color_format = Renderer::kSceneFormat;
  if (renderer.targets.velocity) desc.second_color_format = Renderer::kVelocityFormat;
  desc.depth_format = Renderer::kDepthFormat;
  // kHas of frame.glsl.
  if (renderer.shadows) desc.fragment_constant = renderer.device.software ? 1 : 2;
  if (renderer.shadows && renderer.shadows->cascades.size() > Shadows::kSkyMap) desc.fragment_constant |= kHasSkyMap;
  if (renderer.targets.deferred) desc.fragment_constant |= kIsDeferred;
  return desc;
}

/// What knows of shadow maps.
void create_lit_pipelines(Renderer& renderer) {
  PipelineDesc desc = scene_desc(renderer);
  if (renderer.targets.deferred) {
    desc.vertex_spirv = fullscreen_vert_spirv;
    desc.fragment_spirv = light_frag_spirv;
    desc.depth_format = desc.second_color_format = VK_FORMAT_UNDEFINED;
    renderer.light_pipeline = create_pipeline(renderer.device, desc);
    desc = scene_desc(renderer);
  }
  const VkVertexInputBindingDescription vertex{0, sizeof(TerrainVertex), VK_VERTEX_INPUT_RATE_VERTEX};
  const std::array<VkVertexInputAttributeDescription, 3> vertex_attributes = {
      {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(TerrainVertex, position)},
       {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(TerrainVertex, normal)},
       {2, 0, VK_FORMAT_R32_SFLOAT, offsetof(TerrainVertex, foot)}}};
  desc.vertex_spirv = terrain_vert_spirv;
  desc.fragment_spirv = terrain_frag_spirv;
  desc.bindings = {&vertex, 1};
  desc.attributes = vertex_attributes;
  renderer.ground_pipeline = create_pipeline(renderer.device, desc);

  const VkVertexInputBindingDescription instance{0, sizeof(Tuft), VK_VERTEX_INPUT_RATE_INSTANCE};
  const std::array<VkVertexInputAttributeDescription, 2> instance_attributes = {
      {{0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Tuft, root)}, {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Tuft, yaw_rad)}}};
  desc.vertex_spirv = tufts_vert_spirv;
  desc.fragment_spirv = tufts_frag_spirv;
  desc.bindings = {&instance, 1};
  desc.attributes = instance_attributes;
  renderer.tuft_pipeline = create_pipeline(renderer.device, desc);
}

void create_screen_pipelines(Renderer& renderer) {
  PipelineDesc desc = scene_desc(renderer);
  desc.vertex_spirv = fullscreen_vert_spirv;
  desc.fragment_spirv = sky_frag_spirv;
  desc.depth_write = false;
  renderer.sky_pipeline = create_pipeline(renderer.device, desc);
  desc.fragment_spirv = tone_map_frag_spirv;
  desc.color_format = Renderer::kPictureFormat;
  desc.second_color_format = desc.depth_format = VK_FORMAT_UNDEFINED;
  renderer.tone_map_pipeline = create_pipeline(renderer.device, desc);
  desc.fragment_spirv = enlarge_frag_spirv;
  renderer.enlarge_pipeline = create_pipeline(renderer.device, desc);
}

FrameUniforms uniforms_of(const Renderer& renderer, std::size_t pane, const FrameView& view) {
  FrameUniforms uniforms;
  uniforms.clip_from_world = view.clip_from_view * view.view_from_world;
  uniforms.world_from_clip = glm::inverse(uniforms.clip_from_world);
  uniforms.clip_from_world_before = renderer.clip_from_world_before[pane];
  uniforms.eye = {view.eye, view.time_s};
  uniforms.sun_direction = {renderer.weather.sun_direction, renderer.time_before_s};
  uniforms.sun_color = {renderer.weather.sun_color, view.debug_view ? 1 : 0};
  uniforms.sky_color = {renderer.weather.sky_color, static_cast<float>(view.temporal_frame % 64)};
  uniforms.ground_color = {renderer.weather.ground_color, renderer.ground_map.among_others ? 1 : 0};
  uniforms.fog = {renderer.weather.fog_color, renderer.weather.fog_density};
  for (std::size_t i = 0; renderer.shadows && i < Shadows::kCascades; ++i)
    uniforms.shadows[i] = renderer.shadows->cascades[i].clip_from_world;
  if (renderer.shadows) uniforms.sky_map = renderer.shadows->cascades.back().clip_from_world;
  uniforms.ground = {renderer.ground_map.extent_m, renderer.weather.exposure, size_px(renderer.blends)};
  uniforms.leaf_color = {renderer.weather.leaf_color, 0};
  uniforms.drawn_px = {size_px(view.pane.extent), 0, 0};
  std::ranges::copy(view.gusts, uniforms.gusts);
  std::ranges::copy(renderer.gusts_before, uniforms.gusts_before);
  return uniforms;
}

void write_uniforms(Renderer& renderer, std::size_t slot, std::span<const FrameView> views) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    const FrameUniforms uniforms = uniforms_of(renderer, i, views[i]);
    std::memcpy(renderer.panes[slot][i].uniforms.mapped, &uniforms, sizeof uniforms);
    renderer.clip_from_world_before[i] = uniforms.clip_from_world;
  }
  renderer.time_before_s = views.front().time_s;
  renderer.gusts_before = views.front().gusts;
}

/// What was drawn to them is kept, or dropped: depth is then 0, reversed depth's farthest.
void begin_pass(VkCommandBuffer commands, VkExtent2D extent, std::span<const Image* const> colors, const Image* depth, bool keep) {
  constexpr std::size_t kMaxColors = 4;
  std::array<VkRenderingAttachmentInfo, kMaxColors + 1> attachments{};
  const auto attach = [&](VkRenderingAttachmentInfo& info, const Image& image, VkAttachmentLoadOp dropped) {
    info = vk_struct<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
    info.imageView = image.view;
    info.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
    info.loadOp = keep ? VK_ATTACHMENT_LOAD_OP_LOAD : dropped;
    info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  };
  for (std::size_t i = 0; i < colors.size(); ++i) attach(attachments[i], *colors[i], VK_ATTACHMENT_LOAD_OP_DONT_CARE);
  if (depth) attach(attachments[kMaxColors], *depth, VK_ATTACHMENT_LOAD_OP_CLEAR);
  VkRenderingInfo info = vk_struct<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  info.renderArea = {{0, 0}, extent};
  info.layerCount = 1;
  info.colorAttachmentCount = static_cast<std::uint32_t>(colors.size());
  info.pColorAttachments = attachments.data();
  info.pDepthAttachment = depth ? &attachments[kMaxColors] : nullptr;
  vkCmdBeginRendering(commands, &info);
}

using Images = std::vector<const Image*>;
Images scene_images(const Renderer& renderer) {
  Images images = {&renderer.scene};
  if (renderer.targets.velocity) images.push_back(&renderer.velocity);
  return images;
}
Images plant_images(const Renderer& renderer) {
  Images images = scene_images(renderer);
  if (!renderer.targets.deferred) return images;
  images.front() = &renderer.light;
  images.insert(images.begin(), {&renderer.albedo, &renderer.normal});
  return images;
}

void bind(const Renderer& renderer, VkCommandBuffer commands, const Renderer::PaneSet& pane, VkPipeline pipeline) {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, renderer.pipeline_layout, 0, 1, &pane.set, 0, nullptr);
}

/// After the ground, by its pipeline.
void record_mounds(const Renderer& renderer, VkCommandBuffer commands, const Renderer::PaneSet& pane, const glm::mat4& clip_from_world,
                   glm::vec3 eye) {
  std::vector<TerrainVertex> vertices(kMaxMounds * kMoundVertices);
  const std::size_t count = gather_mounds(renderer.terrain, renderer.ground_map.feet, clip_from_world, eye, vertices);
  std::memcpy(pane.mounds.mapped, vertices.data(), count * kMoundVertices * sizeof(TerrainVertex));
  if (count == 0) return;
  const VkDeviceSize offset = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, pane.mounds.buffer.address(), &offset);
  vkCmdBindIndexBuffer(commands, renderer.mound_indices.buffer, 0, VK_INDEX_TYPE_UINT32);
  vkCmdDrawIndexed(commands, static_cast<std::uint32_t>(count) * kMoundIndices, 1, 0, 0, 0);
}

void record_ground(const Renderer& renderer, VkCommandBuffer commands, const Renderer::PaneSet& pane, const glm::mat4& clip_from_world) {
  bind(renderer, commands, pane, renderer.ground_pipeline);
  const VkDeviceSize offset = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, renderer.ground_vertices.buffer.address(), &offset);
  vkCmdBindIndexBuffer(commands, renderer.ground_indices.buffer, 0, VK_INDEX_TYPE_UINT32);
  for (const TerrainChunk& chunk : renderer.terrain.chunks)
    if (box_in_view(clip_from_world, chunk.box_min, chunk.box_max))
      vkCmdDrawIndexed(commands, chunk.index_count, 1, chunk.first_index, 0, 0);
}

void record_tufts(const Renderer& renderer, VkCommandBuffer commands, const Renderer::PaneSet& pane, const glm::mat4& clip_from_world,
                  glm::vec3 eye) {
  std::vector<Tuft> tufts(kMaxTufts);
  const std::size_t count = gather_tufts(renderer.terrain, renderer.ground_map, clip_from_world, eye, tufts);
  std::memcpy(pane.tufts.mapped, tufts.data(), count * sizeof(Tuft));
  if (count == 0) return;
  bind(renderer, commands, pane, renderer.tuft_pipeline);
  const VkDeviceSize offset = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, pane.tufts.buffer.address(), &offset);
  vkCmdDraw(commands, kTuftVertices, static_cast<std::uint32_t>(count), 0, 0);
}

void record_over_picture(const Renderer& renderer, VkCommandBuffer commands, const std::function<void()>& draw) {
  ImageBarrier barrier = to_attachment(renderer.picture, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT);
  barrier.from_access = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
  barrier.from_layout = barrier.to_layout;
  record_barrier(commands, barrier);
  begin_pass(commands, renderer.picture.extent, Images{&renderer.picture}, nullptr, true);
  draw();
  vkCmdEndRendering(commands);
}

void record_screen_pass(const Renderer& renderer, VkCommandBuffer commands, std::size_t slot, VkPipeline pipeline, const Image& target,
                        VkExtent2D extent) {
  begin_pass(commands, extent, Images{&target}, nullptr, false);
  bind(renderer, commands, renderer.panes[slot][0], pipeline);
  record_viewport(commands, extent);
  vkCmdDraw(commands, 3, 1, 0, 0);
  vkCmdEndRendering(commands);
}

void record_enlarge(const Renderer& renderer, VkCommandBuffer commands, std::size_t slot) {
  record_barrier(commands, from_attachment(renderer.blended, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                                           VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL));
  record_barrier(commands, to_attachment(renderer.picture, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT));
  record_screen_pass(renderer, commands, slot, renderer.enlarge_pipeline, renderer.picture, renderer.picture.extent);
}

}  // namespace

Renderer::Renderer(const Device& device_in, const Terrain& terrain_in, const GroundMap& ground_map_in, const Weather& weather_in,
                   PlantTargets targets_in, VkExtent2D extent)
    : device(device_in), terrain(terrain_in), ground_map(ground_map_in), weather(weather_in), targets(targets_in) {
  ground_vertices = create_device_buffer(device, std::as_bytes(std::span(terrain.vertices)), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  ground_indices = create_device_buffer(device, std::as_bytes(std::span(terrain.indices)), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  ground_map_image = upload(device, ground_map.texture);
  ground_detail_image = upload(device, make_ground_detail(1));
  ground_litter_image = upload(device, make_litter(1));
  ground_height_image = upload_heights(device, make_height_map(terrain, ground_map.extent_m));
  const std::vector<std::uint32_t> triangles = forest::mound_indices();
  mound_indices = create_device_buffer(device, std::as_bytes(std::span(triangles)), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  for (auto& of_slot : panes)
    for (PaneSet& pane : of_slot) {
      pane.uniforms = create_host_buffer(device, sizeof(FrameUniforms), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
      pane.tufts = create_host_buffer(device, kMaxTufts * sizeof(Tuft), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
      pane.mounds = create_host_buffer(device, kMaxMounds * kMoundVertices * sizeof(TerrainVertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    }
  repeat_sampler = create_sampler(device, VK_SAMPLER_ADDRESS_MODE_REPEAT);
  clamp_sampler = create_sampler(device, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
  map_sampler = create_sampler(device, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE, VK_FILTER_NEAREST);
  set_layout = create_set_layout(device, kBindingTypes);
  pipeline_layout = create_pipeline_layout(device, set_layout, 0);
  allocate_sets(*this);
  create_lit_pipelines(*this);
  create_screen_pipelines(*this);
  resize_renderer(*this, extent);
}

void resize_renderer(Renderer& renderer, VkExtent2D extent) {
  ImageDesc desc;
  desc.extent = extent;
  desc.format = Renderer::kSceneFormat;
  desc.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  renderer.scene = create_image(renderer.device, desc);
  const auto create = [&](Image& image, VkFormat format) {
    desc.format = format;
    image = create_image(renderer.device, desc);
  };
  if (renderer.targets.velocity) create(renderer.velocity, Renderer::kVelocityFormat);
  if (renderer.targets.deferred) {
    create(renderer.albedo, Renderer::kAlbedoFormat);
    create(renderer.normal, Renderer::kNormalFormat);
    create(renderer.light, Renderer::kLightFormat);
  }
  desc.format = Renderer::kDepthFormat;
  desc.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  renderer.depth = create_image(renderer.device, desc);
  desc.format = Renderer::kPictureFormat;
  desc.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  renderer.picture = create_image(renderer.device, desc);
  desc.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  renderer.toned = create_image(renderer.device, desc);
  renderer.blended = create_image(renderer.device, desc);
  renderer.drawn = renderer.blends = extent;
  write_sets(renderer);
  if (renderer.temporal) resize_temporal(*renderer.temporal, renderer.toned, renderer.depth, renderer.velocity);
}

void set_scale(Renderer& renderer, float scale) {
  constexpr float kFewSamples = 0.4f;
  const auto scaled = [&](float share) {
    const glm::uvec2 px = glm::max(glm::round(share * size_px(renderer.picture.extent)), 1.0f);
    return VkExtent2D{px.x, px.y};
  };
  renderer.drawn = scaled(scale);
  // Blending costs the same whatever is drawn, and few samples fill few pixels.
  renderer.blends = !renderer.temporal ? renderer.drawn : scaled(scale <= kFewSamples ? 0.5f : 1.0f);
}

void set_temporal(Renderer& renderer, bool on) {
  if (on == (renderer.temporal != nullptr)) return;
  renderer.temporal = on ? std::make_unique<Temporal>(renderer.device, Renderer::kPictureFormat, renderer.targets.velocity) : nullptr;
  if (on) resize_temporal(*renderer.temporal, renderer.toned, renderer.depth, renderer.velocity);
}

void set_shadows(Renderer& renderer, std::uint32_t size_px) {
  renderer.shadows = size_px > 0 ? std::make_unique<Shadows>(renderer.device, size_px, renderer.targets.deferred) : nullptr;
  create_lit_pipelines(renderer);
  write_sets(renderer);
}

namespace {

/// Ends the pass that plants' surfaces are drawn in, lights them, and begins the pass of all else.
void record_light(const Renderer& renderer, VkCommandBuffer commands, const std::function<void()>& draw_light) {
  vkCmdEndRendering(commands);
  for (const Image* image : {&renderer.albedo, &renderer.normal, &renderer.light})
    record_barrier(commands, from_attachment(*image, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                                             VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL));
  const ImageBarrier sampled = from_depth_attachment(renderer.depth, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT);
  record_barrier(commands, sampled);
  begin_pass(commands, renderer.drawn, Images{&renderer.scene}, nullptr, false);
  draw_light();
  vkCmdEndRendering(commands);
  for (const Image* image : scene_images(renderer)) {
    ImageBarrier kept = to_attachment(*image, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT);
    kept.from_access = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
    kept.from_layout = kept.to_layout;
    record_barrier(commands, kept);
  }
  ImageBarrier depth = to_depth_attachment(renderer.depth, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT);
  depth.from_layout = sampled.to_layout;
  record_barrier(commands, depth);
  begin_pass(commands, renderer.drawn, scene_images(renderer), &renderer.depth, true);
}

}  // namespace

void record_scene(Renderer& renderer, VkCommandBuffer commands, std::size_t slot, std::span<const FrameView> views,
                  const std::function<void()>& draw_plants) {
  for (const Image* image : plant_images(renderer))
    record_barrier(commands, to_attachment(*image, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT));
  if (renderer.targets.deferred) record_barrier(commands, to_attachment(renderer.scene, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT));
  ImageBarrier depth =
      to_depth_attachment(renderer.depth, VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT |
                                              VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT);
  depth.from_access = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;  // the last frame's, where nothing has sampled it since
  record_barrier(commands, depth);

  start_plants(renderer.timer.get(), commands, slot);
  const auto stamp = [&](ScenePass pass) { stamp_pass(renderer.timer.get(), commands, slot, pass); };
  const auto for_each_pane = [&](const auto& record) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      record_viewport(commands, views[i].pane.extent, views[i].pane.offset);
      record(renderer.panes[slot][i], views[i], views[i].clip_from_view * views[i].view_from_world);
    }
  };
  write_uniforms(renderer, slot, views);
  begin_pass(commands, renderer.drawn, plant_images(renderer), &renderer.depth, false);
  draw_plants();
  stamp(ScenePass::plants);
  if (renderer.targets.deferred)
    record_light(renderer, commands, [&] {
      for_each_pane([&](const Renderer::PaneSet& pane, const FrameView&, const glm::mat4&) {
        bind(renderer, commands, pane, renderer.light_pipeline);
        vkCmdDraw(commands, 3, 1, 0, 0);
      });
    });
  stamp(ScenePass::light);
  for_each_pane([&](const Renderer::PaneSet& pane, const FrameView& view, const glm::mat4& clip_from_world) {
    record_ground(renderer, commands, pane, clip_from_world);
    record_mounds(renderer, commands, pane, clip_from_world, view.eye);
  });
  stamp(ScenePass::ground);
  for_each_pane([&](const Renderer::PaneSet& pane, const FrameView& view, const glm::mat4& clip_from_world) {
    record_tufts(renderer, commands, pane, clip_from_world, view.eye);
  });
  stamp(ScenePass::tufts);
  for_each_pane([&](const Renderer::PaneSet& pane, const FrameView&, const glm::mat4&) {
    bind(renderer, commands, pane, renderer.sky_pipeline);
    vkCmdDraw(commands, 3, 1, 0, 0);
  });
  vkCmdEndRendering(commands);
  stamp(ScenePass::sky);
}

void record_tone_map(Renderer& renderer, VkCommandBuffer commands, std::size_t slot, const FrameView& view,
                     const std::function<void()>& draw_overlay) {
  record_barrier(commands, from_attachment(renderer.scene, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                                           VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL));
  const bool enlarges = !same_extent(renderer.blends, renderer.picture.extent);
  const Image& blended = enlarges ? renderer.blended : renderer.picture;
  const Image& toned = renderer.temporal ? renderer.toned : blended;
  record_barrier(commands, to_attachment(toned, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT));
  record_screen_pass(renderer, commands, slot, renderer.tone_map_pipeline, toned, renderer.drawn);
  stamp_pass(renderer.timer.get(), commands, slot, ScenePass::tone_map);
  if (renderer.temporal) {
    const TemporalView temporal_view{view.unmoved_clip_from_world, view.jitter_px, renderer.drawn, renderer.blends, view.unchanged};
    record_temporal(*renderer.temporal, commands, temporal_view,
                    {.toned = toned, .depth = renderer.depth, .velocity = renderer.velocity, .blended = blended});
  }
  if (enlarges) record_enlarge(renderer, commands, slot);
  if (draw_overlay) record_over_picture(renderer, commands, draw_overlay);
  stamp_pass(renderer.timer.get(), commands, slot, ScenePass::temporal);
  record_barrier(commands, from_attachment(renderer.picture, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                                           VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL));
}

std::vector<std::uint8_t> read_picture(const Renderer& renderer) {
  const VkExtent2D extent = renderer.picture.extent;
  const std::size_t bytes = std::size_t{extent.width} * extent.height * 4;
  const Buffer buffer = create_host_buffer(renderer.device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  submit_and_wait(renderer.device, [&](VkCommandBuffer commands) {
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {extent.width, extent.height, 1};
    vkCmdCopyImageToBuffer(commands, renderer.picture.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer.buffer, 1, &region);
    record_to_host(commands);
  });
  std::vector<std::uint8_t> pixels(bytes);
  std::memcpy(pixels.data(), buffer.mapped, bytes);
  return pixels;
}

}  // namespace forest
