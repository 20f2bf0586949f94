#pragma once

// Selects the leaves that a leaf may be collapsed with: the paper's octree cells.

#include "plant.h"

namespace coppice::bake {

/// An octree over the centroids of the live leaves.
///
/// Cells: the root is the cube over box_min of the source vertices with the box's longest side as its edge. The deepest level is
/// D = min(7, 2 + ceil(log2(leaf_count) / 3)); a point's cell there is floor((p - box_min) / edge * 2^D) per axis, clamped to
/// [0, 2^D - 1], and half that, rounded down, one level up.
///
/// The enlarged cell of a leaf for a count N' is the first of these that holds at least N' other leaves: its cell at level D; that cell
/// with the 1, 2, 3 rings of cells around it; its cell at level D - 1 with 2, 3 rings; and so on up. The whole plant if none does.
class LeafOctree {
 public:
  /// source    gives box and depth only: the tree starts empty
  /// id_count  ids are below it
  LeafOctree(const Foliage& source, std::uint32_t id_count);

  void insert(std::uint32_t id, const glm::dvec3& centroid);
  void remove(std::uint32_t id);

  /// The paper's candidates: every other leaf of the enlarged cell.
  /// candidates  replaced; ascending
  void cell_candidates_of(std::uint32_t id, std::uint32_t count, std::vector<std::uint32_t>& candidates);

  /// The `count` of those whose centroids are nearest; ties go to the smaller id.
  /// candidates  replaced; nearest first
  void candidates_of(std::uint32_t id, std::uint32_t count, std::vector<std::uint32_t>& candidates);

 private:
  using Cell = glm::uvec3;
  struct Block {
    Cell low{0}, high{0};  ///< inclusive, cells of `level`
    std::uint32_t level = 0;
  };
  struct Entry {
    glm::dvec3 centroid{0.0};
    Cell cell{0};  ///< deepest level
    std::uint32_t next = kNone, previous = kNone;
  };
  struct Near {
    double squared_distance = 0.0;
    std::uint32_t id = 0;
    auto operator<=>(const Near&) const = default;
  };

  [[nodiscard]] static std::size_t index_of(std::uint32_t level, const Cell& cell);
  [[nodiscard]] Cell cell_of(const glm::dvec3& point) const;
  [[nodiscard]] Block block_round(std::uint32_t id, std::uint32_t level, std::uint32_t rings) const;
  [[nodiscard]] std::uint32_t count_in(const Block& block) const;
  void gather_round(std::uint32_t id, std::uint32_t count);
  void gather(std::uint32_t level, const Cell& cell, std::uint32_t centre_id);
  void change_counts(const Cell& cell, std::uint32_t change);

  glm::dvec3 box_min_{0.0};
  double cells_per_metre_ = 0.0;
  std::uint32_t depth_ = 1;
  std::vector<std::vector<std::uint32_t>> counts_;  ///< [level][cell] live leaves
  std::vector<std::uint32_t> heads_;                ///< [deepest cell] first leaf, kNone if empty
  std::vector<Entry> entries_;                      ///< [id]
  std::vector<Near> gathered_;
};

}  // namespace coppice::bake
