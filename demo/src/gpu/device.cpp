#include "device.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <vector>

#include "failure.h"
#include "vk_struct.h"

namespace forest {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  ++static_cast<Device*>(user)->messages;
  std::fprintf(stderr, "validation: %s\n", data->pMessage);
  return VK_FALSE;
}

/// The loader is there, and no driver is.
std::string no_driver() {
  std::string text = "no Vulkan driver";
  for (const char* variable : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"})
    if (const char* value = std::getenv(variable)) text += std::string(" in ") + variable + "=" + value;
  return text +
         ": install your graphics card's, or one that draws on the processor (on Debian, apt install mesa-vulkan-drivers); where one is "
         "installed in an unusual place, VK_DRIVER_FILES names its .json file";
}

bool has_layer(const char* name) {
  std::uint32_t count = 0;
  check(vkEnumerateInstanceLayerProperties(&count, nullptr), "vkEnumerateInstanceLayerProperties");
  std::vector<VkLayerProperties> layers(count);
  check(vkEnumerateInstanceLayerProperties(&count, layers.data()), "vkEnumerateInstanceLayerProperties");
  return std::any_of(layers.begin(), layers.end(), [&](const auto& layer) { return std::strcmp(layer.layerName, name) == 0; });
}

VkInstance create_instance(const DeviceOptions& options) {
  std::vector<const char*> extensions(options.instance_extensions.begin(), options.instance_extensions.end());
  std::vector<const char*> layers;
  if (options.validation) {
    if (!has_layer(kValidationLayer))
      throw Failure("--validation: " + std::string(kValidationLayer) + " is not installed (package vulkan-validationlayers)");
    layers.push_back(kValidationLayer);
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  }
  VkApplicationInfo application = vk_struct<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = "coppice-forest";
  application.apiVersion = VK_API_VERSION_1_3;
  const VkValidationFeatureEnableEXT enabled = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features = vk_struct<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &enabled;
  VkInstanceCreateInfo info = vk_struct<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pNext = options.validation ? &features : nullptr;
  info.pApplicationInfo = &application;
  info.enabledLayerCount = static_cast<std::uint32_t>(layers.size());
  info.ppEnabledLayerNames = layers.data();
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  VkInstance instance = VK_NULL_HANDLE;
  const VkResult created = vkCreateInstance(&info, nullptr, &instance);
  if (created == VK_ERROR_INCOMPATIBLE_DRIVER) throw Failure(no_driver());
  check(created, "vkCreateInstance");
  return instance;
}

// Created explicitly: one chained to VkInstanceCreateInfo would see only the instance's own creation and destruction.
VkDebugUtilsMessengerEXT create_messenger(VkInstance instance, Device* device) {
  VkDebugUtilsMessengerCreateInfoEXT info =
      vk_struct<VkDebugUtilsMessengerCreateInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  info.pfnUserCallback = on_message;
  info.pUserData = device;
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
  check(vkCreateDebugUtilsMessengerEXT(instance, &info, nullptr, &messenger), "vkCreateDebugUtilsMessengerEXT");
  return messenger;
}

std::optional<std::uint32_t> graphics_family(VkPhysicalDevice physical) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  constexpr VkQueueFlags kNeeded = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  for (std::uint32_t i = 0; i < count; ++i)
    if ((families[i].queueFlags & kNeeded) == kNeeded) return i;
  return std::nullopt;
}

int preference(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 2;
    default:
      return 1;
  }
}

VkPhysicalDevice choose_physical(VkInstance instance) {
  std::uint32_t count = 0;
  check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> devices(count);
  check(vkEnumeratePhysicalDevices(instance, &count, devices.data()), "vkEnumeratePhysicalDevices");
  VkPhysicalDevice best = VK_NULL_HANDLE;
  int best_preference = 0;
  std::string others;
  for (VkPhysicalDevice device : devices) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(device, &properties);
    const int rank = preference(properties.deviceType);
    others += std::string(others.empty() ? "; there is " : ", ") + properties.deviceName + " with Vulkan " +
              std::to_string(VK_API_VERSION_MAJOR(properties.apiVersion)) + "." +
              std::to_string(VK_API_VERSION_MINOR(properties.apiVersion));
    if (properties.apiVersion < VK_API_VERSION_1_3 || !graphics_family(device) || rank <= best_preference) continue;
    best = device;
    best_preference = rank;
  }
  if (!best) throw Failure("no Vulkan 1.3 device with a graphics queue (on Debian, mesa-vulkan-drivers has a software one)" + others);
  return best;
}

struct Features {
  VkPhysicalDeviceFeatures2 core = vk_struct<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
  VkPhysicalDeviceVulkan11Features v11 = vk_struct<VkPhysicalDeviceVulkan11Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES);
  VkPhysicalDeviceVulkan12Features v12 = vk_struct<VkPhysicalDeviceVulkan12Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
  VkPhysicalDeviceVulkan13Features v13 = vk_struct<VkPhysicalDeviceVulkan13Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);

  Features() {
    core.pNext = &v11;
    v11.pNext = &v12;
    v12.pNext = &v13;
  }
  Features(const Features&) = delete;
  Features& operator=(const Features&) = delete;
};

// Switches on what the demo and coppice.h need; throws with the name of the first one the device lacks.
void require_features(const Features& has, Features& wants) {
  const auto require = [](VkBool32 present, VkBool32& wanted, const char* name) {
    if (!present) throw Failure(std::string("the Vulkan device lacks ") + name);
    wanted = VK_TRUE;
  };
  require(has.core.features.multiDrawIndirect, wants.core.features.multiDrawIndirect, "multiDrawIndirect");
  require(has.core.features.drawIndirectFirstInstance, wants.core.features.drawIndirectFirstInstance, "drawIndirectFirstInstance");

  require(has.v12.bufferDeviceAddress, wants.v12.bufferDeviceAddress, "bufferDeviceAddress");
  require(has.v12.scalarBlockLayout, wants.v12.scalarBlockLayout, "scalarBlockLayout");
  require(has.v12.timelineSemaphore, wants.v12.timelineSemaphore, "timelineSemaphore");
  require(has.v13.dynamicRendering, wants.v13.dynamicRendering, "dynamicRendering");
  require(has.v13.synchronization2, wants.v13.synchronization2, "synchronization2");
  wants.core.features.samplerAnisotropy = has.core.features.samplerAnisotropy;
  wants.core.features.textureCompressionBC = has.core.features.textureCompressionBC;
  wants.core.features.shaderInt64 = has.core.features.shaderInt64;
  wants.v12.drawIndirectCount = has.v12.drawIndirectCount;
  wants.v12.shaderBufferInt64Atomics = has.v12.shaderBufferInt64Atomics;
}

VkDevice create_device(VkPhysicalDevice physical, std::uint32_t family, bool swapchain, const Features& wants) {
  const float priority = 1;
  VkDeviceQueueCreateInfo queue = vk_struct<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queue.queueFamilyIndex = family;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  const char* swapchain_name = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
  VkDeviceCreateInfo info = vk_struct<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  info.pNext = &wants.core;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = swapchain ? 1 : 0;
  info.ppEnabledExtensionNames = &swapchain_name;
  VkDevice device = VK_NULL_HANDLE;
  check(vkCreateDevice(physical, &info, nullptr, &device), "vkCreateDevice");
  return device;
}

}  // namespace

Device::Device(const DeviceOptions& options) {
  if (volkInitialize() != VK_SUCCESS) throw Failure("no Vulkan loader (on Debian, install libvulkan1 and mesa-vulkan-drivers)");
  instance = create_instance(options);
  volkLoadInstanceOnly(instance);
  if (options.validation) messenger = create_messenger(instance, this);
  physical = choose_physical(instance);
  if (options.chosen) options.chosen(physical);
  queue_family = *graphics_family(physical);
  VkPhysicalDeviceDriverProperties driver_info =
      vk_struct<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  VkPhysicalDeviceProperties2 properties2 = vk_struct<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
  properties2.pNext = &driver_info;
  vkGetPhysicalDeviceProperties2(physical, &properties2);
  const VkPhysicalDeviceProperties& properties = properties2.properties;
  name = properties.deviceName;
  driver = std::string(driver_info.driverName) + " " + driver_info.driverInfo;
  software = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  patience_s = options.patience_s > 0 ? options.patience_s : software ? kSoftwarePatience_s : kPatience_s;
  vkGetPhysicalDeviceMemoryProperties(physical, &memory);
  Features has, wants;
  vkGetPhysicalDeviceFeatures2(physical, &has.core);
  require_features(has, wants);
  texture_compression_bc = wants.core.features.textureCompressionBC == VK_TRUE;
  draw_indirect_count = wants.v12.drawIndirectCount == VK_TRUE;
  int64_atomics = wants.core.features.shaderInt64 == VK_TRUE && wants.v12.shaderBufferInt64Atomics == VK_TRUE;
  handle = create_device(physical, queue_family, options.swapchain, wants);
  volkLoadDevice(handle);
  vkGetDeviceQueue(handle, queue_family, 0, &queue);
}

Device::~Device() {
  if (handle) vkDestroyDevice(handle, nullptr);
  if (messenger) vkDestroyDebugUtilsMessengerEXT(instance, messenger, nullptr);
  if (instance) vkDestroyInstance(instance, nullptr);
}

VkResult wait_patiently(const Device& device, const std::string& what, const std::function<VkResult(std::uint64_t)>& wait) {
  const VkResult result = wait(static_cast<std::uint64_t>(double{device.patience_s} * 1e9));
  if (result != VK_TIMEOUT) return result;
  std::fprintf(stderr, "coppice-forest: the GPU has not finished %s in %g s: it hangs, or has too much to do\n  device: %s, driver: %s\n%s",
               what.c_str(), static_cast<double>(device.patience_s), device.name.c_str(), device.driver.c_str(),
               device.say_state ? device.say_state().c_str() : "");
  std::fprintf(
      stderr,
      "  --gpu-wait-s waits longer; --path hardware draws without the compute rasteriser; --doctor tries each part of drawing by itself\n");
  std::fflush(nullptr);
  std::_Exit(1);
}

}  // namespace forest
