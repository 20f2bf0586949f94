// A greedy search with a lazy queue. A leaf's entry goes stale when its partner is merged away (it then looks for a new one) or when the
// picture near it changes (its cost is computed again before it is believed). Costs hardly ever fall, so the queue seldom passes over the
// cheapest collapse. Costs are integers and weighed in parallel; which one is taken is decided on one thread.

#include "collapse_image.h"

#include <algorithm>
#include <chrono>
#include <queue>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "collapse_down.h"
#include "mutual_information.h"
#include "octree.h"
#include "quad_match.h"
#include "quad_merge.h"

namespace coppice::bake {
namespace {

/// The best that a pair can do.
struct WeighedPair {
  std::int64_t cost = 0;
  std::uint32_t first = kNone, second = kNone;  ///< first < second
  std::array<std::uint8_t, 4> corners{};
};

/// A leaf's best collapse, as far as is known.
struct Choice {
  WeighedPair pair;
  std::uint32_t weighed_at = 0;  ///< number of collapses before it was weighed
  std::uint32_t stamp = 0;       ///< entries of the queue with another stamp are void
};

struct QueueEntry {
  std::int64_t cost = 0;
  std::uint32_t leaf = 0, stamp = 0;
};
/// For std::priority_queue, whose top is the largest.
struct LaterInQueue {
  bool operator()(const QueueEntry& a, const QueueEntry& b) const { return a.cost != b.cost ? a.cost > b.cost : a.leaf > b.leaf; }
};

class ImageCollapse {
 public:
  ImageCollapse(const Foliage& foliage, const CollapseOptions& options, LiveImage image)
      : options_(options),
        image_(std::move(image)),
        octree_(foliage, image_.id_count()),
        choices_(image_.id_count()),
        is_live_(image_.id_count(), 0),
        next_id_(foliage.leaf_count()) {
    for (std::uint32_t id = 0; id < foliage.leaf_count(); ++id) {
      is_live_[id] = 1;
      octree_.insert(id, quad_centroid(foliage.quads[id]));
    }
    if (foliage.leaf_count() > 1) choose_for_all(foliage.leaf_count());
  }

  [[nodiscard]] std::uint64_t evaluations() const { return evaluations_; }

  /// I(V,L) of the live leaves, and of the background where it counts.
  [[nodiscard]] FixedBits foliage_information() const {
    ViewTotals totals(image_.view_count());
    const std::span<const std::uint32_t> background = image_.areas(image_.background());
    for (std::uint32_t v = 0; v < image_.view_count(); ++v)
      totals.set(v, image_.pixels_per_view() - (options_.count_background ? 0 : background[v]));
    FixedBits sum = options_.count_background ? outcome_information(background, totals) : 0;
    for (std::uint32_t id = 0; id < next_id_; ++id)
      if (is_live_[id] != 0) sum += outcome_information(image_.areas(id), totals);
    return sum;
  }

  Merge step() {
    for (;;) {
      const QueueEntry top = queue_.top();
      queue_.pop();
      if (is_live_[top.leaf] == 0 || choices_[top.leaf].stamp != top.stamp) continue;
      Choice& choice = choices_[top.leaf];
      if (is_live_[choice.pair.first] == 0 || is_live_[choice.pair.second] == 0) {
        choose(top.leaf);
      } else if (choice.weighed_at == collapse_count_) {
        return commit(choice.pair);
      } else {
        set(top.leaf, weigh(choice.pair.first, choice.pair.second));
        ++evaluations_;
      }
    }
  }

 private:
  static bool better(const WeighedPair& a, const WeighedPair& b) {
    if (a.cost != b.cost) return a.cost < b.cost;
    return a.first != b.first ? a.first < b.first : a.second < b.second;
  }

  [[nodiscard]] LiveLeaf merged_leaf(const WeighedPair& pair) const {
    const LiveLeaf& first = image_.leaf(pair.first);
    const LiveLeaf& second = image_.leaf(pair.second);
    return {merged_quad(first.quad, second.quad, pair.corners), merged_card(first.quad, first.card, second.quad, second.card)};
  }

  WeighedPair weigh(std::uint32_t a, std::uint32_t b) {
    WeighedPair pair{0, std::min(a, b), std::max(a, b), {}};
    const Quad& first = image_.leaf(pair.first).quad;
    const Quad& second = image_.leaf(pair.second).quad;
    const std::array corners = {matching_corners(first, second), merge_corners(first, second)};
    std::array<LiveLeaf, 2> shapes;
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      pair.corners = corners[s];
      shapes[s] = merged_leaf(pair);
    }
    std::array<std::int64_t, 2> changes{};
    image_.changes_of(pair.first, pair.second, shapes, scratches_.local(), changes);
    const std::size_t best = changes[1] < changes[0] ? 1 : 0;
    pair.cost = changes[best];
    pair.corners = corners[best];
    return pair;
  }

  void set(std::uint32_t leaf, const WeighedPair& pair) {
    Choice& choice = choices_[leaf];
    choice = {pair, collapse_count_, choice.stamp + 1};
    queue_.push({pair.cost, leaf, choice.stamp});
  }

  void choose(std::uint32_t leaf) {
    octree_.candidates_of(leaf, options_.candidate_count, partners_);
    weighed_.resize(partners_.size());
    tbb::parallel_for(std::size_t{0}, partners_.size(), [&](std::size_t i) { weighed_[i] = weigh(leaf, partners_[i]); });
    evaluations_ += partners_.size();
    set(leaf, *std::min_element(weighed_.begin(), weighed_.end(), better));
  }

  /// choose() for every source leaf, each pair weighed once.
  void choose_for_all(std::uint32_t leaf_count) {
    std::vector<WeighedPair> pairs;
    std::vector<std::vector<std::uint32_t>> candidates(leaf_count);
    for (std::uint32_t leaf = 0; leaf < leaf_count; ++leaf) octree_.candidates_of(leaf, options_.candidate_count, candidates[leaf]);
    for (std::uint32_t leaf = 0; leaf < leaf_count; ++leaf)
      for (const std::uint32_t other : candidates[leaf]) pairs.push_back({0, std::min(leaf, other), std::max(leaf, other), {}});
    const auto by_ids = [](const WeighedPair& a, const WeighedPair& b) {
      return a.first != b.first ? a.first < b.first : a.second < b.second;
    };
    std::sort(pairs.begin(), pairs.end(), by_ids);
    pairs.erase(std::unique(pairs.begin(), pairs.end(), [&](const auto& a, const auto& b) { return !by_ids(a, b) && !by_ids(b, a); }),
                pairs.end());
    tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t i) { pairs[i] = weigh(pairs[i].first, pairs[i].second); });
    evaluations_ += pairs.size();
    std::vector<WeighedPair> best(leaf_count);
    for (const WeighedPair& pair : pairs)
      for (const std::uint32_t leaf : {pair.first, pair.second})
        if (best[leaf].first == kNone || better(pair, best[leaf])) best[leaf] = pair;
    for (std::uint32_t leaf = 0; leaf < leaf_count; ++leaf) set(leaf, best[leaf]);
  }

  Merge commit(const WeighedPair pair) {
    const LiveLeaf merged = merged_leaf(pair);
    image_.apply({pair.first, pair.second, next_id_, merged});
    ++collapse_count_;
    for (const std::uint32_t removed : {pair.first, pair.second}) {
      octree_.remove(removed);
      is_live_[removed] = 0;
    }
    const std::uint32_t result = next_id_++;
    is_live_[result] = 1;
    octree_.insert(result, quad_centroid(merged.quad));
    if (result + 1 < image_.id_count()) choose(result);
    return {pair.first, pair.second, pair.corners};
  }

  CollapseOptions options_;
  LiveImage image_;
  LeafOctree octree_;
  std::vector<Choice> choices_;
  std::vector<std::uint8_t> is_live_;
  std::priority_queue<QueueEntry, std::vector<QueueEntry>, LaterInQueue> queue_;
  std::uint32_t next_id_ = 0, collapse_count_ = 0;
  std::uint64_t evaluations_ = 0;
  std::vector<std::uint32_t> partners_;
  std::vector<WeighedPair> weighed_;
  tbb::enumerable_thread_specific<LiveImage::Scratch> scratches_;
};

Result<void> check_options(const CollapseOptions& options, const ImageErrorOptions& image_options) {
  if (options.candidate_count == 0 || options.candidate_count > kMaxCandidateCount)
    return Error{Status::invalid_argument, "number of candidates is not between 1 and 4096", Error::kNoOffset,
                 std::to_string(options.candidate_count)};
  const std::vector<BlockScale>& scales = image_options.scales;
  bool in_range = !scales.empty();
  for (std::size_t i = 0; i < scales.size(); ++i)
    in_range = in_range && scales[i].shift <= 5 && scales[i].weight >= 1 && scales[i].weight <= 1024 &&
               (i == 0 || scales[i].shift > scales[i - 1].shift);
  if (!in_range) return Error{Status::invalid_argument, "block scales are not ascending shifts from 0 to 5 with weights from 1 to 1024"};
  return {};
}

}  // namespace

Result<CollapseResult> collapse_by_image_error(const Foliage& foliage, const std::vector<Material>& materials,
                                               const std::vector<Image>& images, const std::vector<Viewpoint>& views,
                                               const CollapseOptions& options, const ImageErrorOptions& image_options,
                                               const ProgressFunction& progress) {
  COPPICE_CHECK(check_options(options, image_options));
  const auto start = std::chrono::steady_clock::now();
  COPPICE_TRY(buffers, render_item_buffers(foliage, materials, images, views, options.resolution_px));
  COPPICE_TRY(masks, alpha_masks(materials, images));
  LiveImage image(foliage, materials, images, std::move(masks), views, buffers, image_options);
  buffers = ItemBuffers{};
  CollapseResult result;
  result.visibility_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  ImageCollapse collapse(foliage, options, std::move(image));
  collapse_down(collapse, foliage.leaf_count(), progress, result);
  result.sequence.evaluations = collapse.evaluations();
  return result;
}

}  // namespace coppice::bake
