// limits_layer itself: what it reports, what it refuses, and that bytes of memory that is not coherent go nowhere by themselves. The
// device is vulkan_minimum's, whose memory types are 0: of the device; 1: visible and cached, not coherent; 2: visible and coherent.

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "device_environment.h"
#include "device_rows.h"
#include "mentions.h"
#include "vulkan_device.h"

namespace coppice::test::limits_layer_test {

constexpr std::uint32_t kOfDevice = 0, kNotCoherent = 1, kCoherent = 2;
constexpr std::uint8_t kFill = 0xcd;

/// The device that this program's cases share, without validation, which would report what the layer is here to refuse.
const VulkanDevice& gpu() {
  static const VulkanDevice& device = []() -> const VulkanDevice& {
    static std::vector<std::string> variables =
        environment_of_device("vulkan_minimum", {"COPPICE_TEST_FILL=0xCD", "COPPICE_TEST_LATE=1", "COPPICE_TEST_REVERSE=1"});
    variables.emplace_back("VK_INSTANCE_LAYERS=VK_LAYER_COPPICE_limits");
    for (std::string& variable : variables) ::putenv(variable.data());
    return vulkan_device(Validation::off);
  }();
  return device;
}

/// What a call prints on standard error.
std::string printed_by(const std::function<void()>& call) {
  testing::internal::CaptureStderr();
  call();
  return testing::internal::GetCapturedStderr();
}

struct Memory {
  VkDeviceMemory handle = VK_NULL_HANDLE;
  VkResult result = VK_SUCCESS;
  Memory(VkDeviceSize bytes, std::uint32_t type) {
    const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = bytes, .memoryTypeIndex = type};
    result = vkAllocateMemory(gpu().device, &info, nullptr, &handle);
  }
  ~Memory() {
    if (result == VK_SUCCESS) vkFreeMemory(gpu().device, handle, nullptr);
  }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  [[nodiscard]] std::uint8_t* map() const {
    void* data = nullptr;
    check_vk(vkMapMemory(gpu().device, handle, 0, VK_WHOLE_SIZE, 0, &data), "vkMapMemory");
    return static_cast<std::uint8_t*>(data);
  }
  [[nodiscard]] VkMappedMemoryRange range(VkDeviceSize offset, VkDeviceSize bytes) const {
    return {VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE, nullptr, handle, offset, bytes};
  }
};

VkBuffer buffer_of(VkDeviceSize bytes, VkBufferUsageFlags usage) {
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = usage};
  VkBuffer buffer = VK_NULL_HANDLE;
  check_vk(vkCreateBuffer(gpu().device, &info, nullptr, &buffer), "vkCreateBuffer");
  return buffer;
}

TEST(DeviceRows, HaveNamesOfTheirOwnAndWholeTables) {
  std::set<std::string> names;
  for (const DeviceRow& row : device_rows()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(row.types.empty(), row.heaps.empty()) << row.name;
    bool coherent = row.types.empty();  // Vulkan promises a type that is visible and coherent, for every buffer
    for (std::uint32_t i = 0; i < row.types.size(); ++i) {
      EXPECT_LT(row.types[i].heapIndex, row.heaps.size()) << row.name;
      constexpr VkMemoryPropertyFlags kMapped = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
      coherent = coherent || ((row.types[i].propertyFlags & kMapped) == kMapped && (row.buffer_types >> i & 1u) != 0);
    }
    EXPECT_TRUE(coherent) << row.name;
  }
  EXPECT_GE(names.size(), 13u);
}

class LimitsLayer : public testing::Test {
 protected:
  static void SetUpTestSuite() { gpu(); }  // volk's pointers are there from now on
};

TEST_F(LimitsLayer, ReportsTheRow) {
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroup};
  vkGetPhysicalDeviceProperties2(gpu().physical_device, &properties);
  const VkPhysicalDeviceLimits& limits = properties.properties.limits;
  EXPECT_EQ(limits.maxTexelBufferElements, 65536u);
  EXPECT_EQ(limits.bufferImageGranularity, 131072u);
  EXPECT_EQ(limits.nonCoherentAtomSize, 256u);
  EXPECT_EQ(subgroup.subgroupSize, 4u);
  EXPECT_EQ(properties.properties.deviceType, VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU);
  EXPECT_EQ(gpu().memory.memoryTypeCount, 3u);
  EXPECT_FALSE(gpu().draw_indirect_count);
  EXPECT_FALSE(gpu().int64_atomics);
}

TEST_F(LimitsLayer, RefusesAMissingFeature) {
  const VkPhysicalDeviceVulkan12Features features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                                  .drawIndirectCount = VK_TRUE};
  const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &features};
  VkDevice device = VK_NULL_HANDLE;
  VkResult result = VK_SUCCESS;
  EXPECT_TRUE(mentions(printed_by([&] { result = vkCreateDevice(gpu().physical_device, &info, nullptr, &device); }),
                       {"limits_layer refuses", "vulkan_minimum", "drawIndirectCount"}));
  EXPECT_EQ(result, VK_ERROR_FEATURE_NOT_PRESENT);
  clear_validation_messages();  // the loader's, that there is no device
}

TEST_F(LimitsLayer, RefusesWhatIsBeyondTheLimits) {
  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, 132};
  const VkPipelineLayoutCreateInfo layout_info{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .pushConstantRangeCount = 1, .pPushConstantRanges = &range};
  VkPipelineLayout layout = VK_NULL_HANDLE;
  EXPECT_TRUE(mentions(printed_by([&] { EXPECT_NE(vkCreatePipelineLayout(gpu().device, &layout_info, nullptr, &layout), VK_SUCCESS); }),
                       {"push constants", "132", "128"}));

  VkBuffer texels = buffer_of(65537 * 4, VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT);
  const VkBufferViewCreateInfo view_info{
      .sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, .buffer = texels, .format = VK_FORMAT_R32_UINT, .range = VK_WHOLE_SIZE};
  VkBufferView view = VK_NULL_HANDLE;
  EXPECT_TRUE(mentions(printed_by([&] { EXPECT_NE(vkCreateBufferView(gpu().device, &view_info, nullptr, &view), VK_SUCCESS); }),
                       {"texel buffer", "65537", "65536"}));
  vkDestroyBuffer(gpu().device, texels, nullptr);

  EXPECT_TRUE(
      mentions(printed_by([] { submit(gpu(), [](VkCommandBuffer cmd) { vkCmdDispatch(cmd, 1, 65536, 1); }); }), {"groups in y", "65536"}));
}

TEST_F(LimitsLayer, RefusesWhatAHeapDoesNotHold) {
  constexpr VkDeviceSize kBytes = 160ull << 20;  // the heap has 256 MiB
  EXPECT_TRUE(
      mentions(printed_by([] { EXPECT_EQ(Memory((1ull << 30) + 1, kOfDevice).result, VK_ERROR_OUT_OF_DEVICE_MEMORY); }), {"allocation"}));
  EXPECT_EQ(Memory(kBytes, kCoherent).result, VK_SUCCESS) << "which is freed again";
  const Memory first(kBytes, kCoherent);
  EXPECT_EQ(first.result, VK_SUCCESS);
  EXPECT_TRUE(
      mentions(printed_by([] { EXPECT_EQ(Memory(kBytes, kNotCoherent).result, VK_ERROR_OUT_OF_DEVICE_MEMORY); }), {"heap", "268435456"}));
}

TEST_F(LimitsLayer, MapsOnlyWhatIsVisible) {
  const Memory memory(4096, kOfDevice);
  void* data = nullptr;
  EXPECT_TRUE(mentions(printed_by([&] { EXPECT_NE(vkMapMemory(gpu().device, memory.handle, 0, VK_WHOLE_SIZE, 0, &data), VK_SUCCESS); }),
                       {"host-visible", "0"}));
}

TEST_F(LimitsLayer, FillsFreshMemory) {
  const Memory memory(4096, kCoherent);
  EXPECT_EQ(std::vector<std::uint8_t>(memory.map(), memory.map() + 4096), std::vector<std::uint8_t>(4096, kFill));
}

/// Copies between memory that is not coherent and a buffer that the host always sees.
class NotCoherent : public LimitsLayer {
 protected:
  static constexpr VkDeviceSize kBytes = 4096;
  void SetUp() override { check_vk(vkBindBufferMemory(gpu().device, ours_, memory_.handle, 0), "vkBindBufferMemory"); }
  void TearDown() override { vkDestroyBuffer(gpu().device, ours_, nullptr); }
  static void copy(VkBuffer from, VkBuffer to) {
    submit(gpu(), [&](VkCommandBuffer cmd) {
      const VkBufferCopy region{0, 0, kBytes};
      vkCmdCopyBuffer(cmd, from, to, 1, &region);
      full_barrier(cmd);
    });
  }
  std::uint8_t seen(VkDeviceSize at) const { return static_cast<const std::uint8_t*>(theirs_.mapped())[at]; }

  Memory memory_{kBytes, kNotCoherent};
  VkBuffer ours_ = buffer_of(kBytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  Buffer theirs_{gpu(), kBytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT};
};

TEST_F(NotCoherent, TheDeviceSeesWhatIsFlushed) {
  std::memset(memory_.map(), 1, kBytes);
  copy(ours_, theirs_.handle());
  EXPECT_EQ(seen(0), kFill) << "nothing was flushed";
  const VkMappedMemoryRange range = memory_.range(256, 512);
  check_vk(vkFlushMappedMemoryRanges(gpu().device, 1, &range), "vkFlushMappedMemoryRanges");
  copy(ours_, theirs_.handle());
  EXPECT_EQ(seen(255), kFill);
  EXPECT_EQ(seen(256), 1);
  EXPECT_EQ(seen(767), 1);
  EXPECT_EQ(seen(768), kFill);
}

TEST_F(NotCoherent, TheHostSeesWhatIsInvalidated) {
  std::memset(theirs_.mapped(), 2, kBytes);
  copy(theirs_.handle(), ours_);
  EXPECT_NE(*memory_.map(), 2) << "nothing was invalidated";
  const VkMappedMemoryRange range = memory_.range(0, VK_WHOLE_SIZE);
  check_vk(vkInvalidateMappedMemoryRanges(gpu().device, 1, &range), "vkInvalidateMappedMemoryRanges");
  EXPECT_EQ(*memory_.map(), 2);
}

TEST_F(NotCoherent, RangesAreWholeAtoms) {
  for (const VkMappedMemoryRange& range : {memory_.range(64, 256), memory_.range(0, 300), memory_.range(256, kBytes)})
    EXPECT_TRUE(mentions(printed_by([&] { EXPECT_NE(vkFlushMappedMemoryRanges(gpu().device, 1, &range), VK_SUCCESS); }), {"atoms of 256"}));
}

TEST_F(LimitsLayer, BuffersAndImagesShareNoPage) {
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = VK_FORMAT_R8G8B8A8_UNORM,
                               .extent = {16, 16, 1},
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT};
  VkImage image = VK_NULL_HANDLE;
  check_vk(vkCreateImage(gpu().device, &info, nullptr, &image), "vkCreateImage");
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(gpu().device, image, &needs);
  EXPECT_EQ(needs.memoryTypeBits, 1u);
  EXPECT_EQ(needs.alignment, 65536u);
  const Memory memory(1 << 20, kOfDevice);
  VkBuffer near = buffer_of(256, VK_BUFFER_USAGE_TRANSFER_DST_BIT), far = buffer_of(256, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  EXPECT_EQ(printed_by([&] {
              vkBindImageMemory(gpu().device, image, memory.handle, 0);
              vkBindBufferMemory(gpu().device, far, memory.handle, 131072);
            }),
            "");
  EXPECT_TRUE(
      mentions(printed_by([&] { vkBindBufferMemory(gpu().device, near, memory.handle, 65536); }), {"bufferImageGranularity", "131072"}));
  vkDestroyImage(gpu().device, image, nullptr);
  vkDestroyBuffer(gpu().device, near, nullptr);
  vkDestroyBuffer(gpu().device, far, nullptr);
}

TEST_F(LimitsLayer, RunsNothingBeforeItIsWaitedFor) {
  Buffer buffer(gpu(), 256, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  std::memset(buffer.mapped(), 1, 256);
  const VkCommandBuffer cmd = record(gpu(), [&](VkCommandBuffer recorded) {
    vkCmdFillBuffer(recorded, buffer.handle(), 0, 256, 0x02020202);
    full_barrier(recorded);
  });
  const VkFence fence = submit(gpu(), cmd);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // time enough for a fill, had it begun
  EXPECT_EQ(vkGetFenceStatus(gpu().device, fence), VK_NOT_READY);
  EXPECT_EQ(*static_cast<const std::uint8_t*>(buffer.mapped()), 1);
  EXPECT_EQ(vkWaitForFences(gpu().device, 1, &fence, VK_TRUE, UINT64_MAX), VK_SUCCESS);
  EXPECT_EQ(*static_cast<const std::uint8_t*>(buffer.mapped()), 2);
  vkDestroyFence(gpu().device, fence, nullptr);
  vkFreeCommandBuffers(gpu().device, gpu().command_pool, 1, &cmd);
}

TEST_F(LimitsLayer, ReversesWhatNoBarrierParts) {
  const Buffer buffer(gpu(), 256, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  const auto* const value = static_cast<const std::uint8_t*>(buffer.mapped());
  for (const bool barrier : {false, true}) {
    submit(gpu(), [&](VkCommandBuffer cmd) {
      vkCmdFillBuffer(cmd, buffer.handle(), 0, 256, 0x01010101);
      if (barrier) full_barrier(cmd);
      vkCmdFillBuffer(cmd, buffer.handle(), 0, 256, 0x02020202);
      full_barrier(cmd);
    });
    EXPECT_EQ(*value, barrier ? 2 : 1);
  }
}

}  // namespace coppice::test::limits_layer_test
