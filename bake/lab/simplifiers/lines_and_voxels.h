#pragma once

// Simplifiers whose levels are no leaves: needles as lines, and clouds of voxels. level.h says how these look.

#include <cstdint>
#include <vector>

#include "level.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// [card] The share of it that is no hole, sampled at 16 x 16 points.
/// errors  those of alpha_masks
Result<std::vector<double>> card_coverage(const std::vector<Card>& cards, const std::vector<Material>& materials,
                                          const std::vector<Image>& images);

/// Where a quad shows its card's point (s, t), both in [0, 1], s from corner 0 to 1 and t from 0 to 3: bilinear.
glm::dvec3 quad_point(const Quad& quad, double s, double t);

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

/// Conifer needles as lines (Deng, Zhang, Gay, Lei: Continuous LOD Model of Coniferous Foliage, IJVR 6(4), 2007, and View-Dependent Conifer
/// LOD Models, PMA 2006). A needle under a pixel wide is a line. Two lines that are too thin become one, or lines are drawn at random and
/// the rest left out; transparency makes up for width. Only the abstracts are public. Here a line is a ribbon whose width gives it the area
/// of what it replaces, so that rays through pixels see as much of it as transparency would leave. Swept are merging, with the length of
/// the longer line or that of both, and sampling with the kept lines wider. A line has half of a quad's four vertices, so a level of m
/// leaves has up to 2m lines.
/// leaf_counts  each 1 .. leaf_count (asserted); not empty
/// errors  those of card_coverage
Result<std::vector<Variant>> needle_lines(const ShownFoliage& shown, const std::vector<std::uint32_t>& leaf_counts);

inline constexpr std::uint32_t kVoxelBytes = 11, kLeafBytes = 13;

/// Fills a grid with `cells` cells along the longest side of the leaves' box; voxels are in the order of cells. A leaf's area is
/// distributed over 8 x 8 points of its card, without those in holes.
/// errors  those of alpha_masks
Result<std::vector<Voxel>> fill_voxels(const ShownFoliage& shown, std::uint32_t cells);

/// A cloud of voxels with mean opacity and normals, as engines draw far foliage (Nanite's voxels, of which no more is public, and before
/// them Heitz, Dupuy, Crassin, Dachsbacher: The SGGX Microflake Distribution, SIGGRAPH 2015). Space is cut into cubes; one that has leaves
/// in it keeps their area by normal. Methods are compared at equal bytes. A voxel counts as 11: a position of three times ten bits, a
/// material, area, and nine shares of normals of four bits. A leaf counts as 13, the mean of the bakes of ten plants. The grid is the
/// finest that fits. Swept is how much of the leaves' area counts, since leaves in a cube overlap more or less than leaves that are strewn
/// at random. leaf_counts  each 1 .. leaf_count errors  those of fill_voxels
Result<std::vector<Variant>> voxel_cloud(const ShownFoliage& shown, const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
