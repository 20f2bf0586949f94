// coppice_shared.h means the same to both compilers: a shader sends back every field it sees, and each must come from where C++ put it.

#include <cstring>

#include "compute_pass.h"
#include "coppice_shared.h"
#include "layout_echo_comp.h"

namespace coppice::test::layout_test {

class LayoutTest : public VulkanTest {};

struct Structs {
  gpu::Leaf leaf;
  gpu::Splat splat;
  gpu::Cluster cluster;
  gpu::ClusterList list;
  gpu::CardLook look;
  gpu::Instance instance;
  gpu::Card card;
  gpu::Material material;
  gpu::WoodVertex wood_vertex;
  gpu::LeafMeshVertex leaf_mesh_vertex;
  gpu::Plant plant;
  gpu::View view;
  gpu::Counters counters;
  gpu::DrawCommand command;
  gpu::DrawPush push;
};
constexpr std::uint32_t kWordCount = sizeof(Structs) / 4;
/// Word i of the structs holds this plus i: as a float a number near 1, which no driver rounds or flushes.
constexpr std::uint32_t kFirstWord = 0x3f800000u;

TEST_F(LayoutTest, AShaderEchoesEveryField) {
  const Buffer structs(gpu(), sizeof(Structs), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  // One word more than there are, to see a field too many.
  const Buffer words(gpu(), sizeof(Structs) + 4, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  std::vector<std::uint32_t> sent(kWordCount);
  for (std::uint32_t i = 0; i < kWordCount; ++i) sent[i] = kFirstWord + i;
  std::memcpy(structs.mapped(), sent.data(), sizeof(Structs));
  std::memset(words.mapped(), 0, sizeof(Structs) + 4);

  ComputePass pass(gpu(), layout_echo_comp_spirv, {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  pass.bind(0, structs);
  pass.bind(1, words);
  submit(gpu(), [&](VkCommandBuffer cmd) {
    pass.record(cmd, 1, 1);
    full_barrier(cmd);
  });

  std::vector<std::uint32_t> echoed(kWordCount + 1);
  std::memcpy(echoed.data(), words.mapped(), sizeof(Structs) + 4);
  sent.push_back(0);
  EXPECT_EQ(echoed, sent);
}

}  // namespace coppice::test::layout_test
