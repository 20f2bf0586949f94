#include "card_shown.h"

#include <algorithm>

#include "error_image.h"
#include "parallel_for.h"
#include "tree_order.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

/// Counts of pixels by eighth of a card.
struct Counts {
  std::array<std::uint64_t, std::tuple_size_v<ShownShares>> seen{}, all{};
};

/// [card] What one view sees of all leaves.
std::vector<Counts> count_shown(const BakedPlant& plant, std::span<const std::uint32_t> leaves, const std::vector<AlphaMask>& masks,
                                const Projection& projection) {
  constexpr std::size_t kParts = std::tuple_size_v<ShownShares>;
  constexpr Card kAlong{0, {{{0, 0}, {1, 0}, {1, 0}, {0, 0}}}};  // u from the stalk to the tip
  std::vector<std::uint32_t> depths(std::size_t{kErrorImagePx} * kErrorImagePx, 0xffffffffu);
  std::vector<Counts> counts(plant.card_table.size());
  for (const bool is_nearest_known : {false, true})
    for (const std::uint32_t node : leaves) {
      const std::uint32_t number = plant.tree.nodes[node].card;
      const Card& card = plant.card_table[number];
      const ProjectedQuad quad = project(projection, node_quad(plant.tree, node));
      const RasterQuad raster(quad);
      rasterise_leaf(quad, card, masks[card.material], kErrorImagePx, [&](const QuadFragment& f) {
        std::uint32_t& nearest = depths[static_cast<std::size_t>(f.y) * kErrorImagePx + static_cast<std::size_t>(f.x)];
        if (!is_nearest_known) {
          nearest = std::min(nearest, f.depth);
          return;
        }
        const double along = card_uv(raster.triangles[f.triangle], f.triangle, kAlong, f.x, f.y).x;
        const auto eighth = std::min(static_cast<std::size_t>(std::max(along, 0.0) * kParts), kParts - 1);
        ++counts[number].all[eighth];
        if (f.depth == nearest) ++counts[number].seen[eighth];
      });
    }
  return counts;
}

}  // namespace

Result<std::vector<ShownShares>> shown_shares(const BakedPlant& plant) {
  COPPICE_TRY(masks, alpha_masks(plant.materials, plant.images));
  const std::vector<Projection> projections = error_projections(plant.sphere);
  const std::vector<std::uint32_t> leaves = cut_nodes(plant.tree, plant.tree.leaf_count());
  std::vector<std::vector<Counts>> views(projections.size());
  parallel_for(views.size(), [&](std::size_t view) { views[view] = count_shown(plant, leaves, masks, projections[view]); });
  std::vector<ShownShares> shares(plant.card_table.size());
  for (std::size_t card = 0; card < shares.size(); ++card)
    for (std::size_t eighth = 0; eighth < shares[card].size(); ++eighth) {
      std::uint64_t seen = 1, all = 1;  // a card that no view shows is as good as one in the open
      for (const std::vector<Counts>& counts : views) seen += counts[card].seen[eighth], all += counts[card].all[eighth];
      shares[card][eighth] = static_cast<float>(static_cast<double>(seen) / static_cast<double>(all));
    }
  return shares;
}

}  // namespace coppice::bake
