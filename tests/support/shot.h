#pragma once

#include "coppice/coppice.h"

namespace coppice::test {

/// What one picture is: a camera and the light it sees by.
struct Shot : coppice_camera {
  coppice_light light;
};

inline void init_shot(Shot* shot) {
  coppice_camera_init(shot);
  coppice_light_init(&shot->light);
}

/// A view of the formats of draw_on_white; with COPPICE_OUTPUT_DEPTH of its depth alone.
inline coppice_view_desc view_desc(coppice_output output = COPPICE_OUTPUT_LIT) {
  coppice_view_desc desc;
  coppice_view_desc_init(&desc);
  desc.output = output;
  if (output == COPPICE_OUTPUT_LIT) desc.color_format = VK_FORMAT_R8G8B8A8_SRGB;
  desc.depth_format = VK_FORMAT_D32_SFLOAT;
  return desc;
}

}  // namespace coppice::test
