#include "sun_camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vectors.h"

namespace coppice {
void set_sun_camera(coppice_camera& view, const coppice_sun_desc& desc, bool reversed_depth) {
  constexpr float kRadiiBefore = 4.0f, kRadiiBehind = 2.0f;
  const vec3 sun = normalize(vec3(desc.sun_direction));
  const vec3 right = normalize(cross(std::abs(sun.y) < 0.99f ? vec3(0, 1, 0) : vec3(1, 0, 0), sun));
  const vec3 up = cross(sun, right);
  const std::array<vec3, 3> axes{right, up, sun};
  std::fill_n(view.view_from_world, 16, 0.0);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) view.view_from_world[4 * column + row] = axes[row][column];
    for (std::size_t i = 0; i < 3; ++i) view.view_from_world[12 + row] -= double{axes[row][i]} * desc.center[i];
  }
  view.view_from_world[14] -= double{kRadiiBefore} * double{desc.radius_m};
  view.view_from_world[15] = 1.0;

  // The near plane contains the eye.
  const float depth_per_m = 1.0f / ((kRadiiBefore + kRadiiBehind) * desc.radius_m);
  std::fill_n(view.clip_from_view, 16, 0.0f);
  view.clip_from_view[0] = 1.0f / desc.radius_m;
  view.clip_from_view[5] = -1.0f / desc.radius_m;
  view.clip_from_view[10] = reversed_depth ? depth_per_m : -depth_per_m;
  view.clip_from_view[14] = reversed_depth ? 1.0f : 0.0f;
  view.clip_from_view[15] = 1.0f;
}

}  // namespace coppice
