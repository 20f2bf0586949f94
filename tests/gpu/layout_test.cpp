// coppice_shared.h means the same to both compilers: a shader sends back every field it sees, and each must come from where C++ put it.

#include <array>
#include <cstring>

#include "coppice_shared.h"
#include "layout_echo_comp.h"
#include "vulkan_device.h"

namespace coppice::test {
namespace layout_test {

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

struct EchoPass {
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkDescriptorSet set = VK_NULL_HANDLE;
};

void create_pipeline(const VulkanDevice& gpu, EchoPass& pass) {
  std::array<VkDescriptorSetLayoutBinding, 2> bindings{};
  for (std::uint32_t i = 0; i < 2; ++i) bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  const VkDescriptorSetLayoutCreateInfo set_info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 2, .pBindings = bindings.data()};
  check_vk(vkCreateDescriptorSetLayout(gpu.device, &set_info, nullptr, &pass.set_layout), "vkCreateDescriptorSetLayout");
  const VkPipelineLayoutCreateInfo layout_info{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &pass.set_layout};
  check_vk(vkCreatePipelineLayout(gpu.device, &layout_info, nullptr, &pass.layout), "vkCreatePipelineLayout");
  const VkShaderModule module = create_shader_module(gpu, layout_echo_comp_spirv, sizeof layout_echo_comp_spirv);
  const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                         .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                   .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                   .module = module,
                                                   .pName = "main"},
                                         .layout = pass.layout};
  check_vk(vkCreateComputePipelines(gpu.device, VK_NULL_HANDLE, 1, &info, nullptr, &pass.pipeline), "vkCreateComputePipelines");
  vkDestroyShaderModule(gpu.device, module, nullptr);
}

void create_set(const VulkanDevice& gpu, EchoPass& pass, const Buffer& structs, const Buffer& words) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2};
  const VkDescriptorPoolCreateInfo pool_info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 1, .pPoolSizes = &size};
  check_vk(vkCreateDescriptorPool(gpu.device, &pool_info, nullptr, &pass.pool), "vkCreateDescriptorPool");
  const VkDescriptorSetAllocateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = pass.pool,
                                             .descriptorSetCount = 1,
                                             .pSetLayouts = &pass.set_layout};
  check_vk(vkAllocateDescriptorSets(gpu.device, &set_info, &pass.set), "vkAllocateDescriptorSets");
  const std::array<VkDescriptorBufferInfo, 2> buffers{{{structs.handle(), 0, VK_WHOLE_SIZE}, {words.handle(), 0, VK_WHOLE_SIZE}}};
  for (std::uint32_t i = 0; i < 2; ++i) {
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = pass.set,
                                     .dstBinding = i,
                                     .descriptorCount = 1,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                     .pBufferInfo = &buffers[i]};
    vkUpdateDescriptorSets(gpu.device, 1, &write, 0, nullptr);
  }
}

TEST_F(LayoutTest, AShaderEchoesEveryField) {
  const Buffer structs(gpu(), sizeof(Structs), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  // One word more than there are, to see a field too many.
  const Buffer words(gpu(), sizeof(Structs) + 4, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  std::vector<std::uint32_t> sent(kWordCount);
  for (std::uint32_t i = 0; i < kWordCount; ++i) sent[i] = kFirstWord + i;
  std::memcpy(structs.mapped(), sent.data(), sizeof(Structs));
  std::memset(words.mapped(), 0, sizeof(Structs) + 4);

  EchoPass pass;
  create_pipeline(gpu(), pass);
  create_set(gpu(), pass, structs, words);
  submit(gpu(), [&](VkCommandBuffer cmd) {
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, pass.pipeline);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, pass.layout, 0, 1, &pass.set, 0, nullptr);
    vkCmdDispatch(cmd, 1, 1, 1);
    full_barrier(cmd);
  });
  vkDestroyDescriptorPool(gpu().device, pass.pool, nullptr);
  vkDestroyPipeline(gpu().device, pass.pipeline, nullptr);
  vkDestroyPipelineLayout(gpu().device, pass.layout, nullptr);
  vkDestroyDescriptorSetLayout(gpu().device, pass.set_layout, nullptr);

  std::vector<std::uint32_t> echoed(kWordCount + 1);
  std::memcpy(echoed.data(), words.mapped(), sizeof(Structs) + 4);
  sent.push_back(0);
  EXPECT_EQ(echoed, sent);
}

}  // namespace layout_test
}  // namespace coppice::test
