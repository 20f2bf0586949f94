#pragma once

// A headless Vulkan 1.3 device for tests, under core and synchronization validation. One per process, made on first use:
//
//     class CullTest : public coppice::test::VulkanTest {};
//     TEST_F(CullTest, DrawsNothingBehindTheCamera) {
//       submit(gpu(), [&](VkCommandBuffer cmd) { ... });
//     }
//
// Any validation warning or error fails the test it was raised in; one raised when the device is destroyed (a leaked object) fails
// the program. Without a device or the validation layer the test fails and says what to install: it never skips.
// Helpers throw std::runtime_error naming the call and the VkResult, which GoogleTest reports as a failure.

#include <cstddef>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <volk.h>

#include "picture.h"

namespace coppice::test {

/// The first device the loader lists (VK_DRIVER_FILES chooses), with one graphics and compute queue. Global vk* functions are volk's
/// and loaded for this device.
struct VulkanDevice {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  std::string device_name;
  std::string driver_name;               ///< name and version, "llvmpipe Mesa 22.3.6 ..."
  bool occlusion_query_precise = false;  ///< enabled where there is one
  bool texture_compression_bc = false;   ///< enabled where there is one
  bool draw_indirect_count = false;      ///< likewise
  bool int64_atomics = false;            ///< shaderInt64 and shaderBufferInt64Atomics, likewise
  VkPhysicalDeviceMemoryProperties memory{};

  VkCommandPool command_pool = VK_NULL_HANDLE;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;  ///< what a test creates is compiled once a process
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;

  /// The first of the types with a bit in type_bits that has the wanted properties.
  [[nodiscard]] std::uint32_t memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags wanted) const {
    for (std::uint32_t type = 0; type < memory.memoryTypeCount; ++type)
      if ((type_bits >> type & 1u) != 0 && (memory.memoryTypes[type].propertyFlags & wanted) == wanted) return type;
    throw std::runtime_error("no memory type with the wanted properties");
  }
};

enum class Validation { on, off };
/// What the device draws by: classic is without the feature dynamicRendering.
enum class Rendering { dynamic, classic };

/// The process's device, created by the first call, which decides about validation (off: for timing) and features. Destroyed after the last
/// test.
const VulkanDevice& vulkan_device(Validation validation = Validation::on, Rendering rendering = Rendering::dynamic);

/// Validation warnings and errors since the last clear, oldest first. Thread-safe.
std::vector<std::string> validation_messages();
void clear_validation_messages();

/// Fixture: fails the test on any validation message.
class VulkanTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;
  static const VulkanDevice& gpu() { return vulkan_device(); }
};

/// Throws unless result is VK_SUCCESS. call  static text, the function's name
void check_vk(VkResult result, const char* call);

/// Records one command buffer, submits it and waits until the GPU has finished.
void submit(const VulkanDevice& gpu, const std::function<void(VkCommandBuffer)>& record);

/// The same step by step. A command buffer of the pool, recorded; a fence of its submission. The caller waits, and gives both back.
VkCommandBuffer record(const VulkanDevice& gpu, const std::function<void(VkCommandBuffer)>& record);
VkFence submit(const VulkanDevice& gpu, VkCommandBuffer cmd);

/// A memory barrier between everything before and everything after. For tests of something else than barriers.
void full_barrier(VkCommandBuffer cmd);

/// A buffer in mapped, host-coherent memory. Freed by the destructor; the GPU must be done with it.
class Buffer {
 public:
  Buffer(const VulkanDevice& gpu, VkDeviceSize bytes, VkBufferUsageFlags usage);
  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  [[nodiscard]] VkBuffer handle() const { return buffer_; }
  [[nodiscard]] VkDeviceSize bytes() const { return bytes_; }
  [[nodiscard]] void* mapped() const { return mapped_; }
  /// usage: with VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT
  [[nodiscard]] VkDeviceAddress address() const;

 private:
  VkDevice device_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  void* mapped_ = nullptr;
  VkDeviceSize bytes_ = 0;
};

struct ImageDesc {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;  ///< depth formats get a depth view
  VkImageUsageFlags usage = 0;                 ///< more than transfers: the image gets a view
};

/// Attachments that can be sampled and read back.
ImageDesc color_attachment(std::uint32_t width_px, std::uint32_t height_px, VkFormat format = VK_FORMAT_R8G8B8A8_SRGB);
ImageDesc depth_attachment(std::uint32_t width_px, std::uint32_t height_px, VkFormat format = VK_FORMAT_D32_SFLOAT);

/// A 2D image of one level and layer in device memory, with a view of it. Starts in VK_IMAGE_LAYOUT_UNDEFINED.
class Image {
 public:
  Image(const VulkanDevice& gpu, const ImageDesc& desc);
  ~Image();
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;

  [[nodiscard]] VkImage handle() const { return image_; }
  [[nodiscard]] VkImageView view() const { return view_; }
  [[nodiscard]] const ImageDesc& desc() const { return desc_; }
  [[nodiscard]] VkImageAspectFlags aspect() const;
  /// COLOR_ATTACHMENT_OPTIMAL or DEPTH_STENCIL_ATTACHMENT_OPTIMAL.
  [[nodiscard]] VkImageLayout attachment_layout() const;

 private:
  VkDevice device_;
  ImageDesc desc_;
  VkImage image_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE;
};

/// Records a layout change that waits for everything before it and makes everything after it wait.
void change_layout(VkCommandBuffer cmd, const Image& image, VkImageLayout from, VkImageLayout to);

/// What is drawn to. Images that come from VK_IMAGE_LAYOUT_UNDEFINED are cleared; from another layout they keep what they show.
struct Attachments {
  std::vector<const Image*> colors = {};
  const Image* depth = nullptr;  ///< with its stencil, if it has one
  VkImageLayout colors_from = VK_IMAGE_LAYOUT_UNDEFINED, depth_from = VK_IMAGE_LAYOUT_UNDEFINED;
  VkClearColorValue background{{1.0f, 1.0f, 1.0f, 1.0f}};
  VkClearDepthStencilValue farthest{0.0f, 0};  ///< depth is reversed
};

/// Begins dynamic rendering to the whole of the images, which come to their attachment_layout().
void begin_rendering(VkCommandBuffer cmd, const Attachments& attachments);

/// The bytes of an image with usage TRANSFER_SRC, tightly packed. Changes its layout to TRANSFER_SRC_OPTIMAL.
/// layout  that it has; none: its attachment_layout()
/// aspect  of a depth format with stencil; 0: the image's only one
std::vector<std::uint8_t> read_bytes(const VulkanDevice& gpu, const Image& image, std::size_t pixel_bytes,
                                     std::optional<VkImageLayout> layout = {}, VkImageAspectFlags aspect = 0);

/// The same for a format of R8G8B8A8 or B8G8R8A8, UNORM or SRGB. BGRA is swapped to RGBA.
Picture read_picture(const VulkanDevice& gpu, const Image& image, std::optional<VkImageLayout> layout = {});

/// The same for a D32_SFLOAT or R32_SFLOAT image: [height_px * width_px], rows top to bottom.
std::vector<float> read_floats(const VulkanDevice& gpu, const Image& image, std::optional<VkImageLayout> layout = {});

}  // namespace coppice::test
