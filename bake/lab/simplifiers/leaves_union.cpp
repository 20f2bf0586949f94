#include "leaves_union.h"

#include <cmath>
#include <string>

#include "collapse_geometric.h"
#include "quad_merge.h"
#include "united_leaf.h"

namespace coppice::bake {

double leaves_union_cost(const Quad& first, const Quad& second, double angle_weight, double leaf_size_m) {
  const double first_area = quad_area(first), second_area = quad_area(second), sum = first_area + second_area;
  const double unequal = sum > 0.0 ? std::abs(first_area - second_area) / sum : 0.0;
  const double large = leaf_size_m > 0.0 ? pair_diameter_m(first, second) / leaf_size_m : 0.0;
  return large + angle_weight * leaf_angle(first, second) + unequal;
}

std::vector<Variant> unite_leaves(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts) {
  const double leaf_size_m = mean_leaf_size_m(foliage);
  std::vector<Variant> variants;
  for (const RectangleLength length : {RectangleLength::extent, RectangleLength::similar})
    for (const double angle_weight : {0.5, 1.0, 2.0, 4.0}) {
      UnionRules<UnitedLeaf> rules;
      rules.cost = [=](const UnitedLeaf& a, const UnitedLeaf& b) { return leaves_union_cost(a.quad, b.quad, angle_weight, leaf_size_m); };
      rules.unite = [length](const UnitedLeaf& a, const UnitedLeaf& b) {
        return UnitedLeaf{united_rectangle(a.quad, b.quad, length), merged_card(a.quad, a.card, b.quad, b.card)};
      };
      rules.middle = [](const UnitedLeaf& leaf) { return quad_centroid(leaf.quad); };
      Variant variant;
      variant.parameters =
          std::string(length == RectangleLength::extent ? "extent" : "similar") + ", angle " + std::to_string(angle_weight).substr(0, 3);
      const GreedyUnion<UnitedLeaf> united(foliage, united_leaves(foliage), std::move(rules));
      for (const auto& leaves : unite_to(united, leaf_counts)) variant.levels.push_back(level_of(leaves, foliage.card_table));
      variants.push_back(std::move(variant));
    }
  return variants;
}

}  // namespace coppice::bake
