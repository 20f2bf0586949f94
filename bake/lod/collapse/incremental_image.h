#pragma once

// Incremental image error: the shaded image of a plant in every view while leaves are merged, and its squared error against the plant's
// first image.
//
// An image has four channels, 0..255: the shade under three lights, and coverage. A leaf is lit by coppice_leaf_light; one of the lights
// shines through leaves, as some do, and two do not. The ground is the mean of a dark, a leaf-coloured and a white one: errors over the
// three differ from that only by how much coverage counts, whose channel is weighed by measurement. A merged leaf has the normals of all
// its leaves and an opacity: a pixel composites its leaves front to back. Errors are summed over pixels and over square blocks of pixels:
// blocks are what a viewer sees from far away, and forgive a leaf that moved by a pixel. The image differs from the first one only where a
// merged leaf shows or a removed leaf did, so the cost of a merge takes a walk over the pixels of its three leaves. One walk finds the best
// opacity of a merged leaf together with its cost (MergeCost).
//
// As leaves grow, pixels can: halve() changes to images of half the side, in which all errors keep their meaning.

#include "alpha_mask.h"
#include "fragment_lists.h"
#include "live_visibility.h"
#include "pair_silhouette.h"
#include "plant.h"
#include "visibility.h"

namespace coppice::bake {

inline constexpr std::size_t kImageChannels = 4;
/// Luminance behind the leaves: the mean of grounds of 0, 0.3 and 1, as a display shows them.
inline constexpr float kGround = 110.0f;
using Shade = std::array<std::uint8_t, kImageChannels>;

/// A fragment and what its leaf shows, with the leaf's opacity in place of the coverage.
struct ShownFragment {
  LeafFragment fragment = kNothing;
  Shade color{};
};
[[nodiscard]] inline LeafFragment fragment_of(const ShownFragment& entry) {
  return entry.fragment;
}

/// What a leaf shows in the four channels. albedo  linear luminance; to_viewer  unit
Shade leaf_shade(const ShadingNormals& normals, float albedo, const glm::vec3& to_viewer);

/// Blocks with sides of 2^shift pixels. Their squared difference counts `weight` times for each pixel that the block holds.
struct BlockScale {
  std::uint32_t shift = 3;
  std::int64_t weight = 1;
};

/// The terms of the error. The weights were chosen on ten plants, see DECISIONS.md.
struct ImageErrorOptions {
  std::int64_t pixel_weight = 3;                        ///< weight of squared differences of single pixels; 0 .. 1024
  std::vector<BlockScale> scales = {{3, 8}, {5, 192}};  ///< finest first; shifts 1 .. 5, weights 1 .. 1024
  std::int64_t coverage_weight = 672;                   ///< at the first merge: weight of a view's covered area as one block; 0 .. 1024
  /// These priors are for what no view shows, but some viewer may. The collapse uses them; they are no part of the image's error.
  double mismatch_weight = 0.008;  ///< share of views that are assumed to show the pair, or its merged leaf, with nothing in front
  double color_weight = 6.0;  ///< for the visible area of a leaf that its merged leaf shows in another colour, times the squared difference
  double reach_weight = 1.2e-5;  ///< times sqrt(leaf count) times reach^4: area that is assumed to be wrong in every view, px at 256 px
};

/// What a merge adds to the error if the merged leaf has opacity o: constant + opacity o + opacity2 o^2. In each pixel and block the image
/// is linear in the opacity of one leaf, so the error is a parabola.
struct MergeCost {
  double constant = 0.0, opacity = 0.0, opacity2 = 0.0;
  /// opacity_steps  core/tree.h
  [[nodiscard]] double at(std::uint8_t opacity_steps) const {
    const double o = static_cast<double>(opacity_steps) / kOpaque;
    return constant + (opacity + opacity2 * o) * o;
  }
  /// Whether any view shows the merged leaf.
  [[nodiscard]] bool is_seen() const { return opacity2 > 0.0; }
  /// The cheapest opacity; of equals the smallest. is_seen() must hold.
  [[nodiscard]] std::uint8_t best_opacity() const {
    std::uint8_t best = 1;
    for (std::uint8_t steps = 2; steps <= kOpaque; ++steps)
      if (at(steps) < at(best)) best = steps;
    return best;
  }

  MergeCost& operator+=(const MergeCost& other) {
    constant += other.constant, opacity += other.opacity, opacity2 += other.opacity2;
    return *this;
  }
  [[nodiscard]] MergeCost operator*(double weight) const { return {constant * weight, opacity * weight, opacity2 * weight}; }
};

/// Selects views first, first + stride, ...
struct ViewSubset {
  std::uint32_t first = 0, stride = 1;
};

/// Two leaves that may be merged, the shapes that their merged leaf may have, and the views that judge.
struct MergeTrial {
  std::uint32_t first = 0, second = 0;
  std::span<const PairCorners> shapes;
  ViewSubset views = {};
};

/// areas() are the pixels in which an outcome is in front, whatever its opacity.
class IncrementalImage : public LeafAreas {
 public:
  /// Four channels at once.
  using Channels = float __attribute__((vector_size(16)));

  /// Sums of one view's differences in the blocks of one scale.
  struct BlockSums {
    std::vector<Channels> sums;            ///< [block] 0 between calls
    std::vector<std::uint8_t> is_touched;  ///< [block]
    std::vector<std::uint32_t> touched;
  };
  struct PixelDepth {
    std::uint32_t pixel = 0, depth = 0;
  };
  /// Working memory of one thread.
  struct Scratch {
    std::vector<BlockSums> released, gained;  ///< [scale]
    std::vector<std::uint32_t> stamp;         ///< [pixel] == now: `rest` holds what the pixel shows without the pair
    std::vector<Channels> rest;               ///< [pixel]
    std::uint32_t now = 0;
    std::vector<PixelDepth> walk;  ///< the pixels of the merged leaf that is being evaluated
  };

  /// buffers  render_item_buffers of `shown` with the same views; the conditions are checked there
  IncrementalImage(const ShownFoliage& shown, std::vector<AlphaMask> masks, const std::vector<Viewpoint>& views, const ItemBuffers& buffers,
                   const ImageErrorOptions& options);

  [[nodiscard]] std::uint32_t pixels_per_view() const { return resolution_px_ * resolution_px_; }
  /// The area of a pixel in first-resolution pixels: 1, 4, 16, ...
  [[nodiscard]] double pixel_area() const { return pixel_area_; }

  /// The leaf that a pair becomes, with its normals.
  [[nodiscard]] LiveLeaf merged(std::uint32_t first, std::uint32_t second, const PairCorners& corners, std::uint8_t opacity) const;

  /// Computes how merging a pair would change the error of some views, for each shape that the merged leaf might have. May run on several
  /// threads, each with its own scratch.
  /// costs  [trial.shapes.size()]
  void costs_of(const MergeTrial& trial, Scratch& scratch, std::span<MergeCost> costs) const;

  /// Replaces ImageErrorOptions::coverage_weight from now on.
  void set_coverage_weight(double weight);

  /// The share of the first image's coverage that the present image lacks, over all views; below 0 if it covers more.
  [[nodiscard]] double lost_coverage() const;

  /// Merges two leaves. The result's id must not be live. Parallel over views.
  void apply(const LeafMerge& merge);

  /// Whether the images can be halved.
  [[nodiscard]] bool can_halve() const { return resolution_px_ % 2 == 0 && options_.scales.front().shift > halvings_; }
  /// Changes to images of half the side. The present image is drawn again, and its differences from the first one are box-filtered, so that
  /// drawing larger pixels does not count as an error. live  all live ids, ascending
  void halve(std::span<const std::uint32_t> live);

  /// Squared error of the present image against the first one, over all views, in units of 1/1024 px^2 (a block of 32 x 32 px counts once).
  [[nodiscard]] double error() const;

 private:
  using FixedChannels = std::int32_t __attribute__((vector_size(16)));
  using FixedPixel = std::int16_t __attribute__((vector_size(8)));

  struct View {
    Projection projection;
    glm::vec3 direction{0.0f};  ///< towards the viewer
    PixelLists<ShownFragment> fragments;
    std::vector<FixedPixel> source;                       ///< [pixel] the first image
    std::vector<FixedChannels> shown;                     ///< [pixel] the present image
    std::vector<LeafFragment> last;                       ///< [pixel] the fragment that nothing shows through, or kNothing
    std::vector<std::vector<FixedChannels>> differences;  ///< [scale][block] present image minus the first one
    std::int64_t covered = 0;                             ///< coverage of the first image, summed over pixels: sixteenths of 1/255 px
    std::int64_t excess = 0;                              ///< by how much the present image's coverage exceeds that
    std::vector<LeafFragment> farthest;                   ///< [tile] the farthest of `last`
  };
  /// Pixels of a leaf, visible or not, view by view.
  struct LeafPixels {
    std::vector<std::size_t> view_begin;  ///< [view_count + 1]
    std::vector<PixelDepth> pixels;
    [[nodiscard]] std::span<const PixelDepth> in(std::uint32_t v) const {
      return std::span(pixels).subspan(view_begin[v], view_begin[v + 1] - view_begin[v]);
    }
  };
  using ProjectedPair = std::array<ProjectedPoint, 8>;
  /// The evaluation of a pair in one view.
  struct Weighing {
    const View& view;
    std::uint32_t first, second;
    ProjectedPair corners;
    Scratch& scratch;
    double uncovered = 0.0;  ///< coverage that goes away with the pair, negative
  };

  [[nodiscard]] std::uint32_t shift_of(std::size_t scale) const { return options_.scales[scale].shift - halvings_; }
  [[nodiscard]] std::uint32_t blocks_per_row(std::size_t scale) const {
    return (resolution_px_ + (1u << shift_of(scale)) - 1) >> shift_of(scale);
  }
  [[nodiscard]] std::uint32_t block_of(std::uint32_t pixel) const {
    const auto y = static_cast<std::uint32_t>((pixel + 0.5) * rows_per_pixel_), x = pixel - y * resolution_px_;
    return (y >> finest_shift_) * finest_blocks_per_row_ + (x >> finest_shift_);
  }
  [[nodiscard]] std::uint32_t tile_of(std::uint32_t pixel) const {
    return ((pixel / resolution_px_) >> kTileShift) * tiles_per_row_ + ((pixel % resolution_px_) >> kTileShift);
  }
  /// The area of the outcome that a pixel of view v now shows in front.
  [[nodiscard]] std::uint32_t& front_area(std::uint32_t v, std::uint32_t pixel) {
    return area_px(outcome_of(views_[v].fragments.front(pixel)), v);
  }
  [[nodiscard]] double pixel_weight() const;
  [[nodiscard]] double block_weight(std::size_t scale) const;
  /// What a leaf shows, as its normals say.
  struct Lit {
    ShadingNormals normals;
    float albedo = 0.0f;
    std::uint8_t opacity = kOpaque;
  };
  [[nodiscard]] Lit lit(const LiveLeaf& leaf) const;
  [[nodiscard]] static Shade color_of(const View& view, const Lit& leaf);
  [[nodiscard]] LeafPixels pixels_of(const LiveLeaf& leaf) const;
  [[nodiscard]] FixedChannels composite(const View& view, std::uint32_t pixel, const std::array<std::uint32_t, 2>& without,
                                        LeafFragment& last) const;
  [[nodiscard]] bool is_hidden(const View& view, const ProjectedPair& pair) const;
  void set_resolution(std::uint32_t resolution_px);
  void draw(View& view) const;
  void measure(View& view) const;
  void add_difference(View& view, std::uint32_t pixel, const FixedChannels& change) const;
  void find_farthest(View& view, std::uint32_t tile) const;
  double release(std::uint32_t v, Weighing& weighing) const;
  MergeCost gain(const Weighing& weighing, const PairCorners& corners, const Card& card, const Shade& shade) const;
  [[nodiscard]] Channels gained(const Weighing& weighing, std::uint32_t pixel, LeafFragment merged, const Channels& opaque,
                                const Channels& rest) const;
  void prepare(Scratch& scratch) const;
  void prefetch(const View& view, const Scratch& scratch, std::uint32_t pixel) const;
  static void add(BlockSums& blocks, std::uint32_t block, const Channels& change);
  void add_coarser(std::vector<BlockSums>& scales) const;
  static void clear(std::vector<BlockSums>& scales);

  static constexpr std::uint32_t kTileShift = 3;

  std::uint32_t resolution_px_ = 0, tiles_per_row_ = 0, halvings_ = 0;
  double rows_per_pixel_ = 0.0;  ///< for a multiplication in place of a division
  double pixel_area_ = 1.0;
  double coverage_unit_ = 0.0;  ///< error of a squared excess of one px^2, over 255^2
  std::uint32_t finest_shift_ = 0, finest_blocks_per_row_ = 0;
  ImageErrorOptions options_;
  MaskedCards cards_;
  std::vector<float> albedo_;  ///< [material]
  Sphere sphere_;
  std::vector<Viewpoint> viewpoints_;
  std::vector<View> views_;
  std::vector<LeafPixels> pixels_;  ///< [id_count] empty if not live
};

}  // namespace coppice::bake
