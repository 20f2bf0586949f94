// Counts of draws that the GPU writes: none is above what its call takes, as Vulkan wants it below the device's maxDrawIndirectCount.

#include <vector>

#include "context_fixture.h"
#include "replaced_functions.h"

namespace coppice::test::draw_count_test {

struct CountedDraw {
  VkBuffer buffer;
  VkDeviceSize offset;
  std::uint32_t most;
};

std::vector<CountedDraw>& counted_draws() {
  static std::vector<CountedDraw> of_test;
  return of_test;
}

VKAPI_ATTR void VKAPI_CALL draw_counted(VkCommandBuffer cmd, VkBuffer commands, VkDeviceSize first, VkBuffer count, VkDeviceSize offset,
                                        std::uint32_t most, std::uint32_t stride) {
  counted_draws().push_back({count, offset, most});
  vkCmdDrawIndexedIndirectCount(cmd, commands, first, count, offset, most, stride);
}

/// So that counts can be copied.
VKAPI_ATTR VkResult VKAPI_CALL create_buffer(VkDevice device, const VkBufferCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                             VkBuffer* buffer) {
  VkBufferCreateInfo with = *info;
  with.usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  return vkCreateBuffer(device, &with, callbacks, buffer);
}

class DrawCountTest : public ContextTest {};

TEST_F(DrawCountTest, NoneIsAboveWhatItsCallTakes) {
  ContextDesc with = desc();
  with.memory_budget_bytes = 24ull << 20;
  replace_functions(with, {replacing("vkCmdDrawIndexedIndirectCount", draw_counted), replacing("vkCreateBuffer", create_buffer)});
  create(with);
  const coppice_plant plant = open_random({.leaf_count = 9000, .seed = 3, .wood_lod_count = 1, .texture_side = 0});
  // 144 clusters each, of which a plant has 19,000: a 64th of the budget.
  add(plant, std::vector(200, placement_at()));
  Shot view = make_view({.eye_m = {0.0f, 0.3f, 5.0f}, .width_px = 16, .lod = COPPICE_LOD_FULL});
  pump_until_settled(view);
  frame(view);
  const std::vector<CountedDraw> draws = counted_draws();
  EXPECT_EQ(draws.empty(), !gpu().draw_indirect_count);
  if (draws.empty()) return;
  Buffer counts(gpu(), draws.size() * sizeof(std::uint32_t), VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  submit(gpu(), [&](VkCommandBuffer cmd) {
    full_barrier(cmd);
    for (std::size_t i = 0; i < draws.size(); ++i) {
      const VkBufferCopy region{draws[i].offset, i * sizeof(std::uint32_t), sizeof(std::uint32_t)};
      vkCmdCopyBuffer(cmd, draws[i].buffer, counts.handle(), 1, &region);
    }
    full_barrier(cmd);
  });
  std::size_t full = 0;
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const std::uint32_t count = static_cast<const std::uint32_t*>(counts.mapped())[i];
    EXPECT_LE(count, draws[i].most);
    full += draws[i].most > 1 && count == draws[i].most;
  }
  EXPECT_EQ(full, 1u) << "commands are short";
}

}  // namespace coppice::test::draw_count_test
