#include "incremental_image.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "bounds.h"
#include "check.h"
#include "leaf_shade.h"
#include "parallel_for.h"
#include "quad_merge.h"

namespace coppice::bake {
namespace {

using Channels = IncrementalImage::Channels;

/// The largest block has 32 x 32 pixels and counts once; smaller ones count as often as they fit into it.
constexpr std::uint32_t kLargestShift = 5;
constexpr Channels kBackground{kGround, kGround, kGround, 0.0f};
/// The coverage of a leaf, added to its shade.
constexpr Channels kFullCoverage{0.0f, 0.0f, 0.0f, 255.0f};
/// Less transmittance than this counts as none: an eighth of a step of 255.
constexpr float kMinShare = 1.0f / 2048.0f;
/// How many pixels ahead of a walk memory is prefetched.
constexpr std::size_t kListsAhead = 16, kEntriesAhead = 8;
constexpr float kOpacityUnit = 1.0f / kOpaque;
constexpr std::array kNoLeaves{kNone, kNone};

Channels channels_of(const Shade& shade) {
  return Channels{static_cast<float>(shade[0]), static_cast<float>(shade[1]), static_cast<float>(shade[2]), static_cast<float>(shade[3])};
}

/// Composites the leaves of a pixel front to back.
struct Layers {
  Channels light{};    ///< their shade, without coverage
  float share = 1.0f;  ///< transmittance: the share of what is behind that shows

  /// color  the leaf's shade, with its opacity in place of coverage
  void put(const Shade& color) {
    // All three channels at once: each keeps its byte's place, and a factor moves it back.
    static_assert(std::endian::native == std::endian::little);
    using Words = std::int32_t __attribute__((vector_size(16)));
    constexpr Words kBytes{0xff, 0xff00, 0xff0000, 0};
    constexpr Channels kPlaces{1.0f, 1.0f / 0x100, 1.0f / 0x10000, 0.0f};
    const auto word = std::bit_cast<std::int32_t>(color);
    const float opacity = static_cast<float>(color[3]) * kOpacityUnit;
    light += share * opacity * kPlaces * __builtin_convertvector(Words{word, word, word, word} & kBytes, Channels);
    share *= 1.0f - opacity;
  }
  [[nodiscard]] bool is_closed() const { return share < kMinShare; }
  [[nodiscard]] Channels channels() const { return light + (1.0f - share) * kFullCoverage; }
};

float sum_of(const Channels& channels) {
  return (channels[0] + channels[1]) + (channels[2] + channels[3]);
}
float dot(const Channels& a, const Channels& b) {
  return sum_of(a * b);
}

/// Sums of squares of rest + opacity * gain.
struct SquareSums {
  Channels rest_gain{}, gain2{};

  void add(const Channels& rest, const Channels& gain) {
    rest_gain += rest * gain;
    gain2 += gain * gain;
  }
  [[nodiscard]] MergeCost cost() const { return {.opacity = 2.0 * double{sum_of(rest_gain)}, .opacity2 = double{sum_of(gain2)}}; }
};

/// Pixels are kept in whole sixteenths, so that sums of changes equal drawing again, to the bit.
constexpr float kFixedUnit = 16.0f;

template <class Fixed>
Channels unfixed(const Fixed& channels) {
  return __builtin_convertvector(channels, Channels) * (1.0f / kFixedUnit);
}

void sort_and_unite(std::vector<std::uint32_t>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

Shade leaf_shade(const ShadingNormals& normals, float albedo, const glm::vec3& to_viewer) {
  // Three lights distinguish normals, whichever way a viewer's light comes from.
  struct Light {
    glm::vec3 direction;
    float translucency;
  };
  static const std::array lights = {Light{glm::normalize(glm::vec3(0.4f, 0.8f, 0.45f)), kTranslucency},
                                    Light{glm::normalize(glm::vec3(-0.8f, 0.4f, 0.45f)), 0.0f},
                                    Light{glm::normalize(glm::vec3(0.1f, 0.5f, -0.85f)), 0.0f}};
  Shade shade{};
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const float cosine = leaf_cosine(normals, lights[i].direction, to_viewer, lights[i].translucency);
    shade[i] = static_cast<std::uint8_t>(std::lround(lambert_luminance(albedo, cosine)));
  }
  shade.back() = 255;
  return shade;
}

IncrementalImage::IncrementalImage(const ShownFoliage& shown, std::vector<AlphaMask> masks, const std::vector<Viewpoint>& views,
                                   const ItemBuffers& buffers, const ImageErrorOptions& options)
    : LeafAreas(shown.foliage, buffers.view_count),
      options_(options),
      cards_{shown.foliage.card_table, std::move(masks)},
      sphere_(bounding_sphere(shown.foliage)),
      viewpoints_(views),
      views_(buffers.view_count),
      pixels_(id_count()) {
  for (std::size_t m = 0; m < shown.materials.size(); ++m)
    albedo_.push_back(mean_texel_luminance(shown.materials[m], shown.images, cards_.masks[m]));
  const Foliage& foliage = shown.foliage;
  set_resolution(buffers.resolution_px);
  set_coverage_weight(static_cast<double>(options.coverage_weight));
  parallel_for(foliage.leaf_count(), [&](std::uint32_t i) {
    leaves_[i].normals = foliage.normals.empty() ? kFlatNormals : foliage.normals[i];
    leaves_[i].normal_sum = source_normal_sum(foliage, i);
    pixels_[i] = pixels_of(leaves_[i]);
  });
  parallel_for(view_count(), [&](std::uint32_t v) {
    View& view = views_[v];
    std::vector<Shade> colors;
    for (std::uint32_t i = 0; i < foliage.leaf_count(); ++i) colors.push_back(color_of(view, lit(leaves_[i])));
    view.fragments = PixelLists<ShownFragment>(buffers, v, [&](LeafFragment fragment) {
      return ShownFragment{fragment, colors[fragment_leaf(fragment)]};
    });
    draw(view);
    for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel) {
      ++front_area(v, pixel);
      view.source.push_back(__builtin_convertvector(view.shown[pixel], FixedPixel));
    }
    measure(view);
  });
}

void IncrementalImage::set_resolution(std::uint32_t resolution_px) {
  resolution_px_ = resolution_px;
  rows_per_pixel_ = 1.0 / resolution_px;
  tiles_per_row_ = (resolution_px + (1u << kTileShift) - 1) >> kTileShift;
  finest_shift_ = shift_of(0);
  finest_blocks_per_row_ = blocks_per_row(0);
  for (std::uint32_t v = 0; v < view_count(); ++v) {
    views_[v].projection = make_projection(viewpoints_[v], sphere_, resolution_px);
    views_[v].direction = viewpoints_[v].direction;
  }
}

/// Composites a pixel's fragments, nearest first, without two leaves.
/// last  the fragment that nothing shows through, or kNothing
inline IncrementalImage::FixedChannels IncrementalImage::composite(const View& view, std::uint32_t pixel,
                                                                   const std::array<std::uint32_t, 2>& without, LeafFragment& last) const {
  Layers layers;
  last = kNothing;
  for (const auto& [fragment, color] : view.fragments.at(pixel)) {
    const std::uint32_t id = fragment_leaf(fragment);
    if (id == without[0] || id == without[1]) continue;
    layers.put(color);
    if (!layers.is_closed()) continue;
    last = fragment;
    layers.share = 0.0f;
    break;
  }
  return __builtin_convertvector((layers.channels() + layers.share * kBackground) * kFixedUnit + 0.5f, FixedChannels);
}

void IncrementalImage::draw(View& view) const {
  view.shown.resize(pixels_per_view());
  view.last.resize(pixels_per_view());
  for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel) view.shown[pixel] = composite(view, pixel, kNoLeaves, view.last[pixel]);
  view.farthest.resize(std::size_t{tiles_per_row_} * tiles_per_row_);
  for (std::uint32_t tile = 0; tile < view.farthest.size(); ++tile) find_farthest(view, tile);
}

/// Measures how the present image differs from the first one.
void IncrementalImage::measure(View& view) const {
  view.covered = view.excess = 0;
  view.differences.clear();
  for (std::size_t scale = 0; scale < options_.scales.size(); ++scale)
    view.differences.emplace_back(std::size_t{blocks_per_row(scale)} * blocks_per_row(scale), FixedChannels{});
  for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel) {
    view.covered += view.source[pixel][3];
    add_difference(view, pixel, view.shown[pixel] - __builtin_convertvector(view.source[pixel], FixedChannels));
  }
}

void IncrementalImage::add_difference(View& view, std::uint32_t pixel, const FixedChannels& change) const {
  view.excess += change[3];
  const std::uint32_t x = pixel % resolution_px_, y = pixel / resolution_px_;
  for (std::size_t scale = 0; scale < options_.scales.size(); ++scale)
    view.differences[scale][(y >> shift_of(scale)) * blocks_per_row(scale) + (x >> shift_of(scale))] += change;
}

double IncrementalImage::lost_coverage() const {
  std::int64_t covered = 0, excess = 0;
  for (const View& view : views_) covered += view.covered, excess += view.excess;
  return covered > 0 ? -static_cast<double>(excess) / static_cast<double>(covered) : 0.0;
}

void IncrementalImage::set_coverage_weight(double weight) {
  constexpr double kScale = 1u << (2 * kLargestShift);
  coverage_unit_ = weight * kScale / (pixels_per_view() * pixel_area_);
}

LiveLeaf IncrementalImage::merged(std::uint32_t first, std::uint32_t second, const PairCorners& corners, std::uint8_t opacity) const {
  LiveLeaf leaf = merged_leaf(leaves_[first], leaves_[second], corners);
  leaf.opacity = opacity;
  leaf.normal_sum = leaves_[first].normal_sum + leaves_[second].normal_sum;
  leaf.normals = node_normals(leaf.normal_sum);
  return leaf;
}

IncrementalImage::Lit IncrementalImage::lit(const LiveLeaf& leaf) const {
  return {shading_normals(leaf.normals, leaf.quad), albedo_[cards_.table[leaf.card].material], leaf.opacity};
}

Shade IncrementalImage::color_of(const View& view, const Lit& leaf) {
  Shade color = leaf_shade(leaf.normals, leaf.albedo, view.direction);
  color[3] = leaf.opacity;
  return color;
}

double IncrementalImage::pixel_weight() const {
  return static_cast<double>(options_.pixel_weight << (2 * kLargestShift)) * pixel_area_;
}

/// Weight of a block's squared difference, which is summed over its pixels.
double IncrementalImage::block_weight(std::size_t scale) const {
  const BlockScale& blocks = options_.scales[scale];
  return static_cast<double>(blocks.weight << (2 * (kLargestShift - blocks.shift))) * pixel_area_ * pixel_area_;
}

void IncrementalImage::find_farthest(View& view, std::uint32_t tile) const {
  const std::uint32_t top = (tile / tiles_per_row_) << kTileShift, left = (tile % tiles_per_row_) << kTileShift;
  LeafFragment farthest = 0;
  for (std::uint32_t y = top; y < std::min(top + (1u << kTileShift), resolution_px_); ++y)
    for (std::uint32_t x = left; x < std::min(left + (1u << kTileShift), resolution_px_); ++x)
      farthest = std::max(farthest, view.last[y * resolution_px_ + x]);
  view.farthest[tile] = farthest;
}

/// Whether every quad of the pair's vertices is behind opaque fragments. False if unsure.
bool IncrementalImage::is_hidden(const View& view, const ProjectedPair& pair) const {
  std::int32_t left = pair[0].x, right = left, top = pair[0].y, bottom = top;
  double depth = pair[0].depth;
  for (const ProjectedPoint& point : pair) {
    left = std::min(left, point.x), right = std::max(right, point.x);
    top = std::min(top, point.y), bottom = std::max(bottom, point.y);
    depth = std::min(depth, point.depth);
  }
  const auto tile = [&](std::int32_t subpixels) {
    const std::int32_t pixel = std::clamp(subpixels / kSubpixels, 0, static_cast<std::int32_t>(resolution_px_) - 1);
    return static_cast<std::uint32_t>(pixel) >> kTileShift;
  };
  const LeafFragment nearest = make_fragment(static_cast<std::uint32_t>(std::max(depth, 0.0)), 0);
  for (std::uint32_t y = tile(top); y <= tile(bottom); ++y)
    for (std::uint32_t x = tile(left); x <= tile(right); ++x)
      if (view.farthest[y * tiles_per_row_ + x] >= nearest) return false;
  return true;
}

IncrementalImage::LeafPixels IncrementalImage::pixels_of(const LiveLeaf& leaf) const {
  LeafPixels result{{0}, {}};
  for (const View& view : views_) {
    for_each_fragment(view.projection, cards_, leaf, 0, [&](std::uint32_t pixel, LeafFragment fragment) {
      result.pixels.push_back({pixel, fragment_depth(fragment)});
    });
    result.view_begin.push_back(result.pixels.size());
  }
  return result;
}

void IncrementalImage::prepare(Scratch& scratch) const {
  if (scratch.stamp.size() == pixels_per_view()) return;
  scratch = {};
  scratch.stamp.resize(pixels_per_view(), 0);
  scratch.rest.resize(pixels_per_view());
  for (std::size_t scale = 0; scale < options_.scales.size(); ++scale) {
    const std::size_t count = std::size_t{blocks_per_row(scale)} * blocks_per_row(scale);
    scratch.released.push_back({std::vector<Channels>(count, Channels{}), std::vector<std::uint8_t>(count), {}});
    scratch.gained.push_back(scratch.released.back());
  }
}

inline void IncrementalImage::add(BlockSums& blocks, std::uint32_t block, const Channels& change) {
  if (blocks.is_touched[block] == 0) {
    blocks.is_touched[block] = 1;
    blocks.touched.push_back(block);
  }
  blocks.sums[block] += change;
}

void IncrementalImage::add_coarser(std::vector<BlockSums>& scales) const {
  for (std::size_t scale = 1; scale < scales.size(); ++scale) {
    const std::uint32_t step = options_.scales[scale].shift - options_.scales[scale - 1].shift;
    const std::uint32_t finer_row = blocks_per_row(scale - 1), row = blocks_per_row(scale);
    const BlockSums& finer = scales[scale - 1];
    for (const std::uint32_t block : finer.touched)
      add(scales[scale], ((block / finer_row) >> step) * row + ((block % finer_row) >> step), finer.sums[block]);
  }
}

void IncrementalImage::clear(std::vector<BlockSums>& scales) {
  for (BlockSums& blocks : scales) {
    for (const std::uint32_t block : blocks.touched) {
      blocks.sums[block] = Channels{};
      blocks.is_touched[block] = 0;
    }
    blocks.touched.clear();
  }
}

inline void IncrementalImage::prefetch(const View& view, const Scratch& scratch, std::uint32_t pixel) const {
  view.fragments.prefetch_list(pixel);
  __builtin_prefetch(&view.last[pixel]);
  __builtin_prefetch(&view.shown[pixel]);
  __builtin_prefetch(&view.source[pixel]);
  __builtin_prefetch(&scratch.stamp[pixel]);
  __builtin_prefetch(&scratch.rest[pixel]);
}

/// Takes the pair away: fills stamp, rest and the sums of released blocks. returns  how that changes the error
double IncrementalImage::release(std::uint32_t v, Weighing& weighing) const {
  const View& view = weighing.view;
  Scratch& scratch = weighing.scratch;
  const std::uint32_t now = ++scratch.now;
  double pixels = 0.0;
  for (const std::uint32_t id : {weighing.first, weighing.second}) {
    const std::span<const PixelDepth> own = pixels_[id].in(v);
    for (std::size_t i = 0; i < std::min(kListsAhead, own.size()); ++i) prefetch(view, scratch, own[i].pixel);
    for (std::size_t i = 0; i < std::min(kEntriesAhead, own.size()); ++i) view.fragments.prefetch_entries(own[i].pixel);
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (i + kListsAhead < own.size()) prefetch(view, scratch, own[i + kListsAhead].pixel);
      if (i + kEntriesAhead < own.size()) view.fragments.prefetch_entries(own[i + kEntriesAhead].pixel);
      const auto [pixel, depth] = own[i];
      if (make_fragment(depth, id) > view.last[pixel] || scratch.stamp[pixel] == now) continue;
      LeafFragment last;
      const Channels rest = unfixed(composite(view, pixel, {weighing.first, weighing.second}, last));
      const Channels source = unfixed(view.source[pixel]);
      const Channels shown = unfixed(view.shown[pixel]), change = rest - shown;
      scratch.stamp[pixel] = now;
      scratch.rest[pixel] = rest;
      pixels += static_cast<double>(dot(change, rest + shown - 2.0f * source));
      weighing.uncovered += static_cast<double>(change[3]);
      add(scratch.released[0], block_of(pixel), change);
    }
  }
  add_coarser(scratch.released);
  double error = pixels * pixel_weight();
  for (std::size_t scale = 0; scale < options_.scales.size(); ++scale) {
    double sum = 0.0;
    for (const std::uint32_t block : scratch.released[scale].touched) {
      const Channels& change = scratch.released[scale].sums[block];
      sum += static_cast<double>(dot(change, 2.0f * unfixed(view.differences[scale][block]) + change));
    }
    error += sum * block_weight(scale);
  }
  const double excess = static_cast<double>(view.excess) / kFixedUnit;
  return error + coverage_unit_ * pixel_area_ * pixel_area_ * weighing.uncovered * (2.0 * excess + weighing.uncovered);
}

/// How an opaque merged leaf changes a pixel: it shows, and hides what is behind.
/// opaque  its own channels; rest  what the pixel shows without the pair
inline Channels IncrementalImage::gained(const Weighing& weighing, std::uint32_t pixel, LeafFragment merged, const Channels& opaque,
                                         const Channels& rest) const {
  Layers in_front;
  for (const auto& [fragment, color] : weighing.view.fragments.at(pixel)) {
    if (fragment > merged) break;
    const std::uint32_t id = fragment_leaf(fragment);
    if (id == weighing.first || id == weighing.second) continue;
    in_front.put(color);
    if (in_front.is_closed()) return Channels{};
  }
  return in_front.share * opaque - (rest - in_front.channels());
}

/// How the merged leaf changes the error after release(), as a function of its opacity. At equal depths it is behind: its id is larger than
/// every live one.
MergeCost IncrementalImage::gain(const Weighing& weighing, const PairCorners& corners, const Card& card, const Shade& shade) const {
  const View& view = weighing.view;
  Scratch& scratch = weighing.scratch;
  Channels opaque = channels_of(shade);
  opaque[3] = kFullCoverage[3];
  double covered = 0.0;
  const auto corner = [&](std::size_t i) { return weighing.corners[corners[i]]; };
  const AlphaMask& mask = cards_.masks[card.material];
  SquareSums pixels;
  std::vector<PixelDepth>& walk = scratch.walk;
  walk.clear();
  rasterise_leaf({corner(0), corner(1), corner(2), corner(3)}, card, mask, view.projection.resolution_px, [&](const QuadFragment& f) {
    walk.push_back({static_cast<std::uint32_t>(f.y) * resolution_px_ + static_cast<std::uint32_t>(f.x), f.depth});
    prefetch(view, scratch, walk.back().pixel);
  });
  for (std::size_t i = 0; i < std::min(kEntriesAhead, walk.size()); ++i) view.fragments.prefetch_entries(walk[i].pixel);
  for (std::size_t i = 0; i < walk.size(); ++i) {
    if (i + kEntriesAhead < walk.size()) view.fragments.prefetch_entries(walk[i + kEntriesAhead].pixel);
    const auto [pixel, depth] = walk[i];
    const bool is_released = scratch.stamp[pixel] == scratch.now;
    const LeafFragment merged = make_fragment(depth, id_count());
    if (!is_released && merged > view.last[pixel]) continue;
    const Channels rest = is_released ? scratch.rest[pixel] : unfixed(view.shown[pixel]);
    const Channels gain = gained(weighing, pixel, merged, opaque, rest);
    pixels.add(rest - unfixed(view.source[pixel]), gain);
    covered += static_cast<double>(gain[3]);
    add(scratch.gained[0], block_of(pixel), gain);
  }
  add_coarser(scratch.gained);
  MergeCost cost = pixels.cost() * pixel_weight();
  for (std::size_t scale = 0; scale < options_.scales.size(); ++scale) {
    SquareSums squares;
    const BlockSums& gained_blocks = scratch.gained[scale];
    for (const std::uint32_t block : gained_blocks.touched) {
      const Channels rest = unfixed(view.differences[scale][block]) + scratch.released[scale].sums[block];
      squares.add(rest, gained_blocks.sums[block]);
    }
    cost += squares.cost() * block_weight(scale);
  }
  const double excess = static_cast<double>(view.excess) / kFixedUnit + weighing.uncovered;
  cost.opacity += coverage_unit_ * pixel_area_ * pixel_area_ * 2.0 * excess * covered;
  cost.opacity2 += coverage_unit_ * pixel_area_ * pixel_area_ * covered * covered;
  clear(scratch.gained);
  return cost;
}

void IncrementalImage::costs_of(const MergeTrial& trial, Scratch& scratch, std::span<MergeCost> costs) const {
  const auto& [first, second, shapes, subset] = trial;
  COPPICE_ASSERT(costs.size() == shapes.size() && shapes.size() <= PairShapes::kMax);
  prepare(scratch);
  std::fill(costs.begin(), costs.end(), MergeCost{});
  if (shapes.empty()) return;
  const LiveLeaf leaf = merged(first, second, shapes[0], kOpaque);  // its normals and card are those of all shapes
  const Lit shown = lit(leaf);
  const Card& card = cards_.table[leaf.card];
  for (std::uint32_t v = subset.first; v < view_count(); v += subset.stride) {
    const View& view = views_[v];
    Weighing weighing{view, first, second, {}, scratch};
    for (std::size_t i = 0; i < 4; ++i) {
      weighing.corners[i] = project(view.projection, leaves_[first].quad[i]);
      weighing.corners[i + 4] = project(view.projection, leaves_[second].quad[i]);
    }
    if (is_hidden(view, weighing.corners)) continue;
    const double released_error = release(v, weighing);
    const Shade shade = color_of(view, shown);
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      costs[s].constant += released_error;
      costs[s] += gain(weighing, shapes[s], card, shade);
    }
    clear(scratch.released);
  }
}

void IncrementalImage::apply(const LeafMerge& merge) {
  leaves_[merge.result] = merge.leaf;
  pixels_[merge.result] = pixels_of(merge.leaf);
  const Lit shown = lit(merge.leaf);
  parallel_for(view_count(), [&](std::uint32_t v) {
    View& view = views_[v];
    const Shade color = color_of(view, shown);
    std::vector<std::uint32_t> pixels, tiles;
    for (const std::uint32_t id : {merge.first, merge.second, merge.result}) {
      for (const auto& [pixel, depth] : pixels_[id].in(v)) {
        const LeafFragment fragment = make_fragment(depth, id);
        --front_area(v, pixel);
        if (id == merge.result)
          view.fragments.insert(pixel, {fragment, color});
        else
          view.fragments.remove(pixel, fragment);
        ++front_area(v, pixel);
        // If the pair was the last fragment, its own walk has listed the pixel.
        if (fragment <= view.last[pixel]) pixels.push_back(pixel);
      }
    }
    sort_and_unite(pixels);
    for (const std::uint32_t pixel : pixels) {
      const FixedChannels before = view.shown[pixel];
      view.shown[pixel] = composite(view, pixel, kNoLeaves, view.last[pixel]);
      add_difference(view, pixel, view.shown[pixel] - before);
      tiles.push_back(tile_of(pixel));
    }
    sort_and_unite(tiles);
    for (const std::uint32_t tile : tiles) find_farthest(view, tile);
  });
  pixels_[merge.first] = pixels_[merge.second] = LeafPixels{};
}

void IncrementalImage::halve(std::span<const std::uint32_t> live) {
  COPPICE_ASSERT(can_halve());
  const std::uint32_t row = resolution_px_;
  ++halvings_;
  pixel_area_ *= 4.0;
  set_resolution(row / 2);
  parallel_for(live.size(), [&](std::size_t i) { pixels_[live[i]] = pixels_of(leaves_[live[i]]); });
  parallel_for(view_count(), [&](std::uint32_t v) {
    View& view = views_[v];
    std::vector<FixedChannels> differences(pixels_per_view());
    for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel) {
      const std::size_t top = std::size_t{pixel / resolution_px_} * 2 * row + (pixel % resolution_px_) * 2;
      FixedChannels sum{2, 2, 2, 2};
      for (const std::size_t i : {top, top + 1, top + row, top + row + 1})
        sum += view.shown[i] - __builtin_convertvector(view.source[i], FixedChannels);
      differences[pixel] = sum >> 2;
    }
    view.fragments = PixelLists<ShownFragment>(pixels_per_view());
    for (const std::uint32_t id : live) {
      const Shade color = color_of(view, lit(leaves_[id]));
      for (const auto& [pixel, depth] : pixels_[id].in(v)) view.fragments.insert(pixel, {make_fragment(depth, id), color});
      area_px(id, v) = 0;
    }
    area_px(background(), v) = 0;
    for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel) ++front_area(v, pixel);
    draw(view);
    view.source.resize(pixels_per_view());
    for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel)
      view.source[pixel] = __builtin_convertvector(view.shown[pixel] - differences[pixel], FixedPixel);
    measure(view);
  });
}

double IncrementalImage::error() const {
  double total = 0.0;
  const auto square = [](const FixedChannels& channels) {
    double sum = 0.0;
    for (std::size_t c = 0; c < kImageChannels; ++c) sum += static_cast<double>(channels[c]) * channels[c];
    return sum / (double{kFixedUnit} * kFixedUnit);
  };
  for (const View& view : views_) {
    const double excess = static_cast<double>(view.excess) / kFixedUnit * pixel_area_;
    total += coverage_unit_ * excess * excess;
    for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel)
      total += pixel_weight() * square(view.shown[pixel] - __builtin_convertvector(view.source[pixel], FixedChannels));
    for (std::size_t scale = 0; scale < options_.scales.size(); ++scale)
      for (const FixedChannels& block : view.differences[scale]) total += block_weight(scale) * square(block);
  }
  return total;
}

}  // namespace coppice::bake
