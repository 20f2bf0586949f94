#pragma once

#include <cstdint>
#include <vector>

#include "piece_points.h"
#include "plant.h"

namespace coppice::bake {

/// Joins pieces that touch in points and are lobes of one leaf, or segments of one twig. Leaves that touch look the same at one place; the
/// whole plant tells them apart. Pieces with the same list of triangles, the same part of the image and edges of the same proportions are
/// copies of one *kind*. Pieces are joined where
/// - nearly every piece of one kind touches just one of another kind, and the other way round: each lobe has its own form or its own part
///   of the image, and its place. One middle lobe may have two side lobes of one kind;
/// - nearly every piece of a kind touches another copy side by side, with another corner than that one does, or in two points and more:
///   equal strips. End to end only if they are slender, as segments of twigs are;
/// - nearly every piece of a kind lies with two copies or more in one plane, fanned out of one point, and has no image to say otherwise.
/// Copies of one leaf that touch at their stalks are none of these.
/// piece_of  [triangle count] the first triangle of the piece each belongs to, kNone for triangles of none; gets the joined pieces
void join_lobes(const Mesh& mesh, const Points& points, std::vector<std::uint32_t>& piece_of);

}  // namespace coppice::bake
