#include "vulkan_abi.h"

namespace coppice {

template <>
coppice_vulkan_desc struct_defaults() {
  auto desc = zeroed_struct<coppice_vulkan_desc>();
  desc.compute_raster = VK_TRUE;
  return desc;
}

template <>
coppice_vulkan_view_desc struct_defaults() {
  auto desc = zeroed_struct<coppice_vulkan_view_desc>();
  desc.depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  desc.samples = VK_SAMPLE_COUNT_1_BIT;
  return desc;
}

template <>
coppice_light struct_defaults() {
  auto light = zeroed_struct<coppice_light>();
  light.sun_direction[1] = 1.0f;
  for (int i = 0; i < 3; ++i) {
    light.sun_color[i] = 3.0f;
    light.sky_color[i] = 0.6f;
    light.ground_color[i] = 0.2f;
  }
  light.shadow_map_bytes = sizeof(coppice_shadow_map);
  return light;
}

}  // namespace coppice

void coppice_vulkan_struct_init(coppice_vulkan_struct kind, void* data, size_t bytes) {
  if (data == nullptr || bytes < sizeof(uint32_t) || bytes > coppice::kMaxStructBytes) return;
  const auto size = static_cast<uint32_t>(bytes);
  switch (kind) {
    case COPPICE_VULKAN_STRUCT_DESC:
      return coppice::init_struct<coppice_vulkan_desc>(data, size);
    case COPPICE_VULKAN_STRUCT_DEVICE_MEMORY:
      return coppice::init_struct<coppice_device_memory>(data, size);
    case COPPICE_VULKAN_STRUCT_VIEW_DESC:
      return coppice::init_struct<coppice_vulkan_view_desc>(data, size);
    case COPPICE_VULKAN_STRUCT_LIGHT:
      return coppice::init_struct<coppice_light>(data, size);
    case COPPICE_VULKAN_STRUCT_OCCLUDER:
      return coppice::init_struct<coppice_occluder>(data, size);
    case COPPICE_VULKAN_STRUCT_MAX_ENUM:
      break;
  }
  coppice::init_zeroed(data, size);
}
