#pragma once

#include <cstdint>
#include <vector>

#include "piece_points.h"
#include "plant.h"

namespace coppice::bake {

/// The triangles of a soup, grouped into pieces; each piece may be a leaf.
struct Pieces : Groups {
  std::vector<std::uint32_t> loose;         ///< collapsed triangles (two corners in one place) that touch no piece
  std::vector<std::uint32_t> loose_points;  ///< [loose.size()] the smallest point of each; equal for those that lie together
  std::vector<std::uint32_t> seams;         ///< collapsed triangles, and pieces without area, that touch a piece
  std::vector<std::uint32_t> seam_pieces;   ///< [seams.size()] the piece that each touches
};

/// Splits a soup into pieces, each of one mesh instance and one material.
///
/// Three kinds of contact say what belongs together. Triangles connect *by edge* if they share an edge of welded positions that has two
/// triangles, or are the same triangle, in either winding; *by index* if they share a vertex; *by weld* if they share a welded position.
/// Connecting by index alone splits leaves at texture seams, by weld alone joins leaves that touch. Where the three differ, repetition
/// decides; a class is the pieces with equal numbers of triangles and points:
/// - A welded piece that is repeated as a whole (8 times) and has unlike parts is one piece, unless most of it is several of each part, as
/// in a twig with its leaves. Otherwise its parts by edge and index are the pieces.
/// - Such a part falls apart by edge if the smaller parts are alike and repeated: leaves whose shared vertex was merged when they were
/// exported.
/// - A part by edge falls apart by index if that gives a class most of whose members touch nothing: leaves that share an edge with their
/// neighbours here and there.
/// Pieces that still touch are joined if they are lobes of one leaf or segments of one twig: leaf_lobes.h. Pieces without area become seams
/// of the pieces that they touch.
/// welded  from weld(): for each vertex the vertex that it is one with
Pieces split_pieces(const Mesh& mesh, const std::vector<std::uint32_t>& welded);

/// Splits a soup into surfaces: triangles that connect by edge. This separates blades that grow out of common points, but also lobes of a
/// leaf.
Pieces split_surfaces(const Mesh& mesh, const std::vector<std::uint32_t>& welded);

/// Finds pieces of different materials that are one leaf, because they share an edge or a whole triangle: blade and midrib, front and back.
/// candidates  [pieces.ranges.size()] whether the piece takes part
/// returns [pieces.ranges.size()] the smallest piece that each is one with
std::vector<std::uint32_t> join_materials(const Mesh& mesh, const std::vector<std::uint32_t>& welded, const Pieces& pieces,
                                          const std::vector<bool>& candidates);

}  // namespace coppice::bake
