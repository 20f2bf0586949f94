#include "octree.h"

#include <algorithm>
#include <bit>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"

namespace coppice::bake {

LeafOctree::LeafOctree(const Foliage& source, std::uint32_t id_count) : entries_(id_count) {
  PointBox<glm::vec3> box;
  for (const Quad& quad : source.quads)
    for (const glm::vec3& corner : quad) box.add(corner);
  const std::uint32_t leaf_count = std::max(source.leaf_count(), 1u);
  const auto log2_ceiling = static_cast<std::uint32_t>(std::bit_width(leaf_count - 1));
  depth_ = std::min(7u, 2 + (log2_ceiling + 2) / 3);
  box_min_ = box.low;
  const glm::dvec3 extent = glm::dvec3(box.high) - glm::dvec3(box.low);
  const double edge = std::max({extent.x, extent.y, extent.z});
  cells_per_metre_ = edge > 0.0 ? static_cast<double>(1u << depth_) / edge : 0.0;
  for (std::uint32_t level = 0; level <= depth_; ++level) counts_.emplace_back(std::size_t{1} << (3 * level), 0u);
  heads_.assign(std::size_t{1} << (3 * depth_), kNone);
}

std::size_t LeafOctree::index_of(std::uint32_t level, const Cell& cell) {
  return (((std::size_t{cell.z} << level) | cell.y) << level) | cell.x;
}

LeafOctree::Cell LeafOctree::cell_of(const glm::dvec3& point) const {
  return Cell(glm::clamp(glm::floor((point - box_min_) * cells_per_metre_), 0.0, static_cast<double>((1u << depth_) - 1)));
}

void LeafOctree::change_counts(const Cell& cell, std::uint32_t change) {
  for (std::uint32_t level = 0; level <= depth_; ++level) counts_[level][index_of(level, cell >> (depth_ - level))] += change;
}

void LeafOctree::insert(std::uint32_t id, const glm::dvec3& centroid) {
  Entry& entry = entries_[id];
  entry.centroid = centroid;
  entry.cell = cell_of(centroid);
  std::uint32_t& head = heads_[index_of(depth_, entry.cell)];
  entry.previous = kNone;
  entry.next = head;
  if (head != kNone) entries_[head].previous = id;
  head = id;
  change_counts(entry.cell, 1);
}

void LeafOctree::remove(std::uint32_t id) {
  const Entry& entry = entries_[id];
  if (entry.next != kNone) entries_[entry.next].previous = entry.previous;
  (entry.previous != kNone ? entries_[entry.previous].next : heads_[index_of(depth_, entry.cell)]) = entry.next;
  change_counts(entry.cell, ~0u);
}

LeafOctree::Block LeafOctree::block_round(std::uint32_t id, std::uint32_t level, std::uint32_t rings) const {
  const Cell cell = entries_[id].cell >> (depth_ - level);
  return {cell - glm::min(cell, Cell(rings)), glm::min(cell + rings, Cell((1u << level) - 1)), level};
}

std::uint32_t LeafOctree::count_in(const Block& block) const {
  std::uint32_t count = 0;
  for (std::uint32_t z = block.low.z; z <= block.high.z; ++z)
    for (std::uint32_t y = block.low.y; y <= block.high.y; ++y)
      for (std::uint32_t x = block.low.x; x <= block.high.x; ++x) count += counts_[block.level][index_of(block.level, {x, y, z})];
  return count;
}

/// Walks down from `cell` and skips empty subtrees.
void LeafOctree::gather(std::uint32_t level, const Cell& cell, std::uint32_t centre_id) {
  if (counts_[level][index_of(level, cell)] == 0) return;
  if (level < depth_) {
    for (std::uint32_t child = 0; child < 8; ++child) gather(level + 1, cell * 2u + Cell(child & 1, child >> 1 & 1, child >> 2), centre_id);
    return;
  }
  for (std::uint32_t id = heads_[index_of(depth_, cell)]; id != kNone; id = entries_[id].next) {
    if (id == centre_id) continue;
    const glm::dvec3 offset = entries_[id].centroid - entries_[centre_id].centroid;
    gathered_.push_back({glm::dot(offset, offset), id});
  }
}

void LeafOctree::gather_round(std::uint32_t id, std::uint32_t count) {
  // The blocks are the cell with 0, 1, 2, 3 rings of neighbours, then 2 and 3 rings one level up, and so on to the root, which holds
  // everything.
  Block block = block_round(id, depth_, 0);
  for (std::uint32_t rings = 1, level = depth_; level > 0 && count_in(block) <= count;) {  // the leaf itself is one of them
    block = block_round(id, level, rings);
    ++rings;
    if (rings > 3) rings = 2, --level;
  }
  if (count_in(block) <= count) block = block_round(id, 0, 0);
  gathered_.clear();
  for (std::uint32_t z = block.low.z; z <= block.high.z; ++z)
    for (std::uint32_t y = block.low.y; y <= block.high.y; ++y)
      for (std::uint32_t x = block.low.x; x <= block.high.x; ++x) gather(block.level, {x, y, z}, id);
}

void LeafOctree::cell_candidates_of(std::uint32_t id, std::uint32_t count, std::vector<std::uint32_t>& candidates) {
  gather_round(id, count);
  candidates.clear();
  for (const Near& near : gathered_) candidates.push_back(near.id);
  std::sort(candidates.begin(), candidates.end());
}

void LeafOctree::candidates_of(std::uint32_t id, std::uint32_t count, std::vector<std::uint32_t>& candidates) {
  gather_round(id, count);
  const std::size_t kept = std::min<std::size_t>(count, gathered_.size());
  std::partial_sort(gathered_.begin(), gathered_.begin() + static_cast<std::ptrdiff_t>(kept), gathered_.end());
  candidates.clear();
  for (std::size_t i = 0; i < kept; ++i) candidates.push_back(gathered_[i].id);
}

}  // namespace coppice::bake
