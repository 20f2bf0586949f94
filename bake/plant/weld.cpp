#include "weld.h"

#include <cstddef>
#include <limits>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/ext/vector_int3_sized.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "union_find.h"

namespace coppice::bake {
namespace {

// Vertices are filed in a grid whose cells are some tolerances wide, so that most are compared within their own cell only. Filed vertices
// are more than a tolerance apart, so that a cell holds some hundreds at most, whatever the plant's shape.
constexpr double kCellTolerances = 8.0;

struct Cell {
  std::int64_t x = 0, y = 0, z = 0;
  std::uint32_t group = 0;
  bool operator==(const Cell&) const = default;
};

struct HashCell {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t hash = cell.group;
    for (const std::int64_t part : {cell.x, cell.y, cell.z}) {
      hash = (hash ^ static_cast<std::uint64_t>(part)) * 0x9e3779b97f4a7c15ull;
      hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash);
  }
};

class Grid {
 public:
  Grid(std::span<const glm::vec3> positions, const glm::dvec3& low, double tolerance_m)
      : positions_(positions), next_(positions.size(), kEnd), low_(low), tolerance_m_(tolerance_m), cell_m_(tolerance_m * kCellTolerances) {
    first_.reserve(positions.size());
  }

  /// Joins vertex i with the filed vertices that it coincides with; files it if there are none.
  void add(std::uint32_t i, std::uint32_t group, UnionFind& sets) {
    const glm::dvec3 scaled = (glm::dvec3(positions_[i]) - low_) / cell_m_;
    const double margin = 1.0 / kCellTolerances;
    const glm::i64vec3 from(glm::floor(scaled - margin)), to(glm::floor(scaled + margin)), own(glm::floor(scaled));
    bool joined = false;
    for (std::int64_t x = from.x; x <= to.x; ++x)
      for (std::int64_t y = from.y; y <= to.y; ++y)
        for (std::int64_t z = from.z; z <= to.z; ++z) joined = join_cell({x, y, z, group}, i, sets) || joined;
    if (joined) return;
    std::uint32_t& head = first_.try_emplace({own.x, own.y, own.z, group}, kEnd).first->second;
    next_[i] = head;
    head = i;
  }

 private:
  static constexpr std::uint32_t kEnd = std::numeric_limits<std::uint32_t>::max();

  bool join_cell(const Cell& where, std::uint32_t i, UnionFind& sets) {
    const auto head = first_.find(where);
    if (head == first_.end()) return false;
    bool joined = false;
    for (std::uint32_t j = head->second; j != kEnd; j = next_[j])
      if (glm::distance(glm::dvec3(positions_[i]), glm::dvec3(positions_[j])) <= tolerance_m_) {
        sets.join(i, j);
        joined = true;
      }
    return joined;
  }

  std::span<const glm::vec3> positions_;
  std::unordered_map<Cell, std::uint32_t, HashCell> first_;
  std::vector<std::uint32_t> next_;
  glm::dvec3 low_;
  double tolerance_m_;
  double cell_m_;
};

}  // namespace

std::vector<std::uint32_t> weld(std::span<const glm::vec3> positions, std::span<const std::uint32_t> groups) {
  if (positions.empty()) return {};
  const auto box = box_of(positions);
  const double diagonal_m = glm::distance(glm::dvec3(box.low), glm::dvec3(box.high));
  // All vertices are in one point: any cell size files them together.
  const double tolerance_m = diagonal_m > 0.0 ? diagonal_m * static_cast<double>(kWeldTolerance) : 1.0;
  Grid grid(positions, glm::dvec3(box.low), tolerance_m);
  UnionFind sets(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) grid.add(static_cast<std::uint32_t>(i), groups[i], sets);
  std::vector<std::uint32_t> welded(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) welded[i] = sets.find(static_cast<std::uint32_t>(i));
  return welded;
}

}  // namespace coppice::bake
