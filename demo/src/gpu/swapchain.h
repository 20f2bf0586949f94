#pragma once

#include <cstdint>
#include <vector>

#include "device.h"
#include "handle.h"

namespace forest {

/// The window's images. The finished picture is blitted into one of them, so they are transfer destinations only.
struct Swapchain {
  Handle<VkSwapchainKHR> handle;
  VkExtent2D extent = {};
  std::vector<VkImage> images;
  std::vector<Handle<VkSemaphore>> rendered;  ///< per image: the blit is done, it may be shown
};

inline bool same_size(VkExtent2D a, VkExtent2D b) {
  return a.width == b.width && a.height == b.height;
}

/// size  the framebuffer's, used where the surface leaves the choice. The GPU must not use the images of `old` any more.
/// errors  Failure: the queue cannot present to the surface, or it offers no 8-bit UNORM format
Swapchain create_swapchain(const Device& device, VkSurfaceKHR surface, VkExtent2D size, Swapchain old);
/// The next image, with VK_SUCCESS or VK_SUBOPTIMAL_KHR. VK_ERROR_OUT_OF_DATE_KHR: the swapchain no longer fits the window and must be
/// created anew; VK_TIMEOUT: there was none for a second.
VkResult acquire_image(const Device& device, const Swapchain& swapchain, VkSemaphore acquired, std::uint32_t& image_index);
/// False when the swapchain no longer fits the window.
bool present_image(const Device& device, const Swapchain& swapchain, std::uint32_t image_index);
/// Copies `picture`, which is in TRANSFER_SRC layout, to the image, scaled to its size, and leaves it ready to present.
void record_blit_to_image(VkCommandBuffer commands, const Swapchain& swapchain, std::uint32_t image_index, VkImage picture,
                          VkExtent2D picture_extent);

}  // namespace forest
