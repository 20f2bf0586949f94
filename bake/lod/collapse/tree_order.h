#pragma once

#include "plant.h"

namespace coppice::bake {

/// Renumbers a collapse sequence in refinement order (core/tree.h): the last merge is split 0, its result node 0; a merge's first and
/// second become nodes 2s+1 and 2s+2. merged_card (quad_merge.h) chooses a merged node's card.
/// foliage   the source leaves, at least one
/// sequence  foliage.leaf_count() - 1 merges that use every node once (asserted)
Tree build_tree(const Foliage& foliage, const CollapseSequence& sequence);

/// Nodes of cut(m), ascending. m in [1, leaf_count] (asserted).
std::vector<std::uint32_t> cut_nodes(const Tree& tree, std::uint32_t leaf_count);

Quad node_quad(const Tree& tree, std::uint32_t node);

/// A cut as leaves of its own.
Foliage cut_foliage(const Tree& tree, const std::vector<Card>& card_table, std::uint32_t leaf_count);

/// The same leaves without opacities: a leaf of opacity o shrinks about its middle to o times its area.
Foliage solid_foliage(Foliage foliage);

}  // namespace coppice::bake
