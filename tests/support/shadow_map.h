#pragma once

// A shadow map of the tests: the sun's view of a sphere, drawn by Coppice, and what a light says of it.

#include <algorithm>
#include <array>
#include <functional>

#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "context_fixture.h"

namespace coppice::test {

struct SunSphere {
  std::array<double, 3> center{};  ///< world space, m
  float radius_m = 12.0f;
};

/// Thread and lifetime: of its test, which has a context.
class ContextWithMapTest : public ContextTest {
 protected:
  static constexpr std::uint32_t kMapPx = 256;

  void create_map_view() { map_view_ = create_view(COPPICE_OUTPUT_DEPTH); }

  /// As fine as the camera, whose light's sun it is.
  [[nodiscard]] Shot sun_of(const Shot& camera, const SunSphere& sphere) const {
    auto desc = defaults(coppice_sun_desc_init);
    std::ranges::copy(camera.light.sun_direction, desc.sun_direction);
    std::ranges::copy(sphere.center, desc.center);
    desc.radius_m = sphere.radius_m;
    desc.size_px = kMapPx;
    Shot sun;
    init_shot(&sun);
    EXPECT_EQ(coppice_sun_camera(context_, map_view_, &desc, &sun), COPPICE_OK) << log_;
    sun.error_px = camera.error_px;
    return sun;
  }

  void record_map(VkCommandBuffer cmd, const Shot& sun) {
    record_cull(cmd, sun);
    record_map(cmd, [&] { record_draw(cmd, sun); });
  }
  /// draw: records what the map, which begins empty, is to hold
  void record_map(VkCommandBuffer cmd, const std::function<void()>& draw) {
    begin_rendering(cmd, {.depth = &map_});
    draw();
    vkCmdEndRendering(cmd);
    change_layout(cmd, map_, map_.attachment_layout(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  }

  [[nodiscard]] coppice_shadow_map map_of(const Shot& sun) const {
    coppice_shadow_map map{};
    map.image = map_.view();
    const glm::dmat4 clip_from_world = glm::dmat4(glm::make_mat4(sun.clip_from_view)) * glm::make_mat4(sun.view_from_world);
    std::copy_n(glm::value_ptr(clip_from_world), 16, map.clip_from_world);
    return map;
  }

  /// The camera's picture, the map drawn before it and lit by it. others: maps before it in the list, which hold nothing in view
  Picture frame_with_map(Shot camera, const SunSphere& sphere, std::uint32_t others = 0) {
    const Shot sun = sun_of(camera, sphere);
    std::array<coppice_shadow_map, COPPICE_MAX_SHADOW_MAPS> maps{};
    for (std::uint32_t i = 0; i <= others; ++i) {
      maps[i] = map_of(sun);
      if (i < others) maps[i].clip_from_world[12] += 10.0;
    }
    camera.light.shadow_maps = maps.data();
    camera.light.shadow_map_count = others + 1;
    return frame(camera, [&](VkCommandBuffer cmd) { record_map(cmd, sun); }, {&sun, 1});
  }

  Image map_{gpu(), depth_attachment(kMapPx, kMapPx)};
  coppice_view map_view_ = 0;
};

}  // namespace coppice::test
