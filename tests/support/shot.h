#pragma once

#include "coppice/vulkan.h"

namespace coppice::test {

/// What one picture is: a camera and the light it sees by. What light.shadow_maps points to is the test's.
struct Shot : coppice_camera {
  coppice_light light;
};

inline void init_shot(Shot* shot) {
  coppice_camera_init(shot);
  coppice_light_init(&shot->light);
}

/// A view of the formats of draw_on_white; with COPPICE_OUTPUT_DEPTH of its depth alone.
inline coppice_status create_view(coppice_context* context, coppice_view* view, coppice_output output = COPPICE_OUTPUT_LIT) {
  coppice_view_desc desc;
  coppice_view_desc_init(&desc);
  desc.output = output;
  coppice_vulkan_view_desc vulkan;
  coppice_vulkan_view_desc_init(&vulkan);
  if (output == COPPICE_OUTPUT_LIT) vulkan.color_format = VK_FORMAT_R8G8B8A8_SRGB;
  vulkan.depth_format = VK_FORMAT_D32_SFLOAT;
  return coppice_vulkan_view_create(context, &desc, &vulkan, view);
}

}  // namespace coppice::test
