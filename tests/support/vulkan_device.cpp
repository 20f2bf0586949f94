#include "vulkan_device.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <map>
#include <mutex>
#include <utility>

namespace coppice::test {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
constexpr const char* kInstall = " (Debian: third_party/install, or apt-get install mesa-vulkan-drivers vulkan-validationlayers)";

struct MessageLog {
  std::mutex mutex;
  std::vector<std::string> lines;
};

MessageLog& message_log() {
  static MessageLog log;
  return log;
}

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
  MessageLog& log = message_log();
  const std::lock_guard lock(log.mutex);
  log.lines.emplace_back(data->pMessage);
  return VK_FALSE;
}

VkInstance create_instance(Validation validation) {
  if (volkInitialize() != VK_SUCCESS) throw std::runtime_error(std::string("no Vulkan loader") + kInstall);
  const bool on = validation == Validation::on;
  const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  const VkValidationFeaturesEXT features{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                         .enabledValidationFeatureCount = 1,
                                         .pEnabledValidationFeatures = &synchronization};
  const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
  const char* const extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                  .pNext = on ? &features : nullptr,
                                  .pApplicationInfo = &application,
                                  .enabledLayerCount = on ? 1u : 0u,
                                  .ppEnabledLayerNames = &kValidationLayer,
                                  .enabledExtensionCount = 1,
                                  .ppEnabledExtensionNames = &extension};
  VkInstance instance = VK_NULL_HANDLE;
  const VkResult result = vkCreateInstance(&info, nullptr, &instance);
  if (result == VK_ERROR_LAYER_NOT_PRESENT) throw std::runtime_error(std::string("no ") + kValidationLayer + kInstall);
  check_vk(result, "vkCreateInstance");
  volkLoadInstance(instance);
  return instance;
}

/// An explicit messenger: one chained to the instance's create info sees only vkCreateInstance and vkDestroyInstance.
VkDebugUtilsMessengerEXT create_messenger(VkInstance instance) {
  const VkDebugUtilsMessengerCreateInfoEXT info{
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                     VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
      .pfnUserCallback = on_message};
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
  check_vk(vkCreateDebugUtilsMessengerEXT(instance, &info, nullptr, &messenger), "vkCreateDebugUtilsMessengerEXT");
  return messenger;
}

VkPhysicalDevice first_physical_device(VkInstance instance) {
  std::uint32_t count = 0;
  check_vk(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices");
  if (count == 0) throw std::runtime_error(std::string("no Vulkan device") + kInstall);
  std::vector<VkPhysicalDevice> devices(count);
  check_vk(vkEnumeratePhysicalDevices(instance, &count, devices.data()), "vkEnumeratePhysicalDevices");
  return devices.front();
}

std::uint32_t graphics_and_compute_family(VkPhysicalDevice physical_device) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical_device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical_device, &count, families.data());
  constexpr VkQueueFlags kWanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  const auto found = std::ranges::find_if(families, [](const auto& family) { return (family.queueFlags & kWanted) == kWanted; });
  if (found == families.end()) throw std::runtime_error("the device has no queue for graphics and compute");
  return static_cast<std::uint32_t>(std::distance(families.begin(), found));
}

/// What coppice_vulkan_desc::device asks for and no more, so that a feature missing from that list shows under validation.
/// Exceptions: occlusionQueryPrecise for the tests themselves; independentBlend, which COPPICE_CONTENT_NONE asks for; textureCompressionBC,
/// drawIndirectCount and 64-bit atomics, which a context may be told of.
VkDevice create_device(VulkanDevice& gpu, Rendering rendering) {
  VkPhysicalDeviceVulkan12Features available12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceFeatures2 available2{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &available12};
  vkGetPhysicalDeviceFeatures2(gpu.physical_device, &available2);
  const VkPhysicalDeviceFeatures& available = available2.features;
  gpu.int64_atomics = available.shaderInt64 == VK_TRUE && available12.shaderBufferInt64Atomics == VK_TRUE;
  gpu.draw_indirect_count = available12.drawIndirectCount == VK_TRUE;
  gpu.occlusion_query_precise = available.occlusionQueryPrecise == VK_TRUE;
  gpu.texture_compression_bc = available.textureCompressionBC == VK_TRUE;

  VkPhysicalDeviceVulkan13Features features13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  features13.dynamicRendering = rendering == Rendering::dynamic ? VK_TRUE : VK_FALSE;
  features13.synchronization2 = VK_TRUE;
  VkPhysicalDeviceVulkan12Features features12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &features13};
  features12.drawIndirectCount = available12.drawIndirectCount;
  features12.scalarBlockLayout = VK_TRUE;
  features12.bufferDeviceAddress = VK_TRUE;
  features12.shaderBufferInt64Atomics = gpu.int64_atomics ? VK_TRUE : VK_FALSE;
  VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features12};
  features.features.multiDrawIndirect = VK_TRUE;
  features.features.drawIndirectFirstInstance = VK_TRUE;
  features.features.samplerAnisotropy = available.samplerAnisotropy;
  features.features.independentBlend = available.independentBlend;
  features.features.occlusionQueryPrecise = available.occlusionQueryPrecise;
  features.features.textureCompressionBC = available.textureCompressionBC;
  features.features.shaderInt64 = gpu.int64_atomics ? VK_TRUE : VK_FALSE;

  const float priority = 1.0f;
  const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                      .queueFamilyIndex = gpu.queue_family,
                                      .queueCount = 1,
                                      .pQueuePriorities = &priority};
  const VkDeviceCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &features, .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue};
  VkDevice device = VK_NULL_HANDLE;
  check_vk(vkCreateDevice(gpu.physical_device, &info, nullptr, &device), "vkCreateDevice");
  volkLoadDevice(device);
  return device;
}

void name_device(VulkanDevice& gpu) {
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
  vkGetPhysicalDeviceProperties2(gpu.physical_device, &properties);
  gpu.device_name = properties.properties.deviceName;
  gpu.driver_name = std::string(driver.driverName) + " " + driver.driverInfo;
  vkGetPhysicalDeviceMemoryProperties(gpu.physical_device, &gpu.memory);
  std::printf("Vulkan device: %s, driver: %s\n", gpu.device_name.c_str(), gpu.driver_name.c_str());
}

VulkanDevice open_device(Validation validation, Rendering rendering) {
  VulkanDevice gpu;
  gpu.instance = create_instance(validation);
  gpu.messenger = create_messenger(gpu.instance);
  gpu.physical_device = first_physical_device(gpu.instance);
  gpu.queue_family = graphics_and_compute_family(gpu.physical_device);
  name_device(gpu);
  gpu.device = create_device(gpu, rendering);
  vkGetDeviceQueue(gpu.device, gpu.queue_family, 0, &gpu.queue);
  const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                     .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                     .queueFamilyIndex = gpu.queue_family};
  check_vk(vkCreateCommandPool(gpu.device, &pool, nullptr, &gpu.command_pool), "vkCreateCommandPool");
  const VkPipelineCacheCreateInfo cache{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  check_vk(vkCreatePipelineCache(gpu.device, &cache, nullptr, &gpu.pipeline_cache), "vkCreatePipelineCache");
  return gpu;
}

void close_device(VulkanDevice& gpu) {
  vkDestroyPipelineCache(gpu.device, gpu.pipeline_cache, nullptr);
  vkDestroyCommandPool(gpu.device, gpu.command_pool, nullptr);
  vkDestroyDevice(gpu.device, nullptr);
  vkDestroyDebugUtilsMessengerEXT(gpu.instance, gpu.messenger, nullptr);
  vkDestroyInstance(gpu.instance, nullptr);
  gpu = {};
}

VulkanDevice& device_storage() {
  static VulkanDevice gpu;
  return gpu;
}

/// Fails once per distinct message in the log, with how often it came, and empties it.
void expect_no_messages(const char* when) {
  std::map<std::string, std::size_t> times;
  for (const std::string& line : validation_messages()) ++times[line];
  for (const auto& [line, count] : times) ADD_FAILURE() << "Vulkan validation, " << when << ", " << count << " times:\n" << line;
  clear_validation_messages();
}

/// Destroys the device after the last test: objects a test leaked are reported then.
class DeviceEnvironment : public ::testing::Environment {
 public:
  void TearDown() override {
    if (device_storage().device == VK_NULL_HANDLE) return;
    close_device(device_storage());
    expect_no_messages("destroying the device");
  }
};

[[maybe_unused]] const auto* const device_environment = ::testing::AddGlobalTestEnvironment(new DeviceEnvironment);

/// Any buffer may be addressed from a shader.
VkDeviceMemory allocate(const VulkanDevice& gpu, const VkMemoryRequirements& needs, VkMemoryPropertyFlags wanted) {
  const VkMemoryAllocateFlagsInfo flags{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
  const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .pNext = &flags,
                                  .allocationSize = needs.size,
                                  .memoryTypeIndex = gpu.memory_type(needs.memoryTypeBits, wanted)};
  VkDeviceMemory memory = VK_NULL_HANDLE;
  check_vk(vkAllocateMemory(gpu.device, &info, nullptr, &memory), "vkAllocateMemory");
  return memory;
}

}  // namespace

const VulkanDevice& vulkan_device(Validation validation, Rendering rendering) {
  VulkanDevice& gpu = device_storage();
  if (gpu.device == VK_NULL_HANDLE) gpu = open_device(validation, rendering);
  return gpu;
}

std::vector<std::string> validation_messages() {
  MessageLog& log = message_log();
  const std::lock_guard lock(log.mutex);
  return log.lines;
}

void clear_validation_messages() {
  MessageLog& log = message_log();
  const std::lock_guard lock(log.mutex);
  log.lines.clear();
}

void VulkanTest::SetUp() {
  vulkan_device();
  expect_no_messages("creating the device");
}

void VulkanTest::TearDown() {
  expect_no_messages("in this test");
}

void check_vk(VkResult result, const char* call) {
  if (result != VK_SUCCESS) throw std::runtime_error(std::string(call) + " returned VkResult " + std::to_string(result));
}

/// A driver that hangs fails the test with VK_TIMEOUT. Software drivers under sanitizers take minutes.
constexpr std::uint64_t kMostWait_ns = 600'000'000'000;

VkCommandBuffer record(const VulkanDevice& gpu, const std::function<void(VkCommandBuffer)>& record) {
  const VkCommandBufferAllocateInfo allocation{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                               .commandPool = gpu.command_pool,
                                               .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                               .commandBufferCount = 1};
  VkCommandBuffer cmd = VK_NULL_HANDLE;
  check_vk(vkAllocateCommandBuffers(gpu.device, &allocation, &cmd), "vkAllocateCommandBuffers");
  const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                       .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  check_vk(vkBeginCommandBuffer(cmd, &begin), "vkBeginCommandBuffer");
  record(cmd);
  check_vk(vkEndCommandBuffer(cmd), "vkEndCommandBuffer");
  return cmd;
}

VkFence submit(const VulkanDevice& gpu, VkCommandBuffer cmd) {
  const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence fence = VK_NULL_HANDLE;
  check_vk(vkCreateFence(gpu.device, &fence_info, nullptr, &fence), "vkCreateFence");
  const VkCommandBufferSubmitInfo buffer{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, .commandBuffer = cmd};
  const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2, .commandBufferInfoCount = 1, .pCommandBufferInfos = &buffer};
  check_vk(vkQueueSubmit2(gpu.queue, 1, &info, fence), "vkQueueSubmit2");
  return fence;
}

void submit(const VulkanDevice& gpu, const std::function<void(VkCommandBuffer)>& record) {
  const VkCommandBuffer cmd = test::record(gpu, record);
  const VkFence fence = submit(gpu, cmd);
  check_vk(vkWaitForFences(gpu.device, 1, &fence, VK_TRUE, kMostWait_ns), "vkWaitForFences");
  vkDestroyFence(gpu.device, fence, nullptr);
  vkFreeCommandBuffers(gpu.device, gpu.command_pool, 1, &cmd);
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

Buffer::Buffer(const VulkanDevice& gpu, VkDeviceSize bytes, VkBufferUsageFlags usage) : device_(gpu.device), bytes_(bytes) {
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = usage};
  check_vk(vkCreateBuffer(device_, &info, nullptr, &buffer_), "vkCreateBuffer");
  VkMemoryRequirements needs{};
  vkGetBufferMemoryRequirements(device_, buffer_, &needs);
  memory_ = allocate(gpu, needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  check_vk(vkBindBufferMemory(device_, buffer_, memory_, 0), "vkBindBufferMemory");
  check_vk(vkMapMemory(device_, memory_, 0, VK_WHOLE_SIZE, 0, &mapped_), "vkMapMemory");
}

Buffer::~Buffer() {
  vkDestroyBuffer(device_, buffer_, nullptr);
  vkFreeMemory(device_, memory_, nullptr);
}

VkDeviceAddress Buffer::address() const {
  const VkBufferDeviceAddressInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer_};
  return vkGetBufferDeviceAddress(device_, &info);
}

constexpr VkImageUsageFlags kReadable = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;

ImageDesc color_attachment(std::uint32_t width_px, std::uint32_t height_px, VkFormat format) {
  return {width_px, height_px, format, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | kReadable};
}

ImageDesc depth_attachment(std::uint32_t width_px, std::uint32_t height_px, VkFormat format) {
  return {width_px, height_px, format, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | kReadable};
}

Image::Image(const VulkanDevice& gpu, const ImageDesc& desc) : device_(gpu.device), desc_(desc) {
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = desc.format,
                               .extent = {desc.width_px, desc.height_px, 1},
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .usage = desc.usage};
  check_vk(vkCreateImage(device_, &info, nullptr, &image_), "vkCreateImage");
  VkMemoryRequirements needs{};
  vkGetImageMemoryRequirements(device_, image_, &needs);
  memory_ = allocate(gpu, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  check_vk(vkBindImageMemory(device_, image_, memory_, 0), "vkBindImageMemory");
  const VkImageViewCreateInfo view{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   .image = image_,
                                   .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                   .format = desc.format,
                                   .subresourceRange = {aspect(), 0, 1, 0, 1}};
  check_vk(vkCreateImageView(device_, &view, nullptr, &view_), "vkCreateImageView");
}

Image::~Image() {
  vkDestroyImageView(device_, view_, nullptr);
  vkDestroyImage(device_, image_, nullptr);
  vkFreeMemory(device_, memory_, nullptr);
}

VkImageAspectFlags Image::aspect() const {
  if (desc_.format == VK_FORMAT_D32_SFLOAT_S8_UINT) return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
  const bool depth = desc_.format == VK_FORMAT_D32_SFLOAT || desc_.format == VK_FORMAT_D16_UNORM;
  return depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

VkImageLayout Image::attachment_layout() const {
  return aspect() == VK_IMAGE_ASPECT_COLOR_BIT ? VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL
                                               : VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
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
                                      .image = image.handle(),
                                      .subresourceRange = {image.aspect(), 0, 1, 0, 1}};
  const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
  vkCmdPipelineBarrier2(cmd, &info);
}

void begin_rendering(VkCommandBuffer cmd, const Attachments& attachments) {
  const auto attach = [&](const Image& image, VkImageLayout from, const VkClearValue& clear) {
    change_layout(cmd, image, from, image.attachment_layout());
    return VkRenderingAttachmentInfo{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                     .imageView = image.view(),
                                     .imageLayout = image.attachment_layout(),
                                     .loadOp = from == VK_IMAGE_LAYOUT_UNDEFINED ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD,
                                     .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                     .clearValue = clear};
  };
  std::vector<VkRenderingAttachmentInfo> colors;
  for (const Image* color : attachments.colors)
    colors.push_back(attach(*color, attachments.colors_from, {.color = attachments.background}));
  const Image& image = *attachments.depth;
  const VkRenderingAttachmentInfo depth = attach(image, attachments.depth_from, {.depthStencil = attachments.farthest});
  const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = {{0, 0}, {image.desc().width_px, image.desc().height_px}},
                                  .layerCount = 1,
                                  .colorAttachmentCount = static_cast<std::uint32_t>(colors.size()),
                                  .pColorAttachments = colors.data(),
                                  .pDepthAttachment = &depth,
                                  .pStencilAttachment = (image.aspect() & VK_IMAGE_ASPECT_STENCIL_BIT) != 0 ? &depth : nullptr};
  vkCmdBeginRendering(cmd, &rendering);
}

std::vector<std::uint8_t> read_bytes(const VulkanDevice& gpu, const Image& image, std::size_t pixel_bytes,
                                     std::optional<VkImageLayout> layout, VkImageAspectFlags aspect) {
  const ImageDesc& desc = image.desc();
  const Buffer copy(gpu, VkDeviceSize{desc.width_px} * desc.height_px * pixel_bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  submit(gpu, [&](VkCommandBuffer cmd) {
    change_layout(cmd, image, layout.value_or(image.attachment_layout()), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    const VkBufferImageCopy region{.imageSubresource = {aspect != 0 ? aspect : image.aspect(), 0, 0, 1},
                                   .imageExtent = {desc.width_px, desc.height_px, 1}};
    vkCmdCopyImageToBuffer(cmd, image.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, copy.handle(), 1, &region);
    full_barrier(cmd);
  });
  const auto* bytes = static_cast<const std::uint8_t*>(copy.mapped());
  return {bytes, bytes + copy.bytes()};
}

Picture read_picture(const VulkanDevice& gpu, const Image& image, std::optional<VkImageLayout> layout) {
  const ImageDesc& desc = image.desc();
  const bool bgra = desc.format == VK_FORMAT_B8G8R8A8_UNORM || desc.format == VK_FORMAT_B8G8R8A8_SRGB;
  const bool rgba = desc.format == VK_FORMAT_R8G8B8A8_UNORM || desc.format == VK_FORMAT_R8G8B8A8_SRGB;
  if (!bgra && !rgba) throw std::runtime_error("read_picture: VkFormat " + std::to_string(desc.format) + " is not 8-bit RGBA or BGRA");
  Picture picture{desc.width_px, desc.height_px, read_bytes(gpu, image, 4, layout)};
  if (bgra) {
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4) std::swap(picture.rgba[i], picture.rgba[i + 2]);
  }
  return picture;
}

std::vector<float> read_floats(const VulkanDevice& gpu, const Image& image, std::optional<VkImageLayout> layout) {
  if (image.desc().format != VK_FORMAT_D32_SFLOAT && image.desc().format != VK_FORMAT_R32_SFLOAT)
    throw std::runtime_error("read_floats: the format is neither D32_SFLOAT nor R32_SFLOAT");
  const std::vector<std::uint8_t> bytes = read_bytes(gpu, image, sizeof(float), layout);
  std::vector<float> floats(bytes.size() / sizeof(float));
  std::memcpy(floats.data(), bytes.data(), bytes.size());
  return floats;
}

}  // namespace coppice::test
