// One Vulkan construct of Coppice's frames a process, without Coppice: gpu_micro TEST. Exit code 0: right, 1: wrong; a hang is the caller's
// to time out. Without an argument it lists the tests. Nothing is destroyed: the process ends.

#define VOLK_IMPLEMENTATION
#include <volk.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "count_comp.h"
#include "full_frag.h"
#include "full_vert.h"
#include "int64_comp.h"
#include "loop_comp.h"

namespace {

using Words = std::span<const std::uint32_t>;

void check(VkResult result, const char* call) {
  if (result == VK_SUCCESS) return;
  std::printf("%s: VkResult %d\n", call, result);
  std::exit(1);
}
#define CHECK(call) check(call, #call)

struct Gpu {
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  VkCommandPool pool = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceMemoryProperties memory{};
};
Gpu gpu;

template <class Info, class Handle>
Handle made(VkResult (*create)(VkDevice, const Info*, const VkAllocationCallbacks*, Handle*), const Info& info, const char* call) {
  Handle handle = VK_NULL_HANDLE;
  check(create(gpu.device, &info, nullptr, &handle), call);
  return handle;
}
#define MADE(create, info) made(create, info, #create)

void open() {
  CHECK(volkInitialize());
  const VkApplicationInfo app{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
  const VkInstanceCreateInfo instance_info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &app};
  VkInstance instance = VK_NULL_HANDLE;
  CHECK(vkCreateInstance(&instance_info, nullptr, &instance));
  volkLoadInstance(instance);
  std::uint32_t count = 1;
  vkEnumeratePhysicalDevices(instance, &count, &gpu.physical);
  if (count == 0) check(VK_ERROR_INITIALIZATION_FAILED, "vkEnumeratePhysicalDevices");
  vkGetPhysicalDeviceProperties(gpu.physical, &gpu.properties);
  vkGetPhysicalDeviceMemoryProperties(gpu.physical, &gpu.memory);
  VkPhysicalDeviceVulkan12Features has12{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceFeatures2 has{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &has12};
  vkGetPhysicalDeviceFeatures2(gpu.physical, &has);
  VkPhysicalDeviceVulkan13Features wants13{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, .synchronization2 = VK_TRUE, .dynamicRendering = VK_TRUE};
  VkPhysicalDeviceVulkan12Features wants12{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                           .pNext = &wants13,
                                           .drawIndirectCount = has12.drawIndirectCount,
                                           .shaderBufferInt64Atomics = has12.shaderBufferInt64Atomics,
                                           .timelineSemaphore = VK_TRUE};
  VkPhysicalDeviceFeatures2 wants{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &wants12};
  wants.features.shaderInt64 = has.features.shaderInt64;
  wants.features.multiDrawIndirect = VK_TRUE;
  const float priority = 1.0f;
  const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
  const VkDeviceCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &wants, .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue};
  CHECK(vkCreateDevice(gpu.physical, &info, nullptr, &gpu.device));
  volkLoadDevice(gpu.device);
  vkGetDeviceQueue(gpu.device, 0, 0, &gpu.queue);
  const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  gpu.pool = MADE(vkCreateCommandPool, pool);
}

VkDeviceMemory allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags flags) {
  std::uint32_t type = 0;
  while (type < gpu.memory.memoryTypeCount &&
         (!(needs.memoryTypeBits >> type & 1u) || (gpu.memory.memoryTypes[type].propertyFlags & flags) != flags))
    ++type;
  const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size, .memoryTypeIndex = type};
  return MADE(vkAllocateMemory, info);
}

struct Buffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  std::uint32_t* mapped = nullptr;
};

enum class Kind { device, host };

Buffer make_buffer(VkDeviceSize bytes, Kind kind) {
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .size = bytes,
                                .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                                         VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                                         VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT};
  Buffer buffer{.buffer = MADE(vkCreateBuffer, info)};
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(gpu.device, buffer.buffer, &needs);
  const bool host = kind == Kind::host;
  const VkDeviceMemory memory = allocate(
      needs, host ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  CHECK(vkBindBufferMemory(gpu.device, buffer.buffer, memory, 0));
  if (host) CHECK(vkMapMemory(gpu.device, memory, 0, VK_WHOLE_SIZE, 0, reinterpret_cast<void**>(&buffer.mapped)));
  return buffer;
}

void full_barrier(VkCommandBuffer cmd) {
  const VkMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                 .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                 .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                 .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
                                 .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT | VK_ACCESS_2_HOST_READ_BIT};
  const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
  vkCmdPipelineBarrier2(cmd, &info);
}

using Record = std::function<void(VkCommandBuffer)>;

VkCommandBuffer recorded(const Record& record) {
  const VkCommandBufferAllocateInfo info{
      .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = gpu.pool, .commandBufferCount = 1};
  VkCommandBuffer cmd = VK_NULL_HANDLE;
  CHECK(vkAllocateCommandBuffers(gpu.device, &info, &cmd));
  const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  CHECK(vkBeginCommandBuffer(cmd, &begin));
  record(cmd);
  CHECK(vkEndCommandBuffer(cmd));
  return cmd;
}

/// signal: null, or what the submission signals
void submit(VkCommandBuffer cmd, const VkSemaphoreSubmitInfo* signal = nullptr) {
  const VkCommandBufferSubmitInfo buffer{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, .commandBuffer = cmd};
  const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                           .commandBufferInfoCount = 1,
                           .pCommandBufferInfos = &buffer,
                           .signalSemaphoreInfoCount = signal != nullptr ? 1u : 0u,
                           .pSignalSemaphoreInfos = signal};
  CHECK(vkQueueSubmit2(gpu.queue, 1, &info, VK_NULL_HANDLE));
}

void run(const Record& record) {
  submit(recorded(record));
  CHECK(vkQueueWaitIdle(gpu.queue));
}

std::vector<std::uint32_t> read(const Buffer& buffer, std::size_t words) {
  const Buffer host = make_buffer(words * 4, Kind::host);
  run([&](VkCommandBuffer cmd) {
    full_barrier(cmd);
    const VkBufferCopy region{0, 0, words * 4};
    vkCmdCopyBuffer(cmd, buffer.buffer, host.buffer, 1, &region);
    full_barrier(cmd);
  });
  return {host.mapped, host.mapped + words};
}

VkShaderModule make_module(Words words) {
  const VkShaderModuleCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = words.size_bytes(), .pCode = words.data()};
  return MADE(vkCreateShaderModule, info);
}

VkPipelineLayout make_layout(VkShaderStageFlags stages, std::uint32_t push_bytes, std::span<const VkDescriptorSetLayout> sets) {
  const VkPushConstantRange range{stages, 0, push_bytes};
  const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                        .setLayoutCount = static_cast<std::uint32_t>(sets.size()),
                                        .pSetLayouts = sets.data(),
                                        .pushConstantRangeCount = push_bytes > 0 ? 1u : 0u,
                                        .pPushConstantRanges = &range};
  return MADE(vkCreatePipelineLayout, info);
}

struct Compute {
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkDescriptorSet set = VK_NULL_HANDLE;
};

/// Binding 0 is `buffer`; with `texels` binding 1 is its words as texels. lanes: of a group, constant 1
Compute make_compute(Words words, std::uint32_t push_bytes, std::uint32_t lanes, const Buffer& buffer, bool texels = false) {
  constexpr std::array kTypes{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER};
  std::array<VkDescriptorSetLayoutBinding, 2> bindings;
  std::array<VkDescriptorPoolSize, 2> sizes;
  for (std::uint32_t i = 0; i < 2; ++i) {
    bindings[i] = {i, kTypes[i], 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    sizes[i] = {kTypes[i], 1};
  }
  const VkDescriptorSetLayoutCreateInfo set_info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = bindings.size(), .pBindings = bindings.data()};
  const VkDescriptorSetLayout set_layout = MADE(vkCreateDescriptorSetLayout, set_info);
  Compute compute{.layout = make_layout(VK_SHADER_STAGE_COMPUTE_BIT, push_bytes, {&set_layout, 1})};

  const VkSpecializationMapEntry entry{1, 0, sizeof lanes};
  const VkSpecializationInfo constants{1, &entry, sizeof lanes, &lanes};
  const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                         .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                   .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                   .module = make_module(words),
                                                   .pName = "main",
                                                   .pSpecializationInfo = &constants},
                                         .layout = compute.layout};
  CHECK(vkCreateComputePipelines(gpu.device, VK_NULL_HANDLE, 1, &info, nullptr, &compute.pipeline));

  const VkDescriptorPoolCreateInfo pool_info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = sizes.size(), .pPoolSizes = sizes.data()};
  const VkDescriptorSetAllocateInfo allocate_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                  .descriptorPool = MADE(vkCreateDescriptorPool, pool_info),
                                                  .descriptorSetCount = 1,
                                                  .pSetLayouts = &set_layout};
  CHECK(vkAllocateDescriptorSets(gpu.device, &allocate_info, &compute.set));
  const VkBufferViewCreateInfo view_info{.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                         .buffer = buffer.buffer,
                                         .format = VK_FORMAT_R32_UINT,
                                         .range = std::uint64_t{4} << 10};
  const VkBufferView view = MADE(vkCreateBufferView, view_info);
  const VkDescriptorBufferInfo whole{buffer.buffer, 0, VK_WHOLE_SIZE};
  std::array<VkWriteDescriptorSet, 2> writes;
  for (std::uint32_t i = 0; i < 2; ++i)
    writes[i] = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                 .dstSet = compute.set,
                 .dstBinding = i,
                 .descriptorCount = 1,
                 .descriptorType = kTypes[i],
                 .pBufferInfo = &whole,
                 .pTexelBufferView = &view};
  vkUpdateDescriptorSets(gpu.device, texels ? 2 : 1, writes.data(), 0, nullptr);
  return compute;
}

void bind_compute(VkCommandBuffer cmd, const Compute& compute, Words push) {
  vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, compute.pipeline);
  vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, compute.layout, 0, 1, &compute.set, 0, nullptr);
  if (!push.empty())
    vkCmdPushConstants(cmd, compute.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, static_cast<std::uint32_t>(push.size_bytes()), push.data());
}

int expect(const char* what, std::uint64_t is, std::uint64_t wanted) {
  if (is == wanted) return 0;
  std::printf("%s is %llu, not %llu\n", what, static_cast<unsigned long long>(is), static_cast<unsigned long long>(wanted));
  return 1;
}

int empty() {
  run([](VkCommandBuffer) {});
  return 0;
}

int update() {
  constexpr std::uint32_t kOther = 0xabababab;
  const Buffer buffer = make_buffer(1 << 20, Kind::device);
  std::vector<std::uint32_t> words(512);
  for (std::uint32_t i = 0; i < words.size(); ++i) words[i] = i * 77 + 1;
  int faults = 0;
  for (const std::uint32_t bytes : {4u, 44u, 188u, 480u, 528u, 704u, 1268u}) {
    run([&](VkCommandBuffer cmd) {
      vkCmdFillBuffer(cmd, buffer.buffer, 0, VK_WHOLE_SIZE, kOther);
      full_barrier(cmd);
      vkCmdUpdateBuffer(cmd, buffer.buffer, 256, bytes, words.data());
      full_barrier(cmd);
    });
    const auto is = read(buffer, 1024);
    faults += expect("the last word", is[64 + bytes / 4 - 1], words[bytes / 4 - 1]) + expect("the one behind", is[64 + bytes / 4], kOther);
  }
  return faults;
}

/// loop.comp: items whose count differs by lane, appended by subgroups.
int loop(std::uint32_t lanes, bool indirect) {
  constexpr std::uint32_t kItems = 3000, kMost = 500;
  const Buffer buffer = make_buffer(1 << 22, Kind::device), groups = make_buffer(4096, Kind::device);
  std::array<std::uint32_t, 20> push{};
  push[0] = kItems;
  push[1] = kMost;
  push[18] = 1 << 20;
  const Compute compute = make_compute(loop_comp, sizeof push, lanes, buffer);
  std::uint32_t trips = 0, large = 0;
  for (std::uint32_t item = 0; item < kItems; ++item)
    for (std::uint32_t i = 0; i < 5 + 37 * (item % 7); ++i) {
      ++trips;
      large += (i * 2654435769u >> 29) == 0;
    }
  int faults = 0;
  for (int turn = 0; turn < 3; ++turn) {
    run([&](VkCommandBuffer cmd) {
      const std::array<std::uint32_t, 8> counts{kItems, 1, 1, 0, 0, 1, 1, 0};
      vkCmdFillBuffer(cmd, buffer.buffer, 0, VK_WHOLE_SIZE, 0);
      vkCmdUpdateBuffer(cmd, groups.buffer, 0, sizeof counts, counts.data());
      full_barrier(cmd);
      bind_compute(cmd, compute, push);
      if (!indirect) vkCmdDispatch(cmd, kItems, 1, 1);
      for (const VkDeviceSize offset : {16, 0, 16}) {
        if (!indirect) continue;
        vkCmdDispatchIndirect(cmd, groups.buffer, offset);  // no groups, all, none
        full_barrier(cmd);
      }
    });
    const auto is = read(buffer, 16);
    faults += expect("what was appended and taken", is[0] + is[4], trips) + expect("what was taken", is[4], std::min(large, kMost)) +
              expect("groups", is[2], kItems) + expect("lanes", is[3], lanes);
  }
  return faults;
}

int push_of_two_sizes() {
  const Buffer buffer = make_buffer(4096, Kind::device);
  const Compute count = make_compute(count_comp, 4, 1, buffer);
  const auto add = [&](std::uint32_t value) {
    run([&](VkCommandBuffer cmd) {
      bind_compute(cmd, count, {&value, 1});
      vkCmdDispatch(cmd, 5, 1, 1);
      full_barrier(cmd);
    });
    return read(buffer, 8)[5];
  };
  run([&](VkCommandBuffer cmd) { vkCmdFillBuffer(cmd, buffer.buffer, 0, VK_WHOLE_SIZE, 0); });
  int faults = expect("the sum", add(7), 35);
  faults += loop(32, false);
  return faults + expect("the sum", add(1), 40);
}

int int64_and_texels() {
  const Buffer buffer = make_buffer(1 << 16, Kind::device);
  const Compute compute = make_compute(int64_comp, 0, 1, buffer, true);
  run([&](VkCommandBuffer cmd) {
    vkCmdFillBuffer(cmd, buffer.buffer, 0, VK_WHOLE_SIZE, 0);
    full_barrier(cmd);
    bind_compute(cmd, compute, {});
    for (int turn = 0; turn < 4; ++turn) {
      vkCmdDispatch(cmd, 4000, 1, 1);
      full_barrier(cmd);
    }
  });
  std::vector<std::uint64_t> wanted(257);
  for (std::uint64_t i = 0; i < 256000; ++i) {
    const std::uint64_t key = (static_cast<std::uint32_t>(i) * 2654435769u) | 1u;
    wanted[i % wanted.size()] = std::max(wanted[i % wanted.size()], key << 32 | i);
  }
  const auto is = read(buffer, 2 * wanted.size());
  std::uint64_t wrong = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) wrong += (std::uint64_t{is[2 * i + 1]} << 32 | is[2 * i]) != wanted[i];
  return expect("wrong pixels", wrong, 0);
}

// ---- pictures

constexpr std::uint32_t kSide_px = 64;
constexpr VkFormat kColor = VK_FORMAT_R8G8B8A8_UNORM, kDepth = VK_FORMAT_D32_SFLOAT;
constexpr VkShaderStageFlags kDrawStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
using Push = std::array<std::uint32_t, 8>;

struct Image {
  VkImage image = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
  VkImageAspectFlags aspect = 0;
};

Image make_image(VkFormat format, VkImageUsageFlags usage) {
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = format,
                               .extent = {kSide_px, kSide_px, 1},
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .usage = usage};
  Image image{.image = MADE(vkCreateImage, info),
              .aspect = VkImageAspectFlags(format == kDepth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT)};
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(gpu.device, image.image, &needs);
  CHECK(vkBindImageMemory(gpu.device, image.image, allocate(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT), 0));
  const VkImageViewCreateInfo view_info{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                        .image = image.image,
                                        .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                        .format = format,
                                        .subresourceRange = {image.aspect, 0, 1, 0, 1}};
  image.view = MADE(vkCreateImageView, view_info);
  return image;
}

void change_layout(VkCommandBuffer cmd, const Image& image, VkImageLayout from, VkImageLayout to) {
  const VkImageMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                      .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                      .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                      .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                      .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                                      .oldLayout = from,
                                      .newLayout = to,
                                      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                      .image = image.image,
                                      .subresourceRange = {image.aspect, 0, 1, 0, 1}};
  const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
  vkCmdPipelineBarrier2(cmd, &info);
}

VkPipeline make_draw(VkPipelineLayout layout) {
  const auto stage = [](VkShaderStageFlagBits bit, Words words) {
    return VkPipelineShaderStageCreateInfo{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = bit, .module = make_module(words), .pName = "main"};
  };
  const std::array stages{stage(VK_SHADER_STAGE_VERTEX_BIT, full_vert), stage(VK_SHADER_STAGE_FRAGMENT_BIT, full_frag)};
  const VkPipelineVertexInputStateCreateInfo input{.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  const VkPipelineInputAssemblyStateCreateInfo assembly{.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo raster{.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1};
  const VkPipelineMultisampleStateCreateInfo samples{.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                     .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineDepthStencilStateCreateInfo depth{.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                    .depthTestEnable = VK_TRUE,
                                                    .depthWriteEnable = VK_TRUE,
                                                    .depthCompareOp = VK_COMPARE_OP_GREATER_OR_EQUAL};
  const VkPipelineColorBlendAttachmentState all{.colorWriteMask = 15};
  const VkPipelineColorBlendStateCreateInfo blend{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO, .attachmentCount = 1, .pAttachments = &all};
  const std::array states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, .dynamicStateCount = states.size(), .pDynamicStates = states.data()};
  const VkPipelineRenderingCreateInfo rendering{.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                .colorAttachmentCount = 1,
                                                .pColorAttachmentFormats = &kColor,
                                                .depthAttachmentFormat = kDepth};
  const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .pNext = &rendering,
                                          .stageCount = stages.size(),
                                          .pStages = stages.data(),
                                          .pVertexInputState = &input,
                                          .pInputAssemblyState = &assembly,
                                          .pViewportState = &viewport,
                                          .pRasterizationState = &raster,
                                          .pMultisampleState = &samples,
                                          .pDepthStencilState = &depth,
                                          .pColorBlendState = &blend,
                                          .pDynamicState = &dynamic,
                                          .layout = layout};
  VkPipeline made = VK_NULL_HANDLE;
  CHECK(vkCreateGraphicsPipelines(gpu.device, VK_NULL_HANDLE, 1, &info, nullptr, &made));
  return made;
}

/// How many pixels are green after draws(cmd). discard: full.frag leaves out every second column
std::uint32_t green_pixels(const Record& draws, bool discard = false) {
  const Image color = make_image(kColor, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
  const Image depth = make_image(kDepth, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
  const Buffer host = make_buffer(kSide_px * kSide_px * 4, Kind::host);
  const VkPipelineLayout layout = make_layout(kDrawStages, sizeof(Push), {});
  const VkPipeline pipeline = make_draw(layout);
  run([&](VkCommandBuffer cmd) {
    change_layout(cmd, color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
    change_layout(cmd, depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
    VkRenderingAttachmentInfo colors{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                     .imageView = color.view,
                                     .imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                     .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                     .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    VkRenderingAttachmentInfo depths = colors;
    depths.imageView = depth.view;
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{0, 0}, {kSide_px, kSide_px}},
                                    .layerCount = 1,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &colors,
                                    .pDepthAttachment = &depths};
    vkCmdBeginRendering(cmd, &rendering);
    const VkViewport viewport{0, 0, kSide_px, kSide_px, 0, 1};
    vkCmdSetViewport(cmd, 0, 1, &viewport);
    vkCmdSetScissor(cmd, 0, 1, &rendering.renderArea);
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    const Push push{discard ? 1u : 0u};
    vkCmdPushConstants(cmd, layout, kDrawStages, 0, sizeof push, push.data());
    draws(cmd);
    vkCmdEndRendering(cmd);
    change_layout(cmd, color, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    change_layout(cmd, depth, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    const VkBufferImageCopy region{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, .imageExtent = {kSide_px, kSide_px, 1}};
    vkCmdCopyImageToBuffer(cmd, color.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, host.buffer, 1, &region);
    full_barrier(cmd);
  });
  return static_cast<std::uint32_t>(std::count(host.mapped, host.mapped + kSide_px * kSide_px, 0xff00ff00u));
}

void draw_triangle(VkCommandBuffer cmd) {
  vkCmdDraw(cmd, 3, 1, 0, 0);
}

struct Counted {
  std::uint32_t count, most;
  std::uint32_t wanted_px;
  bool then_direct = false;
};

/// Draws with a count; behind the commands that it counts lie draws of 5 * 10^8 indices, 21,912 times.
int draw_counted(const Counted& draw) {
  const Buffer commands = make_buffer(65536, Kind::device), indices = make_buffer(4096, Kind::device);
  constexpr VkDeviceSize kCountAt = 1024;
  std::vector<VkDrawIndexedIndirectCommand> drawn(260, {555161920, 21912, 0, 0, 0});
  std::fill_n(drawn.begin(), draw.count, VkDrawIndexedIndirectCommand{3, 1, 0, 0, 0});
  run([&](VkCommandBuffer cmd) {
    const std::array<std::uint32_t, 4> index{0, 1, 2};
    vkCmdUpdateBuffer(cmd, commands.buffer, 0, drawn.size() * sizeof drawn[0], drawn.data());
    vkCmdUpdateBuffer(cmd, indices.buffer, 0, sizeof index, index.data());
    vkCmdUpdateBuffer(cmd, indices.buffer, kCountAt, sizeof draw.count, &draw.count);
    full_barrier(cmd);
  });
  const std::uint32_t green = green_pixels([&](VkCommandBuffer cmd) {
    vkCmdBindIndexBuffer(cmd, indices.buffer, 0, VK_INDEX_TYPE_UINT32);
    vkCmdDrawIndexedIndirectCount(cmd, commands.buffer, 0, indices.buffer, kCountAt, draw.most, sizeof drawn[0]);
    if (draw.then_direct) draw_triangle(cmd);
  });
  return expect("green pixels", green, draw.wanted_px);
}

int timeline() {
  constexpr std::uint64_t kFrames = 50, kAhead = 2, kMostWait_ns = 10'000'000'000;
  const VkSemaphoreTypeCreateInfo type{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO, .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
  const VkSemaphoreCreateInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
  const VkSemaphore semaphore = MADE(vkCreateSemaphore, info);
  const Buffer buffer = make_buffer(1 << 24, Kind::device);
  for (std::uint64_t frame = 1; frame <= kFrames + kAhead; ++frame) {
    if (frame <= kFrames) {
      const VkSemaphoreSubmitInfo signal{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                         .semaphore = semaphore,
                                         .value = frame,
                                         .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
      submit(recorded([&](VkCommandBuffer cmd) {
               full_barrier(cmd);
               vkCmdFillBuffer(cmd, buffer.buffer, 0, VK_WHOLE_SIZE, static_cast<std::uint32_t>(frame));
             }),
             &signal);
    }
    if (frame <= kAhead) continue;
    const std::uint64_t done = frame - kAhead;
    const VkSemaphoreWaitInfo wait{
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, .semaphoreCount = 1, .pSemaphores = &semaphore, .pValues = &done};
    CHECK(vkWaitSemaphores(gpu.device, &wait, kMostWait_ns));
  }
  return expect("the last frame", read(buffer, 1)[0], kFrames);
}

struct Test {
  const char* name;
  std::function<int()> run;
};
std::function<int()> counted(const Counted& draw) {
  return [draw] { return draw_counted(draw); };
}
constexpr std::uint32_t kAll = kSide_px * kSide_px;
const std::array kTests{
    Test{"empty", empty},
    Test{"update", update},
    Test{"timeline", timeline},
    Test{"push_of_two_sizes", push_of_two_sizes},
    Test{"loop_direct_64", [] { return loop(64, false); }},
    Test{"loop_indirect_64", [] { return loop(64, true); }},
    Test{"loop_indirect_32", [] { return loop(32, true); }},
    Test{"int64_and_texels", int64_and_texels},
    Test{"draw_triangle", [] { return expect("green pixels", green_pixels(draw_triangle), kAll); }},
    Test{"draw_discard_depth", [] { return expect("green pixels", green_pixels(draw_triangle, true), kAll / 2); }},
    Test{"count_1_of_1", counted({1, 1, kAll})},
    Test{"count_0_of_256", counted({0, 256, 0})},
    Test{"count_1_of_256", counted({1, 256, kAll})},
    Test{"count_0_then_direct", counted({0, 256, kAll, true})},
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    for (const Test& test : kTests) std::puts(test.name);
    return 0;
  }
  const auto test = std::ranges::find_if(kTests, [&](const Test& each) { return std::string_view(argv[1]) == each.name; });
  if (test == kTests.end()) {
    std::fprintf(stderr, "gpu_micro: no test %s; without an argument it lists them\n", argv[1]);
    return 2;
  }
  open();
  if (test == kTests.begin()) std::printf("%s, driver 0x%x\n", gpu.properties.deviceName, gpu.properties.driverVersion);
  const int faults = test->run();
  std::printf("%s: %s\n", test->name, faults > 0 ? "WRONG" : "right");
  std::fflush(stdout);
  std::_Exit(faults > 0 ? 1 : 0);
}
