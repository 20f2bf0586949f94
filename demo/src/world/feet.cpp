#include "feet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace forest {
namespace {

constexpr std::uint32_t kSides = 16, kRings = 4;
static_assert(kSides * kRings == kMoundVertices);
constexpr float kReach_m = 36;
constexpr float kLargestFoot_m = 1.7f;
// A mound's rim lies this deep in the ground, so that the line where it comes out is as crooked as its roots.
constexpr float kSunk_m = 0.03f;

std::uint32_t cell_of(const Feet& feet, float value) {
  const float cell = (value / feet.half_extent_m * 0.5f + 0.5f) * static_cast<float>(feet.side);
  return static_cast<std::uint32_t>(std::clamp(cell, 0.0f, static_cast<float>(feet.side) - 1));
}

/// visit(foot) for all in cells that the square of this reach touches.
template <class Visit>
void for_each_near(const Feet& feet, glm::vec2 at, float reach_m, const Visit& visit) {
  if (feet.side == 0) return;
  for (std::uint32_t z = cell_of(feet, at.y - reach_m); z <= cell_of(feet, at.y + reach_m); ++z) {
    const std::uint32_t row = z * feet.side;
    const std::uint32_t end = feet.first[row + cell_of(feet, at.x + reach_m) + 1];
    for (std::uint32_t i = feet.first[row + cell_of(feet, at.x - reach_m)]; i < end; ++i) visit(feet.feet[i]);
  }
}

/// Height over the ground without the mound, in parts of its radius. share: of the radius, from the middle
float profile(const Foot& foot, float share, float angle_rad) {
  // Some five roots, no two alike.
  const float root = 0.5f + 0.5f * std::sin(5 * angle_rad + foot.turn_rad + 1.2f * std::sin(2 * angle_rad + 3 * foot.turn_rad));
  const float left = std::max(0.0f, 1 - share / (0.55f + 0.45f * root));
  return 0.42f * left * left;
}

void write_mound(const Terrain& terrain, const Foot& foot, float grown, std::span<TerrainVertex, kMoundVertices> out) {
  constexpr std::array<float, kRings> kShares = {0.02f, 0.3f, 0.62f, 1};
  for (std::uint32_t ring = 0; ring < kRings; ++ring)
    for (std::uint32_t side = 0; side < kSides; ++side) {
      const float angle_rad = 2 * std::numbers::pi_v<float> * static_cast<float>(side) / kSides;
      const glm::vec2 at = foot.position + kShares[ring] * foot.radius_m * glm::vec2(std::cos(angle_rad), std::sin(angle_rad));
      const float above_m = grown * foot.radius_m * profile(foot, kShares[ring], angle_rad) - kSunk_m;
      TerrainVertex& vertex = out[ring * kSides + side];
      vertex.position = {at.x, height_at(terrain, at.x, at.y) + above_m, at.y};
      vertex.foot = grown * (1 - kShares[ring]);
    }
  // By neighbours along the ring and between rings.
  for (std::uint32_t ring = 0; ring < kRings; ++ring)
    for (std::uint32_t side = 0; side < kSides; ++side) {
      const auto at = [&](std::uint32_t of_ring, std::uint32_t of_side) { return out[of_ring * kSides + of_side % kSides].position; };
      const glm::vec3 outwards = at(std::min(ring + 1, kRings - 1), side) - at(ring == 0 ? 0 : ring - 1, side);
      const glm::vec3 along = at(std::max(ring, 1u), side + 1) - at(std::max(ring, 1u), side + kSides - 1);
      out[ring * kSides + side].normal = glm::normalize(glm::cross(along, outwards));
    }
}

}  // namespace

Feet make_feet(const Planting& planting) {
  Feet feet;
  if (planting.plants.size() < 2) return feet;
  constexpr float kCell_m = 4, kMostCells = 1024;
  feet.half_extent_m = planting.half_extent_m;
  feet.side = static_cast<std::uint32_t>(std::clamp(std::ceil(2 * planting.half_extent_m / kCell_m), 1.0f, kMostCells));
  feet.first.assign(std::size_t{feet.side} * feet.side + 1, 0);
  const auto cell = [&](const PlacedPlant& plant) { return cell_of(feet, plant.position.y) * feet.side + cell_of(feet, plant.position.x); };
  for (const PlacedPlant& plant : planting.plants) ++feet.first[cell(plant) + 1];
  for (std::size_t i = 1; i < feet.first.size(); ++i) feet.first[i] += feet.first[i - 1];
  std::vector<std::uint32_t> next(feet.first.begin(), feet.first.end() - 1);
  feet.feet.resize(planting.plants.size());
  for (const PlacedPlant& plant : planting.plants)
    feet.feet[next[cell(plant)]++] = {plant.position, std::clamp(0.3f * plant.crown_radius_m, 0.1f, kLargestFoot_m), plant.yaw_rad};
  return feet;
}

float foot_share(const Feet& feet, glm::vec2 at) {
  float share = 0;
  for_each_near(feet, at, kLargestFoot_m,
                [&](const Foot& foot) { share = std::max(share, 1 - glm::distance(foot.position, at) / foot.radius_m); });
  return share;
}

std::vector<std::uint32_t> mound_indices() {
  std::vector<std::uint32_t> indices;
  for (std::uint32_t mound = 0; mound < kMaxMounds; ++mound)
    for (std::uint32_t ring = 0; ring + 1 < kRings; ++ring)
      for (std::uint32_t side = 0; side < kSides; ++side) {
        const std::uint32_t a = mound * kMoundVertices + ring * kSides + side;
        const std::uint32_t b = mound * kMoundVertices + ring * kSides + (side + 1) % kSides;
        indices.insert(indices.end(), {a, b, b + kSides, a, b + kSides, a + kSides});
      }
  return indices;
}

std::size_t gather_mounds(const Terrain& terrain, const Feet& feet, const glm::mat4& clip_from_world, glm::vec3 eye,
                          std::span<TerrainVertex> out) {
  std::size_t count = 0;
  for_each_near(feet, {eye.x, eye.z}, kReach_m, [&](const Foot& foot) {
    const glm::vec3 at(foot.position.x, height_at(terrain, foot.position.x, foot.position.y), foot.position.y);
    // Small ones end before large ones: as many pixels remain of each.
    const float grown = 3 * (1 - glm::distance(at, eye) / (kReach_m * (0.3f + 0.7f * foot.radius_m / kLargestFoot_m)));
    if (grown <= 0 || count == kMaxMounds || !box_in_view(clip_from_world, at - foot.radius_m, at + foot.radius_m)) return;
    write_mound(terrain, foot, std::min(grown, 1.0f), out.subspan(count++ * kMoundVertices).first<kMoundVertices>());
  });
  return count;
}

}  // namespace forest
