// What a graphics debugger is told, where the engine has enabled VK_EXT_debug_utils, and that nothing is missing where it has not.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "context_fixture.h"
#include "replaced_functions.h"

namespace coppice::test::debug_label_test {

/// What the library has asked for.
struct Told {
  std::vector<std::string> labels;
  std::vector<std::string> names;  ///< those that pipelines have
  int open = 0;
  /// What it has created, by kind and handle, and the name that it has given to that. A handle may come again: then the later counts.
  std::map<std::pair<VkObjectType, std::uint64_t>, std::string> objects;
};

Told& told() {
  static Told of_test;
  return of_test;
}

VKAPI_ATTR void VKAPI_CALL begin_label(VkCommandBuffer, const VkDebugUtilsLabelEXT* label) {
  told().labels.emplace_back(label->pLabelName);
  ++told().open;
}

VKAPI_ATTR void VKAPI_CALL end_label(VkCommandBuffer) {
  --told().open;
}

VKAPI_ATTR VkResult VKAPI_CALL set_name(VkDevice device, const VkDebugUtilsObjectNameInfoEXT* info) {
  if (info->objectType == VK_OBJECT_TYPE_PIPELINE) told().names.emplace_back(info->pObjectName);
  const auto known = told().objects.find({info->objectType, info->objectHandle});
  if (known != told().objects.end()) known->second = info->pObjectName;
  return vkSetDebugUtilsObjectNameEXT(device, info);
}

template <class Handle>
VkResult created(VkResult result, VkObjectType type, Handle handle) {
  if (result == VK_SUCCESS) told().objects[{type, reinterpret_cast<std::uint64_t>(handle)}] = "";
  return result;
}

template <auto& real, VkObjectType type, class Info, class Handle>
VKAPI_ATTR VkResult VKAPI_CALL create_told(VkDevice device, const Info* info, const VkAllocationCallbacks* allocator, Handle* handle) {
  const VkResult result = real(device, info, allocator, handle);
  return created(result, type, *handle);
}

VKAPI_ATTR VkResult VKAPI_CALL allocate_set(VkDevice device, const VkDescriptorSetAllocateInfo* info, VkDescriptorSet* set) {
  const VkResult result = vkAllocateDescriptorSets(device, info, set);
  return created(result, VK_OBJECT_TYPE_DESCRIPTOR_SET, *set);
}

const ReplacedFunctions kWatched{
    replacing("vkCreateBuffer", create_told<vkCreateBuffer, VK_OBJECT_TYPE_BUFFER, VkBufferCreateInfo, VkBuffer>),
    replacing("vkCreateBufferView", create_told<vkCreateBufferView, VK_OBJECT_TYPE_BUFFER_VIEW, VkBufferViewCreateInfo, VkBufferView>),
    replacing("vkCreateImage", create_told<vkCreateImage, VK_OBJECT_TYPE_IMAGE, VkImageCreateInfo, VkImage>),
    replacing("vkCreateImageView", create_told<vkCreateImageView, VK_OBJECT_TYPE_IMAGE_VIEW, VkImageViewCreateInfo, VkImageView>),
    replacing("vkAllocateMemory", create_told<vkAllocateMemory, VK_OBJECT_TYPE_DEVICE_MEMORY, VkMemoryAllocateInfo, VkDeviceMemory>),
    replacing("vkAllocateDescriptorSets", allocate_set),
    replacing("vkCmdBeginDebugUtilsLabelEXT", begin_label),
    replacing("vkCmdEndDebugUtilsLabelEXT", end_label),
    replacing("vkSetDebugUtilsObjectNameEXT", set_name)};

/// As Debian's loader: it has the extension's functions for a device in any case.
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL without_debug_utils(VkInstance instance, const char* name) {
  return std::strstr(name, "DebugUtils") != nullptr ? nullptr : replaced::of_instance(instance, name);
}

class DebugLabelTest : public ContextTest {
 protected:
  /// A plant in a frame.
  void draw(bool enabled) {
    told() = {};
    ContextDesc with = desc();
    with.compute_raster = VK_TRUE;
    replace_functions(with, kWatched);
    if (!enabled) with.get_instance_proc_addr = without_debug_utils;
    create(with);
    add(open_random({.leaf_count = 20, .leaf_mesh_count = 1}), placement_at());
    frame(make_view({.width_px = 64}));
    EXPECT_EQ(log_, "");
  }
};

TEST_F(DebugLabelTest, EachCallThatRecordsHasALabelAndPipelinesHaveNames) {
  draw(true);
  EXPECT_EQ(told().labels, (std::vector<std::string>{"coppice_record_upload", "coppice_record_cull", "coppice_record_draw"}));
  EXPECT_EQ(told().open, 0);
  EXPECT_NE(std::ranges::find(told().names, "cull.comp"), told().names.end());
  EXPECT_NE(std::ranges::find(told().names, "leaf.vert"), told().names.end());
}

TEST_F(DebugLabelTest, WhatIsCreatedHasANameOfOurs) {
  draw(true);
  std::map<VkObjectType, std::size_t> counts;
  for (const auto& [object, name] : told().objects) {
    ++counts[object.first];
    EXPECT_TRUE(name.starts_with("coppice ")) << "VkObjectType " << object.first << ": '" << name << "'";
  }
  for (const VkObjectType type : {VK_OBJECT_TYPE_BUFFER, VK_OBJECT_TYPE_BUFFER_VIEW, VK_OBJECT_TYPE_IMAGE, VK_OBJECT_TYPE_IMAGE_VIEW,
                                  VK_OBJECT_TYPE_DEVICE_MEMORY, VK_OBJECT_TYPE_DESCRIPTOR_SET})
    EXPECT_GT(counts[type], 0u) << type;
}

TEST_F(DebugLabelTest, NothingIsMissingWithoutTheExtension) {
  draw(false);
  EXPECT_TRUE(told().labels.empty());
  EXPECT_TRUE(told().names.empty());
}

}  // namespace coppice::test::debug_label_test
