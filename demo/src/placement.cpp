// Dart throwing. Candidates are the points of a jittered fine grid, visited in a hashed order; a candidate becomes a plant unless a
// clearing, the trail or an earlier plant is too close. Each species has its own slow noise field: where it is high that species is
// likelier, which gives groves instead of an even mix.
#include "placement.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "noise.h"

namespace forest {
namespace {

constexpr float kTrailHalfWidth_m = 1.1f;
// Crowns as a share of the bounding sphere: trees are taller than wide.
constexpr float kCrownShare = 0.62f;
// Neighbours' crowns may interlock: stems this share of the summed crown radii apart.
constexpr float kSpacingShare = 0.62f;

/// Accepted plants by square cell, for neighbour queries.
struct Occupancy {
  float cell_m = 1;
  int side = 1;
  float half_extent_m = 0;
  std::vector<std::vector<std::uint32_t>> cells;

  Occupancy(float half_extent, float reach_m)
      : cell_m(reach_m), side(static_cast<int>(std::ceil(2 * half_extent / reach_m)) + 1), half_extent_m(half_extent) {
    cells.resize(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  }
  [[nodiscard]] int cell_of(float value) const { return std::clamp(static_cast<int>((value + half_extent_m) / cell_m), 0, side - 1); }
  std::vector<std::uint32_t>& at(int x, int z) {
    return cells[static_cast<std::size_t>(z) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x)];
  }
};

bool has_room(Occupancy& occupancy, const std::vector<PlacedPlant>& plants, const PlacedPlant& candidate) {
  const int cell_x = occupancy.cell_of(candidate.position.x);
  const int cell_z = occupancy.cell_of(candidate.position.y);
  for (int z = std::max(cell_z - 1, 0); z <= std::min(cell_z + 1, occupancy.side - 1); ++z)
    for (int x = std::max(cell_x - 1, 0); x <= std::min(cell_x + 1, occupancy.side - 1); ++x)
      for (std::uint32_t i : occupancy.at(x, z)) {
        const float spacing_m = kSpacingShare * (plants[i].crown_radius_m + candidate.crown_radius_m);
        if (glm::distance(plants[i].position, candidate.position) < spacing_m) return false;
      }
  return true;
}

// Plants of a hand's or a cathedral's size are brought into a forest's range; within it the file's metres are kept.
float fitting_scale(float radius_m) {
  constexpr float kSmallest_m = 0.9f;
  constexpr float kLargest_m = 9;
  return std::clamp(radius_m, kSmallest_m, kLargest_m) / radius_m;
}

std::uint32_t choose_species(std::size_t species_count, glm::vec2 at, float dice, std::uint32_t seed) {
  std::vector<float> share(species_count);
  for (std::size_t s = 0; s < species_count; ++s)
    share[s] = std::exp(2.2f * gradient_noise(at.x / 21, at.y / 21, seed + 211 + static_cast<std::uint32_t>(s)));
  float left = dice * std::accumulate(share.begin(), share.end(), 0.0f);
  for (std::size_t s = 0; s + 1 < species_count; ++s) {
    left -= share[s];
    if (left < 0) return static_cast<std::uint32_t>(s);
  }
  return static_cast<std::uint32_t>(species_count - 1);
}

// Warm to cool green and light to dark, mostly small steps, with a few odd ones.
glm::vec3 choose_tint(glm::vec2 at, float dice, std::uint32_t seed) {
  const float warm = 0.6f * gradient_noise(at.x / 13, at.y / 13, seed + 307) + 0.8f * (dice - 0.5f);
  const float light = 1 + 0.22f * (hash01(static_cast<std::int32_t>(at.x * 64), static_cast<std::int32_t>(at.y * 64), seed) - 0.5f);
  return light * glm::vec3(1 + 0.22f * warm, 1, 1 - 0.28f * warm);
}

PlacedPlant make_candidate(std::span<const Species> species, int x, int z, glm::vec2 at, std::uint32_t seed) {
  PlacedPlant plant;
  plant.position = at;
  plant.species = choose_species(species.size(), at, hash01(x, z, seed + 3), seed);
  const float radius_m = species[plant.species].radius_m;
  plant.scale = fitting_scale(radius_m) * (0.72f + 0.5f * hash01(x, z, seed + 4));
  plant.crown_radius_m = kCrownShare * radius_m * plant.scale;
  plant.yaw_rad = 2 * std::numbers::pi_v<float> * hash01(x, z, seed + 5);
  plant.tint = choose_tint(at, hash01(x, z, seed + 6), seed);
  return plant;
}

// A slow field whose lows are clearings and whose highs are thickets.
bool grows_here(const Trail& trail, const PlacedPlant& plant, float dice, std::uint32_t seed) {
  const float density = 0.8f + 1.6f * fractal_noise(plant.position.x / 34, plant.position.y / 34, 2, seed + 401);
  return dice < density && distance_from(trail, plant.position) > kTrailHalfWidth_m + 0.5f * plant.crown_radius_m;
}

enum class Sweep { trees, undergrowth };

std::vector<PlacedPlant> throw_darts(std::span<const Species> species, std::uint32_t count, std::uint32_t seed, const Planting& square) {
  float largest_m = 0;
  float smallest_m = 1e9f;
  for (const Species& s : species) {
    largest_m = std::max(largest_m, kCrownShare * s.radius_m * fitting_scale(s.radius_m));
    smallest_m = std::min(smallest_m, kCrownShare * s.radius_m * fitting_scale(s.radius_m));
  }
  const float step_m = std::max(0.6f * smallest_m, 2 * square.half_extent_m / 1024);
  const int side = static_cast<int>(2 * square.half_extent_m / step_m);
  std::vector<std::uint32_t> order(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) { return hash(static_cast<std::int32_t>(i), side, seed + 1); };
  std::ranges::sort(order, [&](auto a, auto b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });

  Occupancy occupancy(square.half_extent_m, 2.5f * kSpacingShare * largest_m);
  std::vector<PlacedPlant> plants;
  // Trees first, then what grows between them: in one sweep the many small plants would leave the few large ones no room.
  for (const Sweep sweep : {Sweep::trees, Sweep::undergrowth})
    for (std::uint32_t i : order) {
      if (plants.size() == (sweep == Sweep::trees ? count / 3 : count)) break;
      const int x = static_cast<int>(i) % side;
      const int z = static_cast<int>(i) / side;
      const glm::vec2 jitter(hash01(x, z, seed + 7), hash01(x, z, seed + 8));
      const glm::vec2 at = step_m * (glm::vec2(x, z) + jitter) - square.half_extent_m;
      const PlacedPlant candidate = make_candidate(species, x, z, at, seed);
      if (sweep == Sweep::trees && candidate.crown_radius_m < 0.6f * largest_m) continue;
      if (!grows_here(square.trail, candidate, hash01(x, z, seed + 9), seed) || !has_room(occupancy, plants, candidate)) continue;
      occupancy.at(occupancy.cell_of(at.x), occupancy.cell_of(at.y)).push_back(static_cast<std::uint32_t>(plants.size()));
      plants.push_back(candidate);
    }
  return plants;
}

/// The plant as it is but for a size that fits, in the middle.
Planting plant_one(const Species& species, std::uint32_t seed) {
  PlacedPlant plant;
  plant.scale = fitting_scale(species.radius_m);
  plant.crown_radius_m = kCrownShare * species.radius_m * plant.scale;
  plant.tint = glm::vec3(1);
  Planting planting;
  planting.half_extent_m = 30;
  planting.trail = make_trail(planting.half_extent_m, seed);
  planting.plants = {plant};
  return planting;
}

}  // namespace

Planting plant_forest(std::span<const Species> species, std::uint32_t count, std::uint32_t seed) {
  if (count == 1) return plant_one(species.front(), seed);
  float mean_area_m2 = 0;
  for (const Species& s : species) {
    const float spacing_m = 2 * kSpacingShare * kCrownShare * s.radius_m * fitting_scale(s.radius_m);
    mean_area_m2 += spacing_m * spacing_m / static_cast<float>(species.size());
  }
  Planting planting;
  // A saturated square would be a hedge: room for about twice as many.
  planting.half_extent_m = std::max(30.0f, 0.85f * std::sqrt(static_cast<float>(count) * mean_area_m2));
  for (;;) {
    planting.trail = make_trail(planting.half_extent_m, seed);
    planting.plants = throw_darts(species, count, seed, planting);
    if (planting.plants.size() == count) return planting;
    planting.half_extent_m *= 1.06f;
  }
}

}  // namespace forest
