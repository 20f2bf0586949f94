#include "sun_camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vectors.h"

namespace coppice {
void set_sun_camera(coppice_camera& view, const coppice_sun_desc& desc, bool reversed_depth) {
  // Far enough to be about parallel, near enough for depth to keep millimetres.
  constexpr float kRadiiAway = 40.0f, kRadiiBefore = 4.0f, kRadiiBehind = 2.0f;
  const vec3 sun = normalize(vec3(desc.sun_direction));
  const vec3 right = normalize(cross(std::abs(sun.y) < 0.99f ? vec3(0, 1, 0) : vec3(1, 0, 0), sun));
  const vec3 up = cross(sun, right);
  const float distance_m = kRadiiAway * desc.radius_m;
  const std::array<vec3, 3> axes{right, up, sun};
  std::fill_n(view.view_from_world, 16, 0.0f);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) view.view_from_world[4 * column + row] = axes[row][column];
    view.view_from_world[12 + row] = -dot(axes[row], vec3(desc.center));
  }
  view.view_from_world[14] -= distance_m;
  view.view_from_world[15] = 1.0f;

  const float near_m = distance_m - kRadiiBefore * desc.radius_m, far_m = distance_m + kRadiiBehind * desc.radius_m;
  const float focal = std::sqrt(kRadiiAway * kRadiiAway - 1.0f);  // the tangent cone's
  const float scale = near_m / (far_m - near_m), offset = far_m * scale;
  std::fill_n(view.clip_from_view, 16, 0.0f);
  view.clip_from_view[0] = focal;
  view.clip_from_view[5] = -focal;
  view.clip_from_view[10] = reversed_depth ? scale : -(1.0f + scale);
  view.clip_from_view[11] = -1.0f;
  view.clip_from_view[14] = reversed_depth ? offset : -offset;
}

}  // namespace coppice
