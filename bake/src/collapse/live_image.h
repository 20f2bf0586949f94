#pragma once

// The shaded picture of a plant in every view while leaves are merged, and its squared error against the plant's first picture.
//
// A view is a picture of four channels: the shade of the front leaf under three lights, over white, and coverage, all 0..255. A leaf has
// two sides: lights behind the side that is seen do not reach it. Errors are summed over pixels and over square blocks of pixels: blocks
// are what a viewer sees from far away, and forgive a leaf that moved by a pixel. Pictures differ from the first one only where a merged
// leaf shows or a removed leaf did, so a merge is weighed by walking the pixels of its three leaves. All sums are integers: adding up
// changes gives exactly what rendering anew would.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "alpha_mask.h"
#include "fragment_lists.h"
#include "live_visibility.h"
#include "pair_silhouette.h"
#include "plant.h"
#include "visibility.h"

namespace coppice::bake {

inline constexpr std::size_t kImageChannels = 4;
using Shade = std::array<std::int32_t, kImageChannels>;

/// What each side of a leaf looks like in the four channels. The front is where its corners run counter-clockwise.
struct LeafShades {
  glm::vec3 normal{0.0f};
  std::array<std::uint8_t, kImageChannels> front{}, back{};

  /// direction  towards the viewer
  [[nodiscard]] Shade seen_from(const glm::vec3& direction) const {
    const bool is_front = normal.x * direction.x + normal.y * direction.y + normal.z * direction.z >= 0.0f;
    const std::array<std::uint8_t, kImageChannels>& side = is_front ? front : back;
    return {side[0], side[1], side[2], side[3]};
  }
};

/// albedo  linear luminance
LeafShades leaf_shades(const Quad& quad, float albedo);

/// Blocks of 2^shift pixels a side whose squared difference counts `weight` times, per pixel that the block holds.
struct BlockScale {
  std::uint32_t shift = 3;
  std::int64_t weight = 1;
};

/// What the error is made of. Weights were chosen on ten plants, see DECISIONS.md.
struct ImageErrorOptions {
  std::int64_t pixel_weight = 3;                                 ///< of the squared differences of single pixels; 0 .. 1024
  std::vector<BlockScale> scales = {{3, 8}, {5, 192}};           ///< finest first; shifts 1 .. 5, weights 1 .. 1024
  std::int64_t coverage_weight = 672;                            ///< of a view's covered area as one block; 0 .. 1024
  std::array<std::int64_t, kImageChannels> weights{1, 1, 1, 1};  ///< of the channels' squared differences
  /// What no view shows, but some viewer may. Used by the collapse, not part of the picture's error.
  double mismatch_weight = 0.008;  ///< share of the views that are taken to show the pair, or its merged leaf, with nothing in front
  double color_weight = 6.0;       ///< of the area seen of a leaf that a merged one shows in another colour, by that difference squared
  double reach_weight = 1.2e-5;    ///< times sqrt(leaf count) times reach^4: area that is taken to be wrong in every view, px at 256 px
};

/// Views first, first + stride, ...
struct ViewSubset {
  std::uint32_t first = 0, stride = 1;
};

/// Two leaves that may be merged, the shapes that their merged leaf may have, and the views that judge them.
struct MergeTrial {
  std::uint32_t first = 0, second = 0;
  std::span<const PairCorners> shapes;
  ViewSubset views = {};
};

class LiveImage {
 public:
  /// Differences of one view being added up, scale by scale.
  struct Deltas {
    std::vector<std::vector<Shade>> sums;             ///< [scale][block] 0 between calls
    std::vector<std::vector<std::uint32_t>> touched;  ///< [scale]
    std::vector<std::vector<std::uint8_t>> is_touched;
  };
  /// Working memory of one thread.
  struct Scratch {
    Deltas released, changed;
    std::vector<LeafShades> shades;  ///< [shape]
  };

  /// buffers  of `shown` with the same views; see render_item_buffers for what must hold (checked there)
  LiveImage(const ShownFoliage& shown, std::vector<AlphaMask> masks, const std::vector<Viewpoint>& views, const ItemBuffers& buffers,
            const ImageErrorOptions& options);

  [[nodiscard]] std::uint32_t view_count() const { return static_cast<std::uint32_t>(views_.size()); }
  [[nodiscard]] std::uint32_t pixels_per_view() const { return resolution_px_ * resolution_px_; }
  [[nodiscard]] std::uint32_t id_count() const { return id_count_; }
  [[nodiscard]] std::uint32_t background() const { return id_count_; }
  [[nodiscard]] const LiveLeaf& leaf(std::uint32_t id) const { return leaves_[id]; }
  /// Pixels in which an outcome (leaf id or background) is in front. [view_count] px; 0 for ids that are not live
  [[nodiscard]] std::span<const std::uint32_t> areas(std::uint32_t outcome) const {
    return std::span(areas_px_).subspan(std::size_t{outcome} * view_count(), view_count());
  }

  /// The leaf that a pair becomes: its quad by `corners`, its card the larger leaf's.
  [[nodiscard]] LiveLeaf merged(std::uint32_t first, std::uint32_t second, const PairCorners& corners) const;

  /// What merging a pair would add to the error of some views, once for each shape that the merged leaf might have. May run on several
  /// threads, each with its own scratch.
  /// changes  [trial.shapes.size()]
  void changes_of(const MergeTrial& trial, Scratch& scratch, std::span<std::int64_t> changes) const;

  /// Merges. result  id; not live. Parallel over views.
  void apply(const LeafMerge& merge);

  /// Squared error of the present picture against the first one, all views, in units of 1/1024 px^2 (a block of 32 x 32 px counts once).
  [[nodiscard]] std::int64_t error() const;

 private:
  struct View {
    Projection projection;
    glm::vec3 direction{0.0f};  ///< towards the viewer
    FragmentLists fragments;
    std::vector<std::array<std::uint8_t, kImageChannels>> source;  ///< [pixel] the first picture
    std::vector<std::vector<Shade>> differences;                   ///< [scale][block] present picture less the first one
    std::int64_t excess_px = 0;                                    ///< covered pixels less those of the first picture
    std::vector<LeafFragment> farthest;                            ///< [tile] no front fragment of the tile is behind it
  };
  /// Pixels of a leaf, in front or not, view by view.
  struct LeafPixels {
    std::vector<std::uint32_t> view_begin;  ///< [view_count + 1]
    std::vector<std::uint32_t> pixels;
  };
  using ProjectedPair = std::array<ProjectedPoint, 8>;

  [[nodiscard]] std::uint32_t blocks_per_row(std::size_t scale) const {
    return (resolution_px_ + (1u << options_.scales[scale].shift) - 1) >> options_.scales[scale].shift;
  }
  [[nodiscard]] std::uint32_t block_of(std::uint32_t pixel) const {
    return ((pixel / resolution_px_) >> finest_shift_) * finest_blocks_per_row_ + ((pixel % resolution_px_) >> finest_shift_);
  }
  [[nodiscard]] std::uint32_t tile_of(std::uint32_t pixel) const {
    return ((pixel / resolution_px_) >> kTileShift) * tiles_per_row_ + ((pixel % resolution_px_) >> kTileShift);
  }
  [[nodiscard]] std::uint32_t outcome_of(LeafFragment fragment) const {
    return fragment == FragmentLists::kNothing ? background() : fragment_leaf(fragment);
  }
  [[nodiscard]] std::int64_t weight_of(std::size_t scale) const;
  [[nodiscard]] LeafShades shades_of(const LiveLeaf& leaf) const {
    return leaf_shades(leaf.quad, albedo_[card_table_[leaf.card].material]);
  }
  [[nodiscard]] Shade seen(const View& view, std::uint32_t outcome) const { return shades_[outcome].seen_from(view.direction); }
  [[nodiscard]] std::int64_t pixel_error(const View& view, std::uint32_t pixel, const Shade& shade) const;
  [[nodiscard]] LeafPixels pixels_of(const LiveLeaf& leaf) const;
  [[nodiscard]] bool is_hidden(const View& view, const ProjectedPair& pair) const;
  void find_farthest(View& view, std::uint32_t tile) const;
  template <class Visit>
  void for_each_fragment_of(const View& view, const LiveLeaf& leaf, std::uint32_t id, Visit&& visit) const {
    const Card& card = card_table_[leaf.card];
    for_each_fragment(view.projection, leaf.quad, {card, masks_[card.material]}, id, visit);
  }
  template <class Change>
  void release(std::uint32_t v, std::uint32_t first, std::uint32_t second, Change&& change) const;
  /// A quad in a view.
  struct ProjectedLeaf {
    ProjectedQuad quad;
    const Card& card;
  };
  template <class Change>
  void gain(const View& view, std::uint32_t first, std::uint32_t second, const ProjectedLeaf& leaf, Change&& change) const;
  void prepare(Deltas& deltas) const;
  void add(Deltas& deltas, std::size_t scale, std::uint32_t block, const Shade& change) const;
  void add_coarser(Deltas& deltas) const;
  [[nodiscard]] std::int64_t take_error(const View& view, Deltas& deltas) const;

  static constexpr std::uint32_t kTileShift = 3;

  std::uint32_t id_count_ = 0, resolution_px_ = 0, tiles_per_row_ = 0;
  std::int64_t coverage_unit_ = 0;  ///< error of one px^2 of excess, squared
  std::uint32_t finest_shift_ = 0, finest_blocks_per_row_ = 0;
  ImageErrorOptions options_;
  std::vector<Card> card_table_;
  std::vector<AlphaMask> masks_;
  std::vector<float> albedo_;  ///< [material]
  std::vector<View> views_;
  std::vector<LiveLeaf> leaves_;         ///< [id_count]
  std::vector<LeafPixels> pixels_;       ///< [id_count] empty if not live
  std::vector<LeafShades> shades_;       ///< [id_count + 1] last: the background
  std::vector<std::uint32_t> areas_px_;  ///< [(id_count + 1) * view_count]
};

}  // namespace coppice::bake
