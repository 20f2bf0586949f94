#pragma once

// The shaded picture of a plant in every view while leaves are merged, and its squared error against the plant's first picture.
//
// A view is a picture of four channels: the shade of the front leaf under three lights, over white, and coverage, all 0..255. Errors are
// summed over square blocks of pixels: blocks are what a viewer sees from far away, and forgive a leaf that moved by a pixel. Pictures
// differ from the first one only where a merged leaf shows or a removed leaf did, so a merge is weighed by walking the pixels of its
// three leaves. All sums are integers: adding up changes gives exactly what rendering anew would.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fragment_lists.h"
#include "live_visibility.h"
#include "plant.h"
#include "visibility.h"

namespace coppice::bake {

inline constexpr std::size_t kImageChannels = 4;
using Shade = std::array<std::int32_t, kImageChannels>;

/// A leaf in the four channels. albedo  linear
Shade image_shade(const Quad& quad, float albedo);

/// Blocks of 2^shift pixels a side whose squared difference counts `weight` times, per pixel that the block holds.
struct BlockScale {
  std::uint32_t shift = 3;
  std::int64_t weight = 1;
};

struct ImageErrorOptions {
  std::vector<BlockScale> scales = {{3, 1}, {5, 4}};             ///< finest first; shifts 0 .. 5, weights 1 .. 1024
  std::array<std::int64_t, kImageChannels> weights{1, 1, 1, 1};  ///< of the channels' squared differences
};

class LiveImage {
 public:
  static constexpr std::size_t kMaxShapes = 8;

  /// Differences of one view being added up, scale by scale.
  struct Deltas {
    std::vector<std::vector<Shade>> sums;             ///< [scale][block] 0 between calls
    std::vector<std::vector<std::uint32_t>> touched;  ///< [scale]
    std::vector<std::vector<std::uint8_t>> is_touched;
  };
  /// Working memory of one thread.
  struct Scratch {
    Deltas released, changed;
  };

  /// buffers  of `foliage` with the same views; see render_item_buffers for what must hold (checked there)
  LiveImage(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images, std::vector<AlphaMask> masks,
            const std::vector<Viewpoint>& views, const ItemBuffers& buffers, const ImageErrorOptions& options);

  [[nodiscard]] std::uint32_t view_count() const { return static_cast<std::uint32_t>(views_.size()); }
  [[nodiscard]] std::uint32_t pixels_per_view() const { return resolution_px_ * resolution_px_; }
  [[nodiscard]] std::uint32_t id_count() const { return id_count_; }
  [[nodiscard]] std::uint32_t background() const { return id_count_; }
  [[nodiscard]] const LiveLeaf& leaf(std::uint32_t id) const { return leaves_[id]; }
  /// Pixels in which an outcome (leaf id or background) is in front. [view_count] px; 0 for ids that are not live
  [[nodiscard]] std::span<const std::uint32_t> areas(std::uint32_t outcome) const {
    return std::span(areas_px_).subspan(std::size_t{outcome} * view_count(), view_count());
  }

  /// What merging a pair would add to error(), once for each shape that the merged leaf might have. May run on several threads, each with
  /// its own scratch.
  /// shapes   the merged leaf; at most kMaxShapes
  /// changes  [shapes.size()]
  void changes_of(std::uint32_t first, std::uint32_t second, std::span<const LiveLeaf> shapes, Scratch& scratch,
                  std::span<std::int64_t> changes) const;

  /// Merges. result  id; not live. Parallel over views.
  void apply(const LeafMerge& merge);

  /// Squared error of the present picture against the first one, all views, in units of 1/1024 px^2 (a block of 32 x 32 px counts once).
  [[nodiscard]] std::int64_t error() const;

 private:
  struct View {
    Projection projection;
    FragmentLists fragments;
    std::vector<std::vector<Shade>> differences;  ///< [scale][block] present picture less the first one
  };
  /// Pixels of a leaf, in front or not, view by view.
  struct LeafPixels {
    std::vector<std::uint32_t> view_begin;  ///< [view_count + 1]
    std::vector<std::uint32_t> pixels;
  };

  [[nodiscard]] std::uint32_t blocks_per_row(std::size_t scale) const {
    return (resolution_px_ + (1u << options_.scales[scale].shift) - 1) >> options_.scales[scale].shift;
  }
  [[nodiscard]] std::uint32_t block_of(std::uint32_t pixel) const {
    return ((pixel / resolution_px_) >> finest_shift_) * finest_blocks_per_row_ + ((pixel % resolution_px_) >> finest_shift_);
  }
  [[nodiscard]] std::uint32_t outcome_of(LeafFragment fragment) const {
    return fragment == FragmentLists::kNothing ? background() : fragment_leaf(fragment);
  }
  [[nodiscard]] Shade shade_of(const LiveLeaf& leaf) const { return image_shade(leaf.quad, albedo_[card_table_[leaf.card].material]); }
  [[nodiscard]] std::int64_t weight_of(std::size_t scale) const;
  [[nodiscard]] LeafPixels pixels_of(const LiveLeaf& leaf) const;
  template <class Visit>
  void for_each_fragment(const View& view, const LiveLeaf& leaf, std::uint32_t id, Visit&& visit) const;
  template <class Change>
  void release(std::uint32_t v, std::uint32_t first, std::uint32_t second, Change&& change) const;
  template <class Change>
  void gain(std::uint32_t v, std::uint32_t first, std::uint32_t second, const LiveLeaf& shape, std::uint32_t id, Change&& change) const;
  void prepare(Deltas& deltas) const;
  void add(Deltas& deltas, std::size_t scale, std::uint32_t block, const Shade& change) const;
  void add_coarser(Deltas& deltas) const;
  [[nodiscard]] std::int64_t take_error(const View& view, Deltas& deltas) const;

  std::uint32_t id_count_ = 0, resolution_px_ = 0;
  std::uint32_t finest_shift_ = 0, finest_blocks_per_row_ = 0;
  ImageErrorOptions options_;
  std::vector<Card> card_table_;
  std::vector<AlphaMask> masks_;
  std::vector<float> albedo_;  ///< [material]
  std::vector<View> views_;
  std::vector<LiveLeaf> leaves_;         ///< [id_count]
  std::vector<LeafPixels> pixels_;       ///< [id_count] empty if not live
  std::vector<Shade> shades_;            ///< [id_count + 1] last: the background
  std::vector<std::uint32_t> areas_px_;  ///< [(id_count + 1) * view_count]
};

}  // namespace coppice::bake
