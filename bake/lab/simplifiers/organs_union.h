#pragma once

// Hierarchical union of organs (Zhang, Blaise, Jaeger: Multiresolution Plant Models with Complex Organs, VRCIA 2006): leaves are united as
// in leaves_union.h, but along the plant's hierarchy: first those of one phyllotaxy group, then groups of one axis, then axes. A mesh has
// no record of its growth, and the paper's rules are public as far as that sentence. So the hierarchy here is a tree over the stalks: the
// leaves, halved at the median of their stalks along the longest side of their box, until a group has at most so many leaves. Within a
// group the least costly pair goes first; when each group is one leaf, two neighbouring groups make one. The size of the smallest groups is
// swept.

#include <vector>

#include "level.h"
#include "plant.h"

namespace coppice::bake {

/// Leaves by group, in order, as the stalks' tree has them: neighbours are halves of one whole. Powers of two many.
/// most  leaves of a group, at least 1
std::vector<std::vector<std::uint32_t>> stalk_groups(const Foliage& foliage, std::uint32_t most);

/// leaf_counts  each 1 .. leaf_count (asserted); not empty
std::vector<Variant> unite_organs(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
