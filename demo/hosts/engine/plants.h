#pragma once
// What an engine adds for Coppice: its allocator, jobs and files as hooks, a context, views with a G-buffer or a shadow map, and light.
#include <cmath>
#include <glm/glm.hpp>

#include "engine.h"
#include "light_comp.h"

namespace engine {

inline void check(coppice_status status, const char* call) {
  if (status != COPPICE_OK) throw std::runtime_error(std::string(call) + ": " + coppice_status_text(status));
}

/// A struct of Coppice with its defaults: made(coppice_view_desc_init).
template <class Struct>
Struct made(void (*init)(Struct*)) {
  Struct result;
  init(&result);
  return result;
}

inline coppice_io io_hook(Archive& archive) {
  auto hook = made(coppice_io_init);
  hook.user = &archive;
  hook.open = [](void* user, const char* path, std::uint64_t* bytes) -> std::int64_t {
    const Archive& from = *static_cast<Archive*>(user);
    const auto asset = std::size_t(std::find(from.names.begin(), from.names.end(), path) - from.names.begin());
    if (asset == from.names.size()) return -ENOENT;
    *bytes = from.begins[asset + 1] - from.begins[asset];
    return std::int64_t(asset);
  };
  hook.close = [](void*, std::int64_t) {};
  hook.read = [](void* user, std::int64_t asset, std::uint64_t offset, void* destination, std::size_t bytes,
                 void (*done)(void*, std::int64_t), void* argument) {
    auto& from = *static_cast<Archive*>(user);
    from.reader.submit([=, &from] {
      const std::uint64_t begin = from.begins[std::size_t(asset)] + offset, end = from.begins[std::size_t(asset) + 1];
      const std::size_t there = std::min(bytes, end - std::min(begin, end));  // what follows is another asset's
      const ssize_t count = pread(fileno(from.file.get()), destination, there, off_t(begin));
      done(argument, count < 0 ? -errno : count);
    });
  };
  return hook;
}

using Context = std::unique_ptr<coppice_context, std::function<void(coppice_context*)>>;
/// With a JobPool without threads every call does the same in every run.
inline Context create_context(Gpu& gpu, JobPool& pool, Archive& archive) {
  auto desc = made(coppice_context_desc_init);
  auto vulkan = made(coppice_vulkan_desc_init);
  auto log = made(coppice_log_init);
  log.write = [](void*, coppice_log_level, const char* line) { std::fprintf(stderr, "%s\n", line); };
  auto jobs = made(coppice_jobs_init);
  jobs.user = &pool;
  jobs.submit = [](void* user, const coppice_job* job) {
    static_cast<JobPool*>(user)->submit([function = job->function, argument = job->argument] { function(argument); });
  };
  const coppice_io io = io_hook(archive);
  auto memory = made(coppice_device_memory_init);
  memory.user = &gpu.memory;
  memory.allocate = [](void* user, const VkMemoryRequirements* needs, VkMemoryPropertyFlags properties, coppice_memory_block* block) {
    try {
      allocate(*static_cast<DeviceMemory*>(user), *needs, vk::MemoryPropertyFlags(properties), *block);
      return VK_SUCCESS;
    } catch (const vk::SystemError& error) {
      return VkResult(error.code().value());
    }
  };
  memory.free = [](void* user, const coppice_memory_block* block) { release(*static_cast<DeviceMemory*>(user), *block); };
  desc.log = &log;
  desc.jobs = &jobs;
  desc.io = &io;
  if (pool.threads.empty()) desc.streaming_ms = INFINITY;
  const auto& features = gpu.features.get<vk::PhysicalDeviceFeatures2>().features;
  const auto& features12 = gpu.features.get<vk::PhysicalDeviceVulkan12Features>();
  vulkan.instance = *gpu.instance;
  vulkan.physical_device = *gpu.physical;
  vulkan.device = *gpu.device;
  vulkan.get_instance_proc_addr = gpu.instance.getDispatcher()->vkGetInstanceProcAddr;
  vulkan.device_memory = &memory;
  vulkan.texture_compression_bc = features.textureCompressionBC;
  vulkan.shader_int64_atomics = features.shaderInt64 && features12.shaderBufferInt64Atomics;
  vulkan.draw_indirect_count = features12.drawIndirectCount;
  vulkan.blocking_pipelines = pool.threads.empty();
  coppice_context* context = nullptr;
  check(coppice_vulkan_context_create(&desc, &vulkan, &context), "coppice_vulkan_context_create");
  return {context, [&gpu](coppice_context* each) {
            gpu.device.waitIdle();
            coppice_context_destroy(each);
          }};
}

/// What light.comp is told of a view in a frame; no more bytes than every device takes.
struct LightConstants {
  glm::mat3 ray_from_clip;      ///< from (x, y, 1) in clip space to the way from the eye, on the world's axes
  glm::mat4x3 shadow_from_eye;  ///< from there to clip space of the shadow map
  glm::vec3 sun_direction;
  float eye_height_m;
  glm::vec2 jitter_px;  ///< how much further this frame is moved than the one before
  float newest;         ///< weight of this frame in the history; 1: there is none
  vk::DeviceAddress picture;
};

/// What a surface view's attachments hold by default: albedo, normal, light, user data, velocity.
constexpr std::array kSurfaces = {vk::Format::eR8G8B8A8Srgb, vk::Format::eR8G8B8A8Unorm, vk::Format::eR8G8B8A8Unorm,
                                  vk::Format::eR8G8B8A8Unorm, vk::Format::eR16G16B16A16Sfloat};
struct View {
  coppice_view plants = 0;
  vk::Extent2D size;
  std::vector<Image> images;       ///< depth, and kSurfaces. A shadow map has depth alone, and nothing below
  std::array<Image, 2> histories;  ///< what light() has written in this frame and the one before
  Buffer picture;                  ///< RGBA8 rows
};

inline View create_view(Gpu& gpu, coppice_context* context, coppice_output output, vk::Extent2D size) {
  View view{.size = size};
  auto desc = made(coppice_view_desc_init);
  auto formats = made(coppice_vulkan_view_desc_init);
  desc.output = output;
  formats.depth_format = VK_FORMAT_D32_SFLOAT;
  view.images.push_back(create_image(gpu, vk::Format::eD32Sfloat, size, vk::ImageUsageFlagBits::eDepthStencilAttachment));
  for (std::size_t i = 0; i < kSurfaces.size() && output == COPPICE_OUTPUT_SURFACE; ++i) {
    formats.color_formats[i] = VkFormat(kSurfaces[i]);
    view.images.push_back(create_image(gpu, kSurfaces[i], size, vk::ImageUsageFlagBits::eColorAttachment));
  }
  check(coppice_vulkan_view_create(context, &desc, &formats, &view.plants), "coppice_vulkan_view_create");
  if (output != COPPICE_OUTPUT_SURFACE) return view;
  for (Image& history : view.histories)
    history = create_image(gpu, vk::Format::eR16G16B16A16Sfloat, size, vk::ImageUsageFlagBits::eStorage);
  view.picture = create_buffer(gpu, vk::DeviceSize{4} * size.width * size.height);
  return view;
}

/// Clears the view's images, draws to them, and leaves them to be read by shaders. Depth is reversed: 0 is far.
inline void render(const vk::raii::CommandBuffer& cmd, View& view, const std::function<void()>& draw) {
  std::vector<vk::RenderingAttachmentInfo> to;
  for (Image& image : view.images) {
    change_layout(cmd, image, vk::ImageLayout::eAttachmentOptimal);
    to.emplace_back(*image.view, image.layout, vk::ResolveModeFlagBits::eNone, nullptr, vk::ImageLayout::eUndefined,
                    vk::AttachmentLoadOp::eClear, vk::AttachmentStoreOp::eStore);
  }
  cmd.beginRendering(vk::RenderingInfo({}, {{0, 0}, view.size}, 1, 0, std::uint32_t(to.size() - 1), to.data() + 1, to.data()));
  draw();
  cmd.endRendering();
  for (Image& image : view.images) change_layout(cmd, image, vk::ImageLayout::eShaderReadOnlyOptimal);
}

struct LightPass {
  static constexpr auto kTextures = vk::DescriptorType::eCombinedImageSampler, kImage = vk::DescriptorType::eStorageImage;
  static constexpr std::uint32_t kTextureCount = 8;  ///< depth, kSurfaces, the shadow map, the history
  explicit LightPass(const vk::raii::Device& device) {
    const std::array bindings = {vk::DescriptorSetLayoutBinding(0, kTextures, kTextureCount, vk::ShaderStageFlagBits::eCompute),
                                 vk::DescriptorSetLayoutBinding(1, kImage, 1, vk::ShaderStageFlagBits::eCompute)};
    images = {device, vk::DescriptorSetLayoutCreateInfo(vk::DescriptorSetLayoutCreateFlagBits::ePushDescriptorKHR, bindings)};
    const vk::PushConstantRange constants(vk::ShaderStageFlagBits::eCompute, 0, sizeof(LightConstants));
    layout = {device, vk::PipelineLayoutCreateInfo({}, *images, constants)};
    constexpr auto kClamp = vk::SamplerAddressMode::eClampToEdge;
    nearest = {device, vk::SamplerCreateInfo()};
    linear = {device, vk::SamplerCreateInfo({}, vk::Filter::eLinear, vk::Filter::eLinear, {}, kClamp, kClamp)};
    const vk::raii::ShaderModule code(device, vk::ShaderModuleCreateInfo({}, sizeof light_comp_spirv, light_comp_spirv));
    const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *code, "main");
    pipeline = {device, nullptr, vk::ComputePipelineCreateInfo({}, stage, *layout)};
  }
  vk::raii::DescriptorSetLayout images = nullptr;
  vk::raii::PipelineLayout layout = nullptr;
  vk::raii::Sampler nearest = nullptr, linear = nullptr;
  vk::raii::Pipeline pipeline = nullptr;
};

/// Lights what a view has drawn, and blends it with the frames before (temporal antialiasing).
inline void light(const LightPass& pass, const vk::raii::CommandBuffer& cmd, View& view, const Image& shadow_map,
                  const LightConstants& constants, std::uint64_t frame) {
  Image &past = view.histories[frame % 2], &next = view.histories[(frame + 1) % 2];
  change_layout(cmd, past, vk::ImageLayout::eShaderReadOnlyOptimal);
  change_layout(cmd, next, vk::ImageLayout::eGeneral);
  std::vector<vk::DescriptorImageInfo> infos;
  for (const Image& image : view.images) infos.emplace_back(*pass.nearest, *image.view, image.layout);
  infos.emplace_back(*pass.nearest, *shadow_map.view, shadow_map.layout);
  for (const Image* history : {&past, &next}) infos.emplace_back(*pass.linear, *history->view, history->layout);
  const std::array writes = {vk::WriteDescriptorSet(nullptr, 0, 0, LightPass::kTextureCount, LightPass::kTextures, infos.data()),
                             vk::WriteDescriptorSet(nullptr, 1, 0, 1, LightPass::kImage, &infos.back())};
  cmd.bindPipeline(vk::PipelineBindPoint::eCompute, *pass.pipeline);
  cmd.pushDescriptorSetKHR(vk::PipelineBindPoint::eCompute, *pass.layout, 0, writes);
  cmd.pushConstants<LightConstants>(*pass.layout, vk::ShaderStageFlagBits::eCompute, 0, constants);
  cmd.dispatch((view.size.width + 7) / 8, (view.size.height + 7) / 8, 1);
}

}  // namespace engine
