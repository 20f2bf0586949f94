#include "crown_light.h"

#include <algorithm>
#include <cmath>

#include "coppice_lod.h"
#include "points.h"

namespace coppice::gpu {
namespace {

constexpr std::size_t kCells = kCrownCells;

/// Leaves of all directions cover half their area.
constexpr float kExtinction = 0.5f;
/// A leaf at the crown's surface sees about this share of all directions, by the weights below: it counts as open.
constexpr float kOpenShare = 0.62f;

struct Direction {
  Point unit;
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

/// The cells of a leaf box.
struct Cells {
  Point low{}, cell{};  ///< m

  explicit Cells(const LeafBox& box) : low{box.min.x, box.min.y, box.min.z} {
    const Point step{box.step.x, box.step.y, box.step.z};
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell[axis] = std::max(step[axis] * static_cast<float>(box.largest), 1e-3f) / static_cast<float>(kCells);
  }
  /// In cells; 0 at the box's low side.
  [[nodiscard]] Point place(const Point& p) const {
    return {(p[0] - low[0]) / cell[0], (p[1] - low[1]) / cell[1], (p[2] - low[2]) / cell[2]};
  }
  [[nodiscard]] static std::size_t index(std::size_t x, std::size_t y, std::size_t z) { return (z * kCells + y) * kCells + x; }
};

struct Grid : Cells {
  std::vector<float> extinction = std::vector<float>(kCells * kCells * kCells);  ///< 1/m

  using Cells::Cells;
  /// From the middle of a cell to the box's surface.
  [[nodiscard]] float optical_depth(const Point& from, const Point& direction) const {
    const float step_m = 0.5f * std::min({cell[0], cell[1], cell[2]});
    const Point step{direction[0] * step_m / cell[0], direction[1] * step_m / cell[1], direction[2] * step_m / cell[2]};
    float depth = 0;
    Point at{from[0] + 0.5f * step[0], from[1] + 0.5f * step[1], from[2] + 0.5f * step[2]};
    const auto inside = [](float value) { return value >= 0.0f && value < static_cast<float>(kCells); };
    while (inside(at[0]) && inside(at[1]) && inside(at[2])) {
      depth += extinction[index(static_cast<std::size_t>(at[0]), static_cast<std::size_t>(at[1]), static_cast<std::size_t>(at[2]))];
      for (std::size_t axis = 0; axis < 3; ++axis) at[axis] += step[axis];
    }
    return depth * step_m;
  }
};

/// Spreads a leaf's area over the cells it passes through.
void add_leaf(Grid& grid, const std::array<Point, 4>& corners, float area_m2) {
  constexpr std::size_t kSamples = 4;
  const float volume_m3 = grid.cell[0] * grid.cell[1] * grid.cell[2];
  const float share = kExtinction * area_m2 / (volume_m3 * static_cast<float>(kSamples * kSamples));
  for (std::size_t i = 0; i < kSamples * kSamples; ++i) {
    const float u = (static_cast<float>(i % kSamples) + 0.5f) / kSamples, v = (static_cast<float>(i / kSamples) + 0.5f) / kSamples;
    Point p{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] =
          (1.0f - v) * ((1.0f - u) * corners[0][axis] + u * corners[1][axis]) + v * ((1.0f - u) * corners[3][axis] + u * corners[2][axis]);
    const Point at = grid.place(p);
    std::array<std::size_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<std::size_t>(std::clamp(at[axis], 0.0f, static_cast<float>(kCells) - 0.5f));
    grid.extinction[Grid::index(cell[0], cell[1], cell[2])] += share;
  }
}

CrownSample sample_cell(const Grid& grid, const Point& middle) {
  static const std::array<Direction, 14> kDirections = directions();
  CrownSample sample{.sky = 0};
  float sky_weight = 0;
  for (const Direction& direction : kDirections) {
    const float depth = grid.optical_depth(middle, direction.unit);
    sample.depth += direction.weight * depth;
    // The average of d d^T over the sphere is a third of the identity.
    for (std::size_t axis = 0; axis < 3; ++axis) sample.slope[axis] += 3.0f * direction.weight * depth * direction.unit[axis];
    const float light = direction.weight * (0.6f + 0.4f * direction.unit[1]);  // brighter above than below
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
  const Point step{source.box.step.x, source.box.step.y, source.box.step.z};
  for (std::uint32_t id = 0; id < 2 * leaf_count - 1; ++id) {
    const PageNode& node = id == 0 ? source.root : source.nodes[id - 1];
    if (!lod::coppice_node_alive(id, node.split, leaf_count)) continue;
    std::array<Point, 4> corners{};
    for (std::size_t corner = 0; corner < 4; ++corner)
      for (std::size_t axis = 0; axis < 3; ++axis)
        corners[corner][axis] = grid.low[axis] + step[axis] * static_cast<float>(node.corners[corner][axis]);
    add_leaf(grid, corners, quad_area(corners) * source.looks[node.card].coverage);
  }
  CrownLight light{.box = source.box, .cells = {}};
  light.cells.reserve(grid.extinction.size());
  for (std::size_t z = 0; z < kCells; ++z)
    for (std::size_t y = 0; y < kCells; ++y)
      for (std::size_t x = 0; x < kCells; ++x)
        light.cells.push_back(
            sample_cell(grid, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, static_cast<float>(z) + 0.5f}));
  return light;
}

CrownSample CrownLight::at(const std::array<float, 3>& place) const {
  if (cells.empty()) return {};
  const Point in_cells = Cells(box).place(place);
  std::array<std::size_t, 3> low{};
  Point share{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float at = std::clamp(in_cells[axis] - 0.5f, 0.0f, static_cast<float>(kCells) - 1.0f);
    low[axis] = std::min(static_cast<std::size_t>(at), kCells - 2);
    share[axis] = at - static_cast<float>(low[axis]);
  }
  CrownSample sum{.sky = 0};
  for (std::size_t i = 0; i < 8; ++i) {
    float weight = 1.0f;
    std::array<std::size_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t far = i >> axis & 1u;
      weight *= far != 0 ? share[axis] : 1.0f - share[axis];
      cell[axis] = low[axis] + far;
    }
    const CrownSample& corner = cells[Grid::index(cell[0], cell[1], cell[2])];
    sum.depth += weight * corner.depth;
    for (std::size_t axis = 0; axis < 3; ++axis) sum.slope[axis] += weight * corner.slope[axis];
    sum.sky += weight * corner.sky;
  }
  return sum;
}

std::uint32_t pack_crown(const CrownSample& sample) {
  const float depth = std::clamp(sample.depth / kMaxCrownDepth, 0.0f, 1.0f);
  const long root = std::lround(255.0f * std::sqrt(depth));
  std::uint32_t word = static_cast<std::uint32_t>(root);
  const float stored_depth = kMaxCrownDepth * static_cast<float>(root * root) / (255.0f * 255.0f);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float slope = stored_depth > 0.0f ? sample.slope[axis] / (kMaxCrownSlope * stored_depth) : 0.0f;
    word |= (static_cast<std::uint32_t>(std::lround(31.0f * std::clamp(slope, -1.0f, 1.0f))) & 63u) << (8 + 6 * axis);
  }
  return word | static_cast<std::uint32_t>(std::lround(63.0f * std::clamp(sample.sky, 0.0f, 1.0f))) << 26;
}

std::vector<std::uint32_t> pack_crown(const CrownLight& light) {
  if (light.cells.empty()) return std::vector<std::uint32_t>(kCells * kCells * kCells, pack_crown(CrownSample{}));
  std::vector<std::uint32_t> words;
  words.reserve(light.cells.size());
  for (const CrownSample& cell : light.cells) words.push_back(pack_crown(cell));
  return words;
}

}  // namespace coppice::gpu
