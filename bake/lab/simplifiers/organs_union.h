#pragma once

// Hierarchical union of organs (Zhang, Blaise, Jaeger: Multiresolution Plant Models with Complex Organs, VRCIA 2006). Leaves are united as
// in leaves_union.h, but along the plant's hierarchy: first those of one phyllotaxy group, then groups of one axis, then axes. A mesh has
// no record of its growth, and no more of the paper's rules is public. So the hierarchy here is a tree over the stalks: the leaves are
// halved at the median of their stalks along the longest side of their box until groups are small enough. Within a group the cheapest pair
// goes first; when each group is one leaf, two neighbouring groups become one. The maximum size of the smallest groups is swept.

#include <vector>

#include "level.h"
#include "plant.h"

namespace coppice::bake {

/// Groups leaves by the tree of their stalks, in order: neighbours are halves of one whole. The number of groups is a power of two.
/// max_size  of a group, at least 1
std::vector<std::vector<std::uint32_t>> stalk_groups(const Foliage& foliage, std::uint32_t max_size);

/// leaf_counts  each 1 .. leaf_count (asserted); not empty
std::vector<Variant> unite_organs(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
