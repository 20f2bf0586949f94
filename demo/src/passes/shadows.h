#pragma once

#include <coppice/vulkan.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "resources.h"
#include "terrain.h"

namespace forest {

/// Shadow maps of the sun: squares about the ground before the eye, each several times as large as the one before; and one from straight
/// above, the sky map, which says what grows how high. In still air a map is drawn again only when its square has moved on, or plants have
/// got finer; in wind one of the sun's also when plants may have moved by about one of its texels since. At most one a frame: first squares
/// that have moved, then, in every third frame, what wind has left farthest behind, in texels.
struct Shadows {
  static constexpr std::size_t kCascades = 3;
  static constexpr std::size_t kSkyMap = kCascades;  ///< its place among maps
  static constexpr std::size_t kMaps = kCascades + 1;
  static constexpr std::uint32_t kSize_px = 1024;  ///< side of a map, for a picture drawn at full size
  struct Cascade {
    Image map;
    float radius_m = 0;
    glm::vec3 center = {0, 0, 0};
    glm::mat4 clip_from_world = glm::mat4(1);
    std::uint64_t drawn_frame = 0;  ///< 0: not yet
    std::uint64_t drawn_arrivals = 0;
    float drawn_time_s = 0;
    float drawn_sway_m = 0;
  };
  std::vector<Cascade> cascades;  ///< [kMaps], or without a sky map [kCascades]

  Shadows(const Device& device, std::uint32_t size_px, bool sky_map);
};

struct ShadowFrame {
  const coppice_context* context = nullptr;
  std::array<coppice_view, Shadows::kMaps> views{};
  const Terrain* terrain = nullptr;
  glm::vec3 sun_direction = {0, 1, 0};
  glm::vec3 eye = {0, 0, 0};
  glm::vec3 forward = {0, 0, -1};
  std::uint64_t number = 1;
  std::uint64_t arrivals = 0;  ///< changes with whatever has come or gone
  float time_s = 0;            ///< the wind's
  float sway_m = 0;            ///< how far the wind moves the largest plants to and fro; 0: still air
};

/// A map that a frame draws.
struct DueMap {
  std::size_t cascade = 0;
  coppice_camera camera;
};

/// The maps to draw in this frame: all at first, then one at most.
std::vector<DueMap> due_maps(Shadows& shadows, const ShadowFrame& frame);

/// Records them. cull, draw: record a view's plants, outside and inside rendering
void record_shadows(const Shadows& shadows, VkCommandBuffer commands, std::span<const DueMap> due,
                    const std::function<void(coppice_view)>& cull, const std::function<void(coppice_view)>& draw);

/// All maps are drawn with the next frame.
void outdate(Shadows& shadows);

/// What makes plants receive the shadows.
std::array<coppice_shadow_map, Shadows::kCascades> shadow_maps(const Shadows& shadows);

}  // namespace forest
