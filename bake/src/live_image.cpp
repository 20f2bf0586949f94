#include "live_image.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "check.h"
#include "leaf_shade.h"

namespace coppice::bake {
namespace {

/// The largest block, 32 x 32 pixels, counts once; smaller ones as often as they fit into it.
constexpr std::uint32_t kLargestShift = 5;
constexpr Shade kBackground = {255, 255, 255, 0};

void accumulate(Shade& sum, const Shade& change) {
  for (std::size_t c = 0; c < kImageChannels; ++c) sum[c] += change[c];
}

Shade difference(const Shade& after, const Shade& before) {
  Shade result;
  for (std::size_t c = 0; c < kImageChannels; ++c) result[c] = after[c] - before[c];
  return result;
}

}  // namespace

Shade image_shade(const Quad& quad, float albedo) {
  // Between them the lights tell normals apart whichever way a viewer's light comes from.
  static const std::array lights = {glm::normalize(glm::vec3(0.4f, 0.8f, 0.45f)), glm::normalize(glm::vec3(-0.8f, 0.4f, 0.45f)),
                                    glm::normalize(glm::vec3(0.1f, 0.5f, -0.85f))};
  const auto under = [&](std::size_t light) {
    return static_cast<std::int32_t>(std::lround(shaded_luminance(quad, albedo, lights[light])));
  };
  return {under(0), under(1), under(2), 255};
}

LiveImage::LiveImage(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                     std::vector<AlphaMask> masks, const std::vector<Viewpoint>& views, const ItemBuffers& buffers,
                     const ImageErrorOptions& options)
    : id_count_(2 * foliage.leaf_count() - 1),
      resolution_px_(buffers.resolution_px),
      finest_shift_(options.scales.front().shift),
      finest_blocks_per_row_((resolution_px_ + (1u << finest_shift_) - 1) >> finest_shift_),
      options_(options),
      card_table_(foliage.card_table),
      masks_(std::move(masks)),
      views_(buffers.view_count),
      leaves_(id_count_),
      pixels_(id_count_),
      shades_(id_count_ + 1, kBackground),
      areas_px_(std::size_t{id_count_ + 1} * buffers.view_count, 0) {
  for (std::size_t m = 0; m < materials.size(); ++m) albedo_.push_back(mean_texel_luminance(materials[m], images, masks_[m]));
  const Sphere sphere = bounding_sphere(foliage);
  tbb::parallel_for(0u, view_count(), [&](std::uint32_t v) {
    View& view = views_[v];
    view.projection = make_projection(views[v], sphere, resolution_px_);
    view.fragments = FragmentLists(buffers, v);
    for (std::size_t scale = 0; scale < options_.scales.size(); ++scale)
      view.differences.emplace_back(std::size_t{blocks_per_row(scale)} * blocks_per_row(scale), Shade{});
    for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel)
      ++areas_px_[std::size_t{outcome_of(view.fragments.front(pixel))} * view_count() + v];
  });
  tbb::parallel_for(0u, foliage.leaf_count(), [&](std::uint32_t i) {
    leaves_[i] = {foliage.quads[i], foliage.cards[i]};
    shades_[i] = shade_of(leaves_[i]);
    pixels_[i] = pixels_of(leaves_[i]);
  });
}

std::int64_t LiveImage::weight_of(std::size_t scale) const {
  return options_.scales[scale].weight << (2 * (kLargestShift - options_.scales[scale].shift));
}

template <class Visit>
void LiveImage::for_each_fragment(const View& view, const LiveLeaf& leaf, std::uint32_t id, Visit&& visit) const {
  const Card& card = card_table_[leaf.card];
  const std::int32_t width = view.projection.resolution_px;
  rasterise_leaf(project(view.projection, leaf.quad), card, masks_[card.material], width,
                 [&](const QuadFragment& f) { visit(static_cast<std::uint32_t>(f.y * width + f.x), make_fragment(f.depth, id)); });
}

LiveImage::LeafPixels LiveImage::pixels_of(const LiveLeaf& leaf) const {
  LeafPixels result;
  result.view_begin.reserve(view_count() + 1);
  result.view_begin.push_back(0);
  for (const View& view : views_) {
    for_each_fragment(view, leaf, 0, [&](std::uint32_t pixel, LeafFragment) { result.pixels.push_back(pixel); });
    result.view_begin.push_back(static_cast<std::uint32_t>(result.pixels.size()));
  }
  return result;
}

/// change(pixel, outcome before, outcome after) where one of the two is in front and goes.
template <class Change>
void LiveImage::release(std::uint32_t v, std::uint32_t first, std::uint32_t second, Change&& change) const {
  const FragmentLists& fragments = views_[v].fragments;
  for (const std::uint32_t id : {first, second}) {
    if (areas(id)[v] == 0) continue;
    const LeafPixels& own = pixels_[id];
    for (std::uint32_t i = own.view_begin[v]; i < own.view_begin[v + 1]; ++i) {
      const std::uint32_t pixel = own.pixels[i];
      if (fragment_leaf(fragments.front(pixel)) != id) continue;
      change(pixel, id, outcome_of(fragments.front_without(pixel, first, second)));
    }
  }
}

/// change(pixel, outcome before) where the merged leaf is in front of what is left without the two.
template <class Change>
void LiveImage::gain(std::uint32_t v, std::uint32_t first, std::uint32_t second, const LiveLeaf& shape, std::uint32_t id,
                     Change&& change) const {
  const View& view = views_[v];
  const Card& card = card_table_[shape.card];
  const AlphaMask& mask = masks_[card.material];
  LeafFragment front = FragmentLists::kNothing;  // what is left without the two at the pixel last asked for
  std::uint32_t pixel = kNone;
  // Most of a leaf is hidden: asking for depth first spares most looks at the mask.
  const auto in_front = [&](const RasterTriangle& triangle, std::uint32_t index, std::int32_t x, std::int32_t y) {
    pixel = static_cast<std::uint32_t>(y) * resolution_px_ + static_cast<std::uint32_t>(x);
    front = view.fragments.front(pixel);
    const std::uint32_t leaf = fragment_leaf(front);
    if (leaf == first || leaf == second) front = view.fragments.front_without(pixel, first, second);
    return make_fragment(triangle.depth(x, y), id) <= front && !mask.is_hole(card_uv(triangle, index, card, x, y));
  };
  rasterise_quad(project(view.projection, shape.quad), view.projection.resolution_px, in_front,
                 [&](const QuadFragment&) { change(pixel, outcome_of(front)); });
}

void LiveImage::prepare(Deltas& deltas) const {
  if (!deltas.sums.empty()) return;
  deltas.touched.resize(options_.scales.size());
  for (std::size_t scale = 0; scale < options_.scales.size(); ++scale) {
    const std::size_t count = std::size_t{blocks_per_row(scale)} * blocks_per_row(scale);
    deltas.sums.emplace_back(count, Shade{});
    deltas.is_touched.emplace_back(count, std::uint8_t{0});
  }
}

inline void LiveImage::add(Deltas& deltas, std::size_t scale, std::uint32_t block, const Shade& change) const {
  if (deltas.is_touched[scale][block] == 0) {
    deltas.is_touched[scale][block] = 1;
    deltas.touched[scale].push_back(block);
  }
  accumulate(deltas.sums[scale][block], change);
}

void LiveImage::add_coarser(Deltas& deltas) const {
  for (std::size_t scale = 1; scale < options_.scales.size(); ++scale) {
    const std::uint32_t step = options_.scales[scale].shift - options_.scales[scale - 1].shift;
    const std::uint32_t finer_row = blocks_per_row(scale - 1), row = blocks_per_row(scale);
    for (const std::uint32_t block : deltas.touched[scale - 1])
      add(deltas, scale, ((block / finer_row) >> step) * row + ((block % finer_row) >> step), deltas.sums[scale - 1][block]);
  }
}

/// The error that the deltas would add; clears them.
std::int64_t LiveImage::take_error(const View& view, Deltas& deltas) const {
  std::int64_t total = 0;
  for (std::size_t scale = 0; scale < options_.scales.size(); ++scale) {
    std::int64_t sum = 0;
    for (const std::uint32_t block : deltas.touched[scale]) {
      Shade& delta = deltas.sums[scale][block];
      const Shade& before = view.differences[scale][block];
      for (std::size_t c = 0; c < kImageChannels; ++c)
        sum += options_.weights[c] * (std::int64_t{delta[c]} * (std::int64_t{2} * before[c] + delta[c]));
      delta = Shade{};
      deltas.is_touched[scale][block] = 0;
    }
    deltas.touched[scale].clear();
    total += sum * weight_of(scale);
  }
  return total;
}

void LiveImage::changes_of(std::uint32_t first, std::uint32_t second, std::span<const LiveLeaf> shapes, Scratch& scratch,
                           std::span<std::int64_t> changes) const {
  COPPICE_ASSERT(shapes.size() <= kMaxShapes && changes.size() == shapes.size());
  prepare(scratch.released);
  prepare(scratch.changed);
  std::fill(changes.begin(), changes.end(), std::int64_t{0});
  std::array<Shade, kMaxShapes> shades{};
  for (std::size_t s = 0; s < shapes.size(); ++s) shades[s] = shade_of(shapes[s]);
  Deltas& released = scratch.released;
  for (std::uint32_t v = 0; v < view_count(); ++v) {
    release(v, first, second, [&](std::uint32_t pixel, std::uint32_t before, std::uint32_t after) {
      add(released, 0, block_of(pixel), difference(shades_[after], shades_[before]));
    });
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      for (const std::uint32_t block : released.touched[0]) add(scratch.changed, 0, block, released.sums[0][block]);
      gain(v, first, second, shapes[s], id_count_, [&](std::uint32_t pixel, std::uint32_t before) {
        add(scratch.changed, 0, block_of(pixel), difference(shades[s], shades_[before]));
      });
      add_coarser(scratch.changed);
      changes[s] += take_error(views_[v], scratch.changed);
    }
    for (const std::uint32_t block : released.touched[0]) {
      released.sums[0][block] = Shade{};
      released.is_touched[0][block] = 0;
    }
    released.touched[0].clear();
  }
}

void LiveImage::apply(const LeafMerge& merge) {
  leaves_[merge.result] = merge.leaf;
  shades_[merge.result] = shade_of(merge.leaf);
  pixels_[merge.result] = pixels_of(merge.leaf);
  tbb::parallel_for(0u, view_count(), [&](std::uint32_t v) {
    View& view = views_[v];
    Deltas deltas;
    prepare(deltas);
    const auto area = [&](std::uint32_t outcome) -> std::uint32_t& { return areas_px_[std::size_t{outcome} * view_count() + v]; };
    const auto change = [&](std::uint32_t pixel, std::uint32_t before, std::uint32_t after) {
      --area(before), ++area(after);
      add(deltas, 0, block_of(pixel), difference(shades_[after], shades_[before]));
    };
    // Areas change while the pixels of both are walked: release() must not skip the second leaf because of it, and does not, for a pixel
    // that the first leaf gives up passes to neither.
    release(v, merge.first, merge.second, change);
    gain(v, merge.first, merge.second, merge.leaf, merge.result,
         [&](std::uint32_t pixel, std::uint32_t before) { change(pixel, before, merge.result); });
    add_coarser(deltas);
    for (std::size_t scale = 0; scale < options_.scales.size(); ++scale)
      for (const std::uint32_t block : deltas.touched[scale]) accumulate(view.differences[scale][block], deltas.sums[scale][block]);
    for (const std::uint32_t removed : {merge.first, merge.second})
      for_each_fragment(view, leaves_[removed], removed, [&](std::uint32_t pixel, LeafFragment f) { view.fragments.remove(pixel, f); });
    for_each_fragment(view, merge.leaf, merge.result, [&](std::uint32_t pixel, LeafFragment f) { view.fragments.insert(pixel, f); });
  });
  pixels_[merge.first] = pixels_[merge.second] = LeafPixels{};
}

std::int64_t LiveImage::error() const {
  std::int64_t total = 0;
  for (const View& view : views_)
    for (std::size_t scale = 0; scale < options_.scales.size(); ++scale)
      for (const Shade& block : view.differences[scale])
        for (std::size_t c = 0; c < kImageChannels; ++c)
          total += weight_of(scale) * options_.weights[c] * (std::int64_t{block[c]} * block[c]);
  return total;
}

}  // namespace coppice::bake
