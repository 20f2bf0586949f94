// Devices that have less than the tests' own, as the table in runtime/README.md has it: what the library needs is named when a context or
// a view is created, and without what it wants the picture is the same.

#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "context_fixture.h"
#include "failing_device.h"
#include "mentions.h"
#include "replaced_functions.h"

namespace coppice::test::small_device_test {

/// What the physical device says of itself, changed.
struct SmallDevice {
  std::function<void(VkPhysicalDeviceFeatures2&)> features = [](auto&) {};
  std::function<void(VkPhysicalDeviceProperties2&)> properties = [](auto&) {};
  std::function<void(VkPhysicalDeviceMemoryProperties&)> memory = [](auto&) {};
  VkDeviceAddress address_bits = 0;  ///< that all addresses have besides
};

SmallDevice& small() {
  static SmallDevice of_test;
  return of_test;
}

template <class T>
T* chained(void* next, VkStructureType type) {
  for (auto* at = static_cast<VkBaseOutStructure*>(next); at != nullptr; at = at->pNext)
    if (at->sType == type) return reinterpret_cast<T*>(at);
  return nullptr;
}

VKAPI_ATTR void VKAPI_CALL features_of(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* features) {
  vkGetPhysicalDeviceFeatures2(device, features);
  small().features(*features);
}
VKAPI_ATTR void VKAPI_CALL properties2_of(VkPhysicalDevice device, VkPhysicalDeviceProperties2* properties) {
  vkGetPhysicalDeviceProperties2(device, properties);
  small().properties(*properties);
}
VKAPI_ATTR void VKAPI_CALL properties_of(VkPhysicalDevice device, VkPhysicalDeviceProperties* properties) {
  VkPhysicalDeviceProperties2 all{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  properties2_of(device, &all);
  *properties = all.properties;
}
VKAPI_ATTR void VKAPI_CALL memory_of(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties* memory) {
  vkGetPhysicalDeviceMemoryProperties(device, memory);
  small().memory(*memory);
}

VKAPI_ATTR VkDeviceAddress VKAPI_CALL address_of(VkDevice device, const VkBufferDeviceAddressInfo* info) {
  return vkGetBufferDeviceAddress(device, info) | small().address_bits;
}
class SmallDeviceTest : public ContextTest {
 protected:
  void SetUp() override {
    ContextTest::SetUp();
    small() = {};
  }
  void TearDown() override {
    small() = {};
    ContextTest::TearDown();
  }

  static void TearDownTestSuite() { destroy_shared_pipelines(); }

  ContextDesc small_desc() {
    ContextDesc with = desc();
    fail_with_device_faults(with);  // none are set: contexts share their pipelines
    replace_functions(
        with, {replacing("vkGetBufferDeviceAddress", address_of), replacing("vkGetPhysicalDeviceFeatures2", features_of),
               replacing("vkGetPhysicalDeviceProperties", properties_of), replacing("vkGetPhysicalDeviceProperties2", properties2_of),
               replacing("vkGetPhysicalDeviceMemoryProperties", memory_of)});
    return with;
  }

  void expect_refused(const char* name) {
    log_.clear();
    EXPECT_EQ(create_context(small_desc(), &context_), COPPICE_ERROR_UNSUPPORTED) << name;
    EXPECT_EQ(context_, nullptr);
    EXPECT_TRUE(mentions(log_, {name}));
  }

  Picture draw(const ContextDesc& with) {
    create(with);
    add(open_random({.leaf_count = 1000, .seed = 5}), placement_at());
    const Picture picture = settle(make_view({.eye_m = {0.0f, 0.3f, 12.0f}, .width_px = 128}));
    destroy();
    return picture;
  }
};

TEST_F(SmallDeviceTest, ANeededFeatureThatIsMissingIsNamed) {
  struct Feature {
    const char* name;
    std::function<void(VkPhysicalDeviceFeatures2&)> hide;
  };
  const auto vulkan12 = [](VkPhysicalDeviceFeatures2& features) -> VkPhysicalDeviceVulkan12Features& {
    return *chained<VkPhysicalDeviceVulkan12Features>(features.pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
  };
  const auto vulkan13 = [](VkPhysicalDeviceFeatures2& features) {
    static VkPhysicalDeviceVulkan13Features unasked;
    auto* asked = chained<VkPhysicalDeviceVulkan13Features>(features.pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
    return asked != nullptr ? asked : &unasked;
  };
  const std::vector<Feature> features{
      {"dynamicRendering", [&](auto& has) { vulkan13(has)->dynamicRendering = VK_FALSE; }},
      {"synchronization2", [&](auto& has) { vulkan13(has)->synchronization2 = VK_FALSE; }},
      {"bufferDeviceAddress", [&](auto& has) { vulkan12(has).bufferDeviceAddress = VK_FALSE; }},
      {"scalarBlockLayout", [&](auto& has) { vulkan12(has).scalarBlockLayout = VK_FALSE; }},
      {"multiDrawIndirect", [](auto& has) { has.features.multiDrawIndirect = VK_FALSE; }},
      {"drawIndirectFirstInstance", [](auto& has) { has.features.drawIndirectFirstInstance = VK_FALSE; }},
  };
  for (const Feature& feature : features) {
    small().features = feature.hide;
    expect_refused(feature.name);
  }
}

TEST_F(SmallDeviceTest, ALimitBelowWhatIsNeededIsNamed) {
  small().properties = [](auto& has) { has.properties.apiVersion = VK_API_VERSION_1_2; };
  expect_refused("1.3");
  small().properties = [](auto& has) { has.properties.limits.maxPerStageDescriptorStorageBuffers = 6; };
  expect_refused("maxPerStageDescriptorStorageBuffers");
}

TEST_F(SmallDeviceTest, AKindOfMemoryThatIsMissingIsNamed) {
  const auto without = [](VkMemoryPropertyFlags flag) {
    return [flag](VkPhysicalDeviceMemoryProperties& has) {
      for (VkMemoryType& type : has.memoryTypes) type.propertyFlags &= ~flag;
    };
  };
  small().memory = without(VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  expect_refused("device local");
  small().memory = without(VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  expect_refused("host coherent");
}

TEST_F(SmallDeviceTest, AnAddressOfMoreBitsIsRefused) {
  small().address_bits = VkDeviceAddress{1} << 57;
  expect_refused("57 bits");
}

TEST_F(SmallDeviceTest, MoreThanABufferHoldsIsRefused) {
  small().properties = [](auto& has) { has.properties.limits.maxStorageBufferRange = 1u << 20; };
  ContextDesc with = small_desc();
  with.max_instances = 65536;
  create(with);
  const coppice_plant plant = open_random({.leaf_count = 100});
  const std::vector<coppice_placement> placements(30000, placement_at());
  add(plant, std::span(placements).first(20000));
  EXPECT_NE(try_add(plant, placements), COPPICE_OK);
  EXPECT_TRUE(mentions(log_, {"storage buffer", "limit"}));
  EXPECT_EQ(stats().instance_count, 20000u);
}

TEST_F(SmallDeviceTest, AViewWantsNoMoreThanTheDeviceDrawsTo) {
  small().properties = [](auto& has) { has.properties.limits.maxColorAttachments = 4; };
  small().features = [](auto& has) { has.features.independentBlend = VK_FALSE; };
  create(small_desc());
  auto view_desc = defaults(coppice_view_desc_init);
  view_desc.output = COPPICE_OUTPUT_SURFACE;
  auto formats = defaults(coppice_vulkan_view_desc_init);
  formats.depth_format = VK_FORMAT_D32_SFLOAT;
  for (int i = 0; i < 5; ++i) formats.color_formats[i] = VK_FORMAT_R8G8B8A8_UNORM;
  coppice_view view = 0;
  EXPECT_EQ(coppice_vulkan_view_create(context_, &view_desc, &formats, &view), COPPICE_ERROR_UNSUPPORTED);
  EXPECT_TRUE(mentions(log_, {"color_formats[4]"}));
  for (int i = 2; i < 5; ++i) formats.color_formats[i] = VK_FORMAT_UNDEFINED;
  formats.contents[0] = COPPICE_CONTENT_NORMAL;
  formats.contents[1] = COPPICE_CONTENT_NONE;
  EXPECT_EQ(coppice_vulkan_view_create(context_, &view_desc, &formats, &view), COPPICE_ERROR_UNSUPPORTED);
  EXPECT_TRUE(mentions(log_, {"independentBlend"}));
  formats.contents[1] = COPPICE_CONTENT_ALBEDO;
  EXPECT_EQ(coppice_vulkan_view_create(context_, &view_desc, &formats, &view), COPPICE_OK) << log_;
}

// A plant of more instances than one call draws would be drawn in part.
TEST_F(SmallDeviceTest, InstancesAreNoMoreThanOneCallDraws) {
  small().properties = [](auto& has) { has.properties.limits.maxDrawIndirectCount = 100; };
  create(small_desc());
  const coppice_plant plant = open_random({.leaf_count = 100});
  const std::vector<coppice_placement> placements(100, placement_at());
  add(plant, placements);
  EXPECT_EQ(try_add(plant, std::span(placements).first(1)), COPPICE_ERROR_OUT_OF_MEMORY);
  EXPECT_TRUE(mentions(log_, {"100"}));
}

TEST_F(SmallDeviceTest, WithoutWhatIsWantedThePictureIsTheSame) {
  struct Lack {
    const char* name;
    SmallDevice device;
    bool by_hardware = false;  ///< without the compute rasteriser
    const char* said = "";     ///< in the log; nothing where the picture takes a little longer and no more
  };
  const auto subgroup = [](VkPhysicalDeviceProperties2& has) {
    static VkPhysicalDeviceSubgroupProperties unasked;
    auto* asked = chained<VkPhysicalDeviceSubgroupProperties>(has.pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES);
    return asked != nullptr ? asked : &unasked;
  };
  const std::vector<Lack> lacks{
      {"drawIndirectCount",
       {.features =
            [](auto& has) {
              auto* some = chained<VkPhysicalDeviceVulkan12Features>(has.pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
              some->drawIndirectCount = VK_FALSE;
            }}},
      {"many texels", {.properties = [](auto& has) { has.properties.limits.maxTexelBufferElements = 65536; }}},
      {"subgroups of 4", {.properties = [&](auto& has) { subgroup(has)->subgroupSize = 4; }}},
      {"subgroups of 128", {.properties = [&](auto& has) { subgroup(has)->subgroupSize = 128; }}},
      {"granularity", {.properties = [](auto& has) { has.properties.limits.bufferImageGranularity = 65536; }}},
      {"timestamps", {.properties = [](auto& has) { has.properties.limits.timestampComputeAndGraphics = VK_FALSE; }}, false, "timestamps"},
      {"ballots", {.properties = [&](auto& has) { subgroup(has)->supportedOperations = VK_SUBGROUP_FEATURE_BASIC_BIT; }}, true, "ballots"},
      {"storage buffers",
       {.properties = [](auto& has) { has.properties.limits.maxPerStageDescriptorStorageBuffers = 14; }},
       true,
       "storage buffers"},
  };
  ContextDesc with = small_desc();
  with.pass_times = VK_TRUE;
  with.shader_int64_atomics = gpu().int64_atomics ? VK_TRUE : VK_FALSE;
  const Picture by_hardware = draw(with);
  with.compute_raster = VK_TRUE;
  const Picture by_raster = draw(with);
  EXPECT_NE(by_raster.rgba, by_hardware.rgba);
  EXPECT_EQ(log_, "");
  for (const Lack& lack : lacks) {
    small() = lack.device;
    log_.clear();
    EXPECT_EQ(draw(with).rgba, (lack.by_hardware ? by_hardware : by_raster).rgba) << lack.name;
    if (std::strlen(lack.said) == 0)
      EXPECT_EQ(log_, "") << lack.name;
    else
      EXPECT_TRUE(mentions(log_, {lack.said}));
  }
}

}  // namespace coppice::test::small_device_test
