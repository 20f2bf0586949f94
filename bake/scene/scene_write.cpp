// The tree is built in place, like a sort by halving: a tile moves the plants that it keeps to the front of its run, and the rest is
// partitioned into four runs, one per quadrant. If a tile has more plants than it can hold, it keeps half of them by size, the largest
// first, since these must be visible from farther away; and half by place, the largest in each cell of a grid over the square, so that a
// far square shows plants all over. Everything is ordered by value, not by its place in the input.

#include "scene_write.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>

#include "layout.h"
#include "printable.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kKeptBySize = COPPICE_MAX_TILE_INSTANCES / 2;
constexpr std::size_t kSpreadSide = 32;
static_assert(kKeptBySize + kSpreadSide * kSpreadSide == COPPICE_MAX_TILE_INSTANCES);

struct Tile {
  std::span<ScenePlant> plants;  ///< kept, then those of its descendants
  std::size_t kept = 0;
  std::array<float, 2> square_min_m{};
  float square_side_m = 0.0f;
  std::uint32_t level = 0;
  std::uint32_t first_child = 0, child_mask = 0;
};

class TreeBuilder {
 public:
  TreeBuilder(std::span<const SceneSpecies> species, std::span<ScenePlant> plants) : species_(species), plants_(plants) {}

  Result<std::vector<Tile>> build() {
    std::vector<Tile> tiles{root()};
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      if (tiles.size() > COPPICE_MAX_SCENE_TILES - 4) return Error{Status::invalid_argument, "scene: too many tiles"};
      Tile tile = tiles[i];
      if (tile.plants.size() <= COPPICE_MAX_TILE_INSTANCES) {
        tile.kept = tile.plants.size();
      } else {
        if (tile.level + 1 >= COPPICE_MAX_SCENE_LEVELS)
          return Error{Status::invalid_argument, "scene: too many plants in one place", Error::kNoOffset, place_of(tile)};
        keep(tile);
        tile.first_child = static_cast<std::uint32_t>(tiles.size());
        add_children(tile, tiles);
      }
      tiles[i] = tile;
    }
    return tiles;
  }

 private:
  float radius_m(const ScenePlant& plant) const { return plant.scale * species_[plant.species].sphere_radius_m; }

  /// Larger plants come first. A total order, so that the same plants in another order make the same tree.
  bool before(const ScenePlant& a, const ScenePlant& b) const {
    const float radius_a = radius_m(a), radius_b = radius_m(b);
    if (radius_a != radius_b) return radius_a > radius_b;
    return std::tie(a.position_m, a.species, a.scale, a.yaw, a.tint, a.mirrored) <
           std::tie(b.position_m, b.species, b.scale, b.yaw, b.tint, b.mirrored);
  }

  /// A square of whole metres round all plants.
  Tile root() const {
    Tile tile;
    tile.plants = plants_;
    std::array<float, 2> low{INFINITY, INFINITY}, high{-INFINITY, -INFINITY};
    for (const ScenePlant& plant : plants_)
      for (std::size_t i = 0; i < 2; ++i) {
        low[i] = std::min(low[i], plant.position_m[2 * i]);
        high[i] = std::max(high[i], plant.position_m[2 * i]);
      }
    for (std::size_t i = 0; i < 2; ++i) tile.square_min_m[i] = std::floor(low[i]);
    tile.square_side_m = std::max({1.0f, std::ceil(high[0] - tile.square_min_m[0]), std::ceil(high[1] - tile.square_min_m[1])});
    return tile;
  }

  void keep(Tile& tile) {
    const auto larger = [this](const ScenePlant& a, const ScenePlant& b) { return before(a, b); };
    std::ranges::nth_element(tile.plants, tile.plants.begin() + kKeptBySize, larger);
    constexpr std::uint32_t kNone = 0xffffffffu;
    std::vector<std::uint32_t> best(kSpreadSide * kSpreadSide, kNone);
    const auto cell_of = [&](float at, float min) {
      const float cell = (at - min) / tile.square_side_m * static_cast<float>(kSpreadSide);
      return static_cast<std::size_t>(std::clamp(cell, 0.0f, static_cast<float>(kSpreadSide - 1)));
    };
    for (std::size_t i = kKeptBySize; i < tile.plants.size(); ++i) {
      const ScenePlant& plant = tile.plants[i];
      std::uint32_t& cell =
          best[cell_of(plant.position_m[2], tile.square_min_m[1]) * kSpreadSide + cell_of(plant.position_m[0], tile.square_min_m[0])];
      if (cell == kNone || before(plant, tile.plants[cell])) cell = static_cast<std::uint32_t>(i);
    }
    std::erase(best, kNone);
    std::ranges::sort(best);
    tile.kept = kKeptBySize;
    for (const std::uint32_t i : best) std::swap(tile.plants[tile.kept++], tile.plants[i]);
  }

  static void add_children(Tile& tile, std::vector<Tile>& tiles) {
    const float side_m = 0.5f * tile.square_side_m;
    const float middle_x = tile.square_min_m[0] + side_m, middle_z = tile.square_min_m[1] + side_m;
    const std::span<ScenePlant> rest = tile.plants.subspan(tile.kept);
    const auto middle = std::partition(rest.begin(), rest.end(), [&](const ScenePlant& plant) { return plant.position_m[2] < middle_z; });
    const auto left = [&](const ScenePlant& plant) { return plant.position_m[0] < middle_x; };
    const std::array<std::span<ScenePlant>::iterator, 5> ends = {rest.begin(), std::partition(rest.begin(), middle, left), middle,
                                                                 std::partition(middle, rest.end(), left), rest.end()};
    for (std::uint32_t quadrant = 0; quadrant < 4; ++quadrant) {
      if (ends[quadrant] == ends[quadrant + 1]) continue;
      tile.child_mask |= 1u << quadrant;
      Tile child;
      child.plants = {ends[quadrant], ends[quadrant + 1]};
      child.square_min_m = {(quadrant & 1u) != 0 ? middle_x : tile.square_min_m[0], (quadrant & 2u) != 0 ? middle_z : tile.square_min_m[1]};
      child.square_side_m = side_m;
      child.level = tile.level + 1;
      tiles.push_back(child);
    }
  }

  static std::string place_of(const Tile& tile) {
    return std::to_string(tile.plants.size()) + " within " + std::to_string(tile.square_side_m) + " m of x " +
           std::to_string(tile.square_min_m[0]) + ", z " + std::to_string(tile.square_min_m[1]);
  }

  std::span<const SceneSpecies> species_;
  std::span<ScenePlant> plants_;
};

std::uint16_t quantise(float value, float low, float high) {
  return high > low ? static_cast<std::uint16_t>(std::lround(65535.0f * std::clamp((value - low) / (high - low), 0.0f, 1.0f)))
                    : std::uint16_t{0};
}

/// The place along a Z-shaped curve. Neighbours follow each other, so that they are culled together.
std::uint32_t morton_code(const coppice_scene_instance& instance) {
  const auto spread = [](std::uint32_t bits) {
    bits = (bits | bits << 8) & 0x00ff00ffu;
    bits = (bits | bits << 4) & 0x0f0f0f0fu;
    bits = (bits | bits << 2) & 0x33333333u;
    return (bits | bits << 1) & 0x55555555u;
  };
  return spread(instance.position[0]) | spread(instance.position[2]) << 1;
}

/// Appends the tile's instances to `bytes` and fills its entry.
coppice_scene_tile encode_tile(const Tile& tile, std::span<const SceneSpecies> species, std::vector<std::uint8_t>& bytes) {
  coppice_scene_tile entry{};
  const std::span<const ScenePlant> kept = tile.plants.first(tile.kept);
  std::fill_n(entry.box_min, 3, INFINITY);
  std::fill_n(entry.box_max, 3, -INFINITY);
  entry.scale_min = INFINITY;
  for (const ScenePlant& plant : kept) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      entry.box_min[axis] = std::min(entry.box_min[axis], plant.position_m[axis]);
      entry.box_max[axis] = std::max(entry.box_max[axis], plant.position_m[axis]);
    }
    entry.scale_min = std::min(entry.scale_min, plant.scale);
    entry.scale_max = std::max(entry.scale_max, plant.scale);
  }
  const float log_scales = std::log(entry.scale_max / entry.scale_min);
  std::vector<coppice_scene_instance> instances;
  for (const ScenePlant& plant : kept) {
    coppice_scene_instance instance{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      instance.position[axis] = quantise(plant.position_m[axis], entry.box_min[axis], entry.box_max[axis]);
    instance.species = static_cast<std::uint16_t>(plant.species | (plant.mirrored ? COPPICE_SCENE_MIRRORED : 0u));
    instance.yaw = static_cast<std::uint8_t>((plant.yaw + 128u) >> 8);
    // Rounds down: no decoded plant may be larger than the tile's, and its parent's, largest.
    if (log_scales > 0.0f)
      instance.scale = static_cast<std::uint8_t>(std::clamp(255.0f * std::log(plant.scale / entry.scale_min) / log_scales, 0.0f, 255.0f));
    instance.tint = plant.tint;
    entry.max_radius = std::max(entry.max_radius, plant.scale * species[plant.species].sphere_radius_m);
    instances.push_back(instance);
  }
  const auto key = [](const coppice_scene_instance& i) {
    return std::tuple(morton_code(i), i.position[0], i.position[1], i.position[2], i.species, i.scale, i.yaw, i.tint);
  };
  std::ranges::sort(instances, [&](const auto& a, const auto& b) { return key(a) < key(b); });
  const std::size_t at = bytes.size();
  bytes.resize(at + instances.size() * sizeof(coppice_scene_instance));
  std::memcpy(bytes.data() + at, instances.data(), bytes.size() - at);
  entry.instance_count = static_cast<std::uint32_t>(instances.size());
  entry.first_child = tile.first_child;
  entry.child_mask = tile.child_mask;
  entry.checksum = checksum(std::span(bytes).subspan(at));
  return entry;
}

/// Keeps the scales of a tile within COPPICE_MAX_SCENE_SCALE_RATIO.
constexpr float kMinScale = 1e-23f;

Result<void> check_input(std::span<const SceneSpecies> species, std::span<const ScenePlant> plants) {
  if (plants.empty()) return Error{Status::invalid_argument, "scene: no plant"};
  if (species.empty() || species.size() > COPPICE_MAX_SCENE_SPECIES)
    return Error{Status::invalid_argument, "scene: number of species", Error::kNoOffset, std::to_string(species.size())};
  for (const SceneSpecies& entry : species) {
    if (entry.path.empty() || entry.path.size() > COPPICE_MAX_SCENE_PATH_BYTES || entry.path[0] == '/')
      return Error{Status::invalid_argument, "scene: a species' path must be relative and not too long", Error::kNoOffset, entry.path};
    if (!is_printable(entry.path))
      return Error{Status::invalid_argument, "scene: control characters in a species' path", Error::kNoOffset, entry.path};
    if (!(entry.sphere_radius_m > 0.0f) || !std::isfinite(entry.sphere_radius_m))
      return Error{Status::invalid_argument, "scene: a species has no size", Error::kNoOffset, entry.path};
  }
  for (const ScenePlant& plant : plants) {
    const bool finite = std::ranges::all_of(plant.position_m, [](float at) { return std::abs(at) <= 5e6f; });
    if (!finite || plant.species >= species.size() || !(plant.scale >= kMinScale && plant.scale <= COPPICE_MAX_SCENE_SCALE))
      return Error{Status::invalid_argument, "scene: a plant's place, species or scale is out of range", Error::kNoOffset,
                   "plant " + std::to_string(&plant - plants.data())};
  }
  return {};
}

template <class T>
void put(std::vector<std::uint8_t>& bytes, std::size_t& at, const T& value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
  at += sizeof value;
}

}  // namespace

std::uint16_t pack_tint(const std::array<float, 3>& rgb) {
  const auto bits = [](float value, float one, float max) {
    return static_cast<std::uint16_t>(std::lround(std::clamp(value * one, 0.0f, max)));
  };
  return static_cast<std::uint16_t>(bits(rgb[0], 16, 31) | bits(rgb[1], 32, 63) << 5 | bits(rgb[2], 16, 31) << 11);
}

Result<std::vector<std::uint8_t>> encode_scene(std::span<const SceneSpecies> species, std::span<ScenePlant> plants,
                                               SceneStatistics* statistics, const std::function<void(float)>& progress) {
  COPPICE_CHECK(check_input(species, plants));
  COPPICE_TRY(tiles, TreeBuilder(species, plants).build());
  if (progress) progress(0.5f);
  coppice_scene_header header{};
  std::memcpy(header.magic, COPPICE_SCENE_MAGIC, sizeof header.magic);
  header.version = COPPICE_SCENE_VERSION;
  header.species_count = static_cast<std::uint32_t>(species.size());
  header.tile_count = static_cast<std::uint32_t>(tiles.size());
  for (const SceneSpecies& entry : species) header.path_bytes += static_cast<std::uint32_t>(entry.path.size());
  header.instance_count = plants.size();
  std::ranges::copy(tiles[0].square_min_m, header.square_min);
  header.square_side = tiles[0].square_side_m;
  const auto front_bytes = static_cast<std::size_t>(scene_front_bytes(header));
  header.file_bytes = front_bytes + plants.size() * sizeof(coppice_scene_instance);

  std::vector<std::uint8_t> bytes(front_bytes);
  bytes.reserve(static_cast<std::size_t>(header.file_bytes));
  std::size_t at = kSceneHeaderBytes;
  std::uint32_t path_offset = 0;
  for (const SceneSpecies& entry : species) {
    coppice_scene_species stored{path_offset, static_cast<std::uint32_t>(entry.path.size()), {}, entry.sphere_radius_m};
    std::ranges::copy(entry.sphere_center, stored.sphere_center);
    put(bytes, at, stored);
    path_offset += stored.path_bytes;
  }
  for (const SceneSpecies& entry : species) {
    std::memcpy(bytes.data() + at, entry.path.data(), entry.path.size());
    at += entry.path.size();
  }
  std::uint32_t level_count = 0;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    put(bytes, at, encode_tile(tiles[i], species, bytes));
    level_count = std::max(level_count, tiles[i].level + 1);
    if (progress && i % 256 == 0) progress(0.5f + 0.5f * static_cast<float>(i) / static_cast<float>(tiles.size()));
  }
  header.front_checksum = checksum(std::span(bytes).first(front_bytes).subspan(kSceneHeaderBytes));
  std::memcpy(bytes.data(), &header, sizeof header);
  header.header_checksum = checksum(std::span(bytes).first(offsetof(coppice_scene_header, header_checksum)));
  std::memcpy(bytes.data(), &header, sizeof header);
  if (statistics != nullptr) *statistics = {plants.size(), header.tile_count, level_count, bytes.size()};
  return bytes;
}

}  // namespace coppice::bake
