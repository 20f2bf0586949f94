// A greedy search with a lazy queue. Each leaf keeps its few best collapses; the best of them is its entry in the queue. An entry becomes
// stale when the image changes, so its cost is computed again before it counts. A leaf whose choices are all gone searches again: every
// shape with every neighbour, first in some of the views, the best then in all. Costs are integers and computed in parallel; one thread
// decides which collapse is next.

#include "collapse_image.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

#include <tbb/enumerable_thread_specific.h>
#include <glm/geometric.hpp>

#include "alpha_mask.h"
#include "bounds.h"
#include "collapse_down.h"
#include "leaf_reach.h"
#include "leaf_shade.h"
#include "mutual_information.h"
#include "octree.h"
#include "pair_silhouette.h"
#include "parallel_for.h"
#include "quad_merge.h"
#include "stopwatch.h"

namespace coppice::bake {
namespace {

/// A pair, one shape of its merged leaf and the cost of that merge.
struct WeighedPair {
  std::int64_t cost = 0;
  std::int64_t prior = 0;                       ///< the part of the cost that no image shows
  std::uint32_t first = kNone, second = kNone;  ///< first < second
  std::uint32_t weighed_at = kNone;             ///< number of collapses done when all views were evaluated; kNone: only some views were
  PairCorners corners{};
  std::uint8_t opacity = kOpaque;
};

std::uint8_t steps_of(float opacity) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(opacity * kOpaque), 1l, long{kOpaque}));
}

/// Converts to the queue's units. views  how many views each evaluated one stands for
std::int64_t cost_of(const MergeCost& cost, std::uint8_t opacity, std::uint32_t views) {
  constexpr double kFar = 1e17;
  return static_cast<std::int64_t>(std::clamp(cost.at(opacity) * views, -kFar, kFar));
}

bool is_better(const WeighedPair& a, const WeighedPair& b) {
  return std::tie(a.cost, a.first, a.second) < std::tie(b.cost, b.first, b.second);
}

/// A leaf's best known collapses, the best first.
struct Choices {
  static constexpr std::size_t kMax = 3;
  std::array<WeighedPair, kMax> pairs{};
  std::uint32_t count = 0;
  std::uint32_t stamp = 0;  ///< entries of the queue with another stamp are void

  template <class Predicate>
  void remove_if(Predicate&& predicate) {
    count = static_cast<std::uint32_t>(std::remove_if(pairs.begin(), pairs.begin() + count, predicate) - pairs.begin());
  }
  void sort() { std::sort(pairs.begin(), pairs.begin() + count, is_better); }
  void offer(const WeighedPair& pair) {
    if (count == kMax && !is_better(pair, pairs.back())) return;
    count = std::min<std::uint32_t>(count + 1, kMax);
    pairs[count - 1] = pair;
    sort();
  }
};

struct QueueEntry {
  std::int64_t cost = 0;
  std::uint32_t leaf = 0, stamp = 0;
  auto operator<=>(const QueueEntry&) const = default;
};

class ImageCollapse {
 public:
  /// card_chroma  [card_table.size()] each card's chroma()
  ImageCollapse(const Foliage& foliage, std::vector<glm::vec2> card_chroma, const CollapseOptions& options,
                const ImageErrorOptions& image_options, IncrementalImage image)
      : options_(options),
        image_options_(image_options),
        card_chroma_(std::move(card_chroma)),
        image_(std::move(image)),
        octree_(foliage, image_.id_count()),
        choices_(image_.id_count()),
        reach_(image_.id_count()),
        is_live_(image_.id_count(), 0),
        leaf_count_(foliage.leaf_count()),
        next_id_(foliage.leaf_count()),
        is_alone_(image_.id_count(), 0) {
    const double radius = bounding_sphere(foliage).radius;
    px_per_metre_ = radius > 0.0 ? options.resolution_px / (2.0 * radius) : 0.0;
    sqrt_leaf_count_ = std::sqrt(static_cast<double>(foliage.leaf_count()));
    for (std::uint32_t id = 0; id < foliage.leaf_count(); ++id) {
      is_live_[id] = 1;
      reach_[id] = reach_points(foliage.quads[id]);
      octree_.insert(id, quad_centroid(foliage.quads[id]));
      unweighed_.push_back(id);
    }
  }

  [[nodiscard]] std::uint64_t evaluations() const { return evaluations_; }
  [[nodiscard]] FixedBits foliage_information() const { return bake::foliage_information(image_, options_.count_background); }

  Merge step() {
    if (pixels_are_small()) halve();
    grow_coverage_weight();
    for (;;) {
      while (!queue_.empty() && unweighed_.size() < kBatch) {
        const QueueEntry top = queue_.top();
        Choices& choices = choices_[top.leaf];
        const bool is_void = is_live_[top.leaf] == 0 || choices.stamp != top.stamp;
        const bool is_fresh = !is_void && is_alive(choices.pairs[0]) && choices.pairs[0].weighed_at == collapse_count_;
        if (is_fresh && !unweighed_.empty()) break;
        queue_.pop();
        if (is_void) continue;
        if (is_fresh) return commit(choices.pairs[0]);
        unweighed_.push_back(top.leaf);
      }
      weigh_batch();
    }
  }

 private:
  /// Leaves that are evaluated at once, so that threads have work. The result depends on it.
  static constexpr std::size_t kBatch = 2;

  /// How thoroughly to search for a partner: one view in `view_stride`, then the `finalists` best in all views.
  struct Effort {
    std::uint32_t view_stride = 1;
    std::uint32_t finalists = 1;
  };
  /// The fewer leaves are left, the more each counts.
  [[nodiscard]] Effort effort() const {
    const std::uint32_t live_count = leaf_count_ - collapse_count_;
    const Effort effort = live_count > 8192 ? Effort{8, 1} : live_count > 1024 ? Effort{5, 2} : Effort{3, 2};
    return {std::min(effort.view_stride, image_.view_count()), effort.finalists};
  }

  /// The nearest leaves may all be on one twig, and their merges cannot reach across to the next. Leaves search farther once the crown has
  /// lost coverage.
  [[nodiscard]] std::uint32_t candidate_count() const {
    constexpr double kBearableLoss = 0.005, kGrowth = 1000.0, kMax = 4.0;
    const double times = std::clamp(1.0 + kGrowth * (image_.lost_coverage() - kBearableLoss), 1.0, kMax);
    return static_cast<std::uint32_t>(options_.candidate_count * times);
  }

  /// Leaves that are in front in this many pixels, on average, are judged as well in images of half the side.
  [[nodiscard]] bool pixels_are_small() const {
    constexpr double kEnough = 20.0;
    if (!image_.can_halve()) return false;
    const std::span<const std::uint32_t> uncovered = image_.areas(image_.background());
    const double covered_px = image_.pixels_per_view() - std::accumulate(uncovered.begin(), uncovered.end(), 0.0) / image_.view_count();
    return covered_px > kEnough * (leaf_count_ - collapse_count_);
  }
  void halve() {
    std::vector<std::uint32_t> live;
    for (std::uint32_t id = 0; id < next_id_; ++id)
      if (is_live_[id] != 0) live.push_back(id);
    image_.halve(live);
  }

  /// Merges that ignored coverage would each lose a little of the crown's. The fewer leaves are left, the more coverage counts.
  void grow_coverage_weight() {
    const double merged = static_cast<double>(leaf_count_) / (leaf_count_ - collapse_count_);
    image_.set_coverage_weight(static_cast<double>(image_options_.coverage_weight) * std::sqrt(merged * std::sqrt(merged)));
  }

  [[nodiscard]] bool is_alive(const WeighedPair& pair) const { return is_live_[pair.first] != 0 && is_live_[pair.second] != 0; }

  /// Cost of an area that is wrong in all channels in every view.
  [[nodiscard]] std::int64_t cost_of_px2(double area_px2) const {
    return static_cast<std::int64_t>(std::min(area_px2 * 1024.0 * kImageChannels * 255.0 * 255.0 * image_.view_count(), 1e17));
  }
  [[nodiscard]] std::int64_t mismatch_cost(double mismatch_m2) const {
    return cost_of_px2(image_options_.mismatch_weight * mismatch_m2 * px_per_metre_ * px_per_metre_);
  }
  [[nodiscard]] std::int64_t reach_cost(const WeighedPair& pair, const Quad& quad) const {
    const double reach2_px2 =
        std::max(squared_reach(reach_[pair.first], quad), squared_reach(reach_[pair.second], quad)) * px_per_metre_ * px_per_metre_;
    const double pixel = options_.resolution_px / 256.0;
    return cost_of_px2(image_options_.reach_weight * sqrt_leaf_count_ * reach2_px2 * reach2_px2 / (pixel * pixel));
  }

  /// Cost of the colour that one of the two leaves loses, since the images show luminance only.
  [[nodiscard]] std::int64_t color_cost(const WeighedPair& pair, std::uint32_t merged_card) const {
    const std::uint32_t lost = image_.leaf(pair.first).card == merged_card ? pair.second : pair.first;
    const glm::vec2 change = card_chroma_[merged_card] - card_chroma_[image_.leaf(lost).card];
    if (change == glm::vec2(0.0f)) return 0;
    const std::span<const std::uint32_t> areas_px = image_.areas(lost);
    const double seen_px2 = std::accumulate(areas_px.begin(), areas_px.end(), 0.0) / image_.view_count() * image_.pixel_area();
    return cost_of_px2(image_options_.color_weight * seen_px2 * static_cast<double>(glm::dot(change, change)) / (3.0 * 255.0 * 255.0));
  }

  /// The mean opacity of a pair, by area.
  [[nodiscard]] float pair_opacity(const WeighedPair& pair) const {
    const LiveLeaf &first = image_.leaf(pair.first), &second = image_.leaf(pair.second);
    const double first_m2 = quad_area(first.quad), second_m2 = quad_area(second.quad), both_m2 = first_m2 + second_m2;
    const double steps = both_m2 > 0.0 ? (first_m2 * first.opacity + second_m2 * second.opacity) / both_m2 : double{kOpaque};
    return static_cast<float>(steps / kOpaque);
  }

  /// Finds the best shape of a pair and its opacity, judged by some of the views.
  void weigh_shapes(WeighedPair& pair, ViewSubset subset) {
    const LiveLeaf &first = image_.leaf(pair.first), &second = image_.leaf(pair.second);
    const PairShapes shapes = pair_shapes(first.quad, second.quad);
    const std::uint32_t card = merged_card(first.quad, first.card, second.quad, second.card);
    std::array<PairCorners, PairShapes::kMax> corners;
    for (std::size_t s = 0; s < shapes.count; ++s) corners[s] = shapes.shapes[s].corners;
    std::array<MergeCost, PairShapes::kMax> costs{};
    image_.costs_of({pair.first, pair.second, std::span(corners).first(shapes.count), subset}, scratches_.local(),
                    std::span(costs).first(shapes.count));
    const float before = pair_opacity(pair);
    pair.cost = std::numeric_limits<std::int64_t>::max();
    for (std::size_t s = 0; s < shapes.count; ++s) {
      const std::uint8_t opacity = costs[s].is_seen() ? costs[s].best_opacity() : steps_of(shapes.shapes[s].covering_opacity(before));
      const float mismatch_m2 = shapes.shapes[s].mismatch_m2(before, static_cast<float>(opacity) / kOpaque);
      const std::int64_t change = cost_of(costs[s], opacity, subset.stride), mismatch = mismatch_cost(static_cast<double>(mismatch_m2));
      if (change + mismatch >= pair.cost) continue;
      const std::int64_t prior = mismatch + reach_cost(pair, merged_quad(first.quad, second.quad, corners[s])) + color_cost(pair, card);
      if (change + prior >= pair.cost) continue;
      pair.cost = change + prior;
      pair.prior = prior;
      pair.corners = corners[s];
      pair.opacity = opacity;
    }
  }

  /// Computes the cost of the pair's shape in all views.
  void weigh(WeighedPair& pair) {
    MergeCost cost;
    image_.costs_of({pair.first, pair.second, {&pair.corners, 1}}, scratches_.local(), {&cost, 1});
    if (cost.is_seen()) pair.opacity = cost.best_opacity();
    pair.cost = cost_of(cost, pair.opacity, 1) + pair.prior;
    pair.weighed_at = collapse_count_;
  }

  /// Pairs each leaf that has no choice left with its nearest leaves; every pair once.
  std::vector<WeighedPair> new_pairs() {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ids;
    std::vector<std::uint32_t> partners;
    for (const std::uint32_t leaf : unweighed_) {
      if (is_alone_[leaf] == 0) continue;
      octree_.candidates_of(leaf, candidate_count(), partners);
      for (const std::uint32_t other : partners) ids.emplace_back(std::min(leaf, other), std::max(leaf, other));
    }
    std::ranges::sort(ids);
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    std::vector<WeighedPair> pairs;
    for (const auto& [first, second] : ids) pairs.push_back({.first = first, .second = second});
    return pairs;
  }

  /// Offers new pairs to the batch's leaves without choices, with their costs in some of the views.
  void look_for_partners(std::uint32_t view_stride) {
    std::vector<WeighedPair> pairs = new_pairs();
    const ViewSubset some_views{collapse_count_ % view_stride, view_stride};
    parallel_for(pairs.size(), [&](std::size_t i) { weigh_shapes(pairs[i], some_views); });
    evaluations_ += pairs.size();
    for (const WeighedPair& pair : pairs)
      for (const std::uint32_t leaf : {pair.first, pair.second})
        if (is_alone_[leaf] != 0) choices_[leaf].offer(pair);
  }

  /// Computes the costs of the best choice of each leaf in the batch again. A leaf without choices searches first.
  void weigh_batch() {
    for (const std::uint32_t leaf : unweighed_) {
      choices_[leaf].remove_if([&](const WeighedPair& pair) { return !is_alive(pair); });
      is_alone_[leaf] = choices_[leaf].count == 0;
    }
    const auto [view_stride, finalist_count] = effort();
    look_for_partners(view_stride);
    std::vector<WeighedPair*> finalists;
    for (const std::uint32_t leaf : unweighed_)
      for (std::uint32_t i = 0; i < std::min(choices_[leaf].count, is_alone_[leaf] != 0 ? finalist_count : 1); ++i)
        finalists.push_back(&choices_[leaf].pairs[i]);
    parallel_for(finalists.size(), [&](std::size_t i) { weigh(*finalists[i]); });
    evaluations_ += finalists.size();
    for (const std::uint32_t leaf : unweighed_) {
      is_alone_[leaf] = 0;
      Choices& choices = choices_[leaf];
      choices.sort();
      queue_.push({choices.pairs[0].cost, leaf, ++choices.stamp});
    }
    unweighed_.clear();
  }

  Merge commit(const WeighedPair pair) {
    const LiveLeaf merged = image_.merged(pair.first, pair.second, pair.corners, pair.opacity);
    const std::uint32_t result = next_id_++;
    image_.apply({pair.first, pair.second, result, merged});
    reach_[result] = merged_reach_points(reach_[pair.first], reach_[pair.second]);
    ++collapse_count_;
    for (const std::uint32_t removed : {pair.first, pair.second}) {
      octree_.remove(removed);
      is_live_[removed] = 0;
      reach_[removed] = {};
    }
    is_live_[result] = 1;
    octree_.insert(result, quad_centroid(merged.quad));
    if (result + 1 < image_.id_count()) unweighed_.push_back(result);
    return {pair.first, pair.second, pair.corners, pair.opacity};
  }

  CollapseOptions options_;
  ImageErrorOptions image_options_;
  std::vector<glm::vec2> card_chroma_;
  IncrementalImage image_;
  LeafOctree octree_;
  std::vector<Choices> choices_;
  std::vector<ReachPoints> reach_;  ///< empty if not live
  std::vector<std::uint8_t> is_live_;
  std::priority_queue<QueueEntry, std::vector<QueueEntry>, std::greater<>> queue_;
  double px_per_metre_ = 0.0, sqrt_leaf_count_ = 0.0;
  std::uint32_t leaf_count_ = 0, next_id_ = 0, collapse_count_ = 0;
  std::uint64_t evaluations_ = 0;
  std::vector<std::uint32_t> unweighed_;  ///< leaves of the next batch
  std::vector<std::uint8_t> is_alone_;    ///< [id_count] leaves of the batch that need a partner
  tbb::enumerable_thread_specific<IncrementalImage::Scratch> scratches_;
};

Result<void> check_options(const CollapseOptions& options, const ImageErrorOptions& image_options) {
  COPPICE_CHECK(check_candidate_count(options));
  const std::vector<BlockScale>& scales = image_options.scales;
  bool in_range = !scales.empty() && image_options.pixel_weight >= 0 && image_options.pixel_weight <= 1024 &&
                  image_options.coverage_weight >= 0 && image_options.coverage_weight <= 1024;
  for (std::size_t i = 0; i < scales.size(); ++i)
    in_range = in_range && scales[i].shift >= 1 && scales[i].shift <= 5 && scales[i].weight >= 1 && scales[i].weight <= 1024 &&
               (i == 0 || scales[i].shift > scales[i - 1].shift);
  if (!in_range) return Error{Status::invalid_argument, "block scales are not ascending shifts from 1 to 5, or a weight is over 1024"};
  return {};
}

}  // namespace

Result<CollapseResult> collapse_by_image_error(const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                               const CollapseOptions& options, const ImageErrorOptions& image_options,
                                               const ProgressFunction& progress) {
  COPPICE_CHECK(check_options(options, image_options));
  Stopwatch watch;
  COPPICE_TRY(buffers, render_item_buffers(shown, views, options.resolution_px));
  COPPICE_TRY(masks, alpha_masks(shown.materials, shown.images));
  const std::vector<glm::vec3> colors = mean_texel_colors(shown.materials, shown.images, masks);
  std::vector<glm::vec2> card_chroma;
  for (const Card& card : shown.foliage.card_table) card_chroma.push_back(chroma(colors[card.material]));
  IncrementalImage image(shown, std::move(masks), views, buffers, image_options);
  buffers = ItemBuffers{};
  CollapseResult result;
  result.visibility_seconds = watch.lap();

  ImageCollapse collapse(shown.foliage, std::move(card_chroma), options, image_options, std::move(image));
  collapse_down(collapse, shown.foliage.leaf_count(), progress, result);
  return result;
}

}  // namespace coppice::bake
