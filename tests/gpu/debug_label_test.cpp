// What a graphics debugger is told, where the engine has enabled VK_EXT_debug_utils, and that nothing is missing where it has not.

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "context_fixture.h"

namespace coppice::test {
namespace {

/// What the library has asked for.
struct Told {
  bool enabled = true;
  std::vector<std::string> labels;
  std::vector<std::string> names;  ///< of pipelines
  int open = 0;
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

VKAPI_ATTR VkResult VKAPI_CALL set_name(VkDevice, const VkDebugUtilsObjectNameInfoEXT* info) {
  if (info->objectType == VK_OBJECT_TYPE_PIPELINE && info->objectHandle != 0) told().names.emplace_back(info->pObjectName);
  return VK_SUCCESS;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_function(VkDevice device, const char* name) {
  if (std::strstr(name, "DebugUtils") == nullptr) return vkGetDeviceProcAddr(device, name);
  if (!told().enabled) return nullptr;
  if (std::strcmp(name, "vkCmdBeginDebugUtilsLabelEXT") == 0) return reinterpret_cast<PFN_vkVoidFunction>(begin_label);
  if (std::strcmp(name, "vkCmdEndDebugUtilsLabelEXT") == 0) return reinterpret_cast<PFN_vkVoidFunction>(end_label);
  return reinterpret_cast<PFN_vkVoidFunction>(set_name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_function(VkInstance instance, const char* name) {
  if (std::strcmp(name, "vkGetDeviceProcAddr") == 0) return reinterpret_cast<PFN_vkVoidFunction>(device_function);
  return vkGetInstanceProcAddr(instance, name);
}

class DebugLabelTest : public ContextTest {
 protected:
  /// A plant in a frame.
  void draw(bool enabled) {
    told() = {.enabled = enabled, .labels = {}, .names = {}, .open = 0};
    ContextDesc with = desc();
    with.get_instance_proc_addr = instance_function;
    create(with);
    const std::string path = temporary_plant({.leaf_count = 20}, "debug_label_test");
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

TEST_F(DebugLabelTest, NothingIsMissingWithoutTheExtension) {
  draw(false);
  EXPECT_TRUE(told().labels.empty());
  EXPECT_TRUE(told().names.empty());
}

}  // namespace
}  // namespace coppice::test
