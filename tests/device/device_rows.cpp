// Where the figures come from.
// - "profile NAME": vp_gpuinfo_NAME.json in KhronosGroup/Vulkan-Profiles, an export of vulkan.gpuinfo.org.
// - "Android profile NAME": VP_ANDROID_NAME.json there.
// - "Mesa FILE": what that driver's source sets.
// - "Vulkan 1.3": the table of required limits in the specification.
// No profile has memory types, heaps and the alignment of images: they are as on such devices at gpuinfo.org, from memory.
// Left out is what lavapipe is as strict about: 128 MiB of a storage buffer, 2^27 texels, 128 bytes of push constants, atoms of 64 bytes,
// offsets of 16 bytes, 65,535 groups.

#include "device_rows.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <iterator>

namespace coppice::test {
namespace {

constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, kVisible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT,
                                kCoherent = kVisible | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
                                kLazy = VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT;
constexpr VkPhysicalDeviceType kIntegrated = VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU;
constexpr VkDeviceSize kMiB = 1ull << 20, kGiB = 1ull << 30;

constexpr VkMemoryHeap local(VkDeviceSize bytes) {
  return {bytes, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT};
}
constexpr VkMemoryHeap system(VkDeviceSize bytes) {
  return {bytes, 0};
}

constexpr const char* kGtx1060 = "profile nvidia_geforce_gtx_1060_535_86_5_0_ubuntu_22_04";
constexpr VkPhysicalDeviceLimits kGtx1060Limits{.bufferImageGranularity = 1024, .minUniformBufferOffsetAlignment = 256};

using L = VkPhysicalDeviceLimits;
constexpr std::uint32_t L::*kMaxima[] = {&L::maxImageDimension2D,
                                         &L::maxTexelBufferElements,
                                         &L::maxUniformBufferRange,
                                         &L::maxStorageBufferRange,
                                         &L::maxPushConstantsSize,
                                         &L::maxMemoryAllocationCount,
                                         &L::maxSamplerAllocationCount,
                                         &L::maxBoundDescriptorSets,
                                         &L::maxPerStageDescriptorSamplers,
                                         &L::maxPerStageDescriptorUniformBuffers,
                                         &L::maxPerStageDescriptorStorageBuffers,
                                         &L::maxPerStageDescriptorSampledImages,
                                         &L::maxPerStageDescriptorStorageImages,
                                         &L::maxDescriptorSetSamplers,
                                         &L::maxDescriptorSetUniformBuffers,
                                         &L::maxDescriptorSetStorageBuffers,
                                         &L::maxVertexInputAttributes,
                                         &L::maxComputeSharedMemorySize,
                                         &L::maxComputeWorkGroupInvocations,
                                         &L::maxDrawIndirectCount,
                                         &L::maxColorAttachments};
constexpr VkDeviceSize L::*kAlignments[] = {&L::bufferImageGranularity, &L::minTexelBufferOffsetAlignment,
                                            &L::minUniformBufferOffsetAlignment, &L::minStorageBufferOffsetAlignment,
                                            &L::nonCoherentAtomSize};

struct Feature {
  const char* name;
  VkStructureType structure;
  std::size_t offset;
};
constexpr Feature core(const char* name, std::size_t offset) {
  return {name, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, offset};
}
constexpr Feature of_12(const char* name, std::size_t offset) {
  return {name, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, offset};
}
#define CORE(name) core(#name, offsetof(VkPhysicalDeviceFeatures2, features.name))
#define V12(name) of_12(#name, offsetof(VkPhysicalDeviceVulkan12Features, name))
constexpr Feature kFeatures[] = {CORE(multiDrawIndirect),       CORE(drawIndirectFirstInstance), CORE(shaderInt64),
                                 CORE(shaderFloat64),           CORE(textureCompressionBC),      CORE(samplerAnisotropy),
                                 CORE(geometryShader),          CORE(tessellationShader),        CORE(pipelineStatisticsQuery),
                                 CORE(occlusionQueryPrecise),   V12(drawIndirectCount),          V12(shaderBufferInt64Atomics),
                                 V12(shaderSharedInt64Atomics), V12(samplerFilterMinmax)};

}  // namespace

const std::vector<DeviceRow>& device_rows() {
  static const std::vector<DeviceRow> rows{
      {.name = "driver", .source = "the driver itself"},
      // None of the device's memory is visible. Types of buffers and of images are apart.
      {.name = "nvidia_old",
       .source = kGtx1060,
       .subgroup_size = 32,
       .limits = kGtx1060Limits,
       .heaps = {local(4 * kGiB), system(8 * kGiB)},
       .types = {{0, 1}, {0, 1}, {kLocal, 0}, {kLocal, 0}, {kCoherent, 1}, {kCoherent | kCached, 1}},
       .buffer_types = 0b110101,
       .image_types = 0b001010,
       .image_alignment_bytes = 1024},
      {.name = "nvidia_256_mib_bar",
       .source = kGtx1060,
       .subgroup_size = 32,
       .limits = kGtx1060Limits,
       .heaps = {local(6 * kGiB), system(12 * kGiB), local(246 * kMiB)},
       .types = {{0, 1}, {kLocal, 0}, {kCoherent, 1}, {kCoherent | kCached, 1}, {kLocal | kCoherent, 2}},
       .image_types = 0b00010,
       .image_alignment_bytes = 1024},
      // All of the device's memory is visible.
      {.name = "nvidia_new",
       .source = kGtx1060,
       .subgroup_size = 32,
       .limits = {.bufferImageGranularity = 1024, .minUniformBufferOffsetAlignment = 64},
       .heaps = {local(16 * kGiB), system(32 * kGiB)},
       .types = {{0, 1}, {kLocal, 0}, {kCoherent, 1}, {kCoherent | kCached, 1}, {kLocal | kCoherent, 0}},
       .image_types = 0b00010,
       .image_alignment_bytes = 1024},
      {.name = "amd_rdna_windows",
       .source = "profile amd_radeon_rx_7800_xt_2_0_294_windows_11",
       .subgroup_size = 64,
       .limits = {.nonCoherentAtomSize = 128},
       .heaps = {local(15 * kGiB), system(16 * kGiB), local(256 * kMiB)},
       .types = {{kLocal, 0}, {kCoherent, 1}, {kLocal | kCoherent, 2}, {kCoherent | kCached, 1}},
       .image_alignment_bytes = 65536},
      {.name = "amd_rdna_linux",
       .source = "Mesa radv_physical_device.c",
       .subgroup_size = 64,
       .limits = {.minMemoryMapAlignment = 4096},
       .heaps = {system(16 * kGiB), local(16 * kGiB)},
       .types = {{kLocal, 1}, {kLocal, 1}, {kCoherent, 0}, {kLocal | kCoherent, 1}, {kLocal | kCoherent, 1}, {kCoherent | kCached, 0}},
       .image_alignment_bytes = 65536},
      {.name = "amd_gcn",
       .source = "Mesa radv_physical_device.c",
       .subgroup_size = 64,
       .limits = {.minMemoryMapAlignment = 4096},
       .heaps = {local(8 * kGiB - 256 * kMiB), system(8 * kGiB), local(256 * kMiB)},
       .types = {{kLocal, 0}, {kCoherent, 1}, {kLocal | kCoherent, 2}, {kCoherent | kCached, 1}},
       .image_alignment_bytes = 4096},
      {.name = "intel_arc",
       .source = "profile intel_r__arc_tm__a770_graphics_0_405_1234_windows_11",
       .subgroup_size = 32,
       .limits = {.minTexelBufferOffsetAlignment = 64, .minUniformBufferOffsetAlignment = 64, .minStorageBufferOffsetAlignment = 64},
       .heaps = {local(16 * kGiB), system(16 * kGiB)},
       .types = {{kLocal, 0}, {kLocal | kCoherent, 0}, {kCoherent, 1}, {kCoherent | kCached, 1}},
       .image_alignment_bytes = 65536},
      // Processor and GPU share no cache: what is cached is not coherent.
      {.name = "intel_integrated",
       .source = "Mesa anv_device.c",
       .type = kIntegrated,
       .subgroup_size = 32,
       .limits = {.minMemoryMapAlignment = 4096, .minUniformBufferOffsetAlignment = 64},
       .heaps = {local(4 * kGiB)},
       .types = {{kLocal | kVisible | kCached, 0}, {kLocal | kCoherent, 0}},
       .image_alignment_bytes = 4096},
      {.name = "apple_m1_moltenvk",
       .source = "profile apple_m1_0_2_2209_macos_26_5_1",
       .type = kIntegrated,
       .subgroup_size = 32,
       .limits = {.maxTexelBufferElements = 1u << 26,
                  .maxPerStageDescriptorSamplers = 16,
                  .maxPerStageDescriptorStorageBuffers = 31,
                  .maxDescriptorSetSamplers = 80,
                  .maxDescriptorSetUniformBuffers = 155,
                  .maxDescriptorSetStorageBuffers = 155},
       .heaps = {local(5461 * kMiB)},
       .types = {{kLocal, 0}, {kLocal | kCoherent | kCached, 0}, {kLocal | kLazy, 0}},
       .buffer_types = 0b011,
       .image_types = 0b011,
       .image_alignment_bytes = 16384,
       .missing_features = {"drawIndirectCount", "shaderBufferInt64Atomics", "shaderSharedInt64Atomics", "pipelineStatisticsQuery",
                            "samplerFilterMinmax", "geometryShader", "shaderFloat64"},
       .missing_extensions = {"VK_EXT_transform_feedback", "VK_EXT_conditional_rendering"}},
      // Valhall with Arm's driver.
      {.name = "mali_g78",
       .source = "Android profile 15_minimums; Mesa panvk_physical_device.c",
       .type = kIntegrated,
       .subgroup_size = 16,
       .limits = {.maxTexelBufferElements = 65536, .bufferImageGranularity = 4096, .minTexelBufferOffsetAlignment = 64},
       .heaps = {local(4 * kGiB)},
       .types = {{kLocal | kVisible | kCached, 0}, {kLocal | kCoherent, 0}, {kLocal | kLazy, 0}},
       .buffer_types = 0b011,
       .image_types = 0b011,
       .image_alignment_bytes = 4096,
       .missing_features = {"textureCompressionBC", "drawIndirectCount", "shaderBufferInt64Atomics", "shaderSharedInt64Atomics",
                            "geometryShader", "tessellationShader", "shaderFloat64"}},
      // Bifrost: a command draws once.
      {.name = "mali_g72",
       .source = "Android profile vulkan_profile_2021; Mesa panvk_physical_device.c",
       .type = kIntegrated,
       .subgroup_size = 8,
       .limits = {.maxTexelBufferElements = 65536,
                  .bufferImageGranularity = 4096,
                  .maxPerStageDescriptorStorageBuffers = 4,
                  .maxDrawIndirectCount = 1,
                  .minUniformBufferOffsetAlignment = 256,
                  .minStorageBufferOffsetAlignment = 256},
       .heaps = {local(3 * kGiB)},
       .types = {{kLocal | kCoherent, 0}, {kLocal | kVisible | kCached, 0}},
       .missing_features = {"multiDrawIndirect", "textureCompressionBC", "drawIndirectCount", "shaderBufferInt64Atomics", "shaderInt64"}},
      // Qualcomm's driver.
      {.name = "adreno_640",
       .source = "Android profile 15_minimums",
       .type = kIntegrated,
       .subgroup_size = 64,
       .limits = {.maxTexelBufferElements = 65536,
                  .maxPerStageDescriptorUniformBuffers = 13,
                  .maxPerStageDescriptorStorageBuffers = 12,
                  .minTexelBufferOffsetAlignment = 64,
                  .minUniformBufferOffsetAlignment = 64,
                  .minStorageBufferOffsetAlignment = 64},
       .heaps = {local(3 * kGiB)},
       .types = {{kLocal, 0}, {kLocal | kCoherent, 0}, {kLocal | kVisible | kCached, 0}},
       .image_alignment_bytes = 4096,
       .missing_features = {"drawIndirectCount", "shaderBufferInt64Atomics", "shaderSharedInt64Atomics", "shaderInt64"}},
      {.name = "adreno_730_turnip",
       .source = "Mesa tu_device.cc",
       .type = kIntegrated,
       .subgroup_size = 64,
       .limits = {.minMemoryMapAlignment = 4096, .minTexelBufferOffsetAlignment = 64, .minUniformBufferOffsetAlignment = 64},
       .heaps = {local(6 * kGiB)},
       .types = {{kLocal | kCoherent, 0}, {kLocal | kVisible | kCached, 0}},
       .image_alignment_bytes = 4096,
       .missing_features = {"shaderBufferInt64Atomics", "shaderSharedInt64Atomics"}},
      // The minimum, and what Coppice needs beside it; memory as awkward as the specification allows.
      {.name = "vulkan_minimum",
       .source = "Vulkan 1.3, but 7 storage buffers a stage in place of 4",
       .type = kIntegrated,
       .subgroup_size = 4,
       .limits = {.maxImageDimension2D = 4096,
                  .maxTexelBufferElements = 65536,
                  .maxUniformBufferRange = 16384,
                  .maxMemoryAllocationCount = 4096,
                  .maxSamplerAllocationCount = 4000,
                  .bufferImageGranularity = 131072,
                  .maxBoundDescriptorSets = 4,
                  .maxPerStageDescriptorSamplers = 16,
                  .maxPerStageDescriptorUniformBuffers = 12,
                  .maxPerStageDescriptorStorageBuffers = 7,
                  .maxPerStageDescriptorSampledImages = 16,
                  .maxPerStageDescriptorStorageImages = 4,
                  .maxVertexInputAttributes = 16,
                  .maxComputeSharedMemorySize = 16384,
                  .maxComputeWorkGroupInvocations = 128,
                  .maxComputeWorkGroupSize = {128, 128, 64},
                  .maxDrawIndirectCount = 65535,
                  .maxViewportDimensions = {4096, 4096},
                  .minTexelBufferOffsetAlignment = 256,
                  .minUniformBufferOffsetAlignment = 256,
                  .minStorageBufferOffsetAlignment = 256,
                  .maxColorAttachments = 4,
                  .nonCoherentAtomSize = 256},
       .max_allocation_bytes = 1 * kGiB,
       .heaps = {local(1 * kGiB), system(256 * kMiB)},
       .types = {{kLocal, 0}, {kVisible | kCached, 1}, {kCoherent, 1}},
       .image_types = 0b001,
       .image_alignment_bytes = 65536,
       .missing_features = {"drawIndirectCount", "shaderInt64", "shaderBufferInt64Atomics", "shaderSharedInt64Atomics",
                            "textureCompressionBC", "samplerAnisotropy", "geometryShader", "tessellationShader", "pipelineStatisticsQuery",
                            "occlusionQueryPrecise", "samplerFilterMinmax", "shaderFloat64"}},
  };
  return rows;
}

const DeviceRow* find_row(std::string_view name) {
  const auto found = std::ranges::find(device_rows(), name, [](const DeviceRow& row) { return std::string_view(row.name); });
  return found == device_rows().end() ? nullptr : &*found;
}

void tighten(VkPhysicalDeviceLimits& limits, const DeviceRow& row) {
  for (const auto member : kMaxima) lower(limits.*member, row.limits.*member);
  for (const auto member : kAlignments) limits.*member = std::max(limits.*member, row.limits.*member);
  limits.minMemoryMapAlignment = std::max(limits.minMemoryMapAlignment, row.limits.minMemoryMapAlignment);
  for (int i = 0; i < 3; ++i) lower(limits.maxComputeWorkGroupSize[i], row.limits.maxComputeWorkGroupSize[i]);
  for (int i = 0; i < 2; ++i) lower(limits.maxViewportDimensions[i], row.limits.maxViewportDimensions[i]);
}

VkPhysicalDeviceMemoryProperties tighten(const VkPhysicalDeviceMemoryProperties& driver, const DeviceRow& row) {
  if (row.types.empty()) return driver;
  VkPhysicalDeviceMemoryProperties memory{};
  for (const VkMemoryType& type : row.types) memory.memoryTypes[memory.memoryTypeCount++] = type;
  for (const VkMemoryHeap& heap : row.heaps)
    memory.memoryHeaps[memory.memoryHeapCount++] = {std::min(heap.size, driver.memoryHeaps[0].size), heap.flags};
  return memory;
}

void for_each_missing(const DeviceRow& row, VkPhysicalDeviceFeatures2& chain,
                      const std::function<void(const char* name, VkBool32& enabled)>& visit) {
  for (const char* name : row.missing_features) {
    const auto* feature = std::ranges::find(kFeatures, std::string_view(name), [](const Feature& known) { return known.name; });
    if (feature == std::end(kFeatures)) {
      std::fprintf(stderr, "limits_layer: %s is no feature that it knows\n", name);
      std::abort();
    }
    for (auto* next = reinterpret_cast<VkBaseOutStructure*>(&chain); next != nullptr; next = next->pNext)
      if (next->sType == feature->structure)
        visit(name, *reinterpret_cast<VkBool32*>(reinterpret_cast<std::uint8_t*>(next) + feature->offset));
  }
}

bool lacks_extension(const DeviceRow& row, std::string_view name) {
  return std::ranges::find(row.missing_extensions, name, [](const char* missing) { return std::string_view(missing); }) !=
         row.missing_extensions.end();
}

}  // namespace coppice::test
