#include "tree_order.h"

#include <cmath>

#include "check.h"
#include "quad_merge.h"

namespace coppice::bake {
namespace {

Quad quad_of(const Tree::Node& node, const std::vector<glm::vec3>& vertices) {
  return {vertices[node.vertices[0]], vertices[node.vertices[1]], vertices[node.vertices[2]], vertices[node.vertices[3]]};
}

/// Nodes in the sequence's numbering: source leaves, then merge results.
std::vector<Tree::Node> nodes_in_merge_order(const Foliage& foliage, const CollapseSequence& sequence,
                                             const std::vector<glm::vec3>& vertices) {
  std::vector<Tree::Node> nodes;
  std::vector<NormalSum> normals;
  nodes.reserve(foliage.quads.size() + sequence.merges.size());
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf) {
    nodes.push_back({.vertices = {leaf * 4, leaf * 4 + 1, leaf * 4 + 2, leaf * 4 + 3},
                     .card = foliage.cards[leaf],
                     .normals = foliage.normals.empty() ? kFlatNormals : foliage.normals[leaf]});
    normals.push_back(source_normal_sum(foliage, leaf));
  }
  for (const Merge& merge : sequence.merges) {
    COPPICE_ASSERT(merge.first < merge.second && merge.second < nodes.size());
    const Tree::Node& first = nodes[merge.first];
    const Tree::Node& second = nodes[merge.second];
    Tree::Node result;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint8_t corner = merge.corners[i];
      COPPICE_ASSERT(corner < 8);
      result.vertices[i] = corner < 4 ? first.vertices[corner] : second.vertices[corner - 4u];
    }
    result.card = merged_card(quad_of(first, vertices), first.card, quad_of(second, vertices), second.card);
    result.opacity = merge.opacity;
    normals.push_back(normals[merge.first] + normals[merge.second]);
    result.normals = node_normals(normals.back());
    nodes.push_back(result);
  }
  return nodes;
}

}  // namespace

Tree build_tree(const Foliage& foliage, const CollapseSequence& sequence) {
  const std::uint32_t leaf_count = foliage.leaf_count();
  COPPICE_ASSERT(leaf_count >= 1 && sequence.merges.size() + 1 == leaf_count);
  Tree tree;
  tree.vertices.reserve(std::size_t{leaf_count} * 4);
  for (const Quad& quad : foliage.quads) tree.vertices.insert(tree.vertices.end(), quad.begin(), quad.end());
  const std::vector<Tree::Node> merged = nodes_in_merge_order(foliage, sequence, tree.vertices);

  tree.nodes.resize(merged.size());
  tree.split_parent.resize(leaf_count - 1);
  tree.node_split.assign(merged.size(), kNone);
  tree.node_source.assign(merged.size(), kNone);
  std::vector<std::uint32_t> node_of(merged.size(), kNone);  // [merge order] refinement order
  node_of.back() = 0;
  for (std::uint32_t split = 0; split + 1 < leaf_count; ++split) {
    const std::uint32_t merge_index = leaf_count - 2 - split;
    const Merge& merge = sequence.merges[merge_index];
    const std::uint32_t parent = node_of[leaf_count + merge_index];
    COPPICE_ASSERT(parent != kNone && node_of[merge.first] == kNone && node_of[merge.second] == kNone);
    node_of[merge.first] = 2 * split + 1;
    node_of[merge.second] = 2 * split + 2;
    tree.split_parent[split] = parent;
    tree.node_split[parent] = split;
  }
  for (std::uint32_t i = 0; i < merged.size(); ++i) {
    tree.nodes[node_of[i]] = merged[i];
    if (i < leaf_count) tree.node_source[node_of[i]] = i;
  }
  return tree;
}

std::vector<std::uint32_t> cut_nodes(const Tree& tree, std::uint32_t leaf_count) {
  COPPICE_ASSERT(leaf_count >= 1 && leaf_count <= tree.leaf_count());
  std::vector<std::uint32_t> nodes;
  nodes.reserve(leaf_count);
  for (std::uint32_t node = 0; node < 2 * leaf_count - 1; ++node)
    if (tree.node_split[node] >= leaf_count - 1) nodes.push_back(node);
  return nodes;
}

Quad node_quad(const Tree& tree, std::uint32_t node) {
  return quad_of(tree.nodes[node], tree.vertices);
}

Foliage cut_foliage(const Tree& tree, const std::vector<Card>& card_table, std::uint32_t leaf_count) {
  Foliage foliage;
  foliage.card_table = card_table;
  for (const std::uint32_t node : cut_nodes(tree, leaf_count)) {
    foliage.quads.push_back(node_quad(tree, node));
    foliage.cards.push_back(tree.nodes[node].card);
    foliage.opacities.push_back(tree.nodes[node].opacity);
    foliage.normals.push_back(tree.nodes[node].normals);
  }
  return foliage;
}

Foliage solid_foliage(Foliage foliage) {
  for (std::size_t leaf = 0; leaf < foliage.opacities.size(); ++leaf) {
    std::uint8_t& opacity = foliage.opacities[leaf];
    const glm::vec3 middle(quad_centroid(foliage.quads[leaf]));
    const float scale = std::sqrt(static_cast<float>(opacity) / kOpaque);
    for (glm::vec3& corner : foliage.quads[leaf]) corner = middle + (corner - middle) * scale;
    opacity = kOpaque;
  }
  return foliage;
}

}  // namespace coppice::bake
