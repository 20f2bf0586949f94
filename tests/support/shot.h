#pragma once

#include <algorithm>

#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "coppice/vulkan.h"

namespace coppice::test {

/// What one picture is: a camera and the light it sees by. What light.shadow_maps points to is the test's.
struct Shot : coppice_camera {
  coppice_light light;
};

/// A struct with its defaults, as `init` sets them.
template <class T>
T defaults(void (*init)(T*)) {
  T value;
  init(&value);
  return value;
}

inline void init_shot(Shot* shot) {
  coppice_camera_init(shot);
  coppice_light_init(&shot->light);
}

/// As modelled, but for its scale.
inline coppice_placement placement_at(const glm::dvec3& place = {}, float scale = 1.0f) {
  auto placement = defaults(coppice_placement_init);
  std::copy_n(&place.x, 3, placement.position);
  placement.scale = scale;
  return placement;
}

/// The eye of a pair that is `apart_m` to the right of the camera, which is the first, and turned by `turn_rad` to the right.
inline coppice_eye eye_beside(const coppice_camera& first, double apart_m, double turn_rad) {
  coppice_eye eye{.struct_size = sizeof eye};
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1), turn_rad, glm::dvec3(0, 1, 0));
  const glm::dmat4 moved = turn * glm::translate(glm::dmat4(1), glm::dvec3(-apart_m, 0, 0)) * glm::make_mat4(first.view_from_world);
  std::copy_n(glm::value_ptr(moved), 16, eye.view_from_world);
  std::copy_n(first.clip_from_view, 16, eye.clip_from_view);
  return eye;
}

/// A view of the formats of draw_on_white; with COPPICE_OUTPUT_DEPTH of its depth alone.
inline coppice_status create_view(coppice_context* context, coppice_view* view, coppice_output output = COPPICE_OUTPUT_LIT) {
  auto desc = defaults(coppice_view_desc_init);
  desc.output = output;
  auto vulkan = defaults(coppice_vulkan_view_desc_init);
  if (output == COPPICE_OUTPUT_LIT) vulkan.color_formats[0] = VK_FORMAT_R8G8B8A8_SRGB;
  vulkan.depth_format = VK_FORMAT_D32_SFLOAT;
  return coppice_vulkan_view_create(context, &desc, &vulkan, view);
}

}  // namespace coppice::test
