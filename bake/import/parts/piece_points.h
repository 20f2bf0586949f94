#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "plant.h"

namespace coppice::bake {

/// Diagonal of the box of all positions; 0 without any.
double box_diagonal_m(const Mesh& mesh);

/// The corners of triangles as points: welded positions, separate for each material.
class Points {
 public:
  Points(const Mesh& mesh, const std::vector<std::uint32_t>& welded);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::array<std::uint32_t, 3> of(std::size_t triangle) const {
    return {corners_[3 * triangle], corners_[3 * triangle + 1], corners_[3 * triangle + 2]};
  }
  [[nodiscard]] bool is_collapsed(std::size_t triangle) const {
    const auto [a, b, c] = of(triangle);
    return a == b || b == c || c == a;
  }
  /// Whether the triangle has an area. False also if its corners are in a line, or nearer to one than the weld tolerance: such triangles
  /// fill T-junctions.
  [[nodiscard]] bool has_area(std::size_t triangle) const { return has_area_[triangle]; }

 private:
  std::vector<std::uint32_t> corners_;
  std::size_t count_;
  std::vector<bool> has_area_;
};

using TriangleList = std::span<const std::uint32_t>;

/// Triangles grouped by key: groups in order of their first triangle, triangles in order within each.
struct Groups {
  std::vector<std::uint32_t> triangles;
  std::vector<LeafRange> ranges;  ///< into `triangles`
  [[nodiscard]] TriangleList of(std::size_t group) const {
    return {triangles.data() + ranges[group].first_triangle, ranges[group].triangle_count};
  }
};

/// set_of  a number below `set_limit` for each triangle
template <class SetOf>
Groups group_by(TriangleList triangles, std::size_t set_limit, const SetOf& set_of) {
  Groups groups;
  std::vector<std::uint32_t> group_of(set_limit, kNone);
  for (const std::uint32_t t : triangles) {
    std::uint32_t& group = group_of[set_of(t)];
    if (group == kNone) {
      group = static_cast<std::uint32_t>(groups.ranges.size());
      groups.ranges.emplace_back();
    }
    ++groups.ranges[group].triangle_count;
  }
  std::uint32_t first = 0;
  for (LeafRange& range : groups.ranges) {
    range.first_triangle = first;
    first += std::exchange(range.triangle_count, 0);
  }
  groups.triangles.resize(triangles.size());
  for (const std::uint32_t t : triangles) {
    LeafRange& range = groups.ranges[group_of[set_of(t)]];
    groups.triangles[range.first_triangle + range.triangle_count++] = t;
  }
  return groups;
}

}  // namespace coppice::bake
