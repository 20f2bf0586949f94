#include "leaf_placement.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "bounds.h"
#include "check.h"

namespace coppice::bake {
namespace {

/// Leaves at a stem's pointed end stand this far from its axis: a whorl there would share one point.
constexpr float kMinStandOffM = 0.0015f;

/// Vertices of the leaves placed so far, in cells as wide as the gap that must stay between two leaves.
class VertexGrid {
 public:
  explicit VertexGrid(float gap) : gap_(gap) {}

  [[nodiscard]] bool is_free(const glm::vec3& point) const {
    const glm::ivec3 centre = cell(point);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (touches(key(centre + glm::ivec3(x, y, z)), point)) return false;
    return true;
  }

  void add(const glm::vec3& point) { cells_.emplace(key(cell(point)), point); }

 private:
  [[nodiscard]] glm::ivec3 cell(const glm::vec3& point) const { return glm::ivec3(glm::floor(point / gap_)); }
  static std::uint64_t key(const glm::ivec3& cell) {
    constexpr std::uint64_t kMask = (1u << 21) - 1;
    const auto part = [](int value) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(value)) & kMask; };
    return part(cell.x) << 42 | part(cell.y) << 21 | part(cell.z);
  }
  [[nodiscard]] bool touches(std::uint64_t cell_key, const glm::vec3& point) const {
    const auto [first, last] = cells_.equal_range(cell_key);
    return std::any_of(first, last, [&](const auto& entry) { return glm::distance(entry.second, point) < gap_; });
  }

  float gap_;
  std::unordered_multimap<std::uint64_t, glm::vec3> cells_;
};

float box_diagonal(const std::vector<Stem>& stems) {
  PointBox<glm::vec3> box;
  for (const Stem& stem : stems) std::ranges::for_each(stem.points, [&box](const glm::vec3& point) { box.add(point); });
  return glm::distance(box.low, box.high);
}

/// Leaves per stem: the running sum of length times density, rounded, so that the total is exact.
std::vector<std::uint32_t> leaf_quotas(const Species& species, const std::vector<Stem>& stems) {
  const auto weight = [&](const Stem& stem) {
    const StemLevel& level = species.levels[stem.level];
    return static_cast<double>(level.leaves_per_m * stem.length() * (1.0f - level.leaf_first_fraction));
  };
  double total = 0.0;
  for (const Stem& stem : stems) total += weight(stem);
  COPPICE_ASSERT(total > 0.0);
  std::vector<std::uint32_t> quotas;
  double running = 0.0;
  std::uint32_t given = 0;
  for (const Stem& stem : stems) {
    running += weight(stem);
    const auto upto = static_cast<std::uint32_t>(std::lround(running / total * static_cast<double>(species.leaf_count)));
    quotas.push_back(upto - given);
    given = upto;
  }
  COPPICE_ASSERT(given == species.leaf_count);
  return quotas;
}

/// Turn of leaf `index` round its stem.
float leaf_turn_deg(const LeafHabit& habit, std::uint32_t index) {
  if (habit.whorl_count == 1) return kGoldenAngleDeg * static_cast<float>(index);
  const float step_deg = 360.0f / static_cast<float>(habit.whorl_count);
  const std::uint32_t node = index / habit.whorl_count;
  return step_deg * (static_cast<float>(index % habit.whorl_count) + 0.5f * static_cast<float>(node));
}

/// Turns the upper surface to the light as far as the leaf's direction allows.
glm::vec3 leaf_normal(const Species& species, const glm::vec3& position, const glm::vec3& along, SeededRandom& random) {
  const LeafHabit& habit = species.habit;
  const glm::vec3 jitter{random.around(habit.jitter), random.around(habit.jitter), random.around(habit.jitter)};
  const glm::vec3 light = habit.up_weight * kUp + habit.out_weight * out_of_crown(species, position) + jitter;
  const glm::vec3 across = light - glm::dot(light, along) * along;
  return glm::length(across) > 1e-3f ? glm::normalize(across) : cross_axes(along).first;
}

PlacedLeaf place_leaf(const Species& species, const Stem& stem, float fraction, float turn_deg, SeededRandom& random) {
  const LeafHabit& habit = species.habit;
  const StemPoint at = point_on(stem, fraction);
  const CrossAxes axes = cross_axes(at.tangent);
  const float turn = glm::radians(turn_deg), angle = glm::radians(habit.angle_deg + random.around(habit.angle_spread_deg));
  const glm::vec3 radial = std::cos(turn) * axes.first + std::sin(turn) * axes.second;
  const glm::vec3 outwards = std::cos(angle) * at.tangent + std::sin(angle) * radial;
  PlacedLeaf leaf;
  leaf.petiole_start = at.position + 0.5f * at.radius * radial;
  leaf.pose.stalk = at.position + std::max(at.radius, kMinStandOffM) * radial + habit.petiole_m * (1.0f + random.around(0.25f)) * outwards;
  leaf.pose.along = glm::normalize(outwards - habit.gravity * kUp);
  leaf.pose.normal = leaf_normal(species, at.position, leaf.pose.along, random);
  leaf.pose.length_m = habit.length_m * glm::mix(1.0f, habit.tip_scale, fraction) * (1.0f + random.around(habit.length_spread));
  leaf.pose.width_scale = 1.0f + random.around(habit.width_spread);
  return leaf;
}

bool stands_apart(const VertexGrid& grid, const Mesh& leaf, const LeafPose& pose) {
  return std::ranges::all_of(leaf.positions, [&](const glm::vec3& point) { return grid.is_free(posed(pose, point)); });
}

}  // namespace

std::vector<PlacedLeaf> place_leaves(const Species& species, const std::vector<Stem>& stems, const Mesh& leaf, SeededRandom& random) {
  constexpr int kMaxAttempts = 64;
  const std::vector<std::uint32_t> quotas = leaf_quotas(species, stems);
  VertexGrid grid(kLeafGap * box_diagonal(stems));
  std::vector<PlacedLeaf> leaves;
  for (std::size_t s = 0; s < stems.size(); ++s) {
    const float first_fraction = species.levels[stems[s].level].leaf_first_fraction;
    const std::uint32_t whorl = species.habit.whorl_count;
    const std::uint32_t node_count = (quotas[s] + whorl - 1) / whorl;
    const float phase_deg = 360.0f * random.unit();
    for (std::uint32_t index = 0; index < quotas[s]; ++index) {
      const std::uint32_t node = index / whorl;
      const float rank = static_cast<float>(node + 1) / static_cast<float>(node_count);
      const float fraction = glm::mix(first_fraction, 1.0f, rank);
      PlacedLeaf placed;
      int attempts = 0;
      do {  // a clash is rare; the next attempt draws other numbers
        COPPICE_ASSERT(attempts++ < kMaxAttempts);
        placed = place_leaf(species, stems[s], fraction, phase_deg + leaf_turn_deg(species.habit, index) + random.around(6.0f), random);
      } while (!stands_apart(grid, leaf, placed.pose));
      for (const glm::vec3& point : leaf.positions) grid.add(posed(placed.pose, point));
      leaves.push_back(placed);
    }
  }
  return leaves;
}

}  // namespace coppice::bake
