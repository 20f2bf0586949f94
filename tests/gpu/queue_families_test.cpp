// What a context tells Vulkan where its commands go to queues of several families. Software drivers have one family, so this looks at the
// calls: what is created is shared, barriers name no stage that a queue for compute or for transfers lacks, and the picture stays the same.

#include <set>
#include <vector>

#include "context_fixture.h"
#include "replaced_functions.h"

namespace coppice::test::queue_families_test {

/// What the library has asked for.
struct Asked {
  std::vector<VkSharingMode> modes;                  ///< what buffers and images were created with
  std::vector<std::vector<std::uint32_t>> families;  ///< likewise
  std::set<VkPipelineStageFlags2> stages;            ///< what barriers name
};

Asked& asked() {
  static Asked of_test;
  return of_test;
}

/// Creates it as a device of one family can.
template <auto& real, class Info, class Handle>
VKAPI_ATTR VkResult VKAPI_CALL create_owned(VkDevice device, const Info* info, const VkAllocationCallbacks* allocator, Handle* handle) {
  asked().modes.push_back(info->sharingMode);
  asked().families.emplace_back(info->pQueueFamilyIndices, info->pQueueFamilyIndices + info->queueFamilyIndexCount);
  Info owned = *info;
  owned.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
  owned.queueFamilyIndexCount = 0;
  return real(device, &owned, allocator, handle);
}

VKAPI_ATTR void VKAPI_CALL pipeline_barrier(VkCommandBuffer cmd, const VkDependencyInfo* info) {
  for (std::uint32_t i = 0; i < info->memoryBarrierCount; ++i)
    asked().stages.insert({info->pMemoryBarriers[i].srcStageMask, info->pMemoryBarriers[i].dstStageMask});
  for (std::uint32_t i = 0; i < info->imageMemoryBarrierCount; ++i)
    asked().stages.insert({info->pImageMemoryBarriers[i].srcStageMask, info->pImageMemoryBarriers[i].dstStageMask});
  vkCmdPipelineBarrier2(cmd, info);
}

class QueueFamiliesTest : public ContextTest {
 protected:
  /// A frame of one plant by a context of its own.
  Picture draw(const std::vector<std::uint32_t>& families) {
    asked() = {};
    ContextDesc with = desc();
    with.compute_raster = VK_TRUE;
    replace_functions(with, {replacing("vkCreateBuffer", create_owned<vkCreateBuffer, VkBufferCreateInfo, VkBuffer>),
                             replacing("vkCreateImage", create_owned<vkCreateImage, VkImageCreateInfo, VkImage>),
                             replacing("vkCmdPipelineBarrier2", pipeline_barrier)});
    with.queue_family_count = static_cast<std::uint32_t>(families.size());
    std::ranges::copy(families, with.queue_families);
    create(with);
    add(open_random({.leaf_count = 600, .seed = 4}), placement_at());
    Picture picture = settle(make_view({.width_px = 96}));
    EXPECT_EQ(log_, "");
    destroy();
    return picture;
  }
};

TEST_F(QueueFamiliesTest, OneFamilyOwnsAll) {
  draw({});
  ASSERT_FALSE(asked().modes.empty());
  for (const VkSharingMode mode : asked().modes) EXPECT_EQ(mode, VK_SHARING_MODE_EXCLUSIVE);
  EXPECT_EQ(asked().stages.count(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT), 0u) << "barriers are no wider than they have to be";
}

TEST_F(QueueFamiliesTest, SeveralShareAllAndNoBarrierNamesAStageThatOneLacks) {
  const Picture expected = draw({});
  const std::vector<std::uint32_t> families{0, 5, 2};
  EXPECT_EQ(draw(families).rgba, expected.rgba);
  ASSERT_FALSE(asked().modes.empty());
  for (std::size_t i = 0; i < asked().modes.size(); ++i) {
    EXPECT_EQ(asked().modes[i], VK_SHARING_MODE_CONCURRENT);
    EXPECT_EQ(asked().families[i], families);
  }
  const std::set<VkPipelineStageFlags2> everywhere{VK_PIPELINE_STAGE_2_NONE, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                                   VK_PIPELINE_STAGE_2_HOST_BIT};
  for (const VkPipelineStageFlags2 stages : asked().stages) EXPECT_EQ(everywhere.count(stages), 1u) << stages;
  EXPECT_EQ(asked().stages.count(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT), 1u);
}

}  // namespace coppice::test::queue_families_test
