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
constexpr float kMaxLean_rad = 0.05f;
// Neighbours' crowns may interlock: stems this share of the summed crown radii apart.
constexpr float kSpacingShare = 0.62f;
// Scales of grown plants, relative to their file.
constexpr float kSmallestScale = 0.66f, kLargestScale = 1.24f;

/// Accepted plants of crowns up to max_crown_m by square cell, for neighbour queries.
class CrownGrid {
 public:
  CrownGrid(float half_extent_m, float max_crown_m) : half_extent_m_(half_extent_m), max_crown_m_(max_crown_m) {
    constexpr float kMostCells = 2048;  // a side: enough for a few plants a cell, and 16 MB
    cell_m_ = std::max(2 * kSpacingShare * max_crown_m, 2 * half_extent_m / kMostCells);
    side_ = static_cast<int>(std::ceil(2 * half_extent_m / cell_m_)) + 1;
    first_.assign(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), kNone);
  }

  void add(const PlacedPlant& plant) {
    std::uint32_t& first = first_[index(cell_of(plant.position.x), cell_of(plant.position.y))];
    stems_.push_back({plant.position, plant.crown_radius_m, first});
    first = static_cast<std::uint32_t>(stems_.size() - 1);
  }

  [[nodiscard]] bool has_room(const PlacedPlant& candidate) const {
    const float reach_m = kSpacingShare * (max_crown_m_ + candidate.crown_radius_m);
    const glm::vec2 low = candidate.position - reach_m, high = candidate.position + reach_m;
    for (int z = cell_of(low.y); z <= cell_of(high.y); ++z)
      for (int x = cell_of(low.x); x <= cell_of(high.x); ++x)
        for (std::uint32_t i = first_[index(x, z)]; i != kNone; i = stems_[i].next) {
          const float spacing_m = kSpacingShare * (stems_[i].crown_radius_m + candidate.crown_radius_m);
          if (glm::distance(stems_[i].position, candidate.position) < spacing_m) return false;
        }
    return true;
  }
  [[nodiscard]] float max_crown_m() const { return max_crown_m_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  struct Stem {
    glm::vec2 position;
    float crown_radius_m;
    std::uint32_t next;  ///< in its cell
  };

  [[nodiscard]] int cell_of(float value) const { return std::clamp(static_cast<int>((value + half_extent_m_) / cell_m_), 0, side_ - 1); }
  [[nodiscard]] std::size_t index(int x, int z) const {
    return static_cast<std::size_t>(z) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(x);
  }

  float half_extent_m_, max_crown_m_, cell_m_ = 1;
  int side_ = 1;
  std::vector<std::uint32_t> first_;  ///< per cell
  std::vector<Stem> stems_;
};

/// Accepted plants in a grid per size of crown: a shrub's neighbours are found without looking at every shrub in a tree's reach.
class Occupancy {
 public:
  Occupancy(float half_extent_m, float largest_crown_m, float smallest_crown_m) {
    constexpr float kStep = 2.5f;
    grids_.emplace_back(half_extent_m, largest_crown_m);
    while (grids_.back().max_crown_m() > kStep * smallest_crown_m) grids_.emplace_back(half_extent_m, grids_.back().max_crown_m() / kStep);
  }
  void add(const PlacedPlant& plant) {
    std::size_t grid = grids_.size() - 1;
    while (grid > 0 && grids_[grid].max_crown_m() < plant.crown_radius_m) --grid;
    grids_[grid].add(plant);
  }
  [[nodiscard]] bool has_room(const PlacedPlant& candidate) const {
    return std::ranges::all_of(grids_, [&](const CrownGrid& grid) { return grid.has_room(candidate); });
  }

 private:
  std::vector<CrownGrid> grids_;  ///< largest crowns first
};

/// Where the trail may be near, so that most plants need not ask how far it is.
class TrailMap {
 public:
  TrailMap(const Trail& trail, float half_extent_m, float reach_m) : half_extent_m_(half_extent_m) {
    const float cell_m = 2 * half_extent_m / kSide;
    for (std::size_t i = 0; i < near_.size(); ++i) {
      const glm::vec2 center = (glm::vec2(i % kSide, i / kSide) + 0.5f) * cell_m - half_extent_m;
      near_[i] = distance_from(trail, center) < reach_m + cell_m;
    }
  }
  [[nodiscard]] bool near(glm::vec2 at) const {
    const auto cell = [&](float value) {
      return std::min(static_cast<std::size_t>(std::max((value + half_extent_m_) / (2 * half_extent_m_) * kSide, 0.0f)), kSide - 1);
    };
    return near_[cell(at.y) * kSide + cell(at.x)];
  }

 private:
  static constexpr std::size_t kSide = 256;
  float half_extent_m_;
  std::vector<bool> near_ = std::vector<bool>(kSide * kSide);
};

std::uint32_t choose_species(std::size_t species_count, glm::vec2 at, float dice, std::uint32_t seed) {
  if (species_count == 1) return 0;
  thread_local std::vector<float> share;
  share.resize(species_count);
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

// A slow field whose lows are clearings and whose highs are thickets.
bool grows_here(glm::vec2 at, float dice, std::uint32_t seed) {
  return dice < 0.8f + 1.6f * fractal_noise(at.x / 34, at.y / 34, 2, seed + 401);
}

/// The points of a jittered grid, and what would grow there if there were room.
struct Candidates {
  static constexpr std::uint16_t kUnknown = 0xffff, kNothing = 0xfffe;

  std::span<const Species> species;
  std::uint32_t seed = 0;
  float step_m = 1, half_extent_m = 0;
  int side = 0;
  std::vector<std::uint16_t> kinds;  ///< per point: its species, kNothing in a clearing, or not asked yet

  [[nodiscard]] std::vector<std::uint32_t> hashed_order() const {
    std::vector<std::uint64_t> keys(kinds.size());
    for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = std::uint64_t{hash(static_cast<std::int32_t>(i), side, seed + 1)} << 32 | i;
    std::ranges::sort(keys);
    std::vector<std::uint32_t> order(keys.size());
    std::ranges::transform(keys, order.begin(), [](std::uint64_t key) { return static_cast<std::uint32_t>(key); });
    return order;
  }

  /// Without its tint, which few will need. False: nothing grows there.
  bool make(std::uint32_t i, PlacedPlant& plant) {
    if (kinds[i] == kNothing) return false;
    const int x = static_cast<int>(i) % side;
    const int z = static_cast<int>(i) / side;
    const glm::vec2 jitter(hash01(x, z, seed + 7), hash01(x, z, seed + 8));
    plant.position = step_m * (glm::vec2(x, z) + jitter) - half_extent_m;
    if (kinds[i] == kUnknown)
      kinds[i] = grows_here(plant.position, hash01(x, z, seed + 9), seed)
                     ? static_cast<std::uint16_t>(choose_species(species.size(), plant.position, hash01(x, z, seed + 3), seed))
                     : kNothing;
    if (kinds[i] == kNothing) return false;
    plant.species = kinds[i];
    const float radius_m = species[plant.species].radius_m;
    plant.scale = fitting_scale(radius_m) * (kSmallestScale + (kLargestScale - kSmallestScale) * hash01(x, z, seed + 4));
    plant.crown_radius_m = kCrownShare * radius_m * plant.scale;
    return true;
  }
  [[nodiscard]] float dice(std::uint32_t i) const { return hash01(static_cast<int>(i) % side, static_cast<int>(i) / side, seed + 12); }
  void finish(std::uint32_t i, PlacedPlant& plant) const {
    const int x = static_cast<int>(i) % side;
    const int z = static_cast<int>(i) / side;
    plant.yaw_rad = 2 * std::numbers::pi_v<float> * hash01(x, z, seed + 5);
    plant.mirrored = hash01(x, z, seed + 15) < 0.5f;
    plant.lean_rad = kMaxLean_rad * (2.0f * glm::vec2(hash01(x, z, seed + 10), hash01(x, z, seed + 11)) - 1.0f);
    plant.slope_share = 0.2f + 0.4f * hash01(x, z, seed + 14);
    plant.tint = choose_tint(plant.position, hash01(x, z, seed + 6), seed);
  }
};

/// How many of so many are young.
std::uint32_t young_of(std::uint32_t count) {
  return count / 4;
}

/// The same plant, young: of half a metre at least.
void make_young(PlacedPlant& plant, float radius_m, float dice) {
  constexpr float kSmallest_m = 0.25f;
  const float age = std::min(std::max(0.16f + 0.26f * dice * dice, kSmallest_m / (radius_m * plant.scale)), 1.0f);
  plant.scale *= age;
  plant.crown_radius_m *= age;
}

// Young plants stand in thickets.
bool is_thicket(glm::vec2 at, std::uint32_t seed) {
  return gradient_noise(at.x / 8, at.y / 8, seed + 431) > 0.05f;
}

enum class Sweep { trees, shrubs, young };

std::vector<PlacedPlant> throw_darts(std::span<const Species> species, std::uint32_t count, std::uint32_t seed, const Planting& square) {
  float largest_m = 0;
  float smallest_m = 1e9f;
  for (const Species& s : species) {
    largest_m = std::max(largest_m, kCrownShare * s.radius_m * fitting_scale(s.radius_m));
    smallest_m = std::min(smallest_m, kCrownShare * s.radius_m * fitting_scale(s.radius_m));
  }
  // Some nine darts a plant find room for all of them; a small forest can afford more.
  const float most = std::max(1024.0f, 3 * std::sqrt(static_cast<float>(count)));
  Candidates candidates{species, seed, std::max(0.6f * smallest_m, 2 * square.half_extent_m / most), square.half_extent_m, 0, {}};
  candidates.side = static_cast<int>(2 * square.half_extent_m / candidates.step_m);
  candidates.kinds.assign(static_cast<std::size_t>(candidates.side) * static_cast<std::size_t>(candidates.side), Candidates::kUnknown);
  const std::vector<std::uint32_t> order = candidates.hashed_order();

  Occupancy occupancy(square.half_extent_m, kLargestScale * largest_m, kSmallestScale * smallest_m);
  const TrailMap trail(square.trail, square.half_extent_m, kTrailHalfWidth_m + 0.5f * kLargestScale * largest_m);
  const auto on_trail = [&](const PlacedPlant& plant) {
    return trail.near(plant.position) && distance_from(square.trail, plant.position) <= kTrailHalfWidth_m + 0.5f * plant.crown_radius_m;
  };
  std::vector<PlacedPlant> plants;
  plants.reserve(count);
  // Trees first, then what grows between them: in one sweep the many small plants would leave the few large ones no room.
  const std::uint32_t grown = count - young_of(count);
  for (const Sweep sweep : {Sweep::trees, Sweep::shrubs, Sweep::young})
    for (std::uint32_t i : order) {
      if (plants.size() == (sweep == Sweep::trees ? grown / 3 : sweep == Sweep::shrubs ? grown : count)) break;
      PlacedPlant candidate;
      if (!candidates.make(i, candidate)) continue;
      if (sweep == Sweep::trees && candidate.crown_radius_m < 0.6f * largest_m) continue;
      if (sweep == Sweep::young) {
        if (!is_thicket(candidate.position, seed)) continue;
        make_young(candidate, species[candidate.species].radius_m, candidates.dice(i));
      }
      if (on_trail(candidate) || !occupancy.has_room(candidate)) continue;
      candidates.finish(i, candidate);
      occupancy.add(candidate);
      plants.push_back(candidate);
    }
  return plants;
}

/// The plant as it is but for a size that fits, in the middle.
Planting plant_one(const Species& species, std::uint32_t seed) {
  PlacedPlant plant;
  plant.scale = fitting_scale(species.radius_m);
  plant.crown_radius_m = kCrownShare * species.radius_m * plant.scale;
  Planting planting;
  planting.half_extent_m = 30;
  planting.trail = make_trail(planting.half_extent_m, seed);
  planting.plants = {plant};
  return planting;
}

}  // namespace

float fitting_scale(float radius_m) {
  constexpr float kSmallest_m = 0.9f;
  constexpr float kLargest_m = 9;
  return std::clamp(radius_m, kSmallest_m, kLargest_m) / radius_m;
}

Planting plant_forest(std::span<const Species> species, std::uint32_t count, std::uint32_t seed) {
  if (count == 1) return plant_one(species.front(), seed);
  float mean_area_m2 = 0;
  for (const Species& s : species) {
    const float spacing_m = 2 * kSpacingShare * kCrownShare * s.radius_m * fitting_scale(s.radius_m);
    mean_area_m2 += spacing_m * spacing_m / static_cast<float>(species.size());
  }
  Planting planting;
  // A saturated square would be a hedge: room for about twice as many.
  planting.half_extent_m = std::max(30.0f, 0.85f * std::sqrt(static_cast<float>(count - young_of(count)) * mean_area_m2));
  for (;;) {
    planting.trail = make_trail(planting.half_extent_m, seed);
    planting.plants = throw_darts(species, count, seed, planting);
    if (planting.plants.size() == count) return planting;
    planting.half_extent_m *= 1.06f;
  }
}

}  // namespace forest
