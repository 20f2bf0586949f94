#pragma once

#include "device.h"
#include "pipelines.h"
#include "result.h"

namespace coppice::gpu {

/// True if nearer points have larger depth.
constexpr bool is_reversed(VkCompareOp compare) {
  return compare == VK_COMPARE_OP_GREATER || compare == VK_COMPARE_OP_GREATER_OR_EQUAL;
}

/// True for the attachments of a shadow view.
constexpr bool is_depth_alone(const AttachmentDesc& attachments) {
  return attachments.color_count == 0;
}

/// Packs contents for kContents of surface.glsl.
std::uint32_t packed_contents(const AttachmentDesc& attachments);

bool has_content(const AttachmentDesc& attachments, coppice_content content);

/// Checks that pipelines for these attachments can work, by field of coppice_vulkan_view_desc.
/// errors  invalid_argument: an integer colour format, a depth format without depth; unsupported: this device cannot draw to it
Result<void> check_attachments(const Device& device, const AttachmentDesc& attachments);

}  // namespace coppice::gpu
