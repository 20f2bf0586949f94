#include "area_device.h"

#include <optional>
#include <vector>

namespace coppice::bake {
namespace {

constexpr const char* kNoDriver =
    "--areas vulkan needs a Vulkan driver, and none is installed: install one (Debian: apt-get install mesa-vulkan-drivers), or leave out "
    "--areas";

Result<void> create_instance(AreaDevice& gpu) {
  // volk knows the loader's name on each system.
  if (volkInitialize() != VK_SUCCESS)
    return Error{Status::unsupported,
                 "--areas vulkan needs Vulkan, and no Vulkan loader is installed: install a Vulkan driver (Debian: apt-get install "
                 "mesa-vulkan-drivers), or leave out --areas"};
  const VkApplicationInfo application{
      .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "coppice", .apiVersion = VK_API_VERSION_1_3};
  const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
  const VkResult result = vkCreateInstance(&info, nullptr, &gpu.instance);
  // A loader without any driver returns these.
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER || result == VK_ERROR_INITIALIZATION_FAILED) return Error{Status::unsupported, kNoDriver};
  COPPICE_CHECK(check_vulkan(result, "vkCreateInstance"));
  volkLoadInstanceOnly(gpu.instance);
  return {};
}

std::optional<std::uint32_t> graphics_family(VkPhysicalDevice physical_device) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical_device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical_device, &count, families.data());
  for (std::uint32_t i = 0; i < count; ++i)
    if ((families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0) return i;
  return {};
}

/// Names a feature that areas need and the device lacks; null if it has all.
const char* missing_feature(VkPhysicalDevice physical_device) {
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  vkGetPhysicalDeviceProperties2(physical_device, &properties);
  if (properties.properties.apiVersion < VK_API_VERSION_1_3) return "Vulkan 1.3";
  VkPhysicalDeviceVulkan13Features features13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceVulkan12Features features12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &features13};
  VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features12};
  vkGetPhysicalDeviceFeatures2(physical_device, &features);
  if (features.features.occlusionQueryPrecise == VK_FALSE) return "precise occlusion queries (occlusionQueryPrecise)";
  if (features12.bufferDeviceAddress == VK_FALSE) return "bufferDeviceAddress";
  if (features13.dynamicRendering == VK_FALSE || features13.synchronization2 == VK_FALSE) return "dynamicRendering and synchronization2";
  VkFormatProperties depth{};
  vkGetPhysicalDeviceFormatProperties(physical_device, VK_FORMAT_D32_SFLOAT, &depth);
  if ((depth.optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT) == 0) return "depth buffers of 32 bits (D32_SFLOAT)";
  if (!graphics_family(physical_device)) return "a graphics queue";
  return nullptr;
}

std::string device_name(VkPhysicalDevice physical_device) {
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
  vkGetPhysicalDeviceProperties2(physical_device, &properties);
  return std::string(properties.properties.deviceName) + ", " + driver.driverName + " " + driver.driverInfo + " (" +
         std::to_string(properties.properties.driverVersion) + ")";
}

Result<void> choose_physical_device(AreaDevice& gpu) {
  std::uint32_t count = 0;
  COPPICE_CHECK(check_vulkan(vkEnumeratePhysicalDevices(gpu.instance, &count, nullptr), "vkEnumeratePhysicalDevices"));
  if (count == 0) return Error{Status::unsupported, kNoDriver};
  std::vector<VkPhysicalDevice> devices(count);
  COPPICE_CHECK(check_vulkan(vkEnumeratePhysicalDevices(gpu.instance, &count, devices.data()), "vkEnumeratePhysicalDevices"));
  std::string lacking;
  for (const VkPhysicalDevice device : devices) {
    const char* missing = missing_feature(device);
    gpu.physical_device = device;
    if (missing == nullptr) return {};
    lacking = device_name(device) + " has no " + missing;
  }
  return Error{Status::unsupported, "--areas vulkan cannot use the Vulkan driver; update it, or leave out --areas", Error::kNoOffset,
               lacking};
}

Result<void> create_device(AreaDevice& gpu) {
  VkPhysicalDeviceVulkan13Features features13{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, .synchronization2 = VK_TRUE, .dynamicRendering = VK_TRUE};
  VkPhysicalDeviceVulkan12Features features12{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &features13, .bufferDeviceAddress = VK_TRUE};
  const VkPhysicalDeviceFeatures2 features{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &features12, .features = {.occlusionQueryPrecise = VK_TRUE}};
  gpu.queue_family = *graphics_family(gpu.physical_device);
  const float priority = 1.0f;
  const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                      .queueFamilyIndex = gpu.queue_family,
                                      .queueCount = 1,
                                      .pQueuePriorities = &priority};
  const VkDeviceCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &features, .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue};
  COPPICE_CHECK(check_vulkan(vkCreateDevice(gpu.physical_device, &info, nullptr, &gpu.device), "vkCreateDevice"));
  volkLoadDeviceTable(&gpu.vk, gpu.device);
  gpu.vk.vkGetDeviceQueue(gpu.device, gpu.queue_family, 0, &gpu.queue);
  return {};
}

void describe(AreaDevice& gpu) {
  gpu.name = device_name(gpu.physical_device);
  vkGetPhysicalDeviceMemoryProperties(gpu.physical_device, &gpu.memory);
}

}  // namespace

AreaDevice::~AreaDevice() {
  if (!owned) return;
  if (device != VK_NULL_HANDLE) vk.vkDestroyDevice(device, nullptr);
  if (instance != VK_NULL_HANDLE) vkDestroyInstance(instance, nullptr);
}

Result<std::unique_ptr<AreaDevice>> open_area_device() {
  auto gpu = std::make_unique<AreaDevice>();
  gpu->owned = true;
  COPPICE_CHECK(create_instance(*gpu));
  COPPICE_CHECK(choose_physical_device(*gpu));
  COPPICE_CHECK(create_device(*gpu));
  describe(*gpu);
  return {std::move(gpu)};
}

std::unique_ptr<AreaDevice> borrow_area_device(const DeviceHandles& borrowed) {
  auto gpu = std::make_unique<AreaDevice>();
  static_cast<DeviceHandles&>(*gpu) = borrowed;
  volkLoadDeviceTable(&gpu->vk, gpu->device);
  describe(*gpu);
  return gpu;
}

Result<void> check_vulkan(VkResult result, const char* call) {
  switch (result) {
    case VK_SUCCESS:
      return {};
    case VK_TIMEOUT:
      return Error{Status::device_lost, "the Vulkan device hangs while it measures areas", Error::kNoOffset, call};
    case VK_ERROR_DEVICE_LOST:
      return Error{Status::device_lost, "the Vulkan device was lost while it measured areas", Error::kNoOffset, call};
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return Error{Status::out_of_memory, "the Vulkan device has not enough memory to measure areas", Error::kNoOffset, call};
    default:
      return Error{Status::internal, "Vulkan failed", Error::kNoOffset, std::string(call) + " returned VkResult " + std::to_string(result)};
  }
}

}  // namespace coppice::bake
