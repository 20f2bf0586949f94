#pragma once

#include <cstdint>
#include <vector>

#include "plant.h"
#include "triangle_soup.h"

namespace coppice::bake {

/// The triangles of a soup, grouped into pieces: what may be a leaf each.
struct Pieces {
  std::vector<std::uint32_t> triangles;      ///< of all pieces, ascending within each
  std::vector<LeafRange> ranges;             ///< into `triangles`; pieces in order of their first triangle
  std::vector<std::uint32_t> loose;          ///< collapsed triangles (two corners in one place) that touch no piece
  std::vector<std::uint32_t> loose_numbers;  ///< [loose.size()] those of one number lie together
  std::uint32_t loose_count = 0;             ///< numbers given
  std::vector<std::uint32_t> seams;          ///< collapsed triangles, and pieces without area, that touch a piece
  std::vector<std::uint32_t> seam_pieces;    ///< [seams.size()] which
};

/// Splits a soup into pieces, each of one mesh instance and one material.
///
/// What belongs together is told by three kinds of contact. Triangles connect *by edge* when they share an edge of welded positions that
/// has two triangles, or are the same triangle, in either winding; *by index* when they share a vertex; *by weld* when they share a welded
/// position. Connecting by index alone splits leaves at texture seams, by weld alone joins leaves that touch. Repetition decides, where
/// they differ; a class is the pieces with equal numbers of triangles and points:
/// - a welded piece that is repeated as it is (8 times) and whose parts are not alike is one piece, unless most of it is several of each
///   part, as in a twig with its leaves; else its parts by edge and index are;
/// - such a part falls apart by edge when its parts are alike and repeated: leaves whose shared vertex was merged when they were exported;
/// - a part by edge falls apart by index when that gives a class most of whose members touch nothing: leaves that share an edge with their
///   neighbours here and there.
/// Of the pieces that still touch, those are joined that are lobes of one leaf or segments of one twig: leaf_lobes.h. Pieces without area
/// are seams of what they touch.
/// welded  from weld(): per vertex the vertex it is one with
Pieces split_pieces(const Mesh& mesh, const std::vector<std::uint32_t>& welded);

/// The same, each piece of one surface: what connects by edge. Blades that grow out of common points come apart, and so do lobes of a leaf.
Pieces split_surfaces(const Mesh& mesh, const std::vector<std::uint32_t>& welded);

/// Which pieces of different materials are one leaf, because they share an edge or a whole triangle: blade and midrib, front and back.
/// candidates  [pieces.ranges.size()] whether the piece takes part
/// returns [pieces.ranges.size()] the smallest piece it is one with
std::vector<std::uint32_t> join_materials(const Mesh& mesh, const std::vector<std::uint32_t>& welded, const Pieces& pieces,
                                          const std::vector<bool>& candidates);

}  // namespace coppice::bake
