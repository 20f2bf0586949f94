// Counts of draws that the GPU writes: none is above what its call takes, as Vulkan wants it below the device's maxDrawIndirectCount.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "context_fixture.h"

namespace coppice::test {
namespace draw_count_test {

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

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_function(VkDevice device, const char* name) {
  if (std::string_view(name) == "vkCmdDrawIndexedIndirectCount") return reinterpret_cast<PFN_vkVoidFunction>(draw_counted);
  if (std::string_view(name) == "vkCreateBuffer") return reinterpret_cast<PFN_vkVoidFunction>(create_buffer);
  return vkGetDeviceProcAddr(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_function(VkInstance instance, const char* name) {
  return std::string_view(name) == "vkGetDeviceProcAddr" ? reinterpret_cast<PFN_vkVoidFunction>(device_function)
                                                         : vkGetInstanceProcAddr(instance, name);
}

class DrawCountTest : public ContextTest {};

TEST_F(DrawCountTest, NoneIsAboveWhatItsCallTakes) {
  ContextDesc with = desc();
  with.memory_budget_bytes = 24ull << 20;
  with.get_instance_proc_addr = instance_function;
  create(with);
  const std::string path = temporary_plant({.leaf_count = 9000, .seed = 3, .wood_lod_count = 1, .texture_side = 0}, "draw_count_test");
  const coppice_plant plant = open(path);
  std::filesystem::remove(path);
  coppice_placement placement;
  coppice_placement_init(&placement);
  // 144 clusters each, of which a plant has 19,000: a 64th of the budget.
  const std::vector<coppice_placement> placements(200, placement);
  ASSERT_EQ(coppice_instances_add(context_, plant, placements.data(), sizeof placement, 200, nullptr), COPPICE_OK) << log_;
  Shot view = make_view({.eye_m = {0.0f, 0.3f, 5.0f}, .width_px = 16, .height_px = 16});
  view.lod = COPPICE_LOD_FULL;
  for (int i = 0; i < 400 && (i < 3 || !is_settled(view_)); ++i) pump(view);
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

}  // namespace draw_count_test
}  // namespace coppice::test
