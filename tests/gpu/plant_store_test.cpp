// What a plant has on the GPU where memory runs short on the way: nothing half done is recorded, and nothing is forgotten.

#include "plant_store.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "convert.h"
#include "frame_wind.h"
#include "page_codec.h"
#include "random_tree.h"
#include "renderer_scene.h"

namespace coppice::gpu {
namespace plant_store_test {

/// How many buffers can still be created.
std::uint32_t buffers_left = 0;

/// As vkCreateBuffer; what is in the buffer can be read back.
VKAPI_ATTR VkResult VKAPI_CALL create_while_some_are_left(VkDevice device, const VkBufferCreateInfo* info,
                                                          const VkAllocationCallbacks* callbacks, VkBuffer* buffer) {
  if (buffers_left == 0) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  --buffers_left;
  VkBufferCreateInfo readable = *info;
  readable.usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  return vkCreateBuffer(device, &readable, callbacks, buffer);
}

class PlantStoreTest : public test::VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    buffers_left = 0xffffffffu;
    ASSERT_TRUE(texture_sets_.create());
    ASSERT_TRUE(uploads_.create());
    ASSERT_TRUE(store_.create());
    ASSERT_TRUE(store_.reserve(1));
    filled_ = *create_buffer(device_, {"filled", uploads_.room_bytes(), VK_BUFFER_USAGE_TRANSFER_DST_BIT});
    words_ = *create_buffer(device_, {"words", kTableStride * sizeof(std::uint32_t), VK_BUFFER_USAGE_TRANSFER_DST_BIT});
    begin_frame();
    ASSERT_TRUE(store_.add(0, plant_.file, {looks_, light_}, plant_.lod_words));
    ASSERT_TRUE(allocate_into(cuts_.bytes, default_allocator(), ready_cut_bytes(source_.leaf_count)));
    const auto scratch = std::make_unique<ClusterScratch>();
    build_ready_cuts(source_, nodes(), *scratch, cuts_);
    build_page(source_, 0, nodes(), *scratch, clusters_);
  }
  void TearDown() override {
    destroy_buffer(device_, filled_);
    destroy_buffer(device_, words_);
    VulkanTest::TearDown();
  }
  static Device open() {
    const test::VulkanDevice& gpu = test::vulkan_device();  // loads vkGetInstanceProcAddr
    Device device = *open_device(gpu.instance, gpu.physical_device, gpu.device, vkGetInstanceProcAddr);
    device.vk.vkCreateBuffer = create_while_some_are_left;
    return device;
  }
  /// The GPU has finished all frames before it.
  void begin_frame() {
    ++frame_;
    deletion_.begin_frame(frame_, frame_ - 1);
    uploads_.begin_frame(frame_, frame_ - 1);
  }
  /// Until the staging ring has room for so many bytes.
  void fill_ring(std::uint64_t room_bytes) { ASSERT_TRUE(uploads_.copy(uploads_.room_bytes() - room_bytes, filled_, 0)); }
  Result<void> upload_page() {
    // Addresses in what is uploaded have moved already if an upload failed.
    std::vector<std::uint8_t> clusters = clusters_;
    ReadyCuts cuts;
    EXPECT_TRUE(allocate_into(cuts.bytes, default_allocator(), cuts_.bytes.size()));
    std::ranges::copy(cuts_.bytes, cuts.bytes.begin());
    cuts.lists = cuts_.lists;
    return store_.upload_page({.plant = 0, .page = 0, .clusters = clusters, .ready_cuts = &cuts});
  }
  void record() {
    test::submit(test::vulkan_device(), [&](VkCommandBuffer cmd) {
      uploads_.record(cmd);
      test::full_barrier(cmd);
    });
  }
  /// Where the plant's tables have its first page.
  std::uint64_t page_address() {
    std::uint64_t address = 0;
    const test::Buffer copy(test::vulkan_device(), sizeof address, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    test::submit(test::vulkan_device(), [&](VkCommandBuffer cmd) {
      const VkBufferCopy region{store_.plant(0)->layout.pages_at, 0, sizeof address};
      vkCmdCopyBuffer(cmd, store_.plant(0)->tables.buffer, copy.handle(), 1, &region);
      test::full_barrier(cmd);
    });
    std::memcpy(&address, copy.mapped(), sizeof address);
    return address;
  }
  [[nodiscard]] std::span<const PageNode> nodes() const { return std::span(plant_.nodes).subspan(1); }

  const test::DecodedPlant plant_ = test::decoded_plant(test::random_plant({.leaf_count = 200}));
  const PlantLooks looks_ = *plant_looks(plant_.file, default_allocator());
  const LeafBox box_ = leaf_box(gpu_plant(plant_.file.plant));
  const CrownLight light_ = measure_crown({plant_.nodes[0], nodes(), looks_.cards(), box_});
  const LeafSource source_{root_node(plant_.file.plant), looks_.cards(), box_, &light_, plant_.file.plant.leaf_count};
  std::vector<std::uint8_t> clusters_ = std::vector<std::uint8_t>(kPageBytes);
  ReadyCuts cuts_;

  Device device_ = open();
  OpenMemory memory_{device_};
  DeferredDeletion deletion_{device_};
  Uploads uploads_{device_, deletion_, default_allocator()};
  TextureSets texture_sets_{device_};
  PlantStore store_{device_, deletion_, uploads_, texture_sets_, default_allocator()};
  Buffer filled_, words_;
  std::uint64_t frame_ = 0;
};

TEST_F(PlantStoreTest, AnUploadThatFailsHalfWayIsNotRecorded) {
  ASSERT_TRUE(store_.upload_tables(words_));
  fill_ring(kPageBytes);  // none for what the tables say of the page
  buffers_left = 1;       // the page's
  const auto uploaded = upload_page();
  ASSERT_FALSE(uploaded);
  EXPECT_EQ(uploaded.error().status, Status::out_of_memory);
  record();
  buffers_left = 0xffffffffu;
  begin_frame();
  ASSERT_TRUE(upload_page());
  record();
  EXPECT_EQ(page_address(), store_.plant(0)->pages[0].address);
}

TEST_F(PlantStoreTest, TablesThatGoUpAfterThePageKnowIt) {
  ASSERT_TRUE(upload_page());
  fill_ring(0);
  buffers_left = 0;
  ASSERT_FALSE(store_.upload_tables(words_));
  record();
  buffers_left = 0xffffffffu;
  begin_frame();
  ASSERT_TRUE(store_.upload_tables(words_));
  record();
  EXPECT_EQ(page_address(), store_.plant(0)->pages[0].address);
}

}  // namespace plant_store_test
}  // namespace coppice::gpu
