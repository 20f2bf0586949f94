#include "live_image.h"

#include <algorithm>
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

/// The largest block, 32 x 32 pixels, counts once; smaller ones as often as they fit into it.
constexpr std::uint32_t kLargestShift = 5;
constexpr LeafShades kBackground{glm::vec3(0.0f), {255, 255, 255, 0}, {255, 255, 255, 0}};

void accumulate(Shade& sum, const Shade& change) {
  for (std::size_t c = 0; c < kImageChannels; ++c) sum[c] += change[c];
}

Shade difference(const Shade& after, const Shade& before) {
  Shade result;
  for (std::size_t c = 0; c < kImageChannels; ++c) result[c] = after[c] - before[c];
  return result;
}

}  // namespace

LeafShades leaf_shades(const Quad& quad, float albedo) {
  // Between them the lights tell normals apart whichever way a viewer's light comes from.
  static const std::array lights = {glm::normalize(glm::vec3(0.4f, 0.8f, 0.45f)), glm::normalize(glm::vec3(-0.8f, 0.4f, 0.45f)),
                                    glm::normalize(glm::vec3(0.1f, 0.5f, -0.85f))};
  const glm::vec3 across = glm::cross(quad[2] - quad[0], quad[3] - quad[1]);
  const float length = glm::length(across);
  LeafShades shades{length > 0.0f ? across / length : glm::vec3(0.0f), {}, {}};
  for (std::size_t light = 0; light < lights.size(); ++light) {
    const float cosine = glm::dot(shades.normal, lights[light]);
    shades.front[light] = static_cast<std::uint8_t>(std::lround(lambert_luminance(albedo, std::max(cosine, 0.0f))));
    shades.back[light] = static_cast<std::uint8_t>(std::lround(lambert_luminance(albedo, std::max(-cosine, 0.0f))));
  }
  shades.front.back() = shades.back.back() = 255;
  return shades;
}

LiveImage::LiveImage(const ShownFoliage& shown, std::vector<AlphaMask> masks, const std::vector<Viewpoint>& views,
                     const ItemBuffers& buffers, const ImageErrorOptions& options)
    : id_count_(2 * shown.foliage.leaf_count() - 1),
      resolution_px_(buffers.resolution_px),
      tiles_per_row_((resolution_px_ + (1u << kTileShift) - 1) >> kTileShift),
      coverage_unit_((options.coverage_weight * 255 * 255 << (2 * kLargestShift)) / pixels_per_view()),
      finest_shift_(options.scales.front().shift),
      finest_blocks_per_row_((resolution_px_ + (1u << finest_shift_) - 1) >> finest_shift_),
      options_(options),
      card_table_(shown.foliage.card_table),
      masks_(std::move(masks)),
      views_(buffers.view_count),
      leaves_(id_count_),
      pixels_(id_count_),
      shades_(id_count_ + 1, kBackground),
      areas_px_(std::size_t{id_count_ + 1} * buffers.view_count, 0) {
  const Foliage& foliage = shown.foliage;
  for (std::size_t m = 0; m < shown.materials.size(); ++m)
    albedo_.push_back(mean_texel_luminance(shown.materials[m], shown.images, masks_[m]));
  const Sphere sphere = bounding_sphere(foliage);
  for (std::uint32_t v = 0; v < view_count(); ++v) {
    views_[v].projection = make_projection(views[v], sphere, resolution_px_);
    views_[v].direction = views[v].direction;
  }
  parallel_for(foliage.leaf_count(), [&](std::uint32_t i) {
    leaves_[i] = {foliage.quads[i], foliage.cards[i]};
    shades_[i] = shades_of(leaves_[i]);
    pixels_[i] = pixels_of(leaves_[i]);
  });
  parallel_for(view_count(), [&](std::uint32_t v) {
    View& view = views_[v];
    view.fragments = FragmentLists(buffers, v);
    for (std::size_t scale = 0; scale < options_.scales.size(); ++scale)
      view.differences.emplace_back(std::size_t{blocks_per_row(scale)} * blocks_per_row(scale), Shade{});
    view.source.reserve(pixels_per_view());
    for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel) {
      const std::uint32_t outcome = outcome_of(view.fragments.front(pixel));
      ++areas_px_[std::size_t{outcome} * view_count() + v];
      const Shade shade = seen(view, outcome);
      view.source.push_back({});
      for (std::size_t c = 0; c < kImageChannels; ++c) view.source.back()[c] = static_cast<std::uint8_t>(shade[c]);
    }
    view.farthest.resize(std::size_t{tiles_per_row_} * tiles_per_row_);
    for (std::uint32_t tile = 0; tile < view.farthest.size(); ++tile) find_farthest(view, tile);
  });
}

LiveLeaf LiveImage::merged(std::uint32_t first, std::uint32_t second, const PairCorners& corners) const {
  const LiveLeaf &a = leaves_[first], &b = leaves_[second];
  return {merged_quad(a.quad, b.quad, corners), merged_card(a.quad, a.card, b.quad, b.card)};
}

std::int64_t LiveImage::weight_of(std::size_t scale) const {
  return options_.scales[scale].weight << (2 * (kLargestShift - options_.scales[scale].shift));
}

inline std::int64_t LiveImage::pixel_error(const View& view, std::uint32_t pixel, const Shade& shade) const {
  std::int64_t sum = 0;
  for (std::size_t c = 0; c < kImageChannels; ++c) {
    const std::int64_t difference = shade[c] - view.source[pixel][c];
    sum += options_.weights[c] * difference * difference;
  }
  return sum;
}

void LiveImage::find_farthest(View& view, std::uint32_t tile) const {
  const std::uint32_t top = (tile / tiles_per_row_) << kTileShift, left = (tile % tiles_per_row_) << kTileShift;
  LeafFragment farthest = 0;
  for (std::uint32_t y = top; y < std::min(top + (1u << kTileShift), resolution_px_); ++y)
    for (std::uint32_t x = left; x < std::min(left + (1u << kTileShift), resolution_px_); ++x)
      farthest = std::max(farthest, view.fragments.front(y * resolution_px_ + x));
  view.farthest[tile] = farthest;
}

/// Whether every quad of the pair's vertices is behind what is in front. False if unsure.
bool LiveImage::is_hidden(const View& view, const ProjectedPair& pair) const {
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

LiveImage::LeafPixels LiveImage::pixels_of(const LiveLeaf& leaf) const {
  LeafPixels result;
  result.view_begin.reserve(view_count() + 1);
  result.view_begin.push_back(0);
  for (const View& view : views_) {
    for_each_fragment_of(view, leaf, 0, [&](std::uint32_t pixel, LeafFragment) { result.pixels.push_back(pixel); });
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

/// change(pixel, outcome before) where a quad is in front of what is left without the two. At equal depths it is behind: its id is larger
/// than every live one.
template <class Change>
void LiveImage::gain(const View& view, std::uint32_t first, std::uint32_t second, const ProjectedLeaf& leaf, Change&& change) const {
  const Card& card = leaf.card;
  const AlphaMask& mask = masks_[card.material];
  const RasterQuad quad(leaf.quad);
  const std::int32_t width = view.projection.resolution_px;
  for_each_run(quad, width, [&](const PixelRun& run) {
    const RasterTriangle& triangle = quad.triangles[run.triangle];
    const DepthRow depths = triangle.depths(run.y), other_depths = quad.triangles[1].depths(run.y);
    const auto shows = [&](std::uint32_t index, std::int32_t x) {
      return mask.hole.empty() || !mask.is_hole(card_uv(quad.triangles[index], index, card, x, run.y));
    };
    for (std::int32_t x = run.first; x <= run.last; ++x) {
      const auto pixel = static_cast<std::uint32_t>(run.y * width + x);
      const LeafFragment rest = view.fragments.front_without(pixel, first, second);
      const std::uint32_t depth = fragment_depth(rest);
      // Most of a leaf is hidden: asking for depth first spares most looks at the mask.
      if ((depths.is_nearer(x, depth) && shows(run.triangle, x)) || (run.folded && other_depths.is_nearer(x, depth) && shows(1, x)))
        change(pixel, outcome_of(rest));
    }
  });
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

void LiveImage::changes_of(const MergeTrial& trial, Scratch& scratch, std::span<std::int64_t> changes) const {
  const std::uint32_t first = trial.first, second = trial.second;
  const std::span<const PairCorners> shapes = trial.shapes;
  COPPICE_ASSERT(changes.size() == shapes.size());
  prepare(scratch.released);
  prepare(scratch.changed);
  std::fill(changes.begin(), changes.end(), std::int64_t{0});
  scratch.shades.clear();
  for (const PairCorners& corners : shapes) scratch.shades.push_back(shades_of(merged(first, second, corners)));
  const Card& card = card_table_[merged_card(leaves_[first].quad, leaves_[first].card, leaves_[second].quad, leaves_[second].card)];
  const std::int64_t pixel_unit = options_.pixel_weight << (2 * kLargestShift);
  Deltas& released = scratch.released;
  for (std::uint32_t v = trial.views.first; v < view_count(); v += trial.views.stride) {
    const View& view = views_[v];
    ProjectedPair pair;
    for (std::size_t i = 0; i < 4; ++i) {
      pair[i] = project(view.projection, leaves_[first].quad[i]);
      pair[i + 4] = project(view.projection, leaves_[second].quad[i]);
    }
    if (areas(first)[v] == 0 && areas(second)[v] == 0 && is_hidden(view, pair)) continue;
    std::int64_t released_error = 0, uncovered_px = 0;
    release(v, first, second, [&](std::uint32_t pixel, std::uint32_t before, std::uint32_t after) {
      uncovered_px += after == background() ? 1 : 0;
      const Shade was = seen(view, before), is = seen(view, after);
      released_error += pixel_error(view, pixel, is) - pixel_error(view, pixel, was);
      add(released, 0, block_of(pixel), difference(is, was));
    });
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      const PairCorners& c = shapes[s];
      const Shade shade = scratch.shades[s].seen_from(view.direction);
      std::int64_t gained_error = 0, covered_px = -uncovered_px;
      for (const std::uint32_t block : released.touched[0]) add(scratch.changed, 0, block, released.sums[0][block]);
      gain(view, first, second, {{pair[c[0]], pair[c[1]], pair[c[2]], pair[c[3]]}, card}, [&](std::uint32_t pixel, std::uint32_t before) {
        const Shade was = seen(view, before);
        covered_px += before == background() ? 1 : 0;
        gained_error += pixel_error(view, pixel, shade) - pixel_error(view, pixel, was);
        add(scratch.changed, 0, block_of(pixel), difference(shade, was));
      });
      add_coarser(scratch.changed);
      changes[s] += (released_error + gained_error) * pixel_unit + take_error(view, scratch.changed) +
                    coverage_unit_ * covered_px * (2 * view.excess_px + covered_px);
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
  shades_[merge.result] = shades_of(merge.leaf);
  pixels_[merge.result] = pixels_of(merge.leaf);
  parallel_for(view_count(), [&](std::uint32_t v) {
    View& view = views_[v];
    Deltas deltas;
    prepare(deltas);
    std::vector<std::uint32_t> tiles;
    const auto area = [&](std::uint32_t outcome) -> std::uint32_t& { return areas_px_[std::size_t{outcome} * view_count() + v]; };
    const auto change = [&](std::uint32_t pixel, std::uint32_t before, std::uint32_t after) {
      --area(before), ++area(after);
      view.excess_px += (before == background() ? 1 : 0) - (after == background() ? 1 : 0);
      add(deltas, 0, block_of(pixel), difference(seen(view, after), seen(view, before)));
      if (tiles.empty() || tiles.back() != tile_of(pixel)) tiles.push_back(tile_of(pixel));
    };
    // Areas change while the pixels of both are walked: release() must not skip the second leaf because of it, and does not, for a pixel
    // that the first leaf gives up passes to neither.
    release(v, merge.first, merge.second, change);
    gain(view, merge.first, merge.second, {project(view.projection, merge.leaf.quad), card_table_[merge.leaf.card]},
         [&](std::uint32_t pixel, std::uint32_t before) { change(pixel, before, merge.result); });
    add_coarser(deltas);
    for (std::size_t scale = 0; scale < options_.scales.size(); ++scale)
      for (const std::uint32_t block : deltas.touched[scale]) accumulate(view.differences[scale][block], deltas.sums[scale][block]);
    for (const std::uint32_t removed : {merge.first, merge.second})
      for_each_fragment_of(view, leaves_[removed], removed, [&](std::uint32_t pixel, LeafFragment f) { view.fragments.remove(pixel, f); });
    for_each_fragment_of(view, merge.leaf, merge.result, [&](std::uint32_t pixel, LeafFragment f) { view.fragments.insert(pixel, f); });
    for (const std::uint32_t tile : tiles) find_farthest(view, tile);
  });
  pixels_[merge.first] = pixels_[merge.second] = LeafPixels{};
}

std::int64_t LiveImage::error() const {
  std::int64_t total = 0;
  for (const View& view : views_) {
    total += coverage_unit_ * view.excess_px * view.excess_px;
    for (std::uint32_t pixel = 0; pixel < pixels_per_view(); ++pixel)
      total +=
          (options_.pixel_weight << (2 * kLargestShift)) * pixel_error(view, pixel, seen(view, outcome_of(view.fragments.front(pixel))));
    for (std::size_t scale = 0; scale < options_.scales.size(); ++scale)
      for (const Shade& block : view.differences[scale])
        for (std::size_t c = 0; c < kImageChannels; ++c)
          total += weight_of(scale) * options_.weights[c] * (std::int64_t{block[c]} * block[c]);
  }
  return total;
}

}  // namespace coppice::bake
