// The test device itself: a picture survives the round trip, and each of the mistakes the fixture is there to catch is caught.

#include "vulkan_device.h"

#include <cstdint>

#include <gtest/gtest.h>

namespace coppice::test::vulkan_device_test {

class VulkanDeviceTest : public VulkanTest {};

TEST_F(VulkanDeviceTest, ReadsBackWhatWasUploaded) {
  constexpr std::uint32_t kSide = 5;
  for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_UNORM}) {
    Image image(gpu(),
                {kSide, kSide, format, VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_SAMPLED_BIT});
    Buffer upload(gpu(), kSide * kSide * 4, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    auto* bytes = static_cast<std::uint8_t*>(upload.mapped());
    for (std::uint32_t i = 0; i < kSide * kSide * 4; ++i) bytes[i] = static_cast<std::uint8_t>(7 * i);
    submit(gpu(), [&](VkCommandBuffer cmd) {
      change_layout(cmd, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
      const VkBufferImageCopy region{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, .imageExtent = {kSide, kSide, 1}};
      vkCmdCopyBufferToImage(cmd, upload.handle(), image.handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    });
    const auto picture = read_picture(gpu(), image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    const std::uint8_t* pixel = picture.at(3, 2);
    const std::uint8_t* source = bytes + (2 * kSide + 3) * 4;
    const bool bgra = format == VK_FORMAT_B8G8R8A8_UNORM;
    EXPECT_EQ(pixel[0], source[bgra ? 2 : 0]);
    EXPECT_EQ(pixel[1], source[1]);
    EXPECT_EQ(pixel[2], source[bgra ? 0 : 2]);
    EXPECT_EQ(pixel[3], source[3]);
  }
}

TEST_F(VulkanDeviceTest, CoreValidationIsOn) {
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .size = 0,  // VUID-VkBufferCreateInfo-size-00912
                                .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
  VkBuffer buffer = VK_NULL_HANDLE;
  if (vkCreateBuffer(gpu().device, &info, nullptr, &buffer) == VK_SUCCESS) vkDestroyBuffer(gpu().device, buffer, nullptr);
  EXPECT_EQ(validation_messages().size(), 1u);
  clear_validation_messages();
}

TEST_F(VulkanDeviceTest, SynchronizationValidationIsOn) {
  constexpr VkBufferUsageFlags kBoth = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  Buffer first(gpu(), 64, kBoth);
  Buffer second(gpu(), 64, kBoth);
  submit(gpu(), [&](VkCommandBuffer cmd) {
    const VkBufferCopy region{0, 0, 64};
    vkCmdFillBuffer(cmd, first.handle(), 0, 64, 1);
    vkCmdCopyBuffer(cmd, first.handle(), second.handle(), 1, &region);  // reads the fill without a barrier
  });
  ASSERT_FALSE(validation_messages().empty());
  EXPECT_NE(validation_messages().front().find("READ_AFTER_WRITE"), std::string::npos);
  clear_validation_messages();
}

}  // namespace coppice::test::vulkan_device_test
