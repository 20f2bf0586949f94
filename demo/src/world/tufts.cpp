#include "tufts.h"

#include <algorithm>
#include <cmath>

#include "noise.h"

namespace forest {
namespace {

constexpr float kCell_m = 0.24f;
constexpr float kTuftsReach_m = 20;

/// Channels of the nearest texel of the ground map, 0..1. Outside the map nothing grows.
glm::vec4 ground_state(const GroundMap& map, glm::vec2 at) {
  const auto side = static_cast<float>(map.texture.side_px);
  const glm::vec2 texel = glm::floor((at / map.extent_m * 0.5f + 0.5f) * side);
  if (glm::any(glm::lessThan(texel, glm::vec2(0))) || glm::any(glm::greaterThanEqual(texel, glm::vec2(side)))) return {0, 1, 0, 0};
  const auto first = 4 * (static_cast<std::size_t>(texel.y) * map.texture.side_px + static_cast<std::size_t>(texel.x));
  const auto channel = [&](std::size_t i) { return std::to_integer<int>(map.texture.texels[first + i]); };
  return glm::vec4(channel(0), channel(1), channel(2), channel(3)) / 255.0f;
}

bool in_view(const glm::mat4& clip_from_world, glm::vec3 at) {
  const glm::vec4 clip = clip_from_world * glm::vec4(at, 1);
  return clip.w > 0 && std::abs(clip.x) < clip.w + 0.5f && std::abs(clip.y) < clip.w + 0.5f;
}

}  // namespace

std::size_t gather_tufts(const Terrain& terrain, const GroundMap& map, const glm::mat4& clip_from_world, glm::vec3 eye,
                         std::span<Tuft> out) {
  std::size_t count = 0;
  const int reach = static_cast<int>(kTuftsReach_m / kCell_m);
  const int center_x = static_cast<int>(std::floor(eye.x / kCell_m));
  const int center_z = static_cast<int>(std::floor(eye.z / kCell_m));
  for (int z = center_z - reach; z <= center_z + reach; ++z)
    for (int x = center_x - reach; x <= center_x + reach; ++x) {
      const glm::vec2 at = kCell_m * (glm::vec2(x, z) + glm::vec2(hash01(x, z, 1), hash01(x, z, 2)));
      const float distance_m = glm::distance(at, glm::vec2(eye.x, eye.z));
      // Fewer and lower with distance: where they end, the painted ground has taken over.
      const float fade = 1 - distance_m / kTuftsReach_m;
      const float dice = hash01(x, z, 3);
      if (count == out.size() || dice > 1.6f * fade) continue;
      Tuft tuft;
      tuft.root = {at.x, height_at(terrain, at.x, at.y) - 0.01f, at.y};
      if (!in_view(clip_from_world, tuft.root + glm::vec3(0, 0.15f, 0))) continue;
      const glm::vec4 state = ground_state(map, at);
      // Nothing grows where roots are.
      const float bare = std::clamp(2.2f * foot_share(map.feet, at), 0.0f, 1.0f);
      const float growth = (1 - bare) * (1 - state.y) * (0.35f + 0.65f * state.z) * (0.4f + 0.9f * state.w);
      tuft.height_m = (0.07f + 0.26f * hash01(x, z, 4)) * growth * std::min(1.0f, 2.5f * fade);
      if (tuft.height_m < 0.035f || dice > 1.5f * growth) continue;
      tuft.yaw_rad = 6.2831853f * hash01(x, z, 5);
      tuft.tone = std::clamp(0.55f * hash01(x, z, 6) + 0.7f * (0.65f - state.w), 0.0f, 1.0f);
      tuft.sunlight = state.x;
      tuft.sky = state.z;
      out[count++] = tuft;
    }
  return count;
}

}  // namespace forest
