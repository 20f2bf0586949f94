#include "swapchain.h"

#include <algorithm>
#include <limits>

#include "failure.h"
#include "resources.h"
#include "vk_struct.h"

namespace forest {
namespace {

// UNORM: the picture is sRGB-encoded already; an sRGB format would encode it a second time in the blit.
VkSurfaceFormatKHR choose_format(const Device& device, VkSurfaceKHR surface) {
  std::uint32_t count = 0;
  check(vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical, surface, &count, nullptr), "vkGetPhysicalDeviceSurfaceFormatsKHR");
  std::vector<VkSurfaceFormatKHR> formats(count);
  check(vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical, surface, &count, formats.data()), "vkGetPhysicalDeviceSurfaceFormatsKHR");
  const auto fits = [](const VkSurfaceFormatKHR& format) {
    return format.format == VK_FORMAT_B8G8R8A8_UNORM || format.format == VK_FORMAT_R8G8B8A8_UNORM;
  };
  const auto found = std::find_if(formats.begin(), formats.end(), fits);
  if (found == formats.end()) throw Failure("the window offers no 8-bit UNORM format");
  return *found;
}

VkExtent2D choose_extent(const VkSurfaceCapabilitiesKHR& capabilities, VkExtent2D size) {
  if (capabilities.currentExtent.width != std::numeric_limits<std::uint32_t>::max()) return capabilities.currentExtent;
  return {std::clamp(size.width, capabilities.minImageExtent.width, capabilities.maxImageExtent.width),
          std::clamp(size.height, capabilities.minImageExtent.height, capabilities.maxImageExtent.height)};
}

void fetch_images(const Device& device, Swapchain& swapchain) {
  std::uint32_t count = 0;
  check(vkGetSwapchainImagesKHR(device.handle, swapchain.handle, &count, nullptr), "vkGetSwapchainImagesKHR");
  swapchain.images.resize(count);
  check(vkGetSwapchainImagesKHR(device.handle, swapchain.handle, &count, swapchain.images.data()), "vkGetSwapchainImagesKHR");
  for (std::uint32_t i = 0; i < count; ++i) {
    VkSemaphoreCreateInfo info = vk_struct<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
    VkSemaphore semaphore = VK_NULL_HANDLE;
    check(vkCreateSemaphore(device.handle, &info, nullptr, &semaphore), "vkCreateSemaphore");
    swapchain.rendered.emplace_back(device.handle, semaphore, vkDestroySemaphore);
  }
}

}  // namespace

Swapchain create_swapchain(const Device& device, VkSurfaceKHR surface, VkExtent2D size, Swapchain old) {
  VkBool32 supported = VK_FALSE;
  check(vkGetPhysicalDeviceSurfaceSupportKHR(device.physical, device.queue_family, surface, &supported),
        "vkGetPhysicalDeviceSurfaceSupportKHR");
  if (!supported) throw Failure("the Vulkan device cannot present to this window");
  VkSurfaceCapabilitiesKHR capabilities;
  check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device.physical, surface, &capabilities), "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  const VkSurfaceFormatKHR format = choose_format(device, surface);
  Swapchain swapchain;
  swapchain.extent = choose_extent(capabilities, size);
  VkSwapchainCreateInfoKHR info = vk_struct<VkSwapchainCreateInfoKHR>(VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR);
  info.surface = surface;
  info.minImageCount = capabilities.minImageCount + 1;
  if (capabilities.maxImageCount) info.minImageCount = std::min(info.minImageCount, capabilities.maxImageCount);
  info.imageFormat = format.format;
  info.imageColorSpace = format.colorSpace;
  info.imageExtent = swapchain.extent;
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  info.preTransform = capabilities.currentTransform;
  info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
  info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
  info.clipped = VK_TRUE;
  info.oldSwapchain = old.handle;
  VkSwapchainKHR handle = VK_NULL_HANDLE;
  check(vkCreateSwapchainKHR(device.handle, &info, nullptr, &handle), "vkCreateSwapchainKHR");
  swapchain.handle = {device.handle, handle, vkDestroySwapchainKHR};
  fetch_images(device, swapchain);
  return swapchain;
}

VkResult acquire_image(const Device& device, const Swapchain& swapchain, VkSemaphore acquired, std::uint32_t& image_index) {
  constexpr std::uint64_t kSecond_ns = 1'000'000'000;
  const VkResult result = vkAcquireNextImageKHR(device.handle, swapchain.handle, kSecond_ns, acquired, VK_NULL_HANDLE, &image_index);
  if (result != VK_ERROR_OUT_OF_DATE_KHR) check(result, "vkAcquireNextImageKHR");
  return result;
}

bool present_image(const Device& device, const Swapchain& swapchain, std::uint32_t image_index) {
  VkPresentInfoKHR info = vk_struct<VkPresentInfoKHR>(VK_STRUCTURE_TYPE_PRESENT_INFO_KHR);
  info.waitSemaphoreCount = 1;
  info.pWaitSemaphores = swapchain.rendered[image_index].address();
  info.swapchainCount = 1;
  info.pSwapchains = swapchain.handle.address();
  info.pImageIndices = &image_index;
  const VkResult result = vkQueuePresentKHR(device.queue, &info);
  if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR) return false;
  check(result, "vkQueuePresentKHR");
  return true;
}

void record_blit_to_image(VkCommandBuffer commands, const Swapchain& swapchain, std::uint32_t image_index, VkImage picture,
                          VkExtent2D picture_extent) {
  ImageBarrier barrier;
  barrier.image = swapchain.images[image_index];
  barrier.from_stage = VK_PIPELINE_STAGE_2_BLIT_BIT;  // after the wait for `acquired`, which is in the same stage
  barrier.to_stage = VK_PIPELINE_STAGE_2_BLIT_BIT;
  barrier.to_access = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  barrier.to_layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  record_barrier(commands, barrier);
  const auto corner = [](VkExtent2D extent) {
    return VkOffset3D{static_cast<std::int32_t>(extent.width), static_cast<std::int32_t>(extent.height), 1};
  };
  VkImageBlit region{};
  region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.srcOffsets[1] = corner(picture_extent);
  region.dstOffsets[1] = corner(swapchain.extent);
  vkCmdBlitImage(commands, picture, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, barrier.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region,
                 VK_FILTER_LINEAR);
  barrier.from_access = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  barrier.from_layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  barrier.to_stage = VK_PIPELINE_STAGE_2_NONE;
  barrier.to_access = VK_ACCESS_2_NONE;
  barrier.to_layout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
  record_barrier(commands, barrier);
}

}  // namespace forest
