#include "row_figures.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace coppice::test {
namespace {

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
