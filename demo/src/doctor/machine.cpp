#include "machine.h"

#include <array>
#include <cstdio>

#include "vk_struct.h"

namespace forest {
namespace {

const char* kind_of(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "a graphics card";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "a GPU beside the processor";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "a virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "the processor does a GPU's work";
    default:
      return "a device of another kind";
  }
}

std::string version_text(std::uint32_t version) {
  return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) + "." +
         std::to_string(VK_API_VERSION_PATCH(version));
}

std::string hex(std::uint32_t number) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04x", number);
  return text.data();
}

}  // namespace

std::string describe(VkPhysicalDevice device) {
  auto driver = vk_struct<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  auto all = vk_struct<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
  all.pNext = &driver;
  vkGetPhysicalDeviceProperties2(device, &all);
  const VkPhysicalDeviceProperties& properties = all.properties;
  return std::string(properties.deviceName) + " (" + kind_of(properties.deviceType) + ", " + hex(properties.vendorID) + ":" +
         hex(properties.deviceID) + "), driver " + driver.driverName + " " + driver.driverInfo + ", Vulkan " +
         version_text(properties.apiVersion);
}

std::vector<Need> needs_of(VkPhysicalDevice device) {
  auto v13 = vk_struct<VkPhysicalDeviceVulkan13Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
  auto v12 = vk_struct<VkPhysicalDeviceVulkan12Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
  auto features = vk_struct<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
  features.pNext = &v12;
  v12.pNext = &v13;
  vkGetPhysicalDeviceFeatures2(device, &features);
  const VkPhysicalDeviceFeatures& core = features.features;
  auto subgroup = vk_struct<VkPhysicalDeviceSubgroupProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES);
  auto properties = vk_struct<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
  properties.pNext = &subgroup;
  vkGetPhysicalDeviceProperties2(device, &properties);
  const VkPhysicalDeviceLimits& limits = properties.properties.limits;
  const bool ballots =
      (subgroup.supportedOperations & VK_SUBGROUP_FEATURE_BALLOT_BIT) != 0 && (subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0;
  const char* no_plants = "no plants";
  const char* no_compute = "the hardware draws all leaves";
  return {{"synchronization2", true, v13.synchronization2 == VK_TRUE, no_plants},
          {"dynamicRendering", true, v13.dynamicRendering == VK_TRUE, "views need a render pass; coppice-forest has none"},
          {"bufferDeviceAddress", true, v12.bufferDeviceAddress == VK_TRUE, no_plants},
          {"scalarBlockLayout", true, v12.scalarBlockLayout == VK_TRUE, no_plants},
          {"multiDrawIndirect", true, core.multiDrawIndirect == VK_TRUE, no_plants},
          {"drawIndirectFirstInstance", true, core.drawIndirectFirstInstance == VK_TRUE, no_plants},
          {"timelineSemaphore", true, v12.timelineSemaphore == VK_TRUE, "coppice-forest needs it, the library does not"},
          {"drawIndirectCount", false, v12.drawIndirectCount == VK_TRUE, "draws go through all commands that there is room for"},
          {"textureCompressionBC", false, core.textureCompressionBC == VK_TRUE, "textures take four to eight times the memory"},
          {"shaderInt64", false, core.shaderInt64 == VK_TRUE, "compute shaders go over leaves twice"},
          {"shaderBufferInt64Atomics", false, v12.shaderBufferInt64Atomics == VK_TRUE, "compute shaders go over leaves twice"},
          {"maxTexelBufferElements " + std::to_string(limits.maxTexelBufferElements) + " of 134217728", false,
           limits.maxTexelBufferElements >= 1u << 27, "texels are read from storage buffers"},
          {"maxPerStageDescriptorStorageBuffers " + std::to_string(limits.maxPerStageDescriptorStorageBuffers) + " of 15", false,
           limits.maxPerStageDescriptorStorageBuffers >= 15, no_compute},
          {"subgroup ballots in compute shaders (subgroups of " + std::to_string(subgroup.subgroupSize) + ")", false, ballots, no_compute}};
}

}  // namespace forest
