#pragma once

// Conifer needles as lines (Deng, Zhang, Gay, Lei: Continuous LOD Model of Coniferous Foliage, IJVR 6(4), 2007, and View-Dependent Conifer
// LOD Models, PMA 2006). A needle under a pixel wide is a line. Two lines that are too thin become one, or lines are drawn at random and
// the rest left out; transparency makes up for width. Only the abstracts are public. Here a line is a ribbon whose width gives it the area
// of what it replaces (level.h), so that rays through pixels see as much of it as transparency would leave. Swept are merging, with the
// length of the longer line or that of both, and sampling with the kept lines wider. A line has half of a quad's four vertices, so a level
// of m leaves has up to 2m lines.

#include <vector>

#include "level.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Makes the line from the middle of one short edge to that of the other. Its width gives it the share of the quad's area that its card
/// covers.
/// coverage  in [0, 1]
Needle needle_of(const Quad& quad, std::uint32_t material, double coverage);

/// The length of a line that replaces two.
enum class NeedleLength {
  longer,  ///< that of the longer one
  both,    ///< from the first end of both to the last
};

/// Unites two needles along their mean direction, about the common centre of area, with the area of both and the material of the larger
/// one.
Needle united_needle(const Needle& first, const Needle& second, NeedleLength length);

/// leaf_counts  each 1 .. leaf_count (asserted); not empty
/// errors  those of card_coverage
Result<std::vector<Variant>> needle_lines(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                                          const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
