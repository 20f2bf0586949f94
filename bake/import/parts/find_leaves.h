#pragma once

// Decides which triangles are leaves, by the surface itself: nobody has to name the material.
//
// Each piece of surface (leaf_pieces.h) is judged with its class, the pieces of its material with as many triangles and points. Evidence
// for leaves is positive, for wood negative; a class whose sum is at least kLeafScore is leaves.
//
//   name        +3 a word for foliage in the material's name, +1 for a flower's or a plant's, -1 for a twig's, -3 for wood, pots, soil,
//               fruit (material_words.h)
//   holes       +1 the material's alpha mask, or blending, cuts holes into its image
//   colour      up to +0.75 green where the pieces show the image, -0.5 brown
//   flatness    +1.25 flat or nearly so, +0.75 a sheet that is curled or twisted, falling to -2.5 for tubes and balls; only to -0.5 with
//               holes, where cards may cross
//   repetition  0.65 log10(n), at most 2.6, for n pieces of this class, or half the pieces of about this size
//   size        +0.25 small against the plant, falling to -2 from half its extent
//   company     for pieces beside a larger class of flat pieces in the same material: -4 if they are tubes, balls or many times as long
//               (twigs, rachises, fruit), -8 if they are longer and much more slender (twigs of strips). For pieces of another material:
//               -2.5 if they lie below all leaves, are fewer than a tenth of them, and neither name, holes nor green speak for them
//               (pots)
//
// Bodies (bulk of piece_shape.h from 0.2, flatness below 0.75), such as blobs of a crown, are wood anyway if fewer than a hundred have
// about one size.
//
// A name that speaks for wood counts nothing against open, flat pieces that would be leaves without it, if they are a tenth of the plant's
// surface and more than its other leaves: a tree of one material that is named after its trunk.
//
// If no class is leaves, or so few and small that they are no crown (less than 2 % of the surface, 10 % if there are not eight; a hundred
// that reach into the upper quarter of the plant are one), sheets become leaves: flat pieces that are no bodies, three or more in a
// material, or fewer if they have holes or a word for foliage in their name. Blades of grass, petals and fronds are such sheets, and may be
// as large as their plant. If there are no sheets, pieces that share points, as blades do at their root, are taken apart and judged again;
// then come sheets whose name speaks for wood, if they are open and 30 % of the surface. If there is still no crown, leaves for which only
// their form speaks are wood too, such as marks of a bark, and so may be all of the plant: dead trees, cacti, crowns of a few blobs.

#include <cstdint>
#include <string>
#include <vector>

#include "class_rules.h"
#include "plant.h"
#include "triangle_soup.h"

namespace coppice::bake {

inline constexpr double kLeafScore = 1.75;

/// A soup, separated into leaves and wood.
struct FoundParts {
  Mesh foliage;                          ///< triangles sorted by leaf; welded positions are equal
  std::vector<LeafRange> leaves;         ///< in order of their first triangle; together they are all of `foliage`
  Mesh wood;                             ///< in the soup's order, positions as they were
  std::vector<PieceClass> classes;       ///< by material, then most pieces first
  std::uint32_t dropped_leaf_count = 0;  ///< leaves that were dropped because they have no area
  bool has_crown = false;                ///< there are leaves, and they are more than a few small ones
};

/// Separates a plant into leaves and wood. Collapsed triangles (two corners in one place) and pieces without area are dropped if their
/// material is foliage, and stay if it is wood. A leaf may have parts of several materials if they share an edge. The result does not
/// depend on the number of threads.
/// materials, images  as in Plant; the soup's materials index `materials`
/// rules              [materials.size()] a person's decisions; the evidence decides where none fits
FoundParts find_leaves(TriangleSoup soup, const std::vector<Material>& materials, const std::vector<Image>& images,
                       const std::vector<std::vector<MaterialRule>>& rules);

}  // namespace coppice::bake
