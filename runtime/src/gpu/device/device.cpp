#include "device.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <string>
#include <string_view>

#include "check.h"
#include "debug_label.h"
#include "hooks.h"

namespace coppice::gpu {
namespace {

struct Meaning {
  VkResult result;
  Status status;
  const char* name;
};
constexpr std::array kMeanings{
    Meaning{VK_ERROR_OUT_OF_HOST_MEMORY, Status::out_of_memory, "VK_ERROR_OUT_OF_HOST_MEMORY"},
    Meaning{VK_ERROR_OUT_OF_DEVICE_MEMORY, Status::out_of_memory, "VK_ERROR_OUT_OF_DEVICE_MEMORY"},
    Meaning{VK_ERROR_TOO_MANY_OBJECTS, Status::out_of_memory, "VK_ERROR_TOO_MANY_OBJECTS"},
    Meaning{VK_ERROR_MEMORY_MAP_FAILED, Status::out_of_memory, "VK_ERROR_MEMORY_MAP_FAILED"},
    Meaning{VK_ERROR_OUT_OF_POOL_MEMORY, Status::out_of_memory, "VK_ERROR_OUT_OF_POOL_MEMORY"},
    Meaning{VK_ERROR_FRAGMENTED_POOL, Status::out_of_memory, "VK_ERROR_FRAGMENTED_POOL"},
    Meaning{VK_ERROR_FRAGMENTATION, Status::out_of_memory, "VK_ERROR_FRAGMENTATION"},
    Meaning{VK_ERROR_DEVICE_LOST, Status::device_lost, "VK_ERROR_DEVICE_LOST"},
    Meaning{VK_ERROR_FORMAT_NOT_SUPPORTED, Status::unsupported, "VK_ERROR_FORMAT_NOT_SUPPORTED"},
    Meaning{VK_ERROR_FEATURE_NOT_PRESENT, Status::unsupported, "VK_ERROR_FEATURE_NOT_PRESENT"},
    Meaning{VK_ERROR_EXTENSION_NOT_PRESENT, Status::unsupported, "VK_ERROR_EXTENSION_NOT_PRESENT"},
    Meaning{VK_ERROR_INITIALIZATION_FAILED, Status::internal, "VK_ERROR_INITIALIZATION_FAILED"},
    Meaning{VK_ERROR_UNKNOWN, Status::internal, "VK_ERROR_UNKNOWN"},
};

std::string missing_features(const Functions& vk, VkPhysicalDevice physical_device) {
  VkPhysicalDeviceVulkan13Features vulkan13{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceVulkan12Features vulkan12{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &vulkan13};
  VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &vulkan12};
  vk.vkGetPhysicalDeviceFeatures2(physical_device, &features);

  struct Requirement {
    const char* name;
    VkBool32 present;
  };
  const std::array<Requirement, 6> requirements{{{"dynamicRendering", vulkan13.dynamicRendering},
                                                 {"synchronization2", vulkan13.synchronization2},
                                                 {"bufferDeviceAddress", vulkan12.bufferDeviceAddress},
                                                 {"scalarBlockLayout", vulkan12.scalarBlockLayout},
                                                 {"multiDrawIndirect", features.features.multiDrawIndirect},
                                                 {"drawIndirectFirstInstance", features.features.drawIndirectFirstInstance}}};
  std::string missing;
  for (const Requirement& requirement : requirements)
    if (!requirement.present) missing += (missing.empty() ? "" : ", ") + std::string(requirement.name);
  return missing;
}

std::uint32_t texel_bytes(VkFormat format) {
  if (format == VK_FORMAT_R32_UINT) return 4;
  return format == VK_FORMAT_R32G32_UINT ? 8 : 16;
}

Result<void> back_buffer(Device& device, const BufferDesc& desc, Buffer& buffer) {
  const bool addressable = (desc.usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0;
  VkMemoryRequirements requirements{};
  device.vk.vkGetBufferMemoryRequirements(device.device, buffer.buffer, &requirements);
  COPPICE_TRY(memory, reserve_memory(device, {requirements, desc.kind, false}));
  buffer.memory = memory;
  const coppice_memory_block& source = device.memory.blocks[memory.block].source;
  COPPICE_CHECK(check(device, device.vk.vkBindBufferMemory(device.device, buffer.buffer, source.memory, source.offset + memory.offset),
                      "vkBindBufferMemory"));
  if (desc.usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT) {
    const VkBufferViewCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                      .buffer = buffer.buffer,
                                      .format = desc.texels,
                                      .range = std::min(desc.size_bytes, device.max_texel_count * texel_bytes(desc.texels))};
    COPPICE_CHECK(check_created(device, device.vk.vkCreateBufferView(device.device, &info, nullptr, &buffer.texels), "vkCreateBufferView",
                                buffer.texels));
    name_object(device, VK_OBJECT_TYPE_BUFFER_VIEW, buffer.texels, desc.name);
  }
  if (addressable) {
    const VkBufferDeviceAddressInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer.buffer};
    buffer.address = device.vk.vkGetBufferDeviceAddress(device.device, &info);
    // WorkItem uses the upper bits. No known device has addresses as long.
    if (buffer.address >> kAddressBits != 0) return Error{Status::unsupported, "device addresses of more than 57 bits"};
  }
  if (desc.kind == MemoryKind::host) buffer.mapped = static_cast<std::uint8_t*>(source.mapped) + memory.offset;
  return {};
}

VkFormat vulkan_format(std::uint32_t texture_format) {
  if (texture_format == COPPICE_TEXTURE_BC3) return VK_FORMAT_BC3_SRGB_BLOCK;
  return texture_format == COPPICE_TEXTURE_BC1 ? VK_FORMAT_BC1_RGB_SRGB_BLOCK : VK_FORMAT_R8G8B8A8_SRGB;
}

constexpr const char* kTextureName = "coppice texture";

Result<void> back_texture(Device& device, Texture& texture, MemoryKind kind) {
  VkMemoryRequirements requirements{};
  device.vk.vkGetImageMemoryRequirements(device.device, texture.image, &requirements);
  COPPICE_TRY(memory, reserve_memory(device, {requirements, kind, true}));
  texture.memory = memory;
  const coppice_memory_block& source = device.memory.blocks[memory.block].source;
  COPPICE_CHECK(check(device, device.vk.vkBindImageMemory(device.device, texture.image, source.memory, source.offset + memory.offset),
                      "vkBindImageMemory"));
  const VkImageViewCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   .image = texture.image,
                                   .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                   .format = vulkan_format(texture.format),
                                   .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0, 1}};
  COPPICE_CHECK(
      check_created(device, device.vk.vkCreateImageView(device.device, &info, nullptr, &texture.view), "vkCreateImageView", texture.view));
  name_object(device, VK_OBJECT_TYPE_IMAGE_VIEW, texture.view, kTextureName);
  return {};
}

}  // namespace

Error vulkan_error(VkResult result, const char* call) {
  for (const Meaning& meaning : kMeanings)
    if (meaning.result == result) return Error{meaning.status, call, Error::kNoOffset, meaning.name};
  return Error{Status::internal, call, Error::kNoOffset, "VkResult " + std::to_string(result)};
}

Result<void> check(Device& device, VkResult result, const char* call) {
  if (result == VK_SUCCESS) return {};
  if (result == VK_ERROR_DEVICE_LOST) std::atomic_ref(device.lost_call).store(call);
  return vulkan_error(result, call);
}

Result<void> check_alive(const Device& device) {
  if (device.lost_call == nullptr) return {};
  return Error{Status::device_lost, device.lost_call, Error::kNoOffset,
               "VK_ERROR_DEVICE_LOST; destroy the context, then create it again on a new device"};
}

void go_on_without(Device& device, const Error& error, const char* instead) {
  if (error.status == Status::device_lost) return;
  static std::mutex mutex;  // views are recorded at the same time
  const std::lock_guard lock(mutex);
  if (std::ranges::find(device.warned_calls, std::string_view(error.what)) != device.warned_calls.end()) return;
  device.warned_calls.emplace_back(error.what);
  log_line(device.log, COPPICE_LOG_WARNING, "%s; %s", error.message().c_str(), instead);
}

Result<Device> open_device(VkInstance instance, VkPhysicalDevice physical_device, VkDevice device,
                           PFN_vkGetInstanceProcAddr get_instance_proc_addr) {
  COPPICE_TRY(functions, load_functions(get_instance_proc_addr, instance, device));
  Device opened{.vk = functions, .physical_device = physical_device, .device = device};
  VkPhysicalDeviceProperties properties{};
  opened.vk.vkGetPhysicalDeviceProperties(physical_device, &properties);
  if (properties.apiVersion < VK_API_VERSION_1_3)
    return Error{Status::unsupported, "the device has no Vulkan 1.3", Error::kNoOffset, properties.deviceName};
  if (std::string missing = missing_features(opened.vk, physical_device); !missing.empty())
    return Error{Status::unsupported, "the device lacks features", Error::kNoOffset, missing};
  opened.max_storage_bytes = properties.limits.maxStorageBufferRange;
  opened.max_draw_count = properties.limits.maxDrawIndirectCount;
  opened.max_texel_count = properties.limits.maxTexelBufferElements;
  opened.reads_texels = opened.max_texel_count >= kManyTexels;
  opened.max_colors = properties.limits.maxColorAttachments;
  opened.max_group_count = properties.limits.maxComputeWorkGroupCount[0];
  opened.max_stage_buffers = properties.limits.maxPerStageDescriptorStorageBuffers;
  opened.max_view_width = properties.limits.maxViewportDimensions[0];
  opened.max_view_height = properties.limits.maxViewportDimensions[1];
  opened.sample_counts = properties.limits.framebufferColorSampleCounts & properties.limits.framebufferDepthSampleCounts;
  opened.vk.vkGetPhysicalDeviceMemoryProperties(physical_device, &opened.memory.properties);
  set_granularity(opened.memory, properties.limits.bufferImageGranularity);
  return opened;
}

OptionalFeatures optional_features(const Device& device) {
  VkPhysicalDeviceVulkan12Features vulkan12{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &vulkan12};
  device.vk.vkGetPhysicalDeviceFeatures2(device.physical_device, &features);
  return {.block_textures = features.features.textureCompressionBC == VK_TRUE,
          .draw_counts = vulkan12.drawIndirectCount == VK_TRUE,
          .int64_atomics = features.features.shaderInt64 == VK_TRUE && vulkan12.shaderBufferInt64Atomics == VK_TRUE,
          .independent_blend = features.features.independentBlend == VK_TRUE};
}

Result<Buffer> create_buffer(Device& device, const BufferDesc& desc) {
  const auto beyond = [&](const char* what) { return Error{Status::unsupported, what, Error::kNoOffset, std::to_string(desc.size_bytes)}; };
  if ((desc.usage & VK_BUFFER_USAGE_STORAGE_BUFFER_BIT) && desc.size_bytes > device.max_storage_bytes)
    return beyond("storage buffer beyond the device's limit, bytes");
  if (device.reads_texels && (desc.usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT) &&
      desc.size_bytes / texel_bytes(desc.texels) > device.max_texel_count)
    return beyond("texel buffer beyond the device's limit, bytes");
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .size = desc.size_bytes,
                                .usage = desc.usage,
                                .sharingMode = sharing_mode(device),
                                .queueFamilyIndexCount = static_cast<std::uint32_t>(device.queue_families.size()),
                                .pQueueFamilyIndices = device.queue_families.data()};
  Buffer buffer{.size_bytes = desc.size_bytes};
  COPPICE_CHECK(check(device, device.vk.vkCreateBuffer(device.device, &info, nullptr, &buffer.buffer), "vkCreateBuffer"));
  name_object(device, VK_OBJECT_TYPE_BUFFER, buffer.buffer, desc.name);
  if (auto backed = back_buffer(device, desc, buffer); !backed) {
    destroy_buffer(device, buffer);
    return backed.error();
  }
  return buffer;
}

void destroy_buffer(Device& device, Buffer& buffer) {
  device.vk.vkDestroyBufferView(device.device, buffer.texels, nullptr);
  device.vk.vkDestroyBuffer(device.device, buffer.buffer, nullptr);
  release_memory(device, buffer.memory);
  buffer = {};
}

bool fits_buffer(Device& device, std::uint64_t bytes) {
  // A buffer takes a little more memory than its size.
  constexpr std::uint64_t kRounding = 4096;
  return bytes == 0 || device.memory.ledger->fits(bytes + kRounding);
}

Result<Texture> create_texture(Device& device, const coppice_file_texture& desc, MemoryKind kind) {
  COPPICE_ASSERT(desc.format == COPPICE_TEXTURE_RGBA8 || device.block_textures);
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = vulkan_format(desc.format),
                               .extent = {desc.width, desc.height, 1},
                               .mipLevels = desc.mip_count,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                               .sharingMode = sharing_mode(device),
                               .queueFamilyIndexCount = static_cast<std::uint32_t>(device.queue_families.size()),
                               .pQueueFamilyIndices = device.queue_families.data()};
  Texture texture{.width = desc.width, .height = desc.height, .mip_count = desc.mip_count, .format = desc.format};
  COPPICE_CHECK(check(device, device.vk.vkCreateImage(device.device, &info, nullptr, &texture.image), "vkCreateImage"));
  name_object(device, VK_OBJECT_TYPE_IMAGE, texture.image, kTextureName);
  if (auto backed = back_texture(device, texture, kind); !backed) {
    destroy_texture(device, texture);
    return backed.error();
  }
  return texture;
}

void destroy_texture(Device& device, Texture& texture) {
  device.vk.vkDestroyImageView(device.device, texture.view, nullptr);
  device.vk.vkDestroyImage(device.device, texture.image, nullptr);
  release_memory(device, texture.memory);
  texture = {};
}

VkSharingMode sharing_mode(const Device& device) {
  return device.queue_families.empty() ? VK_SHARING_MODE_EXCLUSIVE : VK_SHARING_MODE_CONCURRENT;
}

VkPipelineStageFlags2 stages_of_queue(const Device& device, VkPipelineStageFlags2 stages) {
  // A compute queue has no graphics stages, and a transfer queue has neither. The host's stage belongs to no queue.
  if (device.queue_families.empty() || stages == VK_PIPELINE_STAGE_2_NONE || stages == VK_PIPELINE_STAGE_2_HOST_BIT) return stages;
  return VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
}

void memory_barrier(const Device& device, VkCommandBuffer cmd, VkPipelineStageFlags2 source_stages, VkAccessFlags2 source_access,
                    VkPipelineStageFlags2 target_stages, VkAccessFlags2 target_access) {
  const VkMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                 .srcStageMask = stages_of_queue(device, source_stages),
                                 .srcAccessMask = source_access,
                                 .dstStageMask = stages_of_queue(device, target_stages),
                                 .dstAccessMask = target_access};
  const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
  device.vk.vkCmdPipelineBarrier2(cmd, &info);
}

}  // namespace coppice::gpu
