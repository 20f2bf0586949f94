#pragma once

// Which triangles are leaves, told from the surface itself: nobody has to say which material it is.
//
// Each piece of surface (leaf_pieces.h) is weighed together with its class, the pieces of its material with as many triangles and points.
// Evidence for leaves counts up, for wood down; a class of at least kLeafScore is leaves.
//
//   name        +3 a word for foliage in the material's name, +1 for a flower's or a plant's, -1 for a twig's, -3 for wood, pots,
//               soil, fruit (material_words.h)
//   holes       +1 the material's alpha mask, or blending, cuts holes into its image
//   colour      up to +0.75 green where the pieces show the image, -0.5 brown
//   flatness    +1.25 flat or nearly so, +0.75 a sheet that is curled or twisted, falling to -2.5 for tubes and balls; only to -0.5 with
//               holes, where cards may cross
//   repetition  0.65 log10(n), at most 2.6, for n pieces of this class, or half the pieces of about this size
//   size        +0.25 small against the plant, falling to -2 from half its extent
//   company     -4 beside a larger class of flat pieces in the same material: tubes and balls among leaves, and what is many times as long
//               (twigs, rachises, fruit); -8 for what is longer and much more slender than they (twigs of strips). -2.5 in another
//               material, below all leaves and fewer than a tenth of them, where neither name, holes nor green speak for it (pots)
//
// Bodies (bulk of piece_shape.h from 0.2, flatness below 0.75), as blobs of a crown are, are wood all the same where they are fewer than a
// hundred of about one size.
//
// Where no class is leaves, sheets are: flat and no bodies, three or more in a material, or fewer that have holes or a word for foliage in
// their name; never where the name speaks for wood. So are blades of grass, petals and fronds, which may be as large as their plant. If
// there are none, pieces that share points, as blades do at their root, are taken apart and weighed again. If there are none still, all of
// the plant is wood: dead trees, cacti, crowns of a few blobs.

#include <cstdint>
#include <string>
#include <vector>

#include "class_rules.h"
#include "plant.h"
#include "triangle_soup.h"

namespace coppice::bake {

inline constexpr double kLeafScore = 1.75;

/// A soup taken apart.
struct FoundParts {
  Mesh foliage;                          ///< triangles sorted by leaf; welded positions are equal
  std::vector<LeafRange> leaves;         ///< in order of their first triangle; tile the foliage
  Mesh wood;                             ///< in the soup's order, positions as they were
  std::vector<PieceClass> classes;       ///< by material, then most pieces first
  std::uint32_t dropped_leaf_count = 0;  ///< without area
};

/// Takes a plant apart. Collapsed triangles (two corners in one place) and pieces without area are dropped where their material is
/// foliage, and stay where it is wood. A leaf may have parts of several materials if they share an edge.
/// materials, images  as in Plant; the soup's materials index the former
/// rules              [materials.size()] what a person has decided; where none fits, the evidence does
/// result             does not depend on the number of threads
FoundParts find_leaves(TriangleSoup soup, const std::vector<Material>& materials, const std::vector<Image>& images,
                       const std::vector<std::vector<MaterialRule>>& rules);

}  // namespace coppice::bake
