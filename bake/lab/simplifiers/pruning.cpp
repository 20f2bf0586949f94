// Pruning leaf p and growing its neighbour q by mutual information replaces two leaves by one. LiveVisibility calls that a merge, so its
// areas stay exact.

#include "pruning.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include <glm/geometric.hpp>

#include "check.h"
#include "live_visibility.h"
#include "mutual_information.h"
#include "quad_merge.h"
#include "seeded_random.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

class Pruning {
 public:
  Pruning(const Foliage& foliage, const CollapseOptions& options, LiveVisibility visibility)
      : foliage_(foliage), options_(options), visibility_(std::move(visibility)) {
    const std::uint32_t leaf_count = foliage.leaf_count();
    source_of_.assign(visibility_.id_count(), kNone);
    information_.assign(visibility_.id_count(), 0);
    next_id_ = leaf_count;
    for (std::uint32_t leaf = 0; leaf < leaf_count; ++leaf) {
      source_of_[leaf] = leaf;
      live_.push_back({leaf, quad_centroid(foliage.quads[leaf])});
      ranking_.insert({0, leaf, leaf});
    }
    refresh_all();
  }

  [[nodiscard]] std::uint32_t live_count() const { return static_cast<std::uint32_t>(live_.size()); }

  PruneStep step() {
    const std::uint32_t pruned = std::get<2>(*ranking_.begin());
    const auto place = find_live(source_of_[pruned]);
    const std::uint32_t grown = nearest_to(*place);
    const LiveLeaf& leaf = visibility_.leaf(grown);
    const LeafMerge merge{pruned, grown, next_id_, {grown_quad(leaf.quad, visibility_.leaf(pruned).quad), leaf.card}};
    const PruneStep step{source_of_[pruned], source_of_[grown]};

    visibility_.owned_pixels(pruned, owned_);
    visibility_.changes_of(merge, owned_, scratch_, changes_);
    const bool totals_change = !options_.count_background && changes_.touch(visibility_.background(), visibility_.view_count());
    visibility_.apply(merge, changes_);
    for (const std::uint32_t removed : {pruned, grown}) ranking_.erase({information_[removed], source_of_[removed], removed});
    live_.erase(place);
    source_of_[next_id_] = step.grown;
    find_live(step.grown)->id = next_id_;
    ranking_.insert({0, step.grown, next_id_++});
    if (totals_change)
      refresh_all();
    else
      for (const std::uint32_t outcome : changes_.outcomes) refresh(outcome);
    return step;
  }

  [[nodiscard]] Foliage foliage() const {
    Foliage result;
    result.card_table = foliage_.card_table;
    for (const Live& live : live_) {
      result.quads.push_back(visibility_.leaf(live.id).quad);
      result.cards.push_back(visibility_.leaf(live.id).card);
      if (!foliage_.normals.empty()) result.normals.push_back(foliage_.normals[source_of_[live.id]]);
    }
    return result;
  }

 private:
  struct Live {
    std::uint32_t id = 0;
    glm::dvec3 centroid{0.0};  ///< scaling does not move it
  };

  /// Finds a source leaf in live_, which is in source order.
  std::vector<Live>::iterator find_live(std::uint32_t source) {
    return std::lower_bound(live_.begin(), live_.end(), source,
                            [&](const Live& live, std::uint32_t wanted) { return source_of_[live.id] < wanted; });
  }

  /// Compares all leaves: an octree's cell may miss the nearest, and distances are cheap compared with visibility.
  [[nodiscard]] std::uint32_t nearest_to(const Live& leaf) const {
    double best = std::numeric_limits<double>::infinity();
    std::uint32_t nearest = kNone;
    for (const Live& other : live_) {
      const glm::dvec3 offset = other.centroid - leaf.centroid;
      const double squared_m2 = glm::dot(offset, offset);
      if (other.id == leaf.id || !(squared_m2 < best)) continue;
      best = squared_m2;
      nearest = other.id;
    }
    COPPICE_ASSERT(nearest != kNone);
    return nearest;
  }

  static Quad grown_quad(const Quad& quad, const Quad& pruned) {
    const double area = quad_area(quad);
    return area > 0.0 ? scaled_quad(quad, std::sqrt((area + quad_area(pruned)) / area)) : quad;
  }

  /// Updates an outcome's rank. Changes never name removed leaves; the background has no rank.
  void refresh(std::uint32_t outcome) {
    if (outcome == visibility_.background()) return;
    const std::uint32_t source = source_of_[outcome];
    ranking_.erase({information_[outcome], source, outcome});
    information_[outcome] = outcome_information(visibility_.areas(outcome), totals_);
    ranking_.insert({information_[outcome], source, outcome});
  }

  void refresh_all() {
    totals_ = view_totals(visibility_.areas(visibility_.background()), visibility_.pixels_per_view(), options_.count_background);
    for (const Live& live : live_) refresh(live.id);
  }

  const Foliage& foliage_;
  CollapseOptions options_;
  LiveVisibility visibility_;
  ViewTotals totals_;
  std::vector<std::uint32_t> source_of_;                                   ///< [id]
  std::vector<FixedBits> information_;                                     ///< [id] I(V,l)
  std::set<std::tuple<FixedBits, std::uint32_t, std::uint32_t>> ranking_;  ///< (I(V,l), source, id) of live leaves
  std::vector<Live> live_;
  std::uint32_t next_id_ = 0;
  OwnedPixels owned_;
  LiveVisibility::Scratch scratch_;
  AreaChanges changes_;
};

}  // namespace

Quad scaled_quad(const Quad& quad, double factor) {
  const glm::dvec3 centroid = quad_centroid(quad);
  Quad scaled{};
  for (std::size_t i = 0; i < 4; ++i) scaled[i] = glm::vec3(centroid + factor * (glm::dvec3(quad[i]) - centroid));
  return scaled;
}

std::vector<std::uint32_t> stochastic_order(std::uint32_t leaf_count, std::uint64_t seed) {
  std::vector<std::uint32_t> order(leaf_count);
  std::iota(order.begin(), order.end(), 0u);
  SeededRandom random(seed);
  for (std::uint32_t i = leaf_count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

Foliage prune_stochastically(const Foliage& foliage, std::uint32_t kept_count, std::uint64_t seed) {
  COPPICE_ASSERT(kept_count >= 1 && kept_count <= foliage.leaf_count());
  std::vector<std::uint32_t> kept = stochastic_order(foliage.leaf_count(), seed);
  kept.resize(kept_count);
  std::sort(kept.begin(), kept.end());
  const double factor = std::sqrt(static_cast<double>(foliage.leaf_count()) / kept_count);
  Foliage result;
  result.card_table = foliage.card_table;
  for (const std::uint32_t leaf : kept) {
    result.quads.push_back(factor == 1.0 ? foliage.quads[leaf] : scaled_quad(foliage.quads[leaf], factor));
    result.cards.push_back(foliage.cards[leaf]);
    if (!foliage.normals.empty()) result.normals.push_back(foliage.normals[leaf]);
  }
  return result;
}

Result<PruneResult> prune_by_mutual_information(const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                                const CollapseOptions& options, const std::vector<std::uint32_t>& leaf_counts,
                                                const ProgressFunction& progress) {
  COPPICE_TRY(visibility, LiveVisibility::create(shown, views, options.resolution_px));
  const std::uint32_t leaf_count = shown.foliage.leaf_count();
  std::uint32_t last = leaf_count;
  for (const std::uint32_t count : leaf_counts) {
    COPPICE_ASSERT(count >= 1 && count <= leaf_count);
    last = std::min(last, count);
  }
  Pruning pruning(shown.foliage, options, std::move(visibility));
  PruneResult result;
  result.levels.resize(leaf_counts.size());
  const std::uint32_t stride = std::max(1u, leaf_count / 256);
  for (;;) {
    for (std::size_t i = 0; i < leaf_counts.size(); ++i)
      if (leaf_counts[i] == pruning.live_count()) result.levels[i] = pruning.foliage();
    if (pruning.live_count() == last) break;
    if (progress && pruning.live_count() % stride == 0)
      progress(static_cast<double>(leaf_count - pruning.live_count()) / (leaf_count - last));
    result.steps.push_back(pruning.step());
  }
  return result;
}

}  // namespace coppice::bake
