#include "collapse_geometric.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "check.h"
#include "collapse_down.h"
#include "greedy_union.h"
#include "leaf_shade.h"
#include "live_visibility.h"
#include "quad_merge.h"
#include "stopwatch.h"

namespace coppice::bake {
namespace {

class Replay {
 public:
  Replay(LiveVisibility visibility, const CollapseSequence& sequence, bool count_background)
      : visibility_(std::move(visibility)), sequence_(sequence), count_background_(count_background) {}

  [[nodiscard]] FixedBits foliage_information() const { return bake::foliage_information(visibility_, count_background_); }
  [[nodiscard]] std::uint64_t evaluations() const { return sequence_.evaluations; }

  Merge step() {
    const Merge& next = sequence_.merges[done_];
    const LiveLeaf leaf = merged_leaf(visibility_.leaf(next.first), visibility_.leaf(next.second), next.corners);
    const auto leaf_count = static_cast<std::uint32_t>(sequence_.merges.size() + 1);
    const LeafMerge merge{next.first, next.second, leaf_count + done_++, leaf};
    visibility_.owned_pixels(merge.first, owned_);
    visibility_.changes_of(merge, owned_, scratch_, changes_);
    visibility_.apply(merge, changes_);
    return next;
  }

 private:
  LiveVisibility visibility_;
  const CollapseSequence& sequence_;
  std::uint32_t done_ = 0;
  bool count_background_ = true;
  LiveVisibility::Scratch scratch_;
  OwnedPixels owned_;
  AreaChanges changes_;
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
  const double normal = 1.0 - std::min(1.0, std::abs(glm::dot(quad_normal(first), quad_normal(second))));
  return distance + size + normal;
}

CollapseSequence collapse_by_similarity(const Foliage& foliage, const ProgressFunction& progress) {
  COPPICE_ASSERT(foliage.leaf_count() >= 1);
  UnionRules<Quad> rules;
  rules.cost = [leaf_size_m = mean_leaf_size_m(foliage)](const Quad& a, const Quad& b) { return leaf_dissimilarity(a, b, leaf_size_m); };
  rules.unite = [](const Quad& a, const Quad& b) { return merged_quad(a, b, merge_corners(a, b)); };
  rules.middle = quad_centroid;
  GreedyUnion<Quad> united(foliage, foliage.quads, std::move(rules));
  CollapseSequence sequence;
  const std::uint32_t merge_count = foliage.leaf_count() - 1, stride = std::max(1u, merge_count / 256);
  for (std::uint32_t i = 0; i < merge_count; ++i) {
    if (progress && i % stride == 0) progress(static_cast<double>(i) / merge_count);
    const auto [first, second] = united.step();
    sequence.merges.push_back({first, second, merge_corners(united.item(first), united.item(second))});
  }
  sequence.evaluations = united.evaluations();
  return sequence;
}

Result<CollapseResult> replay(const ShownFoliage& shown, const std::vector<Viewpoint>& views, const CollapseOptions& options,
                              const CollapseSequence& sequence) {
  Stopwatch watch;
  COPPICE_TRY(visibility, LiveVisibility::create(shown, views, options.resolution_px));
  CollapseResult result;
  result.visibility_seconds = watch.lap();
  Replay collapse(std::move(visibility), sequence, options.count_background);
  collapse_down(collapse, shown.foliage.leaf_count(), {}, result);
  return result;
}

}  // namespace coppice::bake
