#include "collapse_geometric.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>

#include <glm/geometric.hpp>

#include "check.h"
#include "octree.h"
#include "progress.h"
#include "quad_merge.h"

namespace coppice::bake {
namespace {

constexpr std::uint32_t kCandidateCount = 16;

/// Unit normal; zero for a quad without area. The cross product of the diagonals is the mean normal of a bent quad.
glm::dvec3 normal_of(const Quad& quad) {
  const glm::dvec3 across = glm::cross(glm::dvec3(quad[2]) - glm::dvec3(quad[0]), glm::dvec3(quad[3]) - glm::dvec3(quad[1]));
  const double length = glm::length(across);
  return length > 0.0 ? across / length : glm::dvec3(0.0);
}

/// A live leaf's best partner at the last search.
struct Pair {
  double cost = 0.0;
  std::uint32_t leaf = 0, partner = 0;
};

struct CostlierPair {
  bool operator()(const Pair& a, const Pair& b) const {
    const auto key = [](const Pair& p) { return std::tuple(p.cost, std::min(p.leaf, p.partner), std::max(p.leaf, p.partner), p.leaf); };
    return key(a) > key(b);
  }
};

class SimilarityCollapse {
 public:
  explicit SimilarityCollapse(const Foliage& foliage)
      : octree_(foliage, 2 * foliage.leaf_count() - 1), leaf_size_m_(mean_leaf_size_m(foliage)), quads_(foliage.quads) {
    quads_.reserve(2 * foliage.quads.size());
    live_.assign(foliage.quads.size(), true);
    for (std::uint32_t id = 0; id < foliage.leaf_count(); ++id) octree_.insert(id, quad_centroid(quads_[id]));
    for (std::uint32_t id = 0; id < foliage.leaf_count(); ++id) find_partner(id);
  }

  [[nodiscard]] std::uint64_t evaluations() const { return evaluations_; }

  /// Does the next merge. At least two leaves must be live.
  Merge step() {
    const Pair pair = cheapest_pair();
    Merge merge{std::min(pair.leaf, pair.partner), std::max(pair.leaf, pair.partner), {}};
    merge.corners = merge_corners(quads_[merge.first], quads_[merge.second]);
    const auto merged = static_cast<std::uint32_t>(quads_.size());
    quads_.push_back(merged_quad(quads_[merge.first], quads_[merge.second], merge.corners));
    for (const std::uint32_t removed : {merge.first, merge.second}) {
      octree_.remove(removed);
      live_[removed] = false;
    }
    live_.push_back(true);
    octree_.insert(merged, quad_centroid(quads_[merged]));
    find_partner(merged);
    return merge;
  }

 private:
  /// Finds the least dissimilar pair. A pair whose leaf is gone is dropped; a leaf whose partner is gone searches again.
  Pair cheapest_pair() {
    for (;;) {
      COPPICE_ASSERT(!pairs_.empty());
      const Pair pair = pairs_.top();
      pairs_.pop();
      if (!live_[pair.leaf]) continue;
      if (live_[pair.partner]) return pair;
      find_partner(pair.leaf);
    }
  }

  void find_partner(std::uint32_t leaf) {
    octree_.candidates_of(leaf, kCandidateCount, candidates_);
    Pair best{std::numeric_limits<double>::infinity(), leaf, kNone};
    for (const std::uint32_t candidate : candidates_) {
      const double cost = leaf_dissimilarity(quads_[leaf], quads_[candidate], leaf_size_m_);
      if (cost < best.cost || (cost == best.cost && candidate < best.partner)) best = {cost, leaf, candidate};
    }
    evaluations_ += candidates_.size();
    if (best.partner != kNone) pairs_.push(best);
  }

  LeafOctree octree_;
  double leaf_size_m_;
  std::vector<Quad> quads_;  ///< [id]
  std::vector<bool> live_;   ///< [id]
  std::priority_queue<Pair, std::vector<Pair>, CostlierPair> pairs_;
  std::vector<std::uint32_t> candidates_;
  std::uint64_t evaluations_ = 0;
};

}  // namespace

double mean_leaf_size_m(const Foliage& foliage) {
  double sum = 0.0;
  for (const Quad& quad : foliage.quads) sum += std::sqrt(quad_area(quad));
  return foliage.quads.empty() ? 0.0 : sum / static_cast<double>(foliage.quads.size());
}

double leaf_dissimilarity(const Quad& first, const Quad& second, double leaf_size_m) {
  const double distance_m = glm::distance(quad_centroid(first), quad_centroid(second));
  const double first_area = quad_area(first), second_area = quad_area(second), sum = first_area + second_area;
  const double distance = leaf_size_m > 0.0 ? distance_m / leaf_size_m : 0.0;
  const double size = sum > 0.0 ? std::abs(first_area - second_area) / sum : 0.0;
  const double normal = 1.0 - std::min(1.0, std::abs(glm::dot(normal_of(first), normal_of(second))));
  return distance + size + normal;
}

CollapseSequence collapse_by_similarity(const Foliage& foliage, const ProgressFunction& progress) {
  COPPICE_ASSERT(foliage.leaf_count() >= 1);
  SimilarityCollapse collapse(foliage);
  CollapseSequence sequence;
  const std::uint32_t merge_count = foliage.leaf_count() - 1, stride = std::max(1u, merge_count / 256);
  sequence.merges.reserve(merge_count);
  for (std::uint32_t i = 0; i < merge_count; ++i) {
    if (progress && i % stride == 0) progress(static_cast<double>(i) / merge_count);
    sequence.merges.push_back(collapse.step());
  }
  sequence.evaluations = collapse.evaluations();
  return sequence;
}

}  // namespace coppice::bake
