#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

struct FittedLeaf {
  Quad quad{};
  Card card{};  ///< uv as fitted: neither shifted nor shared
};

/// How the plane of a leaf's quad is chosen.
enum class LeafPlane {
  nearest,  ///< equation (1) alone
  shown,    ///< that plane, unless less than half of the leaf's area shows on it; then the triangle's plane on which the most shows
};

/// Fits one quad to each leaf of the plant: the paper's section III, equation (1). The stalk is the leaf vertex nearest the wood,
/// the tip the leaf vertex farthest from where the wood bears it; if several are equally far, or the farthest is the stalk, the one
/// farthest from the stalk. The plane goes through the stalk and two other vertices and minimises the summed distance of all vertices. The
/// quad is the rectangle in it along stalk and tip, as wide on either side as the leaf; its front faces as the leaf's does. A leaf that is
/// a quad already (two triangles, four vertices) keeps its corners and winding, turned so that the edge from corner 3 to 0 is nearest to
/// the wood.
/// returns  one quad per leaf, in leaf order, with the part of the leaf's texture that lies on it; does not depend on the number of threads
/// errors   invalid_argument: a leaf without area
Result<std::vector<FittedLeaf>> fit_leaves(const Plant& plant, LeafPlane plane = LeafPlane::nearest);

/// A plane by a point and a unit normal.
struct Plane {
  glm::dvec3 point{0.0};
  glm::dvec3 normal{0.0};
};

/// Equation (1) of the paper: the plane through points[stalk] and two others with the smallest summed distance to all points. Nearly
/// collinear triples are no planes. With more than 24 other points the pairs come from 24 of them, each the farthest from the earlier ones,
/// starting with the farthest from the stalk. The first pair wins a tie. The normal is zero if all points lie on one line.
Plane best_plane(std::span<const glm::dvec3> points, std::size_t stalk);

/// A small table of cards that many leaves share.
struct SharedCards {
  std::vector<Card> table;             ///< at most COPPICE_MAX_CARDS
  std::vector<std::uint32_t> card_of;  ///< [leaf_count] index into table
};

/// Shares equal cards. If a material has an image, uvs are rounded to 1/4096 and moved by whole numbers so that their mean lies in [0, 1),
/// since textures repeat. A material without an image has one card, the unit square. If there are more than COPPICE_MAX_CARDS distinct
/// cards, the table takes the first card of each material and then, one by one, the card farthest from its nearest in the table (the first
/// wins a tie); every other leaf shows the nearest card of its material.
SharedCards share_cards(const std::vector<Card>& cards, const std::vector<Material>& materials);

/// Shares cards between leaves: the distinct (material, corner uv), at most COPPICE_MAX_CARDS (share_cards).
Foliage share_leaf_cards(const std::vector<FittedLeaf>& leaves, const std::vector<Material>& materials);

/// fit_leaves and share_leaf_cards: quads that show the leaf's texture, but not its outline. card_foliage (leaf_cards.h) shows the outline
/// too.
Result<Foliage> fit_leaf_quads(const Plant& plant);

}  // namespace coppice::bake
