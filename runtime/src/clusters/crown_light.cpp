#include "crown_light.h"

#include <algorithm>
#include <cmath>

#include "leaf_entry.h"

namespace coppice::gpu {
namespace {

constexpr std::size_t kCells = kCrownCells;

/// Leaves of random directions cover half their area.
constexpr float kExtinction = 0.5f;
/// With the weights below, a leaf at the crown's surface sees about this share of all directions: it counts as open.
constexpr float kOpenShare = 0.62f;

struct Direction {
  vec3 unit;
  float weight;
};

/// Six axes and eight diagonals: with these weights they average polynomials of degree five over the sphere exactly (Lebedev).
std::array<Direction, 14> directions() {
  std::array<Direction, 14> all{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t side = 0; side < 2; ++side) {
      all[2 * axis + side].unit[axis] = side == 0 ? 1.0f : -1.0f;
      all[2 * axis + side].weight = 1.0f / 15.0f;
    }
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) all[6 + i].unit[axis] = ((i >> axis & 1u) != 0 ? 1.0f : -1.0f) / std::sqrt(3.0f);
    all[6 + i].weight = 3.0f / 40.0f;
  }
  return all;
}

/// The grid of cells in a leaf box.
struct Grid {
  vec3 low, cell;                                            ///< m
  std::array<float, kCells * kCells * kCells> extinction{};  ///< 1/m

  explicit Grid(const LeafBox& box)
      : low(box.min), cell(max(box.step * static_cast<float>(box.largest), vec3(1e-3f)) * (1.0f / static_cast<float>(kCells))) {}
  /// Index of the cell of a place, which is given in cells from the box's low corner.
  [[nodiscard]] static std::size_t index(const vec3& at) {
    return (static_cast<std::size_t>(at.z) * kCells + static_cast<std::size_t>(at.y)) * kCells + static_cast<std::size_t>(at.x);
  }
  /// Optical depth from the middle of a cell to the box's surface.
  [[nodiscard]] float optical_depth(const vec3& from, const vec3& direction) const {
    const float step_m = 0.5f * std::min({cell.x, cell.y, cell.z});
    const vec3 step = direction * step_m / cell;
    const auto inside = [](float value) { return value >= 0.0f && value < static_cast<float>(kCells); };
    float depth = 0;
    for (vec3 at = from + 0.5f * step; inside(at.x) && inside(at.y) && inside(at.z); at += step) depth += extinction[index(at)];
    return depth * step_m;
  }
};

/// Spreads a leaf's area over the cells that it passes through.
void add_leaf(Grid& grid, const std::array<vec3, 4>& corners, float area_m2) {
  constexpr std::size_t kSamples = 4;
  const float volume_m3 = grid.cell.x * grid.cell.y * grid.cell.z;
  const float share = kExtinction * area_m2 / (volume_m3 * static_cast<float>(kSamples * kSamples));
  for (std::size_t i = 0; i < kSamples * kSamples; ++i) {
    const std::size_t row = i / kSamples, column = i % kSamples;
    const float u = (static_cast<float>(column) + 0.5f) / kSamples, v = (static_cast<float>(row) + 0.5f) / kSamples;
    const vec3 p = (1.0f - v) * ((1.0f - u) * corners[0] + u * corners[1]) + v * ((1.0f - u) * corners[3] + u * corners[2]);
    const vec3 at = clamp((p - grid.low) / grid.cell, vec3(0.0f), vec3(static_cast<float>(kCells) - 0.5f));
    grid.extinction[Grid::index(at)] += share;
  }
}

CrownSample sample_cell(const Grid& grid, const vec3& middle) {
  static const std::array<Direction, 14> all_directions = directions();
  CrownSample sample{};
  float sky_weight = 0;
  for (const Direction& direction : all_directions) {
    const float depth = grid.optical_depth(middle, direction.unit);
    sample.depth += direction.weight * depth;
    // The average of d d^T over the sphere is a third of the identity.
    sample.slope += 3.0f * direction.weight * depth * direction.unit;
    const float light = direction.weight * (0.6f + 0.4f * direction.unit.y);  // the sky is brighter above than below
    sample.sky += light * std::exp(-depth);
    sky_weight += light;
  }
  sample.sky = std::min(sample.sky / (sky_weight * kOpenShare), 1.0f);
  return sample;
}

}  // namespace

CrownLight measure_crown(const CrownSource& source) {
  const auto leaf_count = static_cast<std::uint32_t>(source.nodes.size() / 2 + 1);
  Grid grid(source.box);
  for (std::uint32_t id = 0; id < 2 * leaf_count - 1; ++id) {
    const PageNode& node = id == 0 ? source.root : source.nodes[id - 1];
    if (!lod::coppice_node_alive(id, node.split, leaf_count)) continue;
    std::array<vec3, 4> corners;
    std::ranges::transform(node.corners, corners.begin(), [&](const QuantisedPoint& q) { return source.box.at({q[0], q[1], q[2]}); });
    add_leaf(grid, corners, covered_area_m2(quad_area(corners), source.looks[node.card], node.opacity));
  }
  CrownLight light;
  light.box = source.box;
  std::size_t cell = 0;
  for (std::size_t z = 0; z < kCells; ++z)
    for (std::size_t y = 0; y < kCells; ++y)
      for (std::size_t x = 0; x < kCells; ++x)
        light.words[cell++] =
            pack_crown(sample_cell(grid, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, static_cast<float>(z) + 0.5f}));
  return light;
}

}  // namespace coppice::gpu
