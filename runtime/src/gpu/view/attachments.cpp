// Compares the engine's description of its attachments with what pipelines and the device can draw to.

#include <algorithm>
#include <span>
#include <string>

#include "attachments.h"
#include "coppice_shared.h"

namespace coppice::gpu {
namespace {

/// Fragment shaders write floats, which an integer attachment cannot hold.
bool is_integer(VkFormat format) {
  switch (format) {
#define COPPICE_INTEGERS(name)  \
  case VK_FORMAT_##name##_UINT: \
  case VK_FORMAT_##name##_SINT:
#define COPPICE_PACKED_INTEGERS(name)  \
  case VK_FORMAT_##name##_UINT_PACK32: \
  case VK_FORMAT_##name##_SINT_PACK32:
    COPPICE_INTEGERS(R8)
    COPPICE_INTEGERS(R8G8)
    COPPICE_INTEGERS(R8G8B8)
    COPPICE_INTEGERS(B8G8R8)
    COPPICE_INTEGERS(R8G8B8A8)
    COPPICE_INTEGERS(B8G8R8A8)
    COPPICE_PACKED_INTEGERS(A8B8G8R8)
    COPPICE_PACKED_INTEGERS(A2R10G10B10)
    COPPICE_PACKED_INTEGERS(A2B10G10R10)
    COPPICE_INTEGERS(R16)
    COPPICE_INTEGERS(R16G16)
    COPPICE_INTEGERS(R16G16B16)
    COPPICE_INTEGERS(R16G16B16A16)
    COPPICE_INTEGERS(R32)
    COPPICE_INTEGERS(R32G32)
    COPPICE_INTEGERS(R32G32B32)
    COPPICE_INTEGERS(R32G32B32A32)
    COPPICE_INTEGERS(R64)
    COPPICE_INTEGERS(R64G64)
    COPPICE_INTEGERS(R64G64B64)
    COPPICE_INTEGERS(R64G64B64A64)
#undef COPPICE_INTEGERS
#undef COPPICE_PACKED_INTEGERS
    return true;
    default:
      return false;
  }
}

bool has_stencil(VkFormat format) {
  return format == VK_FORMAT_D16_UNORM_S8_UINT || format == VK_FORMAT_D24_UNORM_S8_UINT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
}

bool has_depth(VkFormat format) {
  return format == VK_FORMAT_D16_UNORM || format == VK_FORMAT_X8_D24_UNORM_PACK32 || format == VK_FORMAT_D32_SFLOAT || has_stencil(format);
}

std::string number(VkFormat format) {
  return "VkFormat " + std::to_string(format);
}

bool has_feature(const Device& device, VkFormat format, VkFormatFeatureFlags feature) {
  VkFormatProperties properties{};
  device.vk.vkGetPhysicalDeviceFormatProperties(device.physical_device, format, &properties);
  return (properties.optimalTilingFeatures & feature) != 0;
}

Result<void> check_depth(const Device& device, VkFormat format, const char* no_depth, const char* unsupported) {
  if (!has_depth(format)) return Error{Status::invalid_argument, no_depth, Error::kNoOffset, number(format)};
  if (!has_feature(device, format, VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT))
    return Error{Status::unsupported, unsupported, Error::kNoOffset, number(format)};
  return {};
}

Result<void> check_color(const Device& device, const AttachmentDesc& attachments, std::uint32_t i) {
  const VkFormat color = attachments.color_formats[i];
  const auto wrong = [&](Status status, const char* what) {
    return Error{status, "a colour attachment", Error::kNoOffset,
                 "vulkan.color_formats[" + std::to_string(i) + "], " + number(color) + ", is " + what};
  };
  if (attachments.contents[i] != COPPICE_CONTENT_NONE && is_integer(color))
    return wrong(Status::invalid_argument, "an integer format, and contents are floats");
  if (has_depth(color) || color == VK_FORMAT_S8_UINT) return wrong(Status::invalid_argument, "a format of depth or stencil");
  if (!has_feature(device, color, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT))
    return wrong(Status::unsupported, "none that this device draws colour to");
  return {};
}

}  // namespace

static_assert(kContentLit == COPPICE_CONTENT_LIT && kContentAlbedo == COPPICE_CONTENT_ALBEDO);
static_assert(kContentNormal == COPPICE_CONTENT_NORMAL && kContentLight == COPPICE_CONTENT_LIGHT);
static_assert(kContentUser == COPPICE_CONTENT_USER && kContentVelocity == COPPICE_CONTENT_VELOCITY);

std::uint32_t packed_contents(const AttachmentDesc& attachments) {
  std::uint32_t packed = 0;
  for (std::uint32_t i = 0; i < attachments.color_count; ++i)
    packed |= static_cast<std::uint32_t>(attachments.contents[i]) << (kContentBits * i);
  return packed;
}

bool has_content(const AttachmentDesc& attachments, coppice_content content) {
  return std::ranges::count(std::span(attachments.contents).first(attachments.color_count), content) > 0;
}

Result<void> check_attachments(const Device& device, const AttachmentDesc& attachments) {
  if (attachments.color_count > device.max_colors)
    return Error{Status::unsupported, "more colour attachments than this device draws to", Error::kNoOffset,
                 "vulkan.color_formats[" + std::to_string(device.max_colors) + "]"};
  for (std::uint32_t i = 0; i < attachments.color_count; ++i) COPPICE_CHECK(check_color(device, attachments, i));
  const std::span contents = std::span(attachments.contents).first(attachments.color_count);
  const auto none = std::ranges::count(contents, COPPICE_CONTENT_NONE);
  if (none != 0 && none != std::ssize(contents) && !optional_features(device).independent_blend)
    return Error{Status::unsupported, "vulkan.contents has COPPICE_CONTENT_NONE beside others, and the device lacks independentBlend"};
  COPPICE_CHECK(check_depth(device, attachments.depth_format, "vulkan.depth_format is not a format of depth",
                            "vulkan.depth_format is none that this device draws depth to"));
  if (attachments.has_stencil && !has_stencil(attachments.depth_format))
    return Error{Status::invalid_argument, "vulkan.has_stencil is VK_TRUE, and depth_format is a format without stencil", Error::kNoOffset,
                 number(attachments.depth_format)};
  if ((device.sample_counts & static_cast<VkSampleCountFlags>(attachments.samples)) == 0)
    return Error{Status::unsupported, "vulkan.samples is more than this device draws colour and depth with", Error::kNoOffset,
                 std::to_string(attachments.samples)};
  return {};
}

}  // namespace coppice::gpu
