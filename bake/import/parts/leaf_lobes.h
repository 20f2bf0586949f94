#pragma once

#include <cstdint>
#include <vector>

#include "piece_points.h"
#include "plant.h"

namespace coppice::bake {

/// Joins pieces that touch in points and are lobes of one leaf, or segments of one twig. At one place, leaves that merely touch look the
/// same; only the whole plant distinguishes them. Pieces with the same list of triangles, the same part of the image and edges of the same
/// proportions are copies of one *kind*. Pieces are joined in three cases:
/// - Nearly every piece of one kind touches just one of another kind, and the other way round: each lobe has its own form, or its own part
/// of the image, and its place. One middle lobe may have two side lobes of one kind.
/// - Nearly every piece of a kind touches another copy side by side, in two points and more or with another corner than the copy: equal
/// strips. Pieces end to end are joined only if they are slender, as segments of twigs are.
/// - Nearly every piece of a kind lies with two copies or more in one plane, fanned out of one point, and has no image that says otherwise.
/// Copies of one leaf that touch at their stalks fit none of these.
/// piece_of  [triangle count] the first triangle of each triangle's piece, kNone for triangles of no piece; receives the joined pieces
void join_lobes(const Mesh& mesh, const Points& points, std::vector<std::uint32_t>& piece_of);

}  // namespace coppice::bake
