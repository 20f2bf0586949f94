#include "vulkan_abi.h"

#include <algorithm>
#include <iterator>

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

template <>
coppice_material_override struct_defaults() {
  auto material_override = zeroed_struct<coppice_material_override>();
  std::ranges::fill(material_override.leaf_tint, 1.0f);
  std::ranges::fill(material_override.wood_tint, 1.0f);
  material_override.leaf_roughness = material_override.wood_roughness = material_override.translucency = -1.0f;
  return material_override;
}

template <>
coppice_triangles struct_defaults() {
  auto triangles = zeroed_struct<coppice_triangles>();
  triangles.wood_lod = COPPICE_NONE;
  return triangles;
}

}  // namespace coppice

void coppice_vulkan_struct_init(coppice_vulkan_struct kind, void* data, size_t bytes) {
  using coppice::init_struct;
  static constexpr coppice::StructInit kInits[] = {init_struct<coppice_vulkan_desc>,      init_struct<coppice_device_memory>,
                                                   init_struct<coppice_vulkan_view_desc>, init_struct<coppice_light>,
                                                   init_struct<coppice_occluder>,         init_struct<coppice_material_override>,
                                                   init_struct<coppice_triangles>};
  static_assert(std::size(kInits) == COPPICE_VULKAN_STRUCT_TRIANGLES + 1);
  coppice::init_kind(kInits, static_cast<std::size_t>(kind), data, bytes);
}
