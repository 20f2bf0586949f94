// The staging ring: what the GPU may still read is not written again, and a copy that was taken back is not recorded.

#include "uploads.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "deferred_deletion.h"
#include "hooks.h"
#include "vulkan_device.h"

namespace coppice::gpu {
namespace uploads_test {

constexpr std::uint64_t kPartBytes = 1ull << 20, kMostParts = 20;

class UploadsTest : public test::VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    ASSERT_TRUE(uploads_.create());
    constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    target_ = *create_buffer(device_, {"target", kMostParts * kPartBytes, kUsage, MemoryKind::host});
  }
  void TearDown() override {
    destroy_buffer(device_, target_);
    VulkanTest::TearDown();
  }
  static Device open() {
    const test::VulkanDevice& gpu = test::vulkan_device();  // loads vkGetInstanceProcAddr
    return *open_device(gpu.instance, gpu.physical_device, gpu.device, vkGetInstanceProcAddr);
  }
  void begin_frame(std::uint64_t frame, std::uint64_t completed) {
    deletion_.begin_frame(frame, completed);
    uploads_.begin_frame(frame, completed);
  }
  std::uint8_t* stage() {
    const auto place = uploads_.copy(kPartBytes, target_, kPartBytes * parts_++);
    EXPECT_TRUE(place);
    return place ? *place : nullptr;
  }
  void record() {
    test::submit(test::vulkan_device(), [&](VkCommandBuffer cmd) {
      uploads_.record(cmd);
      test::full_barrier(cmd);
    });
  }

  Device device_ = open();
  OpenMemory memory_{device_};
  DeferredDeletion deletion_{device_};
  Uploads uploads_{device_, deletion_, default_allocator()};
  Buffer target_;
  std::uint64_t parts_ = 0;
};

TEST_F(UploadsTest, MemoryIsWrittenAgainOnceTheGpuHasFinishedTheFrame) {
  begin_frame(1, 0);
  std::vector<std::uint8_t*> used{stage(), stage()};
  begin_frame(2, 0);
  used.push_back(stage());
  const auto is_used = [&](std::uint8_t* place) { return std::ranges::find(used, place) != used.end(); };
  // More than the ring holds: the rest has buffers of its own.
  for (int i = 0; i < 12; ++i) EXPECT_FALSE(is_used(stage())) << "the GPU has finished no frame";
  begin_frame(3, 1);
  EXPECT_EQ(stage(), used[0]);
  EXPECT_EQ(stage(), used[1]);
  EXPECT_FALSE(is_used(stage())) << "frame 2 goes on";
  record();
  begin_frame(4, 3);
  EXPECT_GE(uploads_.room_bytes(), Uploads::kSliceBytes);
}

TEST_F(UploadsTest, WhatWasTakenBackIsNotCopied) {
  std::memset(target_.mapped, 7, 4);
  begin_frame(1, 0);
  const std::array<std::uint8_t, 4> first{1, 1, 1, 1}, second{2, 2, 2, 2};
  ASSERT_TRUE(uploads_.copy(first, target_, 0));
  const Uploads::Mark mark = uploads_.mark();
  ASSERT_TRUE(uploads_.copy(second, target_, 0));
  ASSERT_TRUE(uploads_.patch(second, target_, 4));
  uploads_.undo(mark);
  record();
  EXPECT_EQ(std::memcmp(target_.mapped, first.data(), first.size()), 0);
  EXPECT_NE(std::memcmp(target_.mapped + 4, second.data(), second.size()), 0);
}

// Moves, copies, patches: each may overwrite what the one before wrote.
TEST_F(UploadsTest, CopiesAreMadeInTheirOrder) {
  constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  Buffer smaller = *create_buffer(device_, {"smaller", 16, kUsage, MemoryKind::host});
  std::memset(smaller.mapped, 1, 16);
  begin_frame(1, 0);
  const std::array<std::uint8_t, 4> copied{2, 2, 2, 2}, patched{3, 3, 3, 3};
  ASSERT_TRUE(uploads_.patch(patched, target_, 8));
  ASSERT_TRUE(uploads_.copy(copied, target_, 4));
  ASSERT_TRUE(uploads_.copy(copied, target_, 8));
  uploads_.move(smaller, target_);
  record();
  const std::vector<std::uint8_t> bytes(target_.mapped, target_.mapped + 12);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3}));
  destroy_buffer(device_, smaller);
}

}  // namespace uploads_test
}  // namespace coppice::gpu
