#include "visibility.h"

#include <algorithm>
#include <cmath>

#include "bounds.h"
#include "parallel_for.h"

namespace coppice::bake {
namespace {

Error invalid(const char* what, std::size_t value) {
  return Error{Status::invalid_argument, what, Error::kNoOffset, std::to_string(value)};
}

Result<void> check_foliage(const Foliage& foliage, const std::vector<Material>& materials) {
  if (foliage.quads.empty()) return Error{Status::invalid_argument, "the plant has no leaves"};
  if (foliage.cards.size() != foliage.quads.size()) return invalid("leaf quads and leaf cards differ in number", foliage.cards.size());
  for (const std::uint32_t card : foliage.cards)
    if (card >= foliage.card_table.size()) return invalid("a leaf's card is out of range", card);
  for (const Card& card : foliage.card_table) {
    if (card.material >= materials.size()) return invalid("a card's material is out of range", card.material);
    for (const glm::vec2& uv : card.uv)
      if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return invalid("a card's texture coordinate is not finite", card.material);
  }
  for (std::size_t leaf = 0; leaf < foliage.quads.size(); ++leaf)
    for (const glm::vec3& corner : foliage.quads[leaf])
      if (!std::isfinite(corner.x) || !std::isfinite(corner.y) || !std::isfinite(corner.z))
        return invalid("a leaf's vertex is not finite", leaf);
  if (!std::isfinite(bounding_sphere(foliage).radius)) return Error{Status::invalid_argument, "the foliage is too large for floats"};
  return {};
}

/// The fragments of one view; begin is relative to its own fragments.
struct ViewFragments {
  std::vector<std::uint32_t> begin;  ///< [pixels + 1]
  std::vector<LeafFragment> fragments;
};

struct PixelFragment {
  std::uint32_t pixel = 0;
  LeafFragment fragment = 0;
};

/// Sorts by pixel, by counting, then by fragment within a pixel.
ViewFragments sort_by_pixel(const std::vector<PixelFragment>& unsorted, std::size_t pixel_count) {
  ViewFragments view;
  view.begin.assign(pixel_count + 1, 0);
  for (const PixelFragment& f : unsorted) ++view.begin[f.pixel + 1];
  for (std::size_t i = 0; i < pixel_count; ++i) view.begin[i + 1] += view.begin[i];
  std::vector<std::uint32_t> next(view.begin.begin(), view.begin.end() - 1);
  view.fragments.resize(unsorted.size());
  for (const PixelFragment& f : unsorted) view.fragments[next[f.pixel]++] = f.fragment;
  for (std::size_t i = 0; i < pixel_count; ++i)
    std::sort(view.fragments.begin() + view.begin[i], view.fragments.begin() + view.begin[i + 1]);
  return view;
}

ViewFragments render_view(const Foliage& foliage, const std::vector<AlphaMask>& masks, const Projection& projection) {
  const auto width = static_cast<std::uint32_t>(projection.resolution_px);
  std::vector<PixelFragment> unsorted;
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf) {
    const Card& card = foliage.card_table[foliage.cards[leaf]];
    rasterise_leaf(project(projection, foliage.quads[leaf]), card, masks[card.material], projection.resolution_px,
                   [&](const QuadFragment& f) {
                     const std::uint32_t pixel = static_cast<std::uint32_t>(f.y) * width + static_cast<std::uint32_t>(f.x);
                     unsorted.push_back({pixel, make_fragment(f.depth, leaf)});
                   });
  }
  return sort_by_pixel(unsorted, std::size_t{width} * width);
}

ItemBuffers join(const std::vector<ViewFragments>& rendered, std::uint32_t leaf_count, std::uint32_t resolution_px) {
  ItemBuffers buffers{static_cast<std::uint32_t>(rendered.size()), leaf_count, resolution_px, {}, {}};
  std::size_t fragment_count = 0;
  for (const ViewFragments& view : rendered) fragment_count += view.fragments.size();
  buffers.fragments.reserve(fragment_count);
  buffers.fragment_begin.reserve(rendered.size() * buffers.pixels_per_view() + 1);
  buffers.fragment_begin.push_back(0);
  for (const ViewFragments& view : rendered) {
    const std::uint64_t base = buffers.fragments.size();
    for (std::size_t i = 1; i < view.begin.size(); ++i) buffers.fragment_begin.push_back(base + view.begin[i]);
    buffers.fragments.insert(buffers.fragments.end(), view.fragments.begin(), view.fragments.end());
  }
  return buffers;
}

}  // namespace

Result<void> check_shown(const ShownFoliage& shown, const std::vector<Viewpoint>& views, std::uint32_t resolution_px) {
  COPPICE_CHECK(check_foliage(shown.foliage, shown.materials));
  if (views.empty() || views.size() > kMaxViewCount) return invalid("number of views is not between 1 and 1024", views.size());
  if (resolution_px == 0 || resolution_px > kMaxResolutionPx) return invalid("resolution is not between 1 and 2048", resolution_px);
  return {};
}

Result<ItemBuffers> render_item_buffers(const ShownFoliage& shown, const std::vector<Viewpoint>& views, std::uint32_t resolution_px) {
  const Foliage& foliage = shown.foliage;
  COPPICE_CHECK(check_shown(shown, views, resolution_px));
  COPPICE_TRY(masks, alpha_masks(shown.materials, shown.images));
  const Sphere sphere = bounding_sphere(foliage);
  std::vector<ViewFragments> rendered(views.size());
  parallel_for(views.size(),
               [&](std::size_t v) { rendered[v] = render_view(foliage, masks, make_projection(views[v], sphere, resolution_px)); });
  return join(rendered, foliage.leaf_count(), resolution_px);
}

}  // namespace coppice::bake
