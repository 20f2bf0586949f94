// The renderer where memory runs short: a frame may draw less or nothing, the next ones draw all.

#include "renderer.h"

#include <gtest/gtest.h>

#include "random_tree.h"
#include "renderer_scene.h"

namespace coppice::test::renderer_test {

constexpr std::uint32_t kSidePx = 128;

/// How many allocations still succeed.
std::uint32_t allocations_left = 0;

VKAPI_ATTR VkResult VKAPI_CALL allocate_while_some_are_left(VkDevice device, const VkMemoryAllocateInfo* info,
                                                            const VkAllocationCallbacks* callbacks, VkDeviceMemory* memory) {
  if (allocations_left == 0) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  --allocations_left;
  return vkAllocateMemory(device, info, callbacks, memory);
}

class RendererTest : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    allocations_left = 0xffffffffu;
  }
  [[nodiscard]] static std::unique_ptr<RendererScene> failing_scene() {
    return std::make_unique<RendererScene>(gpu(), 131072, SceneOptions{.allocate_memory = allocate_while_some_are_left});
  }
};

coppice_placement at(float x, float z) {
  return placement_at({x, 0.0f, z});
}

Shot front_view() {
  return make_view({.eye_m = {0.0f, 0.3f, 5.0f}, .width_px = kSidePx, .lod = COPPICE_LOD_FULL});
}

TEST_F(RendererTest, PagesOfAFrameThatFailedAreDrawnInTheNext) {
  // The pages and the texture leave too little of the 8 MiB staging ring for the instances, which then need memory of their own.
  const DecodedPlant plant = decoded_plant(random_plant({.leaf_count = 5000, .seed = 3, .texture_side = 1391}));
  std::vector<coppice_placement> placements(100000, at(0.0f, 400.0f));
  placements[0] = at(0.0f, 0.0f);
  RendererScene reference(gpu(), 131072);
  reference.place(reference.add_plant(plant), placements);
  const Picture expected = reference.draw(front_view()).picture;

  const auto scene = failing_scene();
  scene->place(scene->add_plant(plant), placements);
  allocations_left = 3;  // a block for pages, one for wood, the texture
  EXPECT_EQ(scene->draw(front_view()).counts.leaves, 0u);
  EXPECT_TRUE(scene->upload_failed());
  allocations_left = 0xffffffffu;
  const RendererScene::Frame frame = scene->draw(front_view());
  EXPECT_FALSE(scene->upload_failed());
  EXPECT_EQ(frame.counts.leaves, 5000u);
  EXPECT_TRUE(frame.picture.rgba == expected.rgba);
}

TEST_F(RendererTest, WithoutMemoryForDrawCommandsPlantsAreCoarser) {
  const DecodedPlant plant = decoded_plant(random_plant({.leaf_count = 9000, .seed = 3, .wood_lod_count = 0, .texture_side = 0}));
  const auto scene = failing_scene();
  const std::uint32_t index = scene->add_plant(plant);
  scene->place(index, std::vector<coppice_placement>(3, at(0.0f, 0.0f)));
  scene->draw(front_view());
  scene->place(index, std::vector<coppice_placement>(300, at(0.0f, 0.0f)));
  allocations_left = 0;
  const std::uint64_t coarser = scene->draw(front_view()).counts.leaves;
  EXPECT_FALSE(scene->upload_failed());
  allocations_left = 0xffffffffu;
  EXPECT_GT(scene->draw(front_view()).counts.leaves, 2 * coarser);
}

TEST_F(RendererTest, DrawCommandsKeepToAShareOfTheBudget) {
  const DecodedPlant plant = decoded_plant(random_plant({.leaf_count = 9000, .seed = 3, .wood_lod_count = 0, .texture_side = 0}));
  RendererScene scene(gpu(), 4096, {.memory_budget_bytes = 1 << 20});  // 819 commands for clusters
  const std::uint32_t many = scene.add_plant(plant), one = scene.add_plant(plant);
  scene.place(many, std::vector<coppice_placement>(100, at(0.0f, 0.0f)));  // 144 clusters each
  scene.place(one, {at(0.0f, 0.0f)});
  const std::vector<float> cuts = scene.select(front_view());
  EXPECT_EQ(std::count(cuts.begin(), cuts.end(), 9000.0f), 5) << "four of the first plant's; a plant that takes little keeps its detail";
  EXPECT_EQ(cuts[100], 9000.0f);
  EXPECT_EQ(std::count(cuts.begin(), cuts.end(), 2250.0f), 1) << "in what is left behind the fourth";
  EXPECT_EQ(std::count(cuts.begin(), cuts.end(), 64.0f), 95) << "for these there is a command of their own each";
}

}  // namespace coppice::test::renderer_test
