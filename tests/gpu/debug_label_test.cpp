// What a graphics debugger is told, where the engine has enabled VK_EXT_debug_utils, and that nothing is missing where it has not.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "context_fixture.h"

namespace coppice::test {
namespace debug_label_test {

/// What the library has asked for.
struct Told {
  bool enabled = true;
  std::vector<std::string> labels;
  std::vector<std::string> names;  ///< of pipelines
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

#define CREATES(function, vk_function, Info, Handle, type)                                                                             \
  VKAPI_ATTR VkResult VKAPI_CALL function(VkDevice device, const Info* info, const VkAllocationCallbacks* allocator, Handle* handle) { \
    const VkResult result = vk_function(device, info, allocator, handle);                                                              \
    return created(result, type, *handle);                                                                                             \
  }
CREATES(create_buffer, vkCreateBuffer, VkBufferCreateInfo, VkBuffer, VK_OBJECT_TYPE_BUFFER)
CREATES(create_buffer_view, vkCreateBufferView, VkBufferViewCreateInfo, VkBufferView, VK_OBJECT_TYPE_BUFFER_VIEW)
CREATES(create_image, vkCreateImage, VkImageCreateInfo, VkImage, VK_OBJECT_TYPE_IMAGE)
CREATES(create_image_view, vkCreateImageView, VkImageViewCreateInfo, VkImageView, VK_OBJECT_TYPE_IMAGE_VIEW)
CREATES(allocate_memory, vkAllocateMemory, VkMemoryAllocateInfo, VkDeviceMemory, VK_OBJECT_TYPE_DEVICE_MEMORY)
#undef CREATES

VKAPI_ATTR VkResult VKAPI_CALL allocate_set(VkDevice device, const VkDescriptorSetAllocateInfo* info, VkDescriptorSet* set) {
  const VkResult result = vkAllocateDescriptorSets(device, info, set);
  return created(result, VK_OBJECT_TYPE_DESCRIPTOR_SET, *set);
}

/// Null: the device's own.
PFN_vkVoidFunction creating_function(const char* name) {
  const std::array<std::pair<const char*, PFN_vkVoidFunction>, 6> functions{{
      {"vkCreateBuffer", reinterpret_cast<PFN_vkVoidFunction>(create_buffer)},
      {"vkCreateBufferView", reinterpret_cast<PFN_vkVoidFunction>(create_buffer_view)},
      {"vkCreateImage", reinterpret_cast<PFN_vkVoidFunction>(create_image)},
      {"vkCreateImageView", reinterpret_cast<PFN_vkVoidFunction>(create_image_view)},
      {"vkAllocateMemory", reinterpret_cast<PFN_vkVoidFunction>(allocate_memory)},
      {"vkAllocateDescriptorSets", reinterpret_cast<PFN_vkVoidFunction>(allocate_set)},
  }};
  const auto found = std::ranges::find_if(functions, [&](const auto& each) { return std::strcmp(each.first, name) == 0; });
  return found == functions.end() ? nullptr : found->second;
}

PFN_vkVoidFunction debug_function(const char* name) {
  if (std::strcmp(name, "vkCmdBeginDebugUtilsLabelEXT") == 0) return reinterpret_cast<PFN_vkVoidFunction>(begin_label);
  if (std::strcmp(name, "vkCmdEndDebugUtilsLabelEXT") == 0) return reinterpret_cast<PFN_vkVoidFunction>(end_label);
  return reinterpret_cast<PFN_vkVoidFunction>(set_name);
}

/// As Debian's loader: it has the extension's functions for a device in any case.
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_function(VkDevice device, const char* name) {
  if (const PFN_vkVoidFunction creates = creating_function(name); creates != nullptr) return creates;
  return std::strstr(name, "DebugUtils") == nullptr ? vkGetDeviceProcAddr(device, name) : debug_function(name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_function(VkInstance instance, const char* name) {
  if (std::strcmp(name, "vkGetDeviceProcAddr") == 0) return reinterpret_cast<PFN_vkVoidFunction>(device_function);
  if (std::strstr(name, "DebugUtils") == nullptr) return vkGetInstanceProcAddr(instance, name);
  return told().enabled ? debug_function(name) : nullptr;
}

class DebugLabelTest : public ContextTest {
 protected:
  /// A plant in a frame.
  void draw(bool enabled) {
    told() = {.enabled = enabled, .labels = {}, .names = {}, .open = 0, .objects = {}};
    ContextDesc with = desc();
    with.compute_raster = VK_TRUE;
    with.get_instance_proc_addr = instance_function;
    create(with);
    const std::string path = temporary_plant({.leaf_count = 20, .leaf_mesh_count = 1}, "debug_label_test");
    const coppice_plant plant = open(path);
    std::filesystem::remove(path);
    coppice_placement placement;
    coppice_placement_init(&placement);
    ASSERT_EQ(coppice_instances_add(context_, plant, &placement, sizeof placement, 1, nullptr), COPPICE_OK) << log_;
    frame(make_view({.width_px = 64, .height_px = 64}));
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

}  // namespace debug_label_test
}  // namespace coppice::test
