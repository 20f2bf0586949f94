#pragma once

// Dynamic rendering to attachments that begin white and at a depth of 0.

#include <memory>
#include <span>
#include <vector>

#include "vulkan_device.h"

namespace coppice::test {

/// What was in the images is gone. depth_layout: what `depth` is brought to; colours to COLOR_ATTACHMENT_OPTIMAL
inline void begin_cleared(VkCommandBuffer cmd, std::span<const std::unique_ptr<Image>> colors, const Image& depth,
                          VkImageLayout depth_layout) {
  std::vector<VkRenderingAttachmentInfo> attachments;
  for (const auto& color : colors) {
    change_layout(cmd, *color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    attachments.push_back({.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                           .imageView = color->view(),
                           .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                           .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                           .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                           .clearValue = {.color = {{1.0f, 1.0f, 1.0f, 1.0f}}}});
  }
  change_layout(cmd, depth, VK_IMAGE_LAYOUT_UNDEFINED, depth_layout);
  const VkRenderingAttachmentInfo depth_attachment{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                                   .imageView = depth.view(),
                                                   .imageLayout = depth_layout,
                                                   .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                   .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
  const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = {{0, 0}, {depth.desc().width_px, depth.desc().height_px}},
                                  .layerCount = 1,
                                  .colorAttachmentCount = static_cast<std::uint32_t>(attachments.size()),
                                  .pColorAttachments = attachments.data(),
                                  .pDepthAttachment = &depth_attachment};
  vkCmdBeginRendering(cmd, &rendering);
}

}  // namespace coppice::test
