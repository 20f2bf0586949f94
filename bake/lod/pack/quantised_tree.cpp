#include "quantised_tree.h"

#include <algorithm>
#include <cmath>

#include "bounds.h"

namespace coppice::bake {
namespace {

Error bad_tree(const char* what, std::size_t split) {
  return {Status::invalid_argument, what, Error::kNoOffset, "split " + std::to_string(split)};
}

Result<void> check_shape(const Tree& tree) {
  const std::size_t leaf_count = tree.leaf_count();
  if (leaf_count > COPPICE_MAX_LEAVES) return Error{Status::invalid_argument, "tree: too many leaves"};
  if (tree.nodes.size() != 2 * leaf_count - 1) return Error{Status::invalid_argument, "tree: node count is not 2 leaves - 1"};
  for (const Tree::Node& node : tree.nodes) {
    if (node.card >= COPPICE_MAX_CARDS) return Error{Status::invalid_argument, "tree: card over COPPICE_MAX_CARDS"};
    if (node.opacity < 1 || node.opacity > kOpaque) return Error{Status::invalid_argument, "tree: opacity outside 1..16"};
    if (!are_normals(node.normals))
      return Error{Status::invalid_argument, "tree: a quad's own normals with other bits, or an axis finer than its along allows"};
    for (std::uint32_t vertex : node.vertices)
      if (vertex >= tree.vertices.size()) return Error{Status::invalid_argument, "tree: vertex index out of range"};
  }
  for (const glm::vec3& vertex : tree.vertices)
    for (int axis = 0; axis < 3; ++axis)
      if (!std::isfinite(vertex[axis])) return Error{Status::invalid_argument, "tree: vertex is not finite"};
  return {};
}

/// Finds which of the children's eight corners are the parent's, by vertex index.
Result<std::array<std::uint8_t, 4>> find_slots(const Tree& tree, std::uint32_t split) {
  std::array<std::uint32_t, 8> corners{};
  std::ranges::copy(tree.nodes[2 * split + 1].vertices, corners.begin());
  std::ranges::copy(tree.nodes[2 * split + 2].vertices, corners.begin() + 4);
  std::array<std::uint8_t, 4> slots{};
  std::array<bool, 8> taken{};
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const auto found = std::ranges::find(corners, tree.nodes[tree.split_parent[split]].vertices[corner]);
    const auto slot = static_cast<std::size_t>(found - corners.begin());
    if (found == corners.end() || taken[slot]) return bad_tree("tree: a parent's vertices are not four of its children's", split);
    taken[slot] = true;
    slots[corner] = static_cast<std::uint8_t>(slot);
  }
  return slots;
}

}  // namespace

QuantisationBox leaf_box(const Tree& tree, std::uint32_t steps) {
  if (tree.vertices.empty()) return {.steps = steps};
  const auto [low, high] = box_of(tree.vertices);
  return {low, high, steps};
}

QuantisedPoint quantise(const QuantisationBox& box, const glm::vec3& point) {
  QuantisedPoint steps{};
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = double{box.max[axis]} - double{box.min[axis]};
    const double share = extent > 0.0 ? (double{point[axis]} - double{box.min[axis]}) / extent : 0.0;
    steps[static_cast<std::size_t>(axis)] = static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * box.steps));
  }
  return steps;
}

glm::vec3 dequantise(const QuantisationBox& box, const QuantisedPoint& point) {
  const glm::vec3 share = glm::vec3(point[0], point[1], point[2]) / static_cast<float>(box.steps);
  return box.min + share * (box.max - box.min);
}

Result<QuantisedTree> quantise_tree(const Tree& tree, std::uint32_t steps) {
  COPPICE_CHECK(check_shape(tree));
  QuantisedTree result;
  result.box = leaf_box(tree, steps);
  for (const Tree::Node& node : tree.nodes) {
    PageNode quantised{.card = static_cast<std::uint8_t>(node.card), .opacity = node.opacity, .normals = node.normals};
    for (std::size_t corner = 0; corner < 4; ++corner)
      quantised.corners[corner] = quantise(result.box, tree.vertices[node.vertices[corner]]);
    result.nodes.push_back(quantised);
  }
  for (std::uint32_t s = 0; s < tree.split_parent.size(); ++s) {
    const std::uint32_t parent = tree.split_parent[s];
    if (parent > 2 * s || result.nodes[parent].split != kNeverReplaced) return bad_tree("tree: a split's parent is not alive", s);
    result.nodes[parent].split = s;
    COPPICE_TRY(parent_slots, find_slots(tree, s));
    Split split{parent, parent_slots, {}, {}};
    std::array<bool, 8> filled{};
    for (std::uint8_t slot : parent_slots) filled[slot] = true;
    std::size_t next = 0;
    for (std::size_t slot = 0; slot < 8; ++slot)
      if (!filled[slot]) split.new_vertices[next++] = result.nodes[2 * s + 1 + slot / 4].corners[slot % 4];
    for (std::uint32_t child = 0; child < 2; ++child) split.cards[child] = static_cast<std::uint8_t>(tree.nodes[2 * s + 1 + child].card);
    result.splits.push_back(split);
  }
  for (const PageNode& node : result.nodes)
    if (node.split == kNeverReplaced && node.opacity != kOpaque) return Error{Status::invalid_argument, "tree: a transparent source leaf"};
  return result;
}

}  // namespace coppice::bake
